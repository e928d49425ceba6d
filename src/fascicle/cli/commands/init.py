"""`fascicle init`: a commented muscle, task or scenario file to begin with."""

from importlib.resources import files
from math import degrees
from string import Template

from ...bundle.schemes import format_names
from .. import options
from ..errors import UserError, user_errors
from ..options import argument, complete_target, flag, option
from ..outputs import check_file, print_line, replace_output, status, write_text


_LIFTS = {"air": "lift_gas", "oil": "lift_oil"}  # scenarios that are templates, by fluid


def _fluids(incomplete: str) -> list[str]:
    return [name for name in _LIFTS if name.startswith(incomplete)]


def run(
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
    from ...files import example_text, scenarios

    if protractor is not None:
        _write_protractor(protractor, overwrite)
        if path is None and sleeve is None:
            return
    if (sleeve is None) != (tube is None):
        raise UserError("--sleeve and --tube: give both, or none of them.")
    if sleeve is not None and (task or scenario or example is not None):
        raise UserError("--sleeve: makes a muscle: drop --task, --scenario and --from.")

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
            from ...core.validation import check_choice  # imports NumPy

            fluid = check_choice(fluid or "air", _LIFTS, "--fluid")
        example = example or _LIFTS[fluid]
        if example not in scenarios():
            names = ", ".join(scenarios())
            raise UserError(f"--from {example}: not a scenario: choose one of {names}.")
    with user_errors():
        text = example_text(example) if example else template(kind)
        if sleeve is not None and tube is not None:
            text = _with_product(text, sleeve, tube)
    write_text("", path, overwrite, text)
    is_scenario = scenario or example in scenarios()
    command = "design" if task else "simulate" if is_scenario else "free-strain"
    print_line(f"wrote {path}: edit it, then run `fascicle {command} {path}`")


def _write_protractor(path: str, overwrite: bool) -> None:
    """Write the strip that measures a braid angle."""
    check_file("--protractor", path, overwrite, [".svg", ".pdf", ".png"])
    from ...plot import to_bytes
    from ...plot.protractor import protractor

    with replace_output("--protractor", path, overwrite) as draft:
        draft.write_bytes(to_bytes(protractor(), draft.suffix.lower()[1:]))
    print_line(f"wrote {path}: print it at 100 %")


def _with_product(text: str, sleeve: str, tube: str) -> str:
    """Template of a muscle with the sizes of a `sleeve` on a `tube`."""
    from ...muscle.products import sleeve_angle
    from ...units import parse

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
            from ...core.validation import NEUTRAL_ANGLE
            from ...muscle import LAWS
            from ...muscle.materials import MATERIALS

        values["angle"] = f"{degrees(NEUTRAL_ANGLE):.1f}"
        for law, names in {"material": MATERIALS, **LAWS}.items():
            key = "law" if law == "collapse" else law  # it has a table
            first, *alternatives = (f'"{name}"' for name in names)
            values[law] = f"{key} = {first}".ljust(33) + "# or " + ", ".join(alternatives)
    text = (files("fascicle.cli") / "templates" / f"{kind}.toml").read_text(encoding="utf-8")
    return Template(text).substitute(values, schemes=format_names('"', 1))
