"""Commands of one muscle: `force`, `free-strain`, `muscles`, `laws` and `init`."""

import inspect
import json
import re
import sys
import textwrap
import tomllib
from collections.abc import Mapping
from importlib import resources
from math import degrees, pi, sqrt
from string import Template
from typing import TYPE_CHECKING, Any

import fascicle as fs

from .. import files, results
from ..bundle.schemes import format_names
from ..io.sanitize import sanitize_line
from ..units import parse
from . import options
from .bundle import check_equilibria, print_states
from .errors import UserError, user_errors
from .inputs import check_grid, load_laws, read_list, read_muscle, read_states, read_target
from .options import Text, argument, complete_target, flag, option, with_options
from .outputs import Outputs, check_file, write_picture, write_text
from .terminal import count_decimals, grid, kpa, number, print_line, print_table, print_text, status


if TYPE_CHECKING:
    from ..muscle.law import AbstractLaw

_LIFTS = {"air": "lift_gas", "oil": "lift_oil"}  # scenarios that are templates, by fluid
_WIDTH = 74  # characters of a line of constants: with the indent, a terminal's 80
# marks in the table of the result's regions 0 to 3, and what they mean
_MARKS = (" ", "b", "c", "s")
_MEANINGS = {
    "b": "buckled, past the free strain: it pushes",
    "c": "collapsed: folded at a hinge",
    "s": "straight, and compressed",
}


@with_options("outputs", Outputs)
def force(
    outputs: Outputs,
    file: options.Target,
    pressure: options.Pressure = options.DEFAULT_PRESSURE,
    strain: options.Strain = options.DEFAULT_STRAIN,
) -> None:
    """Compute a muscle's force over pressure and contraction."""
    pressures = read_list(pressure, "pressure", "--pressure")
    strains = read_list(strain, "strain", "--strain")
    check_grid(len(pressures), len(strains))
    muscle = read_muscle(file, "use `fascicle bundle`")
    with status("computing forces"), user_errors():
        variables = fs.tables.muscle_force(muscle, pressures, strains)
        blocked = float(muscle.blocked_force(max(pressures)))

    def figure() -> Any:
        curves = fs.plot.curves
        return curves.force_strain(muscle, sorted(set(pressures)), curves.smooth(strains))

    title = f"Force of {file}"
    outputs.write(variables, lambda: _print_forces(variables, blocked), figure, title=title)


def _print_forces(variables: "Mapping[str, results.Variable]", blocked: float) -> None:
    pressures = variables["pressure"].values.tolist()
    labels, regions = [f"{kpa(P)} kPa" for P in pressures], variables["region"].values.T
    print_text(
        f"Blocked force at {kpa(max(pressures))} kPa: {blocked:.4g} N. Positive forces pull."
    )
    rows, forces = [], grid(variables["force"].values.T)
    for strain, *pairs in zip(variables["strain"].values, forces, regions, strict=True):
        cells = [f"{force}{_MARKS[region]}" for force, region in zip(*pairs, strict=True)]
        rows.append([f"{strain:.6g}", *cells])
    marks = {_MARKS[region] for region in regions.ravel()}
    caption = "; ".join(f"{mark}: {text}" for mark, text in _MEANINGS.items() if mark in marks)
    print_table("Force [N]", ["strain [-]", *labels], rows, caption)
    rows = [
        [end, *(number(strain, 4) for strain in variables[f"{end}_strain"].values)]
        for end in ("free", "collapse")
    ]
    print_table("Free strain and collapse strain [-]", ["", *labels], rows)


@with_options("outputs", Outputs)
def free_strain(
    outputs: Outputs,
    file: options.Target,
    pressure: options.Pressures = None,
    no_resistance: options.NoResistance = False,
) -> None:
    """Compute the free strain of a muscle or a bundle.

    The free strain is the contraction without load. The table adds a muscle's blocked force and
    collapse strain, or all equilibria of a bundle.
    """
    target = read_target(file)
    if is_bundle := isinstance(target, fs.Bundle):
        pressures = read_states(pressure, target)
        units = len(pressures[0])
        check_grid(len(pressures), units, units)
        with status("finding equilibria"), user_errors():
            variables = fs.tables.bundle_equilibria(target, pressures, not no_resistance)
    elif no_resistance:
        raise UserError("--no-resistance: only a bundle's muscles resist: drop it for a muscle.")
    else:
        text = ",".join(pressure or [options.DEFAULT_PRESSURE])
        pressures = read_list(text, "pressure", "--pressure")
        with status("finding free strains"), user_errors():
            variables = fs.tables.muscle_free_strain(target, pressures)

    def figure() -> Any:
        P = variables["pressures" if is_bundle else "pressure"].values
        strains = variables["free_strain"].values
        return fs.plot.curves.free_strain_states(target, P, strains, not no_resistance)

    table = print_states if is_bundle else _print_free_strains
    outputs.write(variables, lambda: table(variables), figure, title=f"Free strain of {file}")
    check_equilibria(variables)


def _print_free_strains(variables: "Mapping[str, results.Variable]") -> None:
    values = {name: variable.values for name, variable in variables.items()}
    columns = [[kpa(pressure) for pressure in values.pop("pressure")]]
    for name, column in values.items():
        decimals = 4 if name.endswith("strain") else count_decimals(column)
        columns.append([number(value, decimals) for value in column])
    heads = ["pressure [kPa]", "free strain [-]", "blocked force [N]", "collapse strain [-]"]
    title = "Free strain, blocked force and collapse"
    print_table(title, [*heads, "collapse moment [N·m]"], [*zip(*columns, strict=True)])


def muscles(
    name: Text = argument("NAME", "One to print.", None, autocompletion=complete_target),
    measured: bool = flag("Measured muscles, with ranges and errors of their fits.", "--measured"),
    as_json: options.Json = False,
) -> None:
    """List example or measured muscles, or print the file of one."""
    if name is not None:
        if measured:
            raise UserError("NAME and --measured: a name prints one muscle, drop one of them.")
        with user_errors():
            text = files.example_text(name)
        sys.stdout.write(json.dumps({"name": name, "toml": text}) + "\n" if as_json else text)
    elif measured:
        _print_measured(as_json)
    elif as_json:
        print(json.dumps(files.examples()))
    else:
        for example, description in files.examples().items():
            print(f"{example:24}{description}")


def _print_measured(as_json: bool) -> None:
    load_laws()
    if as_json:
        print(json.dumps({name: entry.as_dict() for name, entry in fs.catalog.items()}))
        return
    columns = {  # factors and decimals
        "length [mm]": (1e3, 1), "outer diameter [mm]": (2e3, 1), "pressure [kPa]": (1e-3, 0),
        "contraction [%]": (100, 1), "error [N]": (1, 2), "error [%]": (100, 2),
    }  # fmt: skip
    rows = []
    for entry in fs.catalog.values():
        limits = [ends and ends[1] for ends in entry.range]
        muscle, error = entry.muscle, entry.error
        numbers = (muscle.length, muscle.outer_radius, *limits, error.rmse, error.relative_rmse)
        texts = [
            "-" if x is None else number(factor * float(x), decimals)
            for x, (factor, decimals) in zip(numbers, columns.values(), strict=True)
        ]
        readings = "-" if entry.record is None else str(entry.record.force.size)
        rows.append([entry.name, *texts, readings, entry.basis, entry.license.partition(";")[0]])
    caption = (
        "pressure, contraction: largest measured values; error: root mean square, in N and in % of"
        " the largest force; readings: how many the entry holds; basis: whose fit it is, published"
        " or of `fascicle calibrate` (fit); -: not published. Every command takes a muscle by its"
        " name; `fascicle muscles NAME` prints it with its source."
    )
    heads = ["name", *columns, "readings", "basis", "license"]
    print_table("Measured muscles", heads, rows, caption)


def laws(
    kind: Text = argument(
        "KIND",
        "Kind of law (tension, buckling, collapse, post_collapse or ends), or a law's name, for its"
        " equation, constants, source and domain; default: all laws.",
        None,
    ),
    as_json: options.Json = False,
) -> None:
    """List the laws and their constants, including those of other packages, or explain one."""
    load_laws()
    from ..core.validation import check_choice
    from ..muscle.law import package_of
    from ..muscle.laws import LAWS

    laws = [(name, law) for name, by_name in LAWS.items() for law in by_name.values()]
    if kind is not None:
        with user_errors():
            check_choice(kind, {*LAWS, *(law.name for _, law in laws)}, "kind")
        laws = [(name, law) for name, law in laws if kind in (name, law.name)]
    constants = {law: [x.name for x in (*law.constants(), *law.switches())] for _, law in laws}
    if as_json:
        keys = ("kind", "law", "constants", "source", "package")
        rows = [(x, law.name, constants[law], law.source, package_of(law)) for x, law in laws]
        print(json.dumps([dict(zip(keys, row, strict=True)) for row in rows]))
        return
    printed = ""
    for name, law in laws:
        if kind == law.name:
            _print_law(name, law)
            continue
        if name != printed:
            print(f"{name} laws, default: {LAWS[name].default.name}")
        printed, package = name, package_of(law)
        source = law.source if package == "fascicle" else f"{law.source} [{package}]"
        print(f"  {sanitize_line(law.name):20}{sanitize_line(source)}")
        for line in textwrap.wrap(", ".join(constants[law]), _WIDTH):
            print(f"      {line}")


def _print_law(kind: str, law: "type[AbstractLaw]") -> None:
    """Print a `law` of a `kind`: what it is, its constants with defaults [SI], equation, source."""
    print(f"{kind} law {sanitize_line(law.name)}: {inspect.getdoc(law)}")
    for constant in law.constants():
        default = "required" if constant.default is None else f"default {constant.default:g}"
        print(f"  {constant.name} [{constant.range.unit}], {default}: {constant.about}")
    for switch in law.switches():
        print(f"  {switch.name}, {' or '.join(switch.options)}: {switch.about}")
    print(f"Source: {sanitize_line(law.source)}\n\n{inspect.getdoc(sys.modules[law.__module__])}\n")


def init(
    path: Text = argument("FILE", "File to write; default: muscle.toml, by its kind.", None),
    example: Text = option(
        "Named example to copy.", "NAME", "--from", autocompletion=complete_target
    ),
    task: bool = flag("Task file for `fascicle design`.", "--task"),
    mass: Text = option("Mass that a task lifts: 25kg.", "MASS"),
    stroke: Text = option("Stroke that a task lifts it by: 40mm.", "LENGTH"),
    scenario: bool = flag("Scenario file for `fascicle simulate`.", "--scenario"),
    fluid: Text = option("Fluid of a scenario: air or oil; default: air.", "NAME"),
    sleeve: Text = option("Sleeve's diameter and angle there: '12 mm at 40 deg'.", "SIZE"),
    tube: Text = option("Tube's outer and inner diameter: '9 mm x 7 mm', or '9x7 mm'.", "SIZES"),
    thread: Text = option("Length of one thread of the braid: '277 mm'.", "LENGTH"),
    turns: Text = option("Turns of a thread around the muscle: 1.5.", "NUMBER"),
    length: Text = option("Length at rest between the end fittings: '200 mm'.", "LENGTH"),
    material: Text = option("Material of the tube.", "NAME"),
    protractor: Text = option("Strip (.svg, .pdf) that measures a braid angle on a tube.", "PATH"),
    overwrite: options.Overwrite = False,
) -> None:
    """Write a commented muscle, task or scenario file to edit."""
    values = (sleeve, tube, thread, turns, length, material)
    options = ("--sleeve", "--tube", "--thread", "--turns", "--length", "--material")
    sizes = [option for option, value in zip(options, values, strict=True) if value]
    if protractor is not None:
        check_file("--protractor", protractor, overwrite, [".svg", ".pdf", ".png"])
        from ..plot import protractor as pictures

        write_picture("--protractor", protractor, overwrite, pictures.protractor())
        print_line(f"wrote {protractor}: print it at 100 %")
        if path is None and not sizes:
            return
    other, braid = task or scenario or example, sleeve or thread
    conflicts = {
        "--sleeve: a thread has its own angle: drop --thread.": sleeve and thread,
        "--sleeve: add the --tube that it is on.": sleeve and not tube,
        "--tube: add the --sleeve on it, or a --thread of its braid.": tube and not braid,
        "--thread, --turns and --length: give all three, or no thread.": (
            (thread or turns) and not (thread and turns and length)
        ),
        f"{', '.join(sizes)}: of a muscle: drop --task, --scenario and --from.": sizes and other,
        "--mass and --stroke: give both, with --task.": bool(mass) != bool(stroke),
        "--mass: is lifted by a task: add --task.": mass and not task,
        "--task and --from: a task has no example to copy, drop one.": task and example,
        "--task and --scenario: only one file is written, drop one.": task and scenario,
        "--fluid: chooses a scenario's template: add --scenario.": fluid and not scenario,
        "--fluid and --from: each chooses a scenario, drop one.": fluid and example,
    }
    for message, applies in conflicts.items():
        if applies:
            raise UserError(message)
    kind = "task" if task else "scenario" if scenario else "muscle"
    path = path or f"{kind}.toml"
    check_file("", path, overwrite)
    with user_errors():
        if scenario:
            from ..core.validation import check_choice  # imports NumPy

            example = example or _LIFTS[check_choice(fluid or "air", _LIFTS, "fluid")]
            check_choice(example, files.scenarios(), "example")
        text = files.example_text(example) if example else template(kind, material)
        if sizes:
            text = _with_sizes(text, sleeve, tube, thread, turns, length)
            files.loads(text, f"{' and '.join(sizes)} in {path}")  # they make a muscle
        if mass is not None and stroke is not None:
            text = _with_load(text, mass, stroke)
    write_text("", path, overwrite, text)
    is_scenario = scenario or example in files.scenarios()
    command = "design" if task else "simulate" if is_scenario else "free-strain"
    if braid:
        assumed = {
            "30 deg at the sleeve's nominal diameter": sleeve and "at" not in sleeve,
            "the length": not length,
            "the wall": not tube,
            "the material": not material,
        }
        if texts := [text for text, applies in assumed.items() if applies]:
            print_line(f"assumed: {', '.join(texts)}")
        if sleeve:
            print_line("measure the angle, which decides most: `fascicle init --protractor a.svg`")
    print_line(f"wrote {path}: edit it, then run `fascicle {command} {path}`")


def _with_load(text: str, mass: str, stroke: str) -> str:
    """Template of a task with the weight of a `mass`, lifted by a `stroke`, as its load case, and
    with muscles for it.
    """
    from ..design.summary import STANDARD_GRAVITY

    weight = parse(mass, "mass", "--mass") * STANDARD_GRAVITY
    travel = 1e3 * parse(stroke, "length", "--stroke")
    head, _, remainder = text.partition("example = ")
    _, _, remainder = remainder.partition("# name =")
    load = f'name = "lift"\nforce = "{weight:.6g} N"\nstroke = "{travel:.6g} mm"'
    text = f"{head}{load}\n# name ={remainder}"
    for line in ('reversal_depth = "min"', "envelope = {"):  # of the example's load cases
        text = text.replace(f"\n{line}", f"\n# {line}")
    pressure = parse(tomllib.loads(text)["task"]["supply_pressure"], "pressure")
    radius = 1e3 * sqrt(weight / (pressure * pi))  # of a piston that lifts it
    for name, values in (
        ("radius", (radius, sqrt(2) * radius)),
        ("length", (5 * travel, 7 * travel, 10 * travel)),  # contractions of 20, 14 and 10 %
    ):
        listed = ", ".join(f'"{value:.3g} mm"' for value in values)
        text = re.sub(rf"(?m)^{name} = .*$", f"{name} = [{listed}]", text)
    return text


def _with_sizes(
    text: str, sleeve: Text, tube: Text, thread: Text, turns: Text, length: Text
) -> str:
    """Template of a muscle with sizes of what was bought and counted."""
    from ..muscle.products import sleeve_angle

    lines = {}  # of a file, by the key whose line they replace
    if length:
        lines["length"] = _line("length", parse(length, "length", "--length"), "at rest")
    if thread and turns:
        b, n = parse(thread, "length", "--thread"), parse(turns, "number", "--turns")
        lines["outer_radius"] = _line("thread_length", b, "of one thread of the braid")
        lines["braid_angle"] = f"turns = {n:.6g}".ljust(33) + "# of a thread around the muscle"
    outer, inner = _diameters(tube) if tube else (0.0, 0.0)
    if tube:
        lines["wall_thickness"] = _line("wall_thickness", (outer - inner) / 2, "of the tube")
    if sleeve:
        size, _, angle = sleeve.partition("at")
        nominal = parse(size.strip(), "length", "--sleeve")
        at_nominal = parse(angle.strip() or "30 deg", "angle", "--sleeve")
        with user_errors("--tube: "):
            on_tube = degrees(float(sleeve_angle(nominal, at_nominal, outer)))
        assumed = "" if angle else "; 30 deg at the nominal diameter is assumed: measure it"
        lines["outer_radius"] = _line("outer_radius", outer / 2, "of the tube")
        line = f'braid_angle = "{on_tube:.2f} deg"'.ljust(33)
        lines["braid_angle"] = f"{line}# of the sleeve on the tube{assumed}"
    for key, line in lines.items():
        text = re.sub(rf"(?m)^{key} = .*$", line, text)
    return text


def _line(key: str, value: float, comment: str) -> str:
    """Line of a file with a length [m]."""
    return f'{key} = "{1e3 * value:.6g} mm"'.ljust(33) + f"# {comment}"


def _diameters(tube: str) -> list[float]:
    """Outer and inner diameter of a `tube` [m]."""
    sizes = [entry.strip() for entry in tube.replace("×", "x").split("x")]
    if len(sizes) != 2:
        raise UserError("--tube: give the outer and the inner diameter, such as '9 mm x 7 mm'.")
    if sizes[0].replace(".", "").isdigit():  # one unit for both
        sizes[0] += sizes[1].lstrip("0123456789. ")
    outer, inner = (parse(entry, "length", "--tube") for entry in sizes)
    if not inner < outer:
        raise UserError(f"--tube {tube!r}: the inner diameter must be below the outer one.")
    return [outer, inner]


def template(kind: str, material: Text = None) -> str:
    """Text of the commented file of a kind, "muscle" or "task"; `material`: of the muscle."""
    values = {}
    if kind == "muscle":
        with status("loading the laws"):
            from ..core.validation import NEUTRAL_ANGLE, check_choice
            from ..muscle import LAWS
            from ..muscle.materials import MATERIALS

        values["angle"] = f"{degrees(NEUTRAL_ANGLE):.1f}"
        if material:
            check_choice(material, MATERIALS, "material")
        materials = sorted(MATERIALS, key=lambda name: name != material)  # the chosen one first
        for law, names in {"material": materials, **LAWS}.items():
            key = "law" if law == "collapse" else law  # it has a table
            first, *alternatives = (f'"{name}"' for name in names)
            values[law] = f"{key} = {first}".ljust(33) + "# or " + ", ".join(alternatives)
    path = resources.files("fascicle.cli") / "templates" / f"{kind}.toml"
    values["schemes"] = format_names('"', 1)
    return Template(path.read_text(encoding="utf-8")).substitute(values)


COMMANDS = {x.__name__.replace("_", "-"): x for x in (force, free_strain, muscles, laws, init)}
