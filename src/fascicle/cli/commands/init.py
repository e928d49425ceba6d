"""`fascicle init`: a commented muscle, task or scenario file to begin with."""

from typing import Annotated

import typer

from ...bundle.schemes import listed
from ..options import Replace, complete_target
from ..outputs import say
from ..problems import UserError, refusing
from ..telling import telling
from .task_template import TASK_TEMPLATE


_TEMPLATE = """\
# A muscle file of fascicle. Every quantity carries its unit; `fascicle force FILE` reads it.
format = 1

[muscle]
length = "127 mm"                # between the end fittings, at rest
outer_radius = "6.35 mm"         # of the bladder, at rest; half its diameter
wall_thickness = "1.6 mm"        # of the bladder, at rest
braid_angle = "33 deg"           # of a fiber from the axis, at rest; below %(top)s deg to contract
%(material)s, or a table such as
                                 # { c10 = "90 kPa", c01 = "80 kPa", youngs_modulus = "1.8 MPa" }
%(tension)s
%(buckling)s
%(post_collapse)s
%(ends)s

[muscle.collapse]
%(collapse)s
transition_rate = 25             # how fast the force falls once the bladder has collapsed

# What measurements correct; left out, nothing.
# [muscle.tuning]
# pressure = ["100 kPa", "200 kPa"]    # rows of C1 and C2
# c1 = ["1.5 N", "2 N"]
# c2 = [0.95, 0.97]
# youngs_modulus_factor = 1.25
# collapse_moment_factor = 1.1
# hinge_stiffness_factor = { constant = 1.25, slope = "0.87 1/bar" }
# transition_rate = 100

# Several of them between two plates; muscles that share a pressure are a motor unit.
# [bundle]
# supply_pressure = "413.7 kPa"
# scheme = "orderly"                   # or {schemes}
# [[bundle.motor_unit]]
# count = 1
# [[bundle.motor_unit]]
# count = 4
""".replace("{schemes}", listed('"', 1))


def run(
    path: Annotated[
        str | None,
        typer.Argument(
            metavar="FILE",
            help="Where it goes; left out, muscle.toml, task.toml or scenario.toml.",
            show_default=False,
        ),
    ] = None,
    example: Annotated[
        str | None,
        typer.Option(
            "--from",
            metavar="NAME",
            help="Begin with this named example.",
            autocompletion=complete_target,
            show_default=False,
        ),
    ] = None,
    task: Annotated[
        bool, typer.Option("--task", help="A task file for `fascicle design` instead.")
    ] = False,
    scenario: Annotated[
        bool,
        typer.Option("--scenario", help="A scenario file for `fascicle simulate` instead."),
    ] = False,
    overwrite: Replace = False,
) -> None:
    """Write a commented muscle, task or scenario file, to be edited."""
    from ...files import example_text, scenarios
    from ...files.ours import replacing
    from ...io.atomic import check_writable, write_text

    if task and example is not None:
        raise UserError("--task and --from: muscles are begun from an example, take one.")
    if task and scenario:
        raise UserError("--task and --scenario: one file is written, take one.")
    path = path or ("task.toml" if task else "scenario.toml" if scenario else "muscle.toml")
    with refusing():
        check_writable(path)
        if scenario:
            if example is not None and example not in scenarios():
                raise UserError(f"--from {example}: no scenario, take {', '.join(scenarios())}.")
            example = example or "lift_gas"
        begun = TASK_TEMPLATE if task else _template()
        text = begun if example is None else example_text(example)
        with replacing(path, overwrite) as draft:
            write_text(draft, text)
    say(f"wrote {path}")


def _template() -> str:
    """The muscle's template with the names of all materials and laws."""
    from math import degrees

    with telling("loading the laws"):
        from ...core.validation import NEUTRAL_ANGLE
        from ...muscle import LAWS
        from ...muscle.materials import MATERIALS

    known = {"material": MATERIALS, **LAWS}
    keys = {kind: "law" if kind == "collapse" else kind for kind in known}  # it has a table
    chosen = {kind: _chosen(keys[kind], list(names)) for kind, names in known.items()}
    return _TEMPLATE % {**chosen, "top": f"{degrees(NEUTRAL_ANGLE):.1f}"}


def _chosen(key: str, names: list[str]) -> str:
    """A line of the file: the first of the `names`, the others beside it."""
    first, *others = (f'"{name}"' for name in names)
    return f"{key} = {first}".ljust(33) + "# or " + ", ".join(others)
