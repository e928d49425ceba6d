"""`fascicle init`: a commented muscle, task or scenario file to begin with."""

from importlib.resources import files
from math import degrees
from string import Template

from ...bundle.schemes import format_names
from .. import options
from ..errors import UserError, user_errors
from ..options import argument, complete_target, flag, option
from ..outputs import check_file, print_line, status, write_text


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
    overwrite: bool = options.OVERWRITE,
) -> None:
    """Write a commented muscle, task or scenario file to edit."""
    from ...files import example_text, scenarios

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
    write_text("", path, overwrite, text)
    is_scenario = scenario or example in scenarios()
    command = "design" if task else "simulate" if is_scenario else "free-strain"
    print_line(f"wrote {path}: edit it, then run `fascicle {command} {path}`")


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
