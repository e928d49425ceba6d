"""`fascicle reproduce`: a paper's figures and claims, made anew."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..options import Replace
from ..outputs import say
from ..problems import UserError, refusing
from ..startup import prepare


if TYPE_CHECKING:
    from ...reproduce.claims import Claim


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

    Exit code 1 if a claim fails: one that isn't known to differ.
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
    say(f"claims: {folder / 'claims.json'}")
    say(f"report: {folder / 'report.html'}")
    from ...reproduce.claims import failed

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
    from ...files.ours import check_folder

    check_folder(folder, "reproduce", overwrite)


def _made(folder: Path, overwrite: bool) -> "list[Claim]":
    """The claims, once everything is in `folder`; a bar on the terminal meanwhile."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    from ...files.ours import write_folder
    from ...reproduce import kim2021

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

        claims: list[Claim] = []
        write_folder(
            folder,
            "reproduce",
            lambda draft: claims.extend(kim2021.run(draft, progress)),
            overwrite,
        )
        return claims


def _show(claims: "list[Claim]") -> None:
    """Each claim with the number that decides, kind by kind; then what differs; then the sum."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    from ...reproduce.claims import KINDS, of_kind, summary

    console = Console(file=sys.stdout, highlight=False)
    for kind, about in KINDS.items():
        some = of_kind(claims, kind)
        if not some:
            continue
        console.print(Text(f"{kind.capitalize()}s: {about}", style="bold"))
        table = Table(box=SIMPLE_HEAD, pad_edge=False)
        for head in ("where", "verdict", "claim, and the paper's words", "criterion"):
            table.add_column(head)
        for claim in some:
            verdict = Text(claim.verdict, style=_STYLES[claim.verdict])
            words = Text.assemble(claim.text, (f" “{claim.quote}”", "dim"))
            table.add_row(Text(claim.where), verdict, words, Text(_criteria(claim)))
        console.print(table)
    for claim in claims:
        if not claim.holds:
            text = f"{claim.verdict}: {claim.text} {claim.model} {claim.why}".rstrip()
            console.print(Text(text, style=_STYLES[claim.verdict]), soft_wrap=False)
    console.print(Text(summary(claims)), soft_wrap=True)


def _criteria(claim: "Claim") -> str:
    lines = [f"{one.text}{' (our limit)' if one.ours else ''}" for one in claim.criteria]
    if claim.chosen and claim.holds:
        lines.append(f"chosen: {claim.chosen}")
    return "; ".join(lines)


_STYLES = {
    "holds": "green", "chosen": "", "by definition": "", "differs": "yellow", "fails": "bold red",
}  # fmt: skip
