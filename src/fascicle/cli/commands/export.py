"""`fascicle export`: a muscle or bundle for other programs."""

from pathlib import Path
from typing import Annotated, Any

import typer

from ..inputs import is_scenario, read_scenario, read_target
from ..options import Replace, Target
from ..outputs import say
from ..problems import UserError, refusing
from ..telling import telling


Folder = Annotated[
    str | None,
    typer.Option(
        "--c",
        metavar="FOLDER",
        help="Write the law as C there, a header and a source without dependencies.",
        show_default=False,
    ),
]
Table = Annotated[
    str | None,
    typer.Option(
        "--table",
        metavar="FOLDER",
        help="Write force and volume as a table in C there: some tens of nanoseconds a call.",
        show_default=False,
    ),
]
Fmu = Annotated[
    str | None,
    typer.Option(
        "--fmu",
        metavar="PATH",
        help="Write a unit for co-simulation there, FMI 2.0, from the table: .fmu.",
        show_default=False,
    ),
]
SampleTime = Annotated[
    str | None,
    typer.Option(
        "--sample-time",
        metavar="TIME",
        help="Step that a unit's host is told to take; left out, 1 ms, or the controller's.",
        show_default=False,
    ),
]
Platform = Annotated[
    str | None,
    typer.Option(
        "--platform",
        metavar="NAME",
        help="For which a unit is built, in FMI's words; left out, this one.",
        show_default=False,
    ),
]
Precision = Annotated[
    str,
    typer.Option(
        "--precision",
        metavar="double|float",
        help="Of a table's numbers: float takes a seventh of the room.",
    ),
]


def run(
    file: Target,
    c: Folder = None,
    table: Table = None,
    fmu: Fmu = None,
    precision: Precision = "double",
    name: Annotated[
        str, typer.Option("--name", help="With which files, and names in C, begin.")
    ] = "muscle",
    sample_time: SampleTime = None,
    platform: Platform = None,
    overwrite: Replace = False,
) -> None:
    """Write a muscle's or bundle's force for programs without Python.

    `--c`: the law itself, its slopes and free strain; it needs `fascicle[export]`. `--table`: force
    and volume from one table, which says how far it is off; of a scenario that is controlled by
    force, also its controller's step. `--fmu`: the same for Simulink, OpenModelica and others, with
    its sources, built by a C compiler. All stand for the numbers in the file as they are now.
    """
    asked = {"--c": c, "--table": table}
    given = {flag: Path(folder) for flag, folder in asked.items() if folder is not None}
    if not given and fmu is None:
        raise UserError("nothing to write: give --c or --table and a folder, or --fmu and a file.")
    if fmu is not None:
        _check_unit(fmu, overwrite)
    found = _read(file, c is not None)
    from ...export.pair import checked_name

    with refusing():
        checked_name(name)
    for flag, folder in given.items():
        _check(flag, _paths(folder, name), overwrite)
    if c is not None:
        with telling("writing the law as C"):
            texts = _of_the_law(found, name)
        _write("--c", _paths(Path(c), name), texts, overwrite)
    if table is not None:
        from ...export import tabulated
        from ...export.table_code import written

        with refusing(), telling("computing the table"):
            made = tabulated(found, precision)
            texts = written(made, name, precision)
        _write("--table", _paths(Path(table), name), texts, overwrite)
        say(made.errors)
    if fmu is not None:
        _write_unit(found, Path(fmu), name, sample_time, platform, overwrite)


def _check_unit(fmu: str, overwrite: bool) -> None:
    from ...files.ours import check_file
    from ...io.atomic import check_writable

    if Path(fmu).suffix.lower() != ".fmu":
        raise UserError(f"--fmu {fmu!r}: its name must end in .fmu.")
    with refusing("--fmu "):
        check_writable(fmu)
        check_file(fmu, overwrite)


def _write_unit(
    found: Any, path: Path, name: str, sample_time: str | None, platform: str | None, force: bool
) -> None:
    from ...export import write_fmu
    from ...export.fmu import Unbuilt
    from ...files.ours import replacing

    unbuilt: Unbuilt | None = None
    told = telling("computing the table, building the unit")
    with refusing(), told, replacing(path, force) as draft:
        try:
            write_fmu(found, draft, name, sample_time, platform)
        except Unbuilt as error:
            unbuilt = error
    if unbuilt is not None:
        raise UserError(f"--fmu {path}: {unbuilt}: the file holds sources only.")
    say(f"wrote {path}")


def _read(file: str, law: bool) -> Any:
    """The muscle or bundle, or of a scenario its controller, for its table."""
    if not is_scenario(file):
        return read_target(file)
    if law:
        raise UserError(f"--c: {file} is a scenario, the law is a bundle's: give --table.")
    read = read_scenario(file)
    from ...export.controlling import bundle_of

    with refusing():
        return read.controlled.controller if read.controlled else bundle_of(read.plant)


def _paths(folder: Path, name: str) -> list[Path]:
    return [folder / f"{name}.{end}" for end in ("h", "c")]


def _check(flag: str, paths: list[Path], overwrite: bool) -> None:
    from ...files.ours import check_file
    from ...io.atomic import check_writable

    with refusing(f"{flag} "):
        check_writable(paths[0].parent, folder=True)
        for path in paths:
            check_file(path, overwrite)


def _write(flag: str, paths: list[Path], texts: tuple[str, str], overwrite: bool) -> None:
    from ...files.ours import replacing
    from ...io.atomic import write_text

    with refusing(f"{flag} "):
        paths[0].parent.mkdir(parents=True, exist_ok=True)
        for path, text in zip(paths, texts, strict=True):
            with replacing(path, overwrite) as draft:
                write_text(draft, text)
    say(f"wrote {paths[0]} and {paths[1]}")


def _of_the_law(found: Any, name: str) -> tuple[str, str]:
    from ...export import c_code

    try:
        with refusing():
            return c_code(found, name)
    except ModuleNotFoundError as error:
        raise UserError(str(error)) from None
