"""`fascicle reproduce`: a paper's figures and claims, made anew."""

import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any

import typer

from ..options import Replace
from ..outputs import say
from ..problems import INCOMPLETE, UserError, refusing
from ..startup import prepare
from ..telling import telling


MEASUREMENTS = "measurements"


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
    _checkout()
    if paper == MEASUREMENTS:
        _measured(folder, overwrite)
        return
    with refusing("--out "):
        _check(folder, overwrite)
    prepare()
    reproduction = _load("kim2021.reproduction")
    with refusing("--out "):  # a full disk, a folder gone
        claims = _made(reproduction, folder, overwrite)
    terminal = _load("terminal")
    terminal.print_claims(claims)
    say(f"claims: {folder / 'claims.json'}")
    say(f"report: {folder / 'report.html'}")
    if terminal.failed(claims):
        raise typer.Exit(1)


def _checkout() -> Path:
    """Folder of the checkout that the package runs from, which holds `reproduction`."""
    import fascicle

    folder = Path(fascicle.__file__).resolve().parents[2]
    if not (folder / "reproduction" / "claims.py").is_file():
        raise UserError(
            f"reproduce runs in a checkout of fascicle alone, and {folder} has no folder"
            " `reproduction`: clone the repository and run `make reproduce` there."
        )
    return folder


def _load(name: str) -> ModuleType:
    """Import a module of `reproduction`, which lies beside the package and isn't installed."""
    checkout = str(_checkout())
    if checkout not in sys.path:
        sys.path.append(checkout)
    with telling("loading the paper's figures"):
        return import_module(f"reproduction.{name}")


def _measured(folder: Path, overwrite: bool) -> None:
    """Every measured record in reach against every law, shown and written."""
    prepare()
    measurements = _load("measurements")
    from ...files.ours import write_folder

    with refusing(), telling("reading the records"):
        records = measurements.measured_records()
    left = [record for record in records if record.left_out]
    for record in left:
        say(f"left out: {record.name}: {record.left_out}")
    if len(left) == len(records):
        say(measurements.no_records_message())
        raise typer.Exit(INCOMPLETE)
    with refusing("--out "):
        _check(folder, overwrite)
    comparisons: list[Any] = []
    with refusing(), telling("measurements") as tell:
        write_folder(
            folder,
            "reproduce",
            lambda draft: comparisons.extend(measurements.run(draft, records, tell)),
            overwrite,
        )
    _load("terminal").print_comparisons(comparisons)
    for text in measurements.UNTESTED:
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


def _made(reproduction: ModuleType, folder: Path, overwrite: bool) -> list[Any]:
    """The claims, once everything is in `folder`; a bar on the terminal meanwhile."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    from ...files.ours import write_folder

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
            lambda draft: claims.extend(reproduction.run(draft, progress)),
            overwrite,
        )
        return claims
