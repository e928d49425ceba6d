"""`fascicle reproduce`: a paper's figures and claims, and measured records against every law."""

import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import typer

from .. import options
from ..errors import INCOMPLETE, UserError, user_errors
from ..inputs import load_laws
from ..options import argument, option
from ..outputs import check_folder, print_line, status, write_folder


MEASUREMENTS = "measurements"


def run(
    paper: str = argument(
        "PAPER",
        "Paper: kim2021; or measurements: every available record against every law.",
        autocompletion=lambda: ["kim2021", MEASUREMENTS],
    ),
    out: str | None = option("Folder of results; default: out/PAPER.", "--out -o", metavar="DIR"),
    overwrite: bool = options.OVERWRITE,
) -> None:
    """Reproduce the figures and check the claims of a paper.

    Exit code 1 if a claim fails: one that isn't known to differ; 3 if no measured record is in
    reach, or some had to be left out.
    """
    if paper not in ("kim2021", MEASUREMENTS):
        raise UserError(f"{paper}: no such paper here, choose kim2021, or {MEASUREMENTS}.")
    folder = Path(f"out/{paper}" if out is None else out)
    _add_checkout()
    if paper == MEASUREMENTS:
        _compare_measurements(folder, overwrite)
    else:
        _check_claims(folder, overwrite)


def _add_checkout() -> None:
    """Add the checkout to Python's path, whose `reproduction` lies beside the package."""
    import fascicle

    folder = Path(fascicle.__file__).resolve().parents[2]
    if not (folder / "reproduction" / "claims.py").is_file():
        raise UserError(
            f"reproduce runs in a checkout of fascicle alone, and {folder} has no folder"
            " `reproduction`: clone the repository and run `make reproduce` there."
        )
    if str(folder) not in sys.path:
        sys.path.append(str(folder))


def _compare_measurements(folder: Path, overwrite: bool) -> None:
    """Compare every law with every measured record that is available."""
    load_laws()
    with status("reading the records"), user_errors():
        measurements = import_module("reproduction.measurements")
        records = measurements.measured_records()
    omitted = [record for record in records if record.left_out]
    for record in omitted:
        print_line(f"left out: {record.name}: {record.left_out}")
    if len(omitted) == len(records):
        print_line(measurements.no_records_message())
        raise typer.Exit(INCOMPLETE)
    _make_folder(folder, overwrite)
    comparisons: list[Any] = []
    with user_errors(), status("measurements") as update:
        write_folder(
            folder,
            overwrite,
            lambda draft: comparisons.extend(measurements.run(draft, records, update)),
        )
    import_module("reproduction.terminal").print_comparisons(comparisons)
    for text in (*measurements.UNTESTED, f"report: {folder / 'report.html'}"):
        print_line(text)
    if omitted:
        raise typer.Exit(INCOMPLETE)


def _check_claims(folder: Path, overwrite: bool) -> None:
    """Make the paper's figures, and check its claims."""
    _make_folder(folder, overwrite)
    load_laws()
    with status("loading the paper's figures"):
        kim2021 = import_module("reproduction.kim2021.reproduction")
        terminal = import_module("reproduction.terminal")
    claims: list[Any] = []
    with status("computing") as update:

        def run(draft: Path) -> None:
            claims.extend(kim2021.run(draft, progress))

        def progress(done: int, total: int, figure: str) -> None:
            update(f"{figure}, {done} of {total}")

        write_folder(folder, overwrite, run)
    terminal.print_claims(claims)
    print_line(f"claims: {folder / 'claims.json'}")
    print_line(f"report: {folder / 'report.html'}")
    if terminal.failed(claims):
        raise typer.Exit(1)


def _make_folder(folder: Path, overwrite: bool) -> None:
    """Make the folder, or refuse one that can't be written, before the minutes of work."""
    with user_errors("--out "):
        if folder.exists() and not folder.is_dir():
            raise NotADirectoryError(f"{folder}: it is no folder.")
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OSError(f"{folder}: can't be made: {error.strerror or error}.") from None
    check_folder(folder, overwrite)
