"""`fascicle reproduce`: a paper's figures and claims, made anew."""

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from .options import Replace
from .outputs import say
from .problems import UserError, refusing
from .startup import prepare


def run(
    paper: Annotated[
        str,
        typer.Argument(
            metavar="PAPER",
            help="Which one: kim2021.",
            autocompletion=lambda: ["kim2021"],
            show_default=False,
        ),
    ],
    out: Annotated[
        str | None,
        typer.Option(
            "--out",
            "-o",
            metavar="DIR",
            help="The folder for what is made; left out, out/kim2021.",
            show_default=False,
        ),
    ] = None,
    overwrite: Replace = False,
) -> None:
    """Figures and claims of a paper, made anew.

    Exit code 1 if a claim that must hold doesn't.
    """
    if paper != "kim2021":
        raise UserError(f"{paper}: no such paper here, choose kim2021.")
    folder = Path(f"out/{paper}" if out is None else out)
    with refusing("--out "):
        _check(folder, overwrite)
    prepare()
    with refusing("--out "):  # a full disk, a folder gone
        claims = _made(folder, overwrite)
    _show(claims)
    say(f"report: {folder / 'report.html'}")
    from ..reproduce.claims import failed

    if failed(claims):
        raise typer.Exit(1)


def _check(folder: Path, overwrite: bool) -> None:
    """Refuse a folder that can't be made or written, before the minutes of work."""
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(f"{folder}: it is no folder.")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OSError(f"{folder}: can't be made: {error.strerror or error}.") from None
    from ..describe.ours import check_folder

    check_folder(folder, "reproduce", overwrite)


def _made(folder: Path, overwrite: bool) -> list[Any]:
    """The claims, once everything is in `folder`; a bar on the terminal meanwhile."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    from ..describe.ours import write_folder
    from ..reproduce import kim2021

    columns = (TextColumn("{task.description:24}"), BarColumn(), MofNCompleteColumn(),
               TimeElapsedColumn())  # fmt: skip
    # on stderr, and only where somebody watches
    console = Console(file=sys.stderr)
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as bar:
        task = bar.add_task("", total=None)

        def progress(done: int, total: int, what: str) -> None:
            bar.update(task, completed=done, total=total, description=what)

        claims: list[Any] = []
        write_folder(
            folder,
            "reproduce",
            lambda draft: claims.extend(kim2021.run(draft, progress)),
            overwrite,
        )
        return claims


def _show(claims: list[Any]) -> None:
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    for head in ("where", "verdict", "claim", "what the model gives"):
        table.add_column(head)
    styles = {"holds": "green", "differs": "yellow", "fails": "bold red"}
    for claim in claims:
        verdict = Text(claim.verdict, style=styles[claim.verdict])
        model = f"{claim.model} {claim.why}" if claim.why else claim.model
        table.add_row(Text(claim.where), verdict, Text(claim.text), Text(model))
    Console(file=sys.stdout, highlight=False).print(table)
    counts = [f"{sum(c.verdict == verdict for c in claims)} {verdict}" for verdict in styles]
    print(f"{len(claims)} claims: {', '.join(counts)}")
