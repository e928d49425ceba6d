"""`fascicle export`: a muscle or bundle for other programs, and as a page."""

from pathlib import Path
from typing import Any

from .. import options
from ..errors import UserError, user_errors
from ..inputs import is_scenario, read_list, read_scenario, read_target
from ..options import option
from ..outputs import Outputs, check_file, print_line, replace_output, status, write_text


def run(
    file: str = options.TARGET,
    table: str | None = option(
        "Folder for a table of force, volume and inverse in C: tens of nanoseconds per force.",
        metavar="FOLDER",
    ),
    fmu: str | None = option(
        "Functional mock-up unit (.fmu) with the table, for co-simulation by FMI 2.0.",
        metavar="PATH",
    ),
    page: str | None = option(
        "Web page (.html) that draws the muscle or bundle offline, in any browser.",
        metavar="PATH",
    ),
    values: str | None = option(
        "Force, conjugate volume and deflection as .csv, .json or .nc, for a program that"
        " interpolates.",
        metavar="PATH",
    ),
    pressure: str | None = option(
        "Pressures of the page's curves, or of --values: a list (100kPa,2bar) or a range"
        " (start:stop:step).",
        "--pressure -p",
        metavar="LIST",
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
    """Write a muscle or bundle as C code, an FMU or a web page.

    `--table` writes a table of force and volume, and reports its error; for a scenario with force
    control as FILE it adds one step of the controller. It has the inverse, `NAME_pressures`: the
    pressures for a force and a strain, as `fascicle recruit` chooses. `--fmu`
    packs that table for Simulink, OpenModelica and other hosts; without a C compiler for the
    platform it holds sources only. `--page` writes one file with sliders for pressure and
    contraction, which needs neither fascicle nor a network. Later changes of FILE don't change what
    was exported.
    """
    if table is None and fmu is None and page is None and values is None:
        raise UserError(
            "nothing to write: give --table and a folder, or --fmu, --page or --values and a file."
        )
    if pressure is not None and page is None and values is None:
        raise UserError("--pressure: it is of the page or of --values: give one of them, too.")
    if values is not None and pressure is None:
        raise UserError("--values: give --pressure, too, such as 0kPa:400kPa:5kPa.")
    if fmu is not None:
        check_file("--fmu", fmu, overwrite, [".fmu"])
    if page is not None:
        check_file("--page", page, overwrite, [".html", ".htm"])
    target = _read_exported(file, page is not None)
    from ... import export
    from ...export.c_files import check_c_name

    with user_errors():
        check_c_name(name)
    if table is not None:
        _check_c(table, name, overwrite)
    if values is not None:
        _write_values(values, target, file, pressure or "", overwrite)
    if page is not None:
        write_text("--page", page, overwrite, _page_text(target, file, pressure))
        print_line(f"wrote {page}")
    if table is not None:
        with status("computing the table"), user_errors():
            tables = export.tabulate(target, precision)
            texts = tables.code(name)
        _write_c(table, name, texts, overwrite)
        print_line(tables.errors)
    if fmu is not None:
        from ...export.fmu import UnbuiltUnitError  # needs JAX, a table doesn't

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


def _read_exported(file: str, page: bool) -> Any:
    """Read a muscle, a bundle, or a scenario's controller, which a `page` can't show."""
    if not is_scenario(file):
        return read_target(file)
    if page:
        raise UserError(f"--page: {file} is a scenario, a page is of a bundle: give --table.")
    scenario = read_scenario(file)
    if scenario.control:
        return scenario.control.controller
    from ...export.controller import single_bundle

    with user_errors():
        return single_bundle(scenario.plant)


def _write_values(path: str, target: Any, file: str, pressure: str, overwrite: bool) -> None:
    """Write the values of a muscle's table as a file of labelled data."""
    from ...bundle import Bundle
    from ...results.tables import muscle_table

    if isinstance(target, Bundle):
        raise UserError(f"--values: {file} is a bundle: export each of its muscles.")
    outputs = Outputs(False, False, path, None, overwrite)
    with status("computing the table"), user_errors():
        made = muscle_table(target, read_list(pressure, "pressure", "--pressure"))
    outputs.write(made, lambda: None, title=f"Table of {file}")


def _check_c(folder: str, name: str, overwrite: bool) -> None:
    """Refuse header and source that can't be written, before the work begins."""
    from ...io.atomic import check_writable

    with user_errors("--table "):
        check_writable(folder, folder=True)
    if Path(folder).is_dir():
        for suffix in (".h", ".c"):
            check_file("--table", Path(folder) / f"{name}{suffix}", overwrite)


def _write_c(folder: str, name: str, texts: tuple[str, str], overwrite: bool) -> None:
    """Write the `texts` of header and source, and print their paths."""
    with user_errors("--table "):
        Path(folder).mkdir(parents=True, exist_ok=True)
    paths = [Path(folder) / f"{name}{suffix}" for suffix in (".h", ".c")]
    for path, text in zip(paths, texts, strict=True):
        write_text("--table", path, overwrite, text)
    print_line(f"wrote {paths[0]} and {paths[1]}")


def _page_text(target: Any, file: str, pressure: str | None) -> str:
    """Text of the page of a muscle or bundle."""
    from ...export.page import CURVES, page_text

    pressures = CURVES if pressure is None else read_list(pressure, "pressure", "--pressure")
    with user_errors("--page: "):
        return page_text(target, Path(file).stem, pressures)
