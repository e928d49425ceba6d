"""`fascicle explore`: the explorer, in a browser."""

import os
import sys
from pathlib import Path

from ...core.errors import require
from .. import options
from ..errors import user_errors
from ..inputs import read_target
from ..options import option
from ..outputs import print_line


def run(
    file: str = options.TARGET_OR_EXAMPLE,
    host: str = option(
        "Address to listen on; at 127.0.0.1 no other machine reaches it.", default="127.0.0.1"
    ),
    port: int | None = option("Port; default: 5006 or the next free one.", min=1, max=65535),
    allow_host: list[str] | None = option(
        "Additional host name of this server, such as a proxy's; repeatable.",
        metavar="NAME",
    ),
    show: bool = option("Automatic opening of a browser.", "--show/--no-show", default=True),
) -> None:
    """Open a muscle or bundle in the explorer, in a browser."""
    require("panel")
    _print_at_once("starting")
    target = read_target(file)
    import multiprocessing  # no other command needs it

    from ...explorer.server import serve
    from ...explorer.state import view_of
    from ...explorer.tab import is_computing

    with user_errors():
        view = view_of(target, Path(file).name[:60])
        serve(view, host, port, show, _print_at_once, allow_host or [])
    for process in multiprocessing.active_children():  # a simulation whose visitor is gone
        process.kill()
    if is_computing():
        os._exit(0)  # a fit whose visitor is gone: the interpreter would wait for its end


def _print_at_once(line: str) -> None:
    print_line(line)
    sys.stdout.flush()
