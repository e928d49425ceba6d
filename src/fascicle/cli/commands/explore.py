"""`fascicle explore`: the explorer, in a browser."""

import os
from typing import Annotated

import typer

from ...io.sanitize import sanitize_line
from ..options import complete_target
from ..problems import UserError, refusing


def run(
    file: Annotated[
        str,
        typer.Argument(
            metavar="[FILE]",
            help="A muscle or bundle file, or a named example (see `fascicle muscles`).",
            autocompletion=complete_target,
        ),
    ] = "kim2021_figure_6",
    host: Annotated[
        str,
        typer.Option(
            help="Address to listen on. Any other than 127.0.0.1 lets other machines use it.",
        ),
    ] = "127.0.0.1",
    port: Annotated[
        int | None,
        typer.Option(
            min=1, max=65535, help="Port; left out, 5006 or the next free one.", show_default=False
        ),
    ] = None,
    allow_host: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="A name besides its own that it answers to, such as a proxy's; may be repeated.",
            show_default=False,
        ),
    ] = None,
    show: Annotated[bool, typer.Option("--show/--no-show", help="Open a browser.")] = True,
) -> None:
    """Feel a muscle or a bundle in the browser."""
    from importlib.util import find_spec

    if find_spec("panel") is None:
        raise UserError("the explorer needs the package panel: pip install 'fascicle[explorer]'.")
    from ...explorer.stopping import Stop

    with Stop(_say):
        _serve(file, host, port, show, allow_host or [])
    if _working():
        # a fit that nobody will see: the interpreter would wait for its end
        os._exit(0)


def _serve(file: str, host: str, port: int | None, show: bool, allowed: list[str]) -> None:
    from pathlib import Path

    from ..inputs import read_target

    _say("starting")
    found = read_target(file)
    from ...explorer.server import serve
    from ...explorer.state import view_of

    with refusing():
        view = view_of(found, Path(file).name[:60])
        serve(view, host, port, show, _say, allowed)


def _working() -> bool:
    from ...explorer.background import working

    return working()


def _say(line: str) -> None:
    print(sanitize_line(line), flush=True)
