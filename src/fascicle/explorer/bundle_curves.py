"""Curves of a bundle as arrays: its force-strain space, its state, and pressures for a point."""

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..bundle import Bundle, recruitment
from ..bundle.pressurized import muscle_strain
from ..bundle.recruitment import Overlap, Workspace
from ..core.errors import InvalidInputError
from .muscle_curves import muscle_curves
from .solid import AROUND, RINGS, Solid, muscle_solid
from .state import View
from .widgets import unit_factor


LEVELS, POINTS = 5, 161  # curves of each state, and points of each
_FIBERS = {2: 7, 6: 5, 12: 3}  # each way around, for at most so many muscles
_SPACING = 2.7  # from axis to axis at rest, over the largest radius


@dataclass(frozen=True)
class DrawnSpace:
    """Force-strain `space` of a bundle, its `overlap`, and the largest strain drawn, `top` [-]."""

    space: Workspace
    overlap: Overlap
    top: float


class BundleState(NamedTuple):
    """A bundle at given pressures.

    Forces of its `units` [N], a row each, and of all of them, over `strain` [-]; its `equilibria`
    without load [-], and True for each that is `stable`.
    """

    strain: np.ndarray
    units: np.ndarray
    force: np.ndarray
    equilibria: np.ndarray
    stable: np.ndarray


class Solution(NamedTuple):
    """Recruitment `state` and `pressures` [Pa] of all units that reach a point."""

    state: int
    pressures: tuple[float, ...]
    stable: bool


class BundleSolids(NamedTuple):
    """Muscles of a bundle between its plates.

    The motor unit of each (`owners`), their `positions` (angle [rad], x and y [m]), and the radius
    [m] of their `envelope`.
    """

    solids: list[Solid]
    owners: list[int]
    positions: list[tuple[float, float, float]]
    envelope: float


@lru_cache(maxsize=16)  # visitors share it
def drawn_space(bundle: Bundle, resistance: bool) -> DrawnSpace:
    """Force-strain space of a `bundle`, with `resistance` or without."""
    space = recruitment.workspace(bundle, levels=LEVELS, resistance=resistance)
    return DrawnSpace(space, recruitment.overlap(space), float(space.strain[-1]) * 1.15)


def bundle_state(
    bundle: Bundle, pressures: tuple[float, ...], top: float, resistance: bool
) -> BundleState:
    """State of a bundle at its units' `pressures` [Pa], up to the strain `top` [-]."""
    strain, P = np.linspace(0.0, top, POINTS), np.array(pressures)
    units = np.asarray(bundle.unit_forces(P, strain, resistance)).T
    roots = bundle.equilibria(P, resistance)
    equilibria, stable = np.asarray(roots.strain), np.asarray(roots.stable)
    exists = np.isfinite(equilibria)
    return BundleState(strain, units, units.sum(axis=0), equilibria[exists], stable[exists])


def solutions(
    bundle: Bundle, force: float, strain: float, resistance: bool, unit: str = "N"
) -> tuple[list[Solution], str]:
    """All pressures that reach a `force` [N] at a `strain` [-]; else the nearest, and a remark."""
    result = recruitment.recruit(bundle, force, strain, resistance=resistance)
    supply = bundle.supply_pressure
    if supply is None:
        raise InvalidInputError("supply_pressure", "is needed to recruit", None)

    def solution(state: int, pressures: np.ndarray, stable: bool) -> Solution:
        return Solution(int(state), tuple(map(float, pressures)), bool(stable))

    nearest = solution(result.state, np.asarray(result.pressures), result.stable)
    if status := int(result.status):
        side = "above" if status == 1 else "below"
        nearest_force = float(result.force) / unit_factor(unit, "force")
        return [nearest], (
            f"The point is {side} what is reachable at this strain: the nearest force is"
            f" {nearest_force:.4g} {unit}."
        )
    if bundle.scheme.independent:  # one of a continuum: the cheapest
        return [nearest], ""
    states, levels = np.asarray(result.solutions.state), np.asarray(result.solutions.pressure)
    units, scheme = len(bundle.motor_units), bundle.scheme
    return [
        solution(
            states[i],
            recruitment.pressures_of(
                int(states[i]), float(levels[i]), float(supply), units, scheme
            ),
            result.solutions.stable[i],
        )
        for i in np.flatnonzero(states > 0)
    ], ""


def bundle_solids(view: View, top: float) -> BundleSolids:
    """Muscles of a bundle at the view's pressures and strain, at most `top` [-]."""
    bundle = view.bundle
    count = sum(int(unit.count) for unit in bundle.motor_units)
    fibers = next((number for limit, number in _FIBERS.items() if count <= limit), 0)
    solids, owners = [], []
    for i, unit in enumerate(bundle.motor_units):
        strain = view.strain
        if bundle.ratios is not None:
            strain = float(muscle_strain(bundle.ratios[i], np.asarray(strain)))
        curves = muscle_curves(unit.muscle, view.pressures[i], strain, view.supply, top)
        solids += [muscle_solid(unit.muscle, curves, strain, fibers)] * int(unit.count)
        owners += [i] * int(unit.count)
    widest = max(float(unit.muscle.outer_radius) for unit in bundle.motor_units)
    positions = muscle_positions(count, _SPACING * widest)
    envelope = 0.0
    for solid, position in zip(solids, positions, strict=True):
        tube = solid.transform(*position)[0][: RINGS * AROUND]
        envelope = max(envelope, float(np.hypot(tube[:, 0], tube[:, 1]).max()))
    return BundleSolids(solids, owners, positions, envelope)


def muscle_positions(count: int, spacing: float) -> list[tuple[float, float, float]]:
    """Angle [rad], x and y [m] of muscles in rings, `spacing` [m] apart, that bow outward."""
    polar = [(0.0, np.pi / 2)] if count != 2 else []
    ring = 1
    while len(polar) < count:
        number = min(6 * ring, count - len(polar))
        radius = spacing * (ring if count != 2 else 0.5)  # two stand beside the axis
        polar += [(radius, np.pi / 2 + 2 * np.pi * k / number) for k in range(number)]
        ring += 1
    # a solid bows toward -y
    return [
        (
            float(np.arctan2(-np.cos(theta), -np.sin(theta))),
            float(radius * np.cos(theta)),
            float(radius * np.sin(theta)),
        )
        for radius, theta in polar
    ]
