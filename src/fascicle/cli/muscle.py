"""Commands of one muscle: `force`, `free-strain`, `muscles`, `laws` and `init`."""

import inspect
import json
import sys
import textwrap
from importlib.resources import files
from math import degrees
from string import Template
from typing import TYPE_CHECKING, Any

from ..bundle.schemes import format_names
from ..io.sanitize import sanitize_line
from . import options
from .bundle import check_equilibria, print_states
from .errors import UserError, user_errors
from .inputs import (
    check_grid,
    is_bundle,
    load_laws,
    read_list,
    read_muscle,
    read_states,
    read_target,
)
from .options import argument, complete_target, flag, option, with_options
from .outputs import (
    Outputs,
    check_file,
    count_decimals,
    number,
    print_line,
    print_table,
    print_text,
    replace_output,
    status,
    write_text,
)


if TYPE_CHECKING:
    from ..muscle.law import AbstractLaw

_LIFTS = {"air": "lift_gas", "oil": "lift_oil"}  # scenarios that are templates, by fluid
_WIDTH = 74  # characters of a line of constants: with the indent, a terminal's 80
# marks in the table of the result's regions 0 to 3, and what they mean
_MARKS = (" ", "b", "c", "s")
_MEANINGS = {
    "b": "buckled, past the free strain",
    "c": "collapsed: folded at a hinge",
    "s": "straight, and compressed",
}


@with_options("outputs", Outputs)
def force(
    outputs: Outputs,
    file: str = options.TARGET,
    pressure: str = options.PRESSURE,
    strain: str = options.STRAIN,
) -> None:
    """Compute a muscle's force over pressure and contraction."""
    pressures = read_list(pressure, "pressure", "--pressure")
    strains = read_list(strain, "strain", "--strain")
    check_grid(len(pressures), len(strains))
    muscle = read_muscle(file, "use `fascicle bundle`")
    from ..results.tables import muscle_force

    with status("computing forces"), user_errors():
        variables = muscle_force(muscle, pressures, strains)
        blocked = float(muscle.blocked_force(max(pressures)))

    def figure() -> Any:
        from ..plot.curves import force_strain, smooth

        return force_strain(muscle, sorted(set(pressures)), smooth(strains))

    title = f"Force of {file}"
    outputs.write(variables, lambda: _print_forces(variables, blocked), figure, title=title)


def _print_forces(variables: Any, blocked: float) -> None:
    values = {name: variable.values.tolist() for name, variable in variables.items()}
    labels = [f"{pressure / 1e3:.6g} kPa" for pressure in values["pressure"]]
    highest = values["pressure"].index(max(values["pressure"]))
    free, collapse = (number(values[f"{x}_strain"][highest], 4) for x in ("free", "collapse"))
    print_text(
        f"At {labels[highest]}: blocked force {blocked:.4g} N, free strain {free}, "
        + ("no collapse." if collapse == "-" else f"collapse strain {collapse}.")
    )
    print_text(
        "Positive forces pull. Past the free strain the muscle pushes: its force is negative."
    )
    decimals = count_decimals(variables["force"].values.ravel())
    cells = [
        [f"{number(x, decimals)}{_MARKS[region]}" for x, region in zip(*column, strict=True)]
        for column in zip(values["force"], values["region"], strict=True)
    ]
    rows = [[f"{strain:.6g}", *row] for strain, *row in zip(values["strain"], *cells, strict=True)]
    marks = {_MARKS[region] for regions in values["region"] for region in regions}
    caption = "; ".join(f"{mark}: {text}" for mark, text in _MEANINGS.items() if mark in marks)
    print_table("Force [N]", ["strain [-]", *labels], rows, caption)
    rows = [
        [label, *(number(strain, 4) for strain in values[f"{label}_strain"])]
        for label in ("free", "collapse")
    ]
    print_table("Free strain and collapse strain [-]", ["", *labels], rows)


@with_options("outputs", Outputs)
def free_strain(
    outputs: Outputs,
    file: str = options.TARGET,
    pressure: list[str] | None = option(
        "Gauge pressures: a list or range for a muscle; for a bundle one value or range per motor"
        " unit (344.7kPa,0kPa); repeat for more.",
        "--pressure -p",
        metavar="LIST",
    ),
    no_resistance: bool = options.NO_RESISTANCE,
) -> None:
    """Compute the free strain of a muscle or a bundle.

    The free strain is the contraction without load. The table adds a muscle's blocked force and
    collapse strain, or all equilibria of a bundle.
    """
    target = read_target(file)
    from ..results.tables import bundle_equilibria, muscle_free_strain

    if is_bundle(target):
        pressures = read_states(pressure, target)
        units = len(pressures[0])
        check_grid(len(pressures), units, units)
        with status("finding equilibria"), user_errors():
            variables = bundle_equilibria(target, pressures, not no_resistance)
    elif no_resistance:
        raise UserError("--no-resistance: only a bundle's muscles resist: drop it for a muscle.")
    else:
        text = ",".join(pressure or [options.DEFAULT_PRESSURE])
        pressures = read_list(text, "pressure", "--pressure")
        with status("finding free strains"), user_errors():
            variables = muscle_free_strain(target, pressures)

    def figure() -> Any:
        import numpy as np

        from ..plot.curves import free_strain_states

        strains = variables["free_strain"].values
        return free_strain_states(target, np.array(pressures), strains, not no_resistance)

    table = print_states if is_bundle(target) else _print_free_strains
    outputs.write(variables, lambda: table(variables), figure, title=f"Free strain of {file}")
    check_equilibria(variables)


def _print_free_strains(variables: Any) -> None:
    columns = [[f"{pressure / 1e3:.6g}" for pressure in variables["pressure"].values.tolist()]]
    highest = variables["pressure"].values.argmax()
    free, blocked = (variables[x].values[highest] for x in ("free_strain", "blocked_force"))
    print_text(
        f"At {columns[0][highest]} kPa: free strain {free:.4f}, blocked force {blocked:.4g} N."
    )
    for name in [*variables][1:]:
        values = variables[name].values.tolist()
        decimals = 4 if name.endswith("strain") else count_decimals(values)
        columns.append([number(value, decimals) for value in values])
    heads = ["pressure [kPa]", "free strain [-]", "blocked force [N]", "collapse strain [-]"]
    rows = [*zip(*columns, strict=True)]
    title = "Free strain, blocked force and collapse"
    print_table(title, [*heads, "collapse moment [N·m]"], rows)


def muscles(
    name: str | None = argument(
        "NAME", "Example or measured muscle to print.", None, autocompletion=complete_target
    ),
    measured: bool = flag("Measured muscles, with ranges and errors of their fits.", "--measured"),
    as_json: bool = options.JSON,
) -> None:
    """List example or measured muscles, or print the file of one."""
    from ..files import example_text, examples

    if name is not None:
        if measured:
            raise UserError("NAME and --measured: a name prints one muscle, drop one of them.")
        with user_errors():
            text = example_text(name)
        sys.stdout.write(json.dumps({"name": name, "toml": text}) + "\n" if as_json else text)
    elif measured:
        _print_measured(as_json)
    elif as_json:
        print(json.dumps(examples()))
    else:
        for example, description in examples().items():
            print(f"{example:24}{description}")


def _print_measured(as_json: bool) -> None:
    load_laws()
    from ..files import catalog

    entries = list(catalog.values())
    if as_json:
        print(json.dumps({entry.name: entry.as_dict() for entry in entries}))
        return
    rows = []
    for entry in entries:
        pressure, strain = (ends and ends[1] for ends in entry.range)
        columns = {
            "length [mm]": (float(entry.muscle.length), 1e3, 1),
            "outer diameter [mm]": (2 * float(entry.muscle.outer_radius), 1e3, 1),
            "pressure [kPa]": (pressure, 1e-3, 0),
            "contraction [%]": (strain, 100, 1),
            "error [N]": (entry.error.rmse, 1, 2),
            "error [%]": (entry.error.relative_rmse, 100, 2),
        }
        row = {
            "name": entry.name,
            **{
                head: "-" if x is None else number(factor * x, digits)
                for head, (x, factor, digits) in columns.items()
            },
            "basis": entry.basis,
            "license": entry.license.partition(";")[0],
        }
        rows.append(row)
    caption = (
        "pressure, contraction: largest measured values; error: root mean square, in N and in % of"
        " the largest force; basis: whose fit it is, published or of `fascicle calibrate` (fit); -:"
        " not published. Every command takes a muscle by its name; `fascicle muscles NAME` prints"
        " it with its source."
    )
    print_table("Measured muscles", [*rows[0]], [[*row.values()] for row in rows], caption)


def laws(
    kind: str | None = argument(
        "KIND",
        "Kind of law (tension, buckling, collapse, post_collapse or ends), or a law's name, for its"
        " equation, constants, source and domain; default: all laws.",
        None,
    ),
    as_json: bool = options.JSON,
) -> None:
    """List the laws and their constants, including those of other packages, or explain one."""
    load_laws()
    from ..core.validation import check_choice
    from ..muscle.law import package_of
    from ..muscle.laws import LAWS

    asked = "" if kind is None or kind in LAWS else kind  # one law, by its name
    kinds = [name for name in LAWS if kind in (None, name)]
    laws = [(name, law) for name in kinds for law in LAWS[name].values()]
    if asked:
        laws = [(name, by_name[asked]) for name, by_name in LAWS.items() if asked in by_name]
        with user_errors():
            names = {name for by_name in LAWS.values() for name in by_name.shipped}
            check_choice(asked, [*LAWS, *sorted(names | {law.name for _, law in laws})], "kind")
    entries = [
        {
            "kind": name,
            "law": law.name,
            "constants": [x.name for x in (*law.constants(), *law.switches())],
            "source": law.source,
            "package": package_of(law),
        }
        for name, law in laws
    ]
    if as_json:
        print(json.dumps(entries))
        return
    if asked:
        for name, law in laws:
            _print_law(name, law)
        return
    for name in kinds:
        print(f"{name} laws, default: {LAWS[name].default.name}")
        for entry in (entry for entry in entries if entry["kind"] == name):
            package = "" if entry["package"] == "fascicle" else f" [{entry['package']}]"
            source = sanitize_line(f"{entry['source']}{package}")
            print(f"  {sanitize_line(entry['law']):20}{source}")
            for line in textwrap.wrap(", ".join(entry["constants"]), _WIDTH):
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


def _fluids(incomplete: str) -> list[str]:
    return [name for name in _LIFTS if name.startswith(incomplete)]


def init(
    path: str | None = argument(
        "FILE", "File to write; default: muscle.toml, task.toml or scenario.toml.", None
    ),
    example: str | None = option(
        "Named example to copy instead of the template.",
        "--from",
        metavar="NAME",
        autocompletion=complete_target,
    ),
    task: bool = flag("Task file for `fascicle design`.", "--task"),
    mass: str | None = option("Mass that a task lifts: 25kg.", metavar="MASS"),
    stroke: str | None = option("Stroke that a task lifts it by: 40mm.", metavar="LENGTH"),
    scenario: bool = flag("Scenario file for `fascicle simulate`.", "--scenario"),
    fluid: str | None = option(
        "Fluid of a scenario: air or oil; default: air.", metavar="NAME", autocompletion=_fluids
    ),
    sleeve: str | None = option(
        "Sleeve's nominal diameter and its angle there: '12 mm at 40 deg'; without an angle 30 deg"
        " is assumed.",
        metavar="SIZE",
    ),
    tube: str | None = option(
        "Tube's outer and inner diameter: '9 mm x 7 mm', or '9x7 mm'.", metavar="SIZES"
    ),
    protractor: str | None = option(
        "Strip to print (.svg, .pdf) that measures a braid angle on the tube.", metavar="PATH"
    ),
    overwrite: bool = options.OVERWRITE,
) -> None:
    """Write a commented muscle, task or scenario file to edit."""
    from ..files import example_text, scenarios

    if protractor is not None:
        _write_protractor(protractor, overwrite)
        if path is None and sleeve is None:
            return
    if (sleeve is None) != (tube is None):
        raise UserError("--sleeve and --tube: give both, or none of them.")
    if sleeve is not None and (task or scenario or example is not None):
        raise UserError("--sleeve: makes a muscle: drop --task, --scenario and --from.")

    if (mass is None) != (stroke is None) or (mass is not None and not task):
        raise UserError("--mass and --stroke: give both, with --task.")
    if task and example is not None:
        raise UserError("--task and --from: a task has no example to copy, drop one.")
    if task and scenario:
        raise UserError("--task and --scenario: only one file is written, drop one.")
    if fluid is not None and (not scenario or example is not None):
        raise UserError("--fluid: chooses the template of a scenario: add --scenario, drop --from.")
    kind = "task" if task else "scenario" if scenario else "muscle"
    path = path or f"{kind}.toml"
    check_file("", path, overwrite)
    if scenario:
        with user_errors():
            from ..core.validation import check_choice  # imports NumPy

            fluid = check_choice(fluid or "air", _LIFTS, "--fluid")
        example = example or _LIFTS[fluid]
        if example not in scenarios():
            names = ", ".join(scenarios())
            raise UserError(f"--from {example}: not a scenario: choose one of {names}.")
    with user_errors():
        text = example_text(example) if example else template(kind)
        if sleeve is not None and tube is not None:
            text = _with_product(text, sleeve, tube)
        if mass is not None and stroke is not None:
            text = _with_load(text, mass, stroke)
    write_text("", path, overwrite, text)
    is_scenario = scenario or example in scenarios()
    command = "design" if task else "simulate" if is_scenario else "free-strain"
    print_line(f"wrote {path}: edit it, then run `fascicle {command} {path}`")


def _with_load(text: str, mass: str, stroke: str) -> str:
    """Template of a task with the weight of a `mass`, lifted by a `stroke`, as its load case."""
    from ..design.summary import STANDARD_GRAVITY
    from ..units import parse

    weight = parse(mass, "mass", "--mass") * STANDARD_GRAVITY
    travel = 1e3 * parse(stroke, "length", "--stroke")
    load = f'force = "{weight:.6g} N"\nstroke = "{travel:.6g} mm"'
    lines = text.splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("example = "))
    return "\n".join([*lines[:first], f'name = "lift"\n{load}', *lines[first + 2 :]]) + "\n"


def _write_protractor(path: str, overwrite: bool) -> None:
    """Write the strip that measures a braid angle."""
    check_file("--protractor", path, overwrite, [".svg", ".pdf", ".png"])
    from ..plot import to_bytes
    from ..plot.protractor import protractor

    with replace_output("--protractor", path, overwrite) as draft:
        draft.write_bytes(to_bytes(protractor(), draft.suffix.lower()[1:]))
    print_line(f"wrote {path}: print it at 100 %")


def _with_product(text: str, sleeve: str, tube: str) -> str:
    """Template of a muscle with the sizes of a `sleeve` on a `tube`."""
    from ..muscle.products import sleeve_angle
    from ..units import parse

    size, _, angle = sleeve.partition("at")
    sizes = [entry.strip() for entry in tube.replace("×", "x").split("x")]
    if len(sizes) != 2:
        raise UserError("--tube: give the outer and the inner diameter, such as '9 mm x 7 mm'.")
    if sizes[0].replace(".", "").isdigit():  # one unit for both
        sizes[0] += sizes[1].lstrip("0123456789. ")
    outer, inner = (parse(entry, "length", "--tube") for entry in sizes)
    if not inner < outer:
        raise UserError(f"--tube {tube!r}: the inner diameter must be below the outer one.")
    nominal = parse(size.strip(), "length", "--sleeve")
    at_nominal = parse(angle.strip() or "30 deg", "angle", "--sleeve")
    on_tube = float(sleeve_angle(nominal, at_nominal, outer))
    assumed = "" if angle else "; 30 deg at the nominal diameter is assumed: measure it"
    sizes_of = {
        "outer_radius": (f"{500 * outer:.6g} mm", "of the tube"),
        "wall_thickness": (f"{500 * (outer - inner):.6g} mm", "of the tube"),
        "braid_angle": (f"{degrees(on_tube):.2f} deg", f"of the sleeve on the tube{assumed}"),
    }
    lines = text.splitlines()
    for i, line in enumerate(lines):
        key = line.partition(" = ")[0]
        if key in sizes_of:
            value, comment = sizes_of[key]
            lines[i] = f'{key} = "{value}"'.ljust(33) + f"# {comment}"
    return "\n".join(lines) + "\n"


def template(kind: str) -> str:
    """Text of the commented file of a kind, "muscle" or "task"."""
    values = {}
    if kind == "muscle":
        with status("loading the laws"):
            from ..core.validation import NEUTRAL_ANGLE
            from ..muscle import LAWS
            from ..muscle.materials import MATERIALS

        values["angle"] = f"{degrees(NEUTRAL_ANGLE):.1f}"
        for law, names in {"material": MATERIALS, **LAWS}.items():
            key = "law" if law == "collapse" else law  # it has a table
            first, *alternatives = (f'"{name}"' for name in names)
            values[law] = f"{key} = {first}".ljust(33) + "# or " + ", ".join(alternatives)
    text = (files("fascicle.cli") / "templates" / f"{kind}.toml").read_text(encoding="utf-8")
    return Template(text).substitute(values, schemes=format_names('"', 1))


COMMANDS = {
    "force": force,
    "free-strain": free_strain,
    "muscles": muscles,
    "laws": laws,
    "init": init,
}
