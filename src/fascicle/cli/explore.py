"""Commands that hand over to other parts: `explore`, in a browser, and `reproduce`, a paper."""

import os
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import typer

from ..core.errors import require
from . import options
from .errors import INCOMPLETE, UserError, user_errors
from .inputs import load_laws, read_target
from .options import Texts, argument, option
from .outputs import print_line, print_written, result_folder, status, write_folder


MEASUREMENTS = "measurements"


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

    from ..explorer.server import serve
    from ..explorer.state import view_of
    from ..explorer.tab import is_computing

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
        autocompletion=lambda: ["kim2021", MEASUREMENTS],
    ),
    out: options.OutFolder = None,
    overwrite: options.Overwrite = False,
    verbose: options.Verbose = False,
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
    check = _compare_measurements if paper == MEASUREMENTS else _check_claims
    check(folder, overwrite, verbose)


def _compare_measurements(folder: Path, overwrite: bool, verbose: bool) -> None:
    """Compare every law with every measured record that is available."""
    with status("reading the records"), user_errors():
        measurements = import_module("reproduction.measurements")
        records = measurements.measured_records()
    omitted: dict[str, list[str]] = {}  # names by reason
    for record in records:
        if record.left_out:
            omitted.setdefault(record.left_out, []).append(record.name)
    if is_measured := any(not record.left_out for record in records):
        comparisons, names = _write(
            folder, overwrite, lambda draft, update: measurements.run(draft, records, update)
        )
        import_module("reproduction.terminal").print_comparisons(comparisons, verbose)
        print_line(measurements.UNTESTED[0])
        print_written(folder, names, verbose)
    for reason, names in omitted.items():
        print_line(f"omitted, {reason}: {', '.join(names)}")
    if not is_measured:
        print_line(measurements.no_records_message())
    if omitted:
        raise typer.Exit(INCOMPLETE)


def _check_claims(folder: Path, overwrite: bool, verbose: bool) -> None:
    """Draw the paper's figures, and check its claims."""
    kim2021 = import_module("reproduction.kim2021.reproduction")
    terminal = import_module("reproduction.terminal")

    def run(draft: Path, update: Callable[[str], None]) -> list[Any]:
        def show(done: int, total: int, figure: str) -> None:
            update(f"{figure}, {done} of {total}")

        return kim2021.run(draft, show)

    claims, names = _write(folder, overwrite, run)
    terminal.print_claims(claims, verbose)
    print_written(folder, names, verbose)
    if terminal.failed(claims):
        raise typer.Exit(1)


def _write(
    folder: Path, overwrite: bool, run: Callable[[Path, Callable[[str], None]], list[Any]]
) -> tuple[list[Any], list[str]]:
    """Results of a `run`, and the names of the files that it wrote into the folder, which is made
    or refused before the minutes of work.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"--out {folder}: can't be created: {error.strerror or error}.") from None
    result_folder(f"{folder}", "", False, overwrite)
    results: list[Any] = []
    with user_errors(), status("computing") as update:
        names = write_folder(folder, overwrite, lambda draft: results.extend(run(draft, update)))
    return results, names


COMMANDS = {"explore": explore, "reproduce": reproduce}
