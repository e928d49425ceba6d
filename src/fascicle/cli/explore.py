"""Commands that hand over to other parts: `explore`, in a browser, and `reproduce`, a paper."""

import os
import sys
from importlib import import_module
from pathlib import Path

from ..core.errors import require
from . import options
from .errors import UserError, user_errors
from .inputs import load_laws, read_target
from .options import Text, Texts, argument, option
from .outputs import result_folder
from .terminal import print_line


_PAPERS = ["kim2021", "measurements"]


def explore(
    file: options.Target = "kim2021_figure_6",
    host: str = option("Address to listen on: by default this machine's own.", default="127.0.0.1"),
    port: int | None = option("Port; default: 5006 or the next free one.", min=1, max=65535),
    allow_host: Texts = option("Additional name of this server; repeatable.", "NAME"),
    show: bool = option("Automatic opening of a browser.", names="--show/--no-show", default=True),
) -> None:
    """Open a muscle or bundle in the explorer, in a browser."""
    require("panel")
    _print_at_once("starting")
    target = read_target(file)
    import multiprocessing  # no other command needs it
    import signal

    # Ctrl-C while libraries are loaded could come out as an error of theirs
    handler = signal.signal(signal.SIGINT, lambda *_: os._exit(130))
    from ..explorer.server import serve
    from ..explorer.state import view_of
    from ..explorer.tab import is_computing

    signal.signal(signal.SIGINT, handler)
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


def reproduce(
    paper: str = argument(
        "PAPER",
        "Paper: kim2021; or measurements: every available record against every law.",
        autocompletion=lambda: _PAPERS,
    ),
    out: Text = option("Folder of results; default: out/PAPER.", "FOLDER", "--out -o"),
    overwrite: options.Overwrite = False,
) -> int:
    """Reproduce the figures and check the claims of a paper.

    Exit code 1 if a claim fails that should hold; 3 if no measured record is available,
    or some were omitted.
    """
    import fascicle

    if paper not in _PAPERS:
        raise UserError(f"{paper}: no such paper, choose {', or '.join(_PAPERS)}.")
    checkout = Path(fascicle.__file__).resolve().parents[2]  # has `reproduction`, unlike a wheel
    if not (checkout / "reproduction" / "claims.py").is_file():
        raise UserError(
            f"reproduce runs in a checkout of fascicle alone, and {checkout} has no folder"
            " `reproduction`: clone the repository and run `make reproduce` there."
        )
    if str(checkout) not in sys.path:
        sys.path.append(str(checkout))
    folder = Path(f"out/{paper}" if out is None else out)
    load_laws()
    terminal = import_module("reproduction.terminal")
    with user_errors("--out "):  # before the minutes of work
        folder.parent.mkdir(parents=True, exist_ok=True)
    result_folder(f"{folder}", "", False, overwrite)
    folder.mkdir(exist_ok=True)
    with user_errors():
        return getattr(terminal, paper)(folder, overwrite)


COMMANDS = {"explore": explore, "reproduce": reproduce}
