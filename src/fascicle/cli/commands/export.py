"""`fascicle export`: a muscle or bundle for other programs."""

from pathlib import Path
from typing import Annotated, Any

import typer

from ..inputs import is_scenario, read_scenario, read_target
from ..options import Replace, Target
from ..outputs import say
from ..problems import UserError, refusing


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
    precision: Precision = "double",
    name: Annotated[
        str, typer.Option("--name", help="With which files, and names in C, begin.")
    ] = "muscle",
    overwrite: Replace = False,
) -> None:
    """Write a muscle's or bundle's force for programs without Python.

    `--c`: the law itself, its slopes and free strain; it needs `fascicle[export]`. `--table`: force
    and volume from one table, which says how far it is off; of a scenario that is controlled by
    force, also its controller's step. All stand for the numbers in the file as they are now.
    """
    asked = {"--c": c, "--table": table}
    given = {flag: Path(folder) for flag, folder in asked.items() if folder is not None}
    if not given:
        raise UserError(f"nothing to write: give {' or '.join(asked)} and a folder.")
    if len({folder.resolve() for folder in given.values()}) < len(given):
        raise UserError(f"{' and '.join(given)}: both would write {name}.h: give two folders.")
    found = _read(file, c is not None)
    for flag, folder in given.items():
        _check(flag, _paths(folder, name), overwrite)
    if c is not None:
        _write("--c", _paths(Path(c), name), _of_the_law(found, name), overwrite)
    if table is not None:
        from ...export import tabulated
        from ...export.table_code import checked_name, written

        with refusing():
            checked_name(name)
            made = tabulated(found, precision)
            texts = written(made, name, precision)
        _write("--table", _paths(Path(table), name), texts, overwrite)
        say(made.errors)


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
    from ...core.atomic import check_writable
    from ...files.ours import check_file

    with refusing(f"{flag} "):
        check_writable(paths[0].parent, folder=True)
        for path in paths:
            check_file(path, overwrite)


def _write(flag: str, paths: list[Path], texts: tuple[str, str], overwrite: bool) -> None:
    from ...core.atomic import write_text
    from ...files.ours import replacing

    with refusing(f"{flag} "):
        paths[0].parent.mkdir(parents=True, exist_ok=True)
        for path, text in zip(paths, texts, strict=True):
            with replacing(path, overwrite):
                write_text(path, text)
    say(f"wrote {paths[0]} and {paths[1]}")


def _of_the_law(found: Any, name: str) -> tuple[str, str]:
    from ...export import c_code

    try:
        with refusing():
            return c_code(found, name)
    except ModuleNotFoundError as error:
        raise UserError(str(error)) from None
