"""`fascicle export`: a muscle or bundle for other programs, and as a page."""

from pathlib import Path
from typing import Any, NamedTuple

import fascicle as fs

from .. import export as exports
from ..files import scenarios
from ..io import atomic
from . import options
from .errors import UserError, user_errors
from .inputs import is_path, read_bundle, read_list, read_scenario, read_target
from .options import Text, flag, option, with_options
from .outputs import Outputs, check_file, replace_output, write_text
from .terminal import print_line, status


_ENDINGS = {"--fmu": [".fmu"], "--page": [".html", ".htm"], "--opensim": [".xml"]}
_ENDINGS |= {"--structured-text": [".st"]}


class JointSides(NamedTuple):
    """Options of a joint that two muscles or bundles pull in opposite directions."""

    moment_arm: Text = option(
        "For --table: a joint that two of FILE pull, its arm (50mm).", "VALUE"
    )
    strain: Text = option("Contraction of both sides of the joint at the angle 0.", "VALUE")
    antagonist: Text = option("Antagonist of the joint, if it isn't like FILE.", "FILE")


@with_options("joint", JointSides)
def export(
    joint: JointSides,
    file: options.Target,
    units: options.Units = None,
    table: Text = option("Folder for force, volume and inverse as a table in C.", "FOLDER"),
    fmu: Text = option("Functional mock-up unit (.fmu) for co-simulation by FMI 2.0.", "PATH"),
    plant: bool = flag("For --fmu: the scenario's plant, to be commanded by the host.", "--plant"),
    page: Text = option("Web page (.html) that draws FILE offline, in any browser.", "PATH"),
    values: Text = option("Force, volume and deflection: .csv, .json or .nc.", "PATH"),
    opensim: Text = option("OpenSim's McKibbenActuator (.xml), without the bladder.", "PATH"),
    structured_text: Text = option("Function block (.st) of a muscle's table for a PLC.", "PATH"),
    pressure: Text = option(
        "Pressures of --page and --values, or up to which --opensim and --structured-text go:"
        " a list or range.",
        "LIST",
        "--pressure -p",
    ),
    precision: str = option("Number type of the table.", "double|float", default="double"),
    name: str = option("Prefix of file names and of names in code.", default="muscle"),
    sample_time: Text = option("Step of the FMU; default: 1 ms, or the scenario's.", "TIME"),
    platform: Text = option(
        "Platform of the FMU's binary; default: this machine's. MinGW builds win64 elsewhere.",
        "linux64|darwin64|win64",
    ),
    overwrite: options.Overwrite = False,
) -> None:
    """Write a muscle or bundle as C code, an FMU, Structured Text or a web page.

    `--table` writes a table of force and volume, and reports its error; for a scenario with force
    control as FILE it adds one step of the controller. It has the inverse, `NAME_pressures`: the
    pressures for a force and a strain, as `fascicle recruit` chooses, or with `--moment-arm` those
    for a joint's torque and stiffness. `--fmu` packs that table for Simulink, OpenModelica and
    other hosts; without a C compiler for the platform it holds sources only. With `--plant` it is
    a scenario's plant instead, whose valves the host commands. `--page` writes one file with
    sliders for pressure and contraction, which needs neither fascicle nor a network. Later changes
    of FILE don't change what was exported.
    """
    of_muscle = {"--values": values, "--opensim": opensim, "--structured-text": structured_text}
    outputs = {"--fmu": fmu, "--page": page, **of_muscle}
    _check_outputs(table, outputs, pressure, overwrite)
    if plant and (fmu is None or table or page or any(of_muscle.values())):
        raise UserError("--plant: a scenario's plant is written as a unit: give --fmu alone.")
    target = _read_exported(file, units, page is not None, plant)
    is_table = table is not None and not any(outputs.values())
    tabulated = _as_joint(target, joint, is_table) if any(joint) else target
    from ..export.c_files import check_c_name

    if not isinstance(target, fs.Muscle):
        for option_name in (key for key, path in of_muscle.items() if path):
            raise UserError(f"{option_name}: {file} is a bundle: export each of its muscles.")
    with user_errors():
        check_c_name(name)
    code = [Path(table or "") / f"{name}{suffix}" for suffix in (".h", ".c")]
    if table is not None:
        with user_errors("--table "):
            atomic.check_writable(table, folder=True)
        for path in code if Path(table).is_dir() else ():
            check_file("--table", path, overwrite)
    pressures = None if pressure is None else read_list(pressure, "pressure", "--pressure")
    if values is not None:
        result = Outputs(out=values, overwrite=overwrite)
        with status("computing the table"), user_errors():
            variables = fs.tables.muscle_table(target, pressures)
        result.write(variables, lambda: None, title=f"Table of {file}")
    highest = max(pressures or (), default=None)
    writers = {
        "--opensim": lambda: exports.opensim_element(target, name, highest),
        "--structured-text": lambda: exports.function_block(target, name, precision, highest),
        "--page": lambda: exports.page_text(target, Path(file).stem, *filter(None, [pressures])),
    }
    for option_name, make_text in writers.items():
        if path := outputs[option_name]:
            with status("computing the table"), user_errors(f"{option_name}: "):
                text = make_text()
            write_text(option_name, path, overwrite, text)
            print_line(f"wrote {path}")
    if table is not None:
        with status("computing the table"), user_errors():
            tables = exports.tabulate(tabulated, precision)
            texts = tables.code(name)

        def fill(draft: Path) -> None:
            for path, text in zip(code, texts, strict=True):
                atomic.check_overwrite(path, overwrite)  # again: it may have appeared
                (draft / path.name).write_text(text, encoding="utf-8", newline="\n")

        with user_errors("--table "):
            atomic.write_folder(table, fill, overwrite=True)  # other files of the folder stay
        print_line(f"wrote {code[0]} and {code[1]}")
        print_line(tables.errors)
    if fmu is not None:
        _write_fmu(fmu, target, name, sample_time, platform, overwrite)


def _check_outputs(
    table: str | None, files: dict[str, str | None], pressure: str | None, overwrite: bool
) -> None:
    """Refuse outputs that can't be written, or lack their pressures, before the work begins."""
    written = {name: path for name, path in files.items() if path is not None}
    if table is None and not written:
        names = ", ".join(files)
        raise UserError(f"nothing to write: give --table and a folder, or one of {names}.")
    needy = [name for name in ("--opensim", "--values") if name in written]
    if pressure is not None and written.keys() <= {"--fmu"}:
        names = ", ".join(name for name in files if name != "--fmu")
        raise UserError(f"--pressure: it is of {names}: give one of them, too.")
    if pressure is None and needy:
        raise UserError(f"{needy[0]}: give --pressure, too, such as 0kPa:400kPa:5kPa.")
    for name, path in written.items():
        if name in _ENDINGS:
            check_file(name, path, overwrite, _ENDINGS[name])


def _read_exported(file: str, units: str | None, page: bool, plant: bool) -> Any:
    """Read a muscle, a bundle, or a scenario's controller, which a `page` can't show; the scenario
    itself if its `plant` is asked for.
    """
    from ..files.muscle_files import read_file

    with user_errors():
        is_scenario = "load" in read_file(Path(file)) if is_path(file) else file in scenarios()
    if plant and not is_scenario:
        raise UserError(f"--plant: {file} is no scenario: give one, or drop --plant.")
    if not is_scenario:
        return read_target(file) if units is None else read_bundle(file, units)
    if units is not None:
        raise UserError(f"--units: {file} is a scenario, which has its motor units.")
    if page:
        raise UserError(f"--page: {file} is a scenario, a page is of a bundle: give --table.")
    scenario = read_scenario(file)
    if plant:
        return scenario
    if scenario.control:
        from ..report.words import notes

        for note in notes(scenario.control.findings):
            print_line(f"note: {note}")
        return scenario.control.controller
    from ..export.controller import single_bundle

    with user_errors():
        return single_bundle(scenario.plant)


def _as_joint(target: Any, joint: JointSides, is_table: bool) -> "fs.Joint":
    """A joint of `target` and of its antagonist; `is_table`: that its table alone is written."""
    if joint.moment_arm is None:
        raise UserError("--strain and --antagonist are of a joint: give --moment-arm, too.")
    if not is_table:
        raise UserError("--moment-arm: a joint is written as a table: give --table alone.")
    other = target if joint.antagonist is None else read_target(joint.antagonist)
    with user_errors():
        return fs.Joint(target, other, joint.moment_arm, joint.strain or 0.0)


def _write_fmu(
    fmu: str, target: Any, name: str, sample_time: Text, platform: Text, overwrite: bool
) -> None:
    """Write a unit for co-simulation; without a compiler its sources, and an error."""
    from ..export.fmu import UnbuiltUnitError  # needs JAX, a table doesn't
    from ..files.scenario import Scenario

    message = ""
    with status("computing the table, building the unit"), replace_output("", fmu, overwrite) as x:
        try:
            if isinstance(target, Scenario):
                dt = target.dt if sample_time is None else sample_time
                exports.write_plant_fmu(target.plant, x, name, target.start, dt, platform)
            else:
                exports.write_fmu(target, x, name, sample_time, platform)
        except UnbuiltUnitError as error:
            message = f"{error}"
    if message:
        raise UserError(f"--fmu {fmu}: {message}; the file holds sources only.")
    print_line(f"wrote {fmu}")


COMMANDS = {"export": export}
