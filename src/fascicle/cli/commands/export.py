"""`fascicle export`: a muscle or bundle for other programs."""

from pathlib import Path
from typing import Any

from .. import options
from ..errors import UserError, user_errors
from ..inputs import is_scenario, read_scenario, read_target
from ..options import option
from ..outputs import check_file, print_line, replace_output, status, write_text


def run(
    file: str = options.TARGET,
    c: str | None = option(
        "Folder for the force law and its inverse in C, without dependencies.",
        metavar="FOLDER",
    ),
    table: str | None = option(
        "Folder for a table of force, volume and inverse in C: tens of nanoseconds per force.",
        metavar="FOLDER",
    ),
    fmu: str | None = option(
        "Functional mock-up unit (.fmu) with the table, for co-simulation by FMI 2.0.",
        metavar="PATH",
    ),
    precision: str = option(
        "Number type of the table; float takes a seventh of the memory.",
        metavar="double|float",
        default="double",
    ),
    name: str = option("Prefix of file names and of names in C.", default="muscle"),
    sample_time: str | None = option(
        "Communication step of the FMU; default: 1 ms, or the controller's.", metavar="TIME"
    ),
    platform: str | None = option(
        "Platform of the FMU's binary; default: this machine's. MinGW builds win64 elsewhere.",
        metavar="linux64|darwin64|win64",
    ),
    overwrite: bool = options.OVERWRITE,
) -> None:
    """Write a muscle's or bundle's force as C code or an FMU.

    `--c` writes the force law itself, its derivatives and its free strain; it needs
    `fascicle[export]`. `--table` writes a table of force and volume, and reports its error; for a
    scenario with force control it adds one step of the controller. Both have the inverse,
    `NAME_pressures`: the pressures for a force and a strain, as `fascicle recruit` chooses. `--fmu`
    packs that table for Simulink, OpenModelica and other hosts; without a C compiler for the
    platform it holds sources only. Later changes of FILE don't change what was exported.
    """
    if c is None and table is None and fmu is None:
        raise UserError("nothing to write: give --c or --table and a folder, or --fmu and a file.")
    if fmu is not None:
        check_file("--fmu", fmu, overwrite, [".fmu"])
    target = _read(file, c is not None)
    from ... import export
    from ...export.c_files import check_name
    from ...export.fmu import UnbuiltUnitError

    with user_errors():
        check_name(name)
    for flag, folder in (("--c", c), ("--table", table)):
        if folder is not None:
            _check_c(flag, folder, name, overwrite)
    if c is not None:
        with status("writing the law as C"), user_errors():
            texts = export.c_code(target, name)
        _write_c("--c", c, name, texts, overwrite)
    if table is not None:
        with status("computing the table"), user_errors():
            tables = export.tabulate(target, precision)
            texts = tables.code(name)
        _write_c("--table", table, name, texts, overwrite)
        print_line(tables.errors)
    if fmu is not None:
        message = ""
        with (
            status("computing the table, building the unit"),
            replace_output("", fmu, overwrite) as draft,
        ):
            try:
                export.write_fmu(target, draft, name, sample_time, platform)
            except UnbuiltUnitError as error:
                message = f"{error}"
        if message:
            raise UserError(f"--fmu {fmu}: {message}; the file holds sources only.")
        print_line(f"wrote {fmu}")


def _read(file: str, law: bool) -> Any:
    """Read a muscle, a bundle, or a scenario's controller; `law`: the law itself is exported."""
    if not is_scenario(file):
        return read_target(file)
    if law:
        raise UserError(f"--c: {file} is a scenario, the law is a bundle's: give --table.")
    scenario = read_scenario(file)
    if scenario.control:
        return scenario.control.controller
    from ...export.controller import single_bundle

    with user_errors():
        return single_bundle(scenario.plant)


def _check_c(flag: str, folder: str, name: str, overwrite: bool) -> None:
    from ...io.atomic import check_writable

    with user_errors(f"{flag} "):
        check_writable(folder, folder=True)
    if Path(folder).is_dir():
        for suffix in (".h", ".c"):
            check_file(flag, Path(folder) / f"{name}{suffix}", overwrite)


def _write_c(flag: str, folder: str, name: str, texts: tuple[str, str], overwrite: bool) -> None:
    with user_errors(f"{flag} "):
        Path(folder).mkdir(parents=True, exist_ok=True)
    paths = [Path(folder) / f"{name}{suffix}" for suffix in (".h", ".c")]
    for path, text in zip(paths, texts, strict=True):
        write_text(flag, path, overwrite, text)
    print_line(f"wrote {paths[0]} and {paths[1]}")
