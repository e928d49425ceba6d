"""What a run's control was worth, and policies beside one another, as labelled values."""

from typing import TYPE_CHECKING, Any

import numpy as np

from .labelled import Table, Variable


if TYPE_CHECKING:
    from collections.abc import Mapping

    from ..control import Cascade, ControlMetrics
    from ..dynamics import Trajectory

_WORDS = {
    "drawdown": "deepest fall while the demand didn't fall",
    "dip": "deepest dip of a unit at the strains that were passed",
    "rms": "root mean square of the error, where it could be reached",
    "largest_error": "largest error, where it could be reached",
    "lag": "by which it follows best",
    "supply_energy": "exergy that was drawn from the supply",
    "fluid": "that was drawn from the supply",
    "recruited": "how often a unit was",
    "unreachable": "demands that no policy could reach",
    "moments": "demands in all",
    "first": "unreachable demand",
    "last": "unreachable demand",
    "short": "largest force or moment that an unreachable demand lacks",
}


def followed(controller: "Cascade", run: "Trajectory", reference: Any) -> dict[str, Variable]:
    """What was demanded at each moment, whether it could be had, and what a run was worth.

    **Arguments:**

    - `controller`: that it was run with [-].
    - `run`: one run [SI].
    - `reference`: what was demanded, one for each step [SI].

    **Returns:** variables by name [-]; the demand of the last step is held at the end.
    """
    from ..control import control_metrics, controlled_output, reachability

    unit, force = units_of(controller)
    reach = reachability(controller, run.seen, reference)

    def now(values: Any, unit: str, about: str) -> Variable:
        return Variable(("time",), np.append(values, values[-1]), unit, about)

    pulled = Variable(
        ("time",), controlled_output(controller, run), unit, f"{controller.of} that is controlled"
    )
    return {
        "demand": now(np.asarray(reference, float), unit, f"of {controller.of}, from then on"),
        "controlled": pulled,
        "reachable": now(reach.can, "-", "whether the muscles could do it"),
        "short": now(reach.short, force, "what they lack of it"),
        **worth_of(controller, [control_metrics(controller, run, reference)], ()),
    }


def worth_of(controller: "Cascade", worths: list["ControlMetrics"], dims: tuple[str, ...]) -> dict:
    """What runs were worth.

    **Arguments:**

    - `controller`: of one of them [-].
    - `worths`: of each run [SI].
    - `dims`: the name of their axis [-]; none for a single one.

    **Returns:** variables by name [-].
    """
    unit, force = units_of(controller)
    of = {
        "drawdown": unit, "dip": "N", "rms": unit, "largest_error": unit, "lag": "s",
        "supply_energy": "J", "fluid": "kg", "first": "s", "last": "s", "short": force,
    }  # fmt: skip
    return {
        f"control_{name}": Variable(
            dims,
            np.array([getattr(one, name) for one in worths]) if dims else getattr(worths[0], name),
            of.get(name, "-"), f"{name if name in ('first', 'last') else ''} {words}".strip(),
        )
        for name, words in _WORDS.items()
    }  # fmt: skip


def compared(
    controllers: "Mapping[str, Cascade]", worths: list["ControlMetrics"], closes: Any
) -> Table:
    """Policies beside one another.

    **Arguments:**

    - `controllers`: by the name of the policy [-].
    - `worths`: what each one's run was worth [SI].
    - `closes`: whether each one's run can be trusted [-].

    **Returns:** a table [-], a policy a row, and which of them are on the front of drawdown
    against energy from the supply.
    """
    from ..control import front

    dims, first = ("policy",), next(iter(controllers.values()))
    best = front([one.drawdown for one in worths], [one.supply_energy for one in worths])
    return Table(
        {
            "policy": Variable(dims, np.array(list(controllers)), "-", "which units are fed, when"),
            **worth_of(first, worths, dims),
            "on_front": Variable(
                dims, best, "-", "whether none dips less and takes no more energy, or the reverse"
            ),
            "trusted": Variable(dims, np.array(closes), "-", "whether its balances close"),
        }
    )


def units_of(controller: "Cascade") -> tuple[str, str]:
    """Unit [-] of what a `controller` [-] controls, and of its forces [-]."""
    turns = controller.plant.load.unit == "rad"
    force = "N·m" if turns else "N"
    return (controller.plant.load.unit if controller.of == "position" else force), force
