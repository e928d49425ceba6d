"""`fascicle reproduce`: a paper's figures and claims, and measured records against every law."""

import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import typer

from .. import options
from ..errors import INCOMPLETE, UserError, user_errors
from ..inputs import load_laws
from ..options import argument, option
from ..outputs import print_line, print_written, result_folder, status, write_folder


MEASUREMENTS = "measurements"


def run(
    paper: str = argument(
        "PAPER",
        "Paper: kim2021; or measurements: every available record against every law.",
        autocompletion=lambda: ["kim2021", MEASUREMENTS],
    ),
    out: str | None = option("Folder of results; default: out/PAPER.", "--out -o", metavar="DIR"),
    overwrite: bool = options.OVERWRITE,
    verbose: bool = options.VERBOSE,
) -> None:
    """Reproduce the figures and check the claims of a paper.

    Exit code 1 if a claim fails that should hold; 3 if no measured record is available,
    or some were omitted.
    """
    import fascicle

    if paper not in ("kim2021", MEASUREMENTS):
        raise UserError(f"{paper}: no such paper, choose kim2021, or {MEASUREMENTS}.")
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
    if paper == MEASUREMENTS:
        _compare_measurements(folder, overwrite, verbose)
    else:
        _check_claims(folder, overwrite, verbose)


def _compare_measurements(folder: Path, overwrite: bool, verbose: bool) -> None:
    """Compare every law with every measured record that is available."""
    with status("reading the records"), user_errors():
        measurements = import_module("reproduction.measurements")
        records = measurements.measured_records()
    omitted = [record for record in records if record.left_out]
    if len(omitted) == len(records):
        _print_omitted(omitted)
        print_line(measurements.no_records_message())
        raise typer.Exit(INCOMPLETE)
    _make_folder(folder, overwrite)
    comparisons: list[Any] = []
    with user_errors(), status("measurements") as update:

        def compare_into(draft: Path) -> None:
            comparisons.extend(measurements.run(draft, records, update))

        names = write_folder(folder, overwrite, compare_into)
    import_module("reproduction.terminal").print_comparisons(comparisons, verbose)
    print_line(measurements.UNTESTED[0])
    print_written(folder, names, verbose)
    _print_omitted(omitted)
    if omitted:
        raise typer.Exit(INCOMPLETE)


def _print_omitted(records: Sequence[Any]) -> None:
    """Print the names of omitted records, a line for each reason."""
    reasons: dict[str, list[str]] = {}
    for record in records:
        reasons.setdefault(record.left_out, []).append(record.name)
    for reason, names in reasons.items():
        print_line(f"omitted, {reason}: {', '.join(names)}")


def _check_claims(folder: Path, overwrite: bool, verbose: bool) -> None:
    """Draw the paper's figures, and check its claims."""
    _make_folder(folder, overwrite)
    with status("loading the paper's figures"):
        kim2021 = import_module("reproduction.kim2021.reproduction")
        terminal = import_module("reproduction.terminal")
    claims: list[Any] = []
    with status("computing") as update:

        def reproduce_into(draft: Path) -> None:
            claims.extend(kim2021.run(draft, show_progress))

        def show_progress(done: int, total: int, figure: str) -> None:
            update(f"{figure}, {done} of {total}")

        names = write_folder(folder, overwrite, reproduce_into)
    terminal.print_claims(claims, verbose)
    print_written(folder, names, verbose)
    if terminal.failed(claims):
        raise typer.Exit(1)


def _make_folder(folder: Path, overwrite: bool) -> None:
    """Create the folder, or refuse one that can't be written, before the minutes of work."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise UserError(f"--out {folder}: it is no folder.") from None
    except OSError as error:
        reason = error.strerror or error
        raise UserError(f"--out {folder}: can't be created: {reason}.") from None
    result_folder(f"{folder}", "", False, overwrite)
