"""`fascicle export`: a muscle or bundle for other programs, and as a page."""

from pathlib import Path
from typing import Any

from . import options
from .errors import UserError, user_errors
from .inputs import bundle_of, is_scenario, read_list, read_scenario, read_target
from .options import option
from .outputs import Outputs, check_file, print_line, replace_output, status, write_text


def export(
    file: str = options.TARGET,
    units: str | None = options.UNITS,
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
    opensim: str | None = option(
        "OpenSim's McKibbenActuator of the muscle's braid (.xml), which leaves out the bladder.",
        metavar="PATH",
    ),
    pressure: str | None = option(
        "Pressures of the page's curves, of --values, or up to which --opensim goes: a list"
        " (100kPa,2bar) or a range (start:stop:step).",
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
    _check_outputs(
        table,
        {"--fmu": fmu, "--page": page, "--values": values, "--opensim": opensim},
        pressure,
        overwrite,
    )
    target = _read_exported(file, page is not None)
    if units is not None:
        target = bundle_of(target, units)
    from .. import export
    from ..export.c_files import check_c_name

    with user_errors():
        check_c_name(name)
    if table is not None:
        _check_c(table, name, overwrite)
    pressures = None if pressure is None else read_list(pressure, "pressure", "--pressure")
    if values is not None:
        _write_values(values, target, file, pressures, overwrite)
    if opensim is not None:
        muscle = _single_muscle(target, file, "--opensim")
        with user_errors():
            text = export.opensim_element(muscle, name, max(pressures or ()))
        _write_page("--opensim", opensim, overwrite, text)
    if page is not None:
        _write_page("--page", page, overwrite, _page_text(target, file, pressures))
    if table is not None:
        with status("computing the table"), user_errors():
            tables = export.tabulate(target, precision)
            texts = tables.code(name)
        _write_c(table, name, texts, overwrite)
        print_line(tables.errors)
    if fmu is not None:
        _write_fmu(fmu, target, name, sample_time, platform, overwrite)


def _check_outputs(
    table: str | None, files: dict[str, str | None], pressure: str | None, overwrite: bool
) -> None:
    """Refuse outputs that can't be written, or lack their pressures, before the work begins."""
    endings = {"--fmu": [".fmu"], "--page": [".html", ".htm"], "--opensim": [".xml"]}
    written = {name: path for name, path in files.items() if path is not None}
    if table is None and not written:
        names = ", ".join(files)
        raise UserError(f"nothing to write: give --table and a folder, or one of {names}.")
    with_pressure = {"--page", "--values", "--opensim"} & set(written)
    if pressure is not None and not with_pressure:
        raise UserError("--pressure: it is of --page, --values or --opensim: give one, too.")
    if pressure is None and with_pressure - {"--page"}:
        name = min(with_pressure - {"--page"})
        raise UserError(f"{name}: give --pressure, too, such as 0kPa:400kPa:5kPa.")
    for name, path in written.items():
        if name in endings:
            check_file(name, path, overwrite, endings[name])


def _read_exported(file: str, page: bool) -> Any:
    """Read a muscle, a bundle, or a scenario's controller, which a `page` can't show."""
    if not is_scenario(file):
        return read_target(file)
    if page:
        raise UserError(f"--page: {file} is a scenario, a page is of a bundle: give --table.")
    scenario = read_scenario(file)
    if scenario.control:
        return scenario.control.controller
    from ..export.controller import single_bundle

    with user_errors():
        return single_bundle(scenario.plant)


def _write_page(option_name: str, path: str, overwrite: bool, text: str) -> None:
    """Write a `text`, and print its path."""
    write_text(option_name, path, overwrite, text)
    print_line(f"wrote {path}")


def _write_fmu(
    fmu: str,
    target: Any,
    name: str,
    sample_time: str | None,
    platform: str | None,
    overwrite: bool,
) -> None:
    """Write a unit for co-simulation; without a compiler its sources, and an error."""
    from ..export import write_fmu
    from ..export.fmu import UnbuiltUnitError  # needs JAX, a table doesn't

    message = ""
    with (
        status("computing the table, building the unit"),
        replace_output("", fmu, overwrite) as draft,
    ):
        try:
            write_fmu(target, draft, name, sample_time, platform)
        except UnbuiltUnitError as error:
            message = f"{error}"
    if message:
        raise UserError(f"--fmu {fmu}: {message}; the file holds sources only.")
    print_line(f"wrote {fmu}")


def _single_muscle(target: Any, file: str, option_name: str) -> Any:
    """The muscle that an option needs."""
    from ..bundle import Bundle

    if isinstance(target, Bundle):
        raise UserError(f"{option_name}: {file} is a bundle: export each of its muscles.")
    return target


def _write_values(path: str, target: Any, file: str, pressures: Any, overwrite: bool) -> None:
    """Write the values of a muscle's table as a file of labelled data."""
    from ..results.tables import muscle_table

    muscle = _single_muscle(target, file, "--values")
    outputs = Outputs(False, False, path, None, overwrite)
    with status("computing the table"), user_errors():
        made = muscle_table(muscle, pressures)
    outputs.write(made, lambda: None, title=f"Table of {file}")


def _check_c(folder: str, name: str, overwrite: bool) -> None:
    """Refuse header and source that can't be written, before the work begins."""
    from ..io.atomic import check_writable

    with user_errors("--table "):
        check_writable(folder, folder=True)
    if Path(folder).is_dir():
        for suffix in (".h", ".c"):
            check_file("--table", Path(folder) / f"{name}{suffix}", overwrite)


def _write_c(folder: str, name: str, texts: tuple[str, str], overwrite: bool) -> None:
    """Write the `texts` of header and source, and print their paths."""
    with user_errors("--table "):
        Path(folder).mkdir(parents=True, exist_ok=True)
    header, source = (Path(folder) / f"{name}{suffix}" for suffix in (".h", ".c"))
    # both are drafts until both are complete
    with (
        replace_output("--table", header, overwrite) as header_draft,
        replace_output("--table", source, overwrite) as source_draft,
    ):
        for draft, text in zip((header_draft, source_draft), texts, strict=True):
            draft.write_text(text, encoding="utf-8", newline="\n")
    print_line(f"wrote {header} and {source}")


def _page_text(target: Any, file: str, pressures: list[float] | None) -> str:
    """Text of the page of a muscle or bundle."""
    from ..export.page import CURVES, page_text

    with user_errors("--page: "):
        return page_text(target, Path(file).stem, pressures or CURVES)


COMMANDS = {"export": export}
