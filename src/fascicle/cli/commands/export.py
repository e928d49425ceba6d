"""`fascicle export`: a muscle or bundle for other programs."""

from pathlib import Path
from typing import Any

from .. import options
from ..errors import UserError, user_errors
from ..inputs import is_scenario, read_scenario, read_target
from ..options import option
from ..outputs import check_file, print_line, status, write_file, write_text


def run(
    file: str = options.TARGET,
    c: str | None = option(
        "Folder for the law as C, a header and a source without dependencies.", metavar="FOLDER"
    ),
    table: str | None = option(
        "Folder for force and volume as a table in C: some tens of nanoseconds a call.",
        metavar="FOLDER",
    ),
    fmu: str | None = option(
        "File of a functional mock-up unit (.fmu) with the table: co-simulation, FMI 2.0.",
        metavar="PATH",
    ),
    precision: str = option(
        "Type of a table's numbers: float takes a seventh of the room.",
        metavar="double|float",
        default="double",
    ),
    name: str = option("Prefix of files, and of names in C.", default="muscle"),
    sample_time: str | None = option(
        "Step that a unit asks of its host; default: 1 ms, or the controller's.", metavar="TIME"
    ),
    platform: str | None = option(
        "Platform of a unit, in FMI's words; default: this one.", metavar="NAME"
    ),
    overwrite: bool = options.OVERWRITE,
) -> None:
    """Write a muscle's or bundle's force as C code or an FMU.

    `--c`: the law itself, its slopes and free strain; it needs `fascicle[export]`. `--table`: force
    and volume from one table, with its error; of a scenario that is controlled by force, also its
    controller's step. `--fmu`: the same for Simulink, OpenModelica and others, with its sources,
    built by a C compiler. All hold the numbers of the file as they are now.
    """
    folders = {"--c": c, "--table": table}
    paths = {
        flag: [Path(folder) / f"{name}.{end}" for end in ("h", "c")]
        for flag, folder in folders.items()
        if folder is not None
    }
    if not paths and fmu is None:
        raise UserError("nothing to write: give --c or --table and a folder, or --fmu and a file.")
    if fmu is not None:
        check_file("--fmu", fmu, overwrite, [".fmu"])
    target = _read(file, c is not None)
    from ...export import c_code, tabulated
    from ...export.c_files import checked_name
    from ...export.c_table import written
    from ...io.atomic import check_writable

    with user_errors():
        checked_name(name)
    for flag, pair in paths.items():
        with user_errors(f"{flag} "):
            check_writable(pair[0].parent, folder=True)
        for path in pair:
            if path.parent.is_dir():
                check_file(flag, path, overwrite)
    if c is not None:
        with status("writing the law as C"), user_errors():
            texts = c_code(target, name)
        _write("--c", paths["--c"], texts, overwrite)
    if table is not None:
        with status("computing the table"), user_errors():
            result = tabulated(target, precision)
            texts = written(result, name, precision)
        _write("--table", paths["--table"], texts, overwrite)
        print_line(result.errors)
    if fmu is not None:
        _write_unit(target, fmu, name, sample_time, platform, overwrite)


def _read(file: str, law: bool) -> Any:
    """The muscle or bundle, or the controller of a scenario, for its table."""
    if not is_scenario(file):
        return read_target(file)
    if law:
        raise UserError(f"--c: {file} is a scenario, the law is a bundle's: give --table.")
    scenario = read_scenario(file)
    from ...export.controlling import bundle_of

    with user_errors():
        return scenario.control.controller if scenario.control else bundle_of(scenario.plant)


def _write(flag: str, paths: list[Path], texts: tuple[str, str], overwrite: bool) -> None:
    with user_errors(f"{flag} "):
        paths[0].parent.mkdir(parents=True, exist_ok=True)
    for path, text in zip(paths, texts, strict=True):
        write_text(flag, path, overwrite, text)
    print_line(f"wrote {paths[0]} and {paths[1]}")


def _write_unit(
    target: Any,
    path: str,
    name: str,
    sample_time: str | None,
    platform: str | None,
    overwrite: bool,
) -> None:
    from ...export import write_fmu
    from ...export.fmu import Unbuilt

    unbuilt: Unbuilt | None = None
    building = status("computing the table, building the unit")
    with building, write_file("", path, overwrite) as draft:
        try:
            write_fmu(target, draft, name, sample_time, platform)
        except Unbuilt as error:
            unbuilt = error
    if unbuilt is not None:
        raise UserError(f"--fmu {path}: {unbuilt}: the file holds sources only.")
    print_line(f"wrote {path}")
