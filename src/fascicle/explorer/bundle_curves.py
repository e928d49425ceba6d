"""The bundle's pictures as arrays: its space, its curves at given pressures, the way back."""

from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np

from ..bundle import Bundle, recruitment
from ..bundle.plates import muscle_strain
from ..bundle.space import Overlap, Space
from ..core.errors import InvalidInputError
from ..units import DIMENSIONS
from .muscle_curves import picture
from .solid import AROUND, RINGS, Solid, solid
from .state import View


LEVELS, POINTS = 5, 161
_FIBERS = {2: 7, 6: 5, 12: 3}  # each way around, for at most so many muscles
_APART = 2.7  # of the largest radius: from axis to axis at rest


@dataclass(frozen=True)
class Shown:
    """What is drawn of a bundle's `space`, its `overlap` and how far strain is drawn, `top` [-]."""

    space: Space
    overlap: Overlap
    top: float


@dataclass(frozen=True)
class State:
    """A bundle at given pressures: forces of its `units` [N], a row each, over `strain` [-];
    `zeros`: strains at which it neither pulls nor pushes [-], and which are `stable`.
    """

    strain: np.ndarray
    units: np.ndarray
    zeros: np.ndarray
    stable: np.ndarray

    @property
    def force(self) -> np.ndarray:
        """Of all units [N]."""
        return self.units.sum(axis=0)


@dataclass(frozen=True)
class Way:
    """One way to reach a point: recruitment `state` [-], all units' `pressures` [Pa]."""

    state: int
    pressures: tuple[float, ...]
    stable: bool


def shown_space(bundle: Bundle, resistance: bool) -> Shown:
    """The force-strain space of a `bundle` [-] with or without `resistance` [-]."""
    found = recruitment.space(bundle, levels=LEVELS, resistance=resistance)
    return Shown(found, recruitment.overlap(found), float(found.strain[-1]) * 1.15)


def state_at(bundle: Bundle, pressures: tuple[float, ...], top: float, resistance: bool) -> State:
    """The bundle at its units' pressures.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `pressures`: one for each motor unit [Pa].
    - `top`: the largest strain [-].
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** forces [N] over strains [-].
    """
    strain = np.linspace(0.0, top, POINTS)
    units = np.asarray(bundle.unit_forces(np.array(pressures), strain, resistance))
    found = bundle.equilibria(np.array(pressures), resistance)
    zeros, stable = np.asarray(found.strain), np.asarray(found.stable)
    there = np.isfinite(zeros)
    return State(strain, units.T, zeros[there], stable[there])


def force_at(
    bundle: Bundle, pressures: tuple[float, ...], strain: float, resistance: bool
) -> float:
    """Force [N] of a `bundle` at `pressures` [Pa] and `strain` [-]."""
    return float(bundle.force(np.array(pressures), strain, resistance))


def ways(
    bundle: Bundle, force: float, strain: float, resistance: bool, unit: str = "N"
) -> tuple[list[Way], str]:
    """All pressures that reach a point, and what to say where none does.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `force`: demanded [N].
    - `strain`: there [-].
    - `resistance`: whether units past their own free strain push back [-].
    - `unit`: that forces are told in [-].

    **Returns:** the ways, lowest state first, and a remark [-].
    """
    found = recruitment.recruit(bundle, force, strain, resistance=resistance)
    supply, units = bundle.supply_pressure, len(bundle.motor_units)
    if supply is None:
        raise InvalidInputError("supply_pressure", "is needed to recruit", None)
    out = []
    states, levels, stable = (
        np.asarray(part)
        for part in (found.solutions.state, found.solutions.pressure, found.solutions.stable)
    )
    nearest = tuple(map(float, np.asarray(found.pressures)))
    if bundle.scheme.independent:
        # one of a continuum: the cheapest
        states = states[:0]
        out = [Way(int(found.state), nearest, bool(found.stable))]
    for state, level, falls in zip(states, levels, stable, strict=False):
        if state > 0:
            all_pressures = recruitment.pressures_of(
                int(state), float(level), float(supply), units, bundle.scheme
            )
            out.append(Way(int(state), tuple(map(float, all_pressures)), bool(falls)))
    status = int(found.status)
    if status == 0:
        return out, ""
    side = "above" if status == 1 else "below"
    given = float(found.force) / float(DIMENSIONS["force"].factors[unit])
    remark = f"{side} what is reachable at this strain: the nearest force is {given:.4g} {unit}."
    return [Way(int(found.state), nearest, bool(found.stable))], remark


def solids(view: View, top: float) -> tuple[list[Solid], list[int], list[tuple], float]:
    """All muscles of a bundle between its plates at the view's pressures and strain.

    **Arguments:**

    - `view`: the view [-].
    - `top`: the largest strain [-].

    **Returns:** the muscles, the unit [-] of each, their places (angle [rad], x and y [m]),
    and the radius [m] of the envelope that they need.
    """
    bundle = view.bundle
    count = sum(int(unit.count) for unit in bundle.motor_units)
    fibers = next((number for most, number in _FIBERS.items() if count <= most), 0)
    ratios = bundle.ratios
    drawn, owner = [], []
    for i, unit in enumerate(bundle.motor_units):
        strain = view.strain
        if ratios is not None:
            strain = float(muscle_strain(ratios[i], jnp.asarray(strain)))
        found = picture(unit.muscle, view.pressures[i], strain, view.supply, top)
        one = solid(unit.muscle, found, strain, fibers)
        drawn += [one] * int(unit.count)
        owner += [i] * int(unit.count)
    widest = max(float(unit.muscle.outer_radius) for unit in bundle.motor_units)
    places = arranged(len(drawn), _APART * widest)
    reach = 0.0
    for one, (angle, x, y) in zip(drawn, places, strict=True):
        tube = one.points[: RINGS * AROUND]
        across = tube[:, 0] * np.cos(angle) + tube[:, 1] * np.sin(angle) + x
        up = -tube[:, 0] * np.sin(angle) + tube[:, 1] * np.cos(angle) + y
        reach = max(reach, float(np.hypot(across, up).max()))
    return drawn, owner, places, reach


def arranged(count: int, apart: float) -> list[tuple[float, float, float]]:
    """Places of `count` muscles, `apart` [m] from each other, and the angle [rad] that makes
    each bow outward.
    """
    spots = [(0.0, 0.0)] if count != 2 else []
    ring = 1
    while len(spots) < count:
        number = min(6 * ring, count - len(spots))
        # as few as they are, they stand around the axis evenly
        radius = apart * (ring if count != 2 else 0.5)
        for k in range(number):
            theta = np.pi / 2 + 2 * np.pi * k / number
            spots.append((float(radius * np.cos(theta)), float(radius * np.sin(theta))))
        ring += 1
    out = []
    for x, y in spots:
        theta = np.arctan2(y, x) if (x, y) != (0.0, 0.0) else np.pi / 2
        # the shape bows toward -y of its own
        out.append((float(np.arctan2(-np.cos(theta), -np.sin(theta))), x, y))
    return out
