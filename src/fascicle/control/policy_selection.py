r"""Selection of a policy, with the reason: by reserve, hand-over time and load.

A dip of length $t_c$ moves a load of mass $M$ on its muscles' stiffness $k$ hardly while
$t_c \sqrt{k/M} \ll 1$.

**Source:** derived here.
"""

from typing import NamedTuple

import numpy as np

from ..core.types import Values
from ..dynamics import Plant
from .crossing import Crossing, Path, crossing, hand_over_time


_HARMLESS = 0.2  # of t_c √(k/M), below which a dip moves the load by at most 2 % of what it would


class PolicyChoice(NamedTuple):
    """A `policy`, the reason for it, `why`, and the `crossings` that it depends on."""

    policy: str
    why: str
    crossings: tuple[Crossing, ...]


def select_policy(plant: Plant, reference: Values, dt: float, of: str) -> PolicyChoice:
    """Select a policy for a plant and its reference.

    **Arguments:**

    - `plant`: of one bundle or two.
    - `reference`: one for each step [SI].
    - `dt`: the step [s].
    - `of`: quantity of the reference, "force" or "position".

    **Raises:** `InvalidInputError` as `crossing` does.
    """
    if plant.units == 1:
        return PolicyChoice("orderly", "there is one motor unit, nothing is handed over", ())
    if max(plant.sides) > 0:
        why = "of two bundles each goes its own way, which no path says beforehand"
        return PolicyChoice("hand_over", why, ())
    path = _path(plant, np.asarray(reference, float), dt, of)
    bundle, supply = plant.bundles[0], plant.supply_pressure
    units = range(2, plant.units + 1)
    crossings = tuple(crossing(bundle, path, plant, unit, supply) for unit in units)
    return PolicyChoice(*_select(plant, path, crossings), crossings)


def _select(plant: Plant, path: Path, crossings: tuple[Crossing, ...]) -> tuple[str, str]:
    """A policy and the reason for it."""
    needed = [entry for entry in crossings if entry.needed is not None]
    if not needed:
        return "threshold", f"no crossing is needed: {crossings[0].reason}"
    infeasible = next((entry for entry in needed if not entry.found), None)
    if infeasible is not None:
        ratio = _ratio(plant, path)
        if ratio < _HARMLESS:
            why = f"{infeasible.reason}; the load hardly follows, t_c √(k/M) is {ratio:.2g}"
            return "fast_cross", why
        return "hand_over", f"{infeasible.reason}; it keeps the dip as small as it can be"
    wait = max((entry.needed or 0.0) - (entry.end or 0.0) - (entry.time or 0.0) for entry in needed)
    if wait > 0 and np.ptp(path.strain) > 1e-6:
        why = f"the last crossing ends {wait:.3g} s before the unit is needed: {needed[0]}"
        return "pre_charge", why
    return "hand_over", f"there is a crossing without a dip, {needed[0]}"


def _path(plant: Plant, reference: np.ndarray, dt: float, of: str) -> Path:
    """Demand and strain of quasi-static motion."""
    steps = np.unique(np.linspace(0, len(reference) - 1, 401).astype(int))
    time, target = dt * steps, reference[steps]
    low, high = plant.stroke
    if of == "position":
        q = np.clip(target, low, high)
        return Path.of(time, -np.asarray(plant.load.force(q)), plant.strains(q[:, None])[:, 0])
    q = float(plant.load.motion_at(0.0, 0.0, 0.0)[0])
    return Path.of(time, target, float(np.atleast_1d(plant.strains(q))[0]))


def _ratio(plant: Plant, path: Path) -> float:
    """$t_c \\sqrt{k/M}$ [-], the unit's valve wide open, at the path's middle strain."""
    if plant.load.prescribed:
        return np.inf
    eps = float(np.median(path.strain))
    bundle, supply = plant.bundles[0], plant.supply_pressure
    time = float(hand_over_time(bundle, eps, plant, 2, supply))
    muscles = plant.muscles.at(np.full(plant.units, supply / 2), np.full(plant.units, eps))
    stiff = -np.sum(plant.counts * plant.lengths * plant.gains**2 * muscles.force_by_strain)
    return time * float(np.sqrt(max(stiff, 0.0) / float(plant.load.inertia)))
