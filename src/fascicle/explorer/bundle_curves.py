"""Curves of a bundle as arrays: its force-strain space, its state, and pressures for a point."""

from dataclasses import dataclass
from functools import lru_cache

import jax.numpy as jnp
import numpy as np

from ..bundle import Bundle, recruitment
from ..bundle.pressurized import muscle_strain
from ..bundle.workspace import Overlap, Space
from ..core.errors import InvalidInputError
from ..units import DIMENSIONS
from .muscle_curves import muscle_curves
from .solid import AROUND, RINGS, Solid, muscle_solid
from .state import View


LEVELS, POINTS = 5, 161
_FIBERS = {2: 7, 6: 5, 12: 3}  # each way around, for at most so many muscles
_SPACING = 2.7  # of the largest radius: from axis to axis at rest


@dataclass(frozen=True)
class DrawnSpace:
    """Force-strain `space` of a bundle, its `overlap`, and the largest strain drawn, `top` [-]."""

    space: Space
    overlap: Overlap
    top: float


@dataclass(frozen=True)
class BundleState:
    """A bundle at given pressures.

    Forces of its `units` [N], a row each, over `strain` [-]; its equilibria without load, `zeros`
    [-], and whether each is `stable`.
    """

    strain: np.ndarray
    units: np.ndarray
    zeros: np.ndarray
    stable: np.ndarray

    @property
    def force(self) -> np.ndarray:
        """Force of all units [N]."""
        return self.units.sum(axis=0)


@dataclass(frozen=True)
class Solution:
    """Recruitment `state` and `pressures` [Pa] of all units that reach a point."""

    state: int
    pressures: tuple[float, ...]
    stable: bool


@lru_cache(maxsize=16)  # visitors share it
def drawn_space(bundle: Bundle, resistance: bool) -> DrawnSpace:
    """Force-strain space of a `bundle`, with `resistance` or without."""
    space = recruitment.space(bundle, levels=LEVELS, resistance=resistance)
    return DrawnSpace(space, recruitment.overlap(space), float(space.strain[-1]) * 1.15)


def bundle_state(
    bundle: Bundle, pressures: tuple[float, ...], top: float, resistance: bool
) -> BundleState:
    """State of a bundle.

    **Arguments:**

    - `bundle`: the bundle.
    - `pressures`: one for each motor unit [Pa].
    - `top`: the largest strain [-].
    - `resistance`: whether units past their own free strain push back.
    """
    strain = np.linspace(0.0, top, POINTS)
    units = np.asarray(bundle.unit_forces(np.array(pressures), strain, resistance))
    equilibria = bundle.equilibria(np.array(pressures), resistance)
    zeros, stable = np.asarray(equilibria.strain), np.asarray(equilibria.stable)
    exists = np.isfinite(zeros)
    return BundleState(strain, units.T, zeros[exists], stable[exists])


def solutions(
    bundle: Bundle, force: float, strain: float, resistance: bool, unit: str = "N"
) -> tuple[list[Solution], str]:
    """All pressures that reach a point, lowest state first, and a remark where none does.

    **Arguments:**

    - `bundle`: the bundle.
    - `force`: of the point [N].
    - `strain`: of the point [-].
    - `resistance`: whether units past their own free strain push back.
    - `unit`: of forces in the remark.
    """
    result = recruitment.recruit(bundle, force, strain, resistance=resistance)
    supply, units = bundle.supply_pressure, len(bundle.motor_units)
    if supply is None:
        raise InvalidInputError("supply_pressure", "is needed to recruit", None)
    nearest = Solution(
        int(result.state), tuple(map(float, np.asarray(result.pressures))), bool(result.stable)
    )
    status = int(result.status)
    if status != 0:
        side = "above" if status == 1 else "below"
        reached = float(result.force) / float(DIMENSIONS["force"].factors[unit])
        return [nearest], (
            f"The point is {side} what is reachable at this strain: the nearest force is"
            f" {reached:.4g} {unit}."
        )
    if bundle.scheme.independent:  # one of a continuum: the cheapest
        return [nearest], ""
    states, levels, stable = (
        np.asarray(part)
        for part in (result.solutions.state, result.solutions.pressure, result.solutions.stable)
    )
    several = []
    for state, level, is_stable in zip(states, levels, stable, strict=False):
        if state > 0:
            pressures = recruitment.pressures_of(
                int(state), float(level), float(supply), units, bundle.scheme
            )
            several.append(Solution(int(state), tuple(map(float, pressures)), bool(is_stable)))
    return several, ""


def bundle_solids(view: View, top: float) -> tuple[list[Solid], list[int], list[tuple], float]:
    """Muscles of a bundle between its plates, at the view's pressures and strain.

    **Arguments:** `view`: the view; `top`: the largest strain [-].

    **Returns:** the solids, the unit of each, their places (angle [rad], x and y [m]), and the
    radius [m] of the envelope that they need.
    """
    bundle = view.bundle
    count = sum(int(unit.count) for unit in bundle.motor_units)
    fibers = next((number for most, number in _FIBERS.items() if count <= most), 0)
    ratios = bundle.ratios
    solids, owners = [], []
    for i, unit in enumerate(bundle.motor_units):
        strain = view.strain
        if ratios is not None:
            strain = float(muscle_strain(ratios[i], jnp.asarray(strain)))
        curves = muscle_curves(unit.muscle, view.pressures[i], strain, view.supply, top)
        solids += [muscle_solid(unit.muscle, curves, strain, fibers)] * int(unit.count)
        owners += [i] * int(unit.count)
    widest = max(float(unit.muscle.outer_radius) for unit in bundle.motor_units)
    places = muscle_places(len(solids), _SPACING * widest)
    reach = 0.0
    for solid, (angle, x, y) in zip(solids, places, strict=True):
        tube = solid.points[: RINGS * AROUND]
        across = tube[:, 0] * np.cos(angle) + tube[:, 1] * np.sin(angle) + x
        up = -tube[:, 0] * np.sin(angle) + tube[:, 1] * np.cos(angle) + y
        reach = max(reach, float(np.hypot(across, up).max()))
    return solids, owners, places, reach


def muscle_places(count: int, spacing: float) -> list[tuple[float, float, float]]:
    """Places of `count` muscles in rings, `spacing` [m] from each other.

    **Returns:** the angle [rad] that makes each bow outward, x and y [m].
    """
    spots = [(0.0, 0.0)] if count != 2 else []
    ring = 1
    while len(spots) < count:
        number = min(6 * ring, count - len(spots))
        radius = spacing * (ring if count != 2 else 0.5)  # two stand beside the axis
        for k in range(number):
            theta = np.pi / 2 + 2 * np.pi * k / number
            spots.append((float(radius * np.cos(theta)), float(radius * np.sin(theta))))
        ring += 1
    places = []
    for x, y in spots:
        theta = np.arctan2(y, x) if (x, y) != (0.0, 0.0) else np.pi / 2
        # a solid bows toward -y
        places.append((float(np.arctan2(-np.cos(theta), -np.sin(theta))), x, y))
    return places
