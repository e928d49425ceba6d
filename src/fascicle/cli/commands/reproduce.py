"""`fascicle reproduce`: a paper's figures and claims, made anew."""

import sys
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Annotated

import typer

from ..options import Replace
from ..outputs import say
from ..problems import INCOMPLETE, UserError, refusing
from ..startup import prepare
from ..telling import telling


if TYPE_CHECKING:
    from ...reproduce.claims import Claim


MEASUREMENTS = "measurements"
_WIDEST = 40  # characters of a label in a line


def run(
    paper: Annotated[
        str,
        typer.Argument(
            metavar="PAPER",
            help="Which one: kim2021; or measurements, every measured record in reach against"
            " every law.",
            autocompletion=lambda: ["kim2021", MEASUREMENTS],
            show_default=False,
        ),
    ],
    out: Annotated[
        str | None,
        typer.Option(
            "--out",
            "-o",
            metavar="DIR",
            help="The folder for what is made; left out, out/PAPER.",
            show_default=False,
        ),
    ] = None,
    overwrite: Replace = False,
) -> None:
    """Figures and claims of a paper, made anew.

    Exit code 1 if a claim fails: one that isn't known to differ; 3 if no measured record is in
    reach, or some had to be left out.
    """
    if paper not in ("kim2021", MEASUREMENTS):
        raise UserError(f"{paper}: no such paper here, choose kim2021, or {MEASUREMENTS}.")
    folder = Path(f"out/{paper}" if out is None else out)
    if paper == MEASUREMENTS:
        _measured(folder, overwrite)
        return
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


def _measured(folder: Path, overwrite: bool) -> None:
    """Every measured record in reach against every law, shown and written."""
    prepare()
    with telling("loading the records"):
        from ...files.ours import write_folder
        from ...reproduce.measurements import Judged, measured_records, nothing, run
        from ...reproduce.measurements.report import UNTESTED
        from ..printed import show

    with refusing(), telling("reading the records"):
        records = measured_records()
    left = [one for one in records if one.left_out]
    for one in left:
        say(f"left out: {one.name}: {one.left_out}")
    if len(left) == len(records):
        say(nothing())
        raise typer.Exit(INCOMPLETE)
    with refusing("--out "):
        _check(folder, overwrite)
    found: list[Judged] = []
    with refusing(), telling("measurements") as tell:
        write_folder(
            folder, "reproduce", lambda draft: found.extend(run(draft, records, tell)), overwrite
        )
    heads = ["", "free", "rmse", "left out", "along pressure", "along strain"]
    for one in found:
        rows = [
            [fill(law.row.label, _WIDEST), str(law.row.free), f"{law.row.relative_rmse:.2%}",
             f"{law.row.relative_left_out_rmse:.2%}",
             *(f"{low:+.3g} to {high:+.3g} N" for low, high in
               (law.along_pressure, law.along_strain))]
            for law in one.against
        ]  # fmt: skip
        show(f"{one.measured.name}: error over the largest force, mean residuals", heads, rows)
        best = one.against[0]
        say(f"{best.row.label}: {best.misses or 'six numbers without physics'}")
    for text in UNTESTED:
        say(text)
    say(f"report: {folder / 'report.html'}")
    if left:
        raise typer.Exit(INCOMPLETE)


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

    with telling("loading the paper's figures"):
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

    from ...reproduce.claims import KINDS, of_kind, remarks, summary

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
    for sentence in (*remarks(claims), summary(claims)):
        console.print(Text(sentence), soft_wrap=True)


def _criteria(claim: "Claim") -> str:
    lines = [f"{one.text}{one.whose}" for one in claim.criteria]
    if claim.chosen and claim.holds:
        lines.append(f"chosen: {claim.chosen}")
    return "; ".join(lines)


_STYLES = {
    "holds": "green", "chosen": "", "by definition": "", "differs": "yellow", "fails": "bold red",
}  # fmt: skip
