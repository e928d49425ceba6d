"""Curves of a bundle as arrays: its workspace, its state, and pressures for a point."""

from typing import NamedTuple

import numpy as np

from ..bundle import Bundle, recruitment
from ..bundle.energetics import unit_volume_change, work
from ..bundle.pressurized import muscle_strain
from ..bundle.recruitment import Overlap, Workspace
from ..bundle.reversal import Reversal, free_strain_curve, reversal
from ..bundle.states import resolve_supply_pressure, states_of
from ..core.errors import InvalidInputError
from .muscle_curves import muscle_curves
from .solid import AROUND, RINGS, Solid, muscle_solid
from .state import View


LEVELS, POINTS = 5, 161  # curves of each state, and points of each
_PRESSURES = 97  # steps of 4 kPa at 60 psi, smooth on a screen
_FIBERS = {2: 7, 6: 5, 12: 3}  # each way around, for at most so many muscles
_SPACING = 2.7  # from axis to axis at rest, over the largest radius


class BundleWorkspace(NamedTuple):
    """A bundle's `workspace`, `overlap` of recruitment states, and a chart's `top` strain [-]."""

    workspace: Workspace
    overlap: Overlap
    top: float


class BundleSolids(NamedTuple):
    """Solids of a bundle's muscles for the drawing in space: the motor unit of each (`owners`),
    their `positions` (angle [rad], x and y [m]), and the radius [m] of their `envelope`.
    """

    solids: list[Solid]
    owners: list[int]
    positions: list[tuple[float, float, float]]
    envelope: float


class BundleState(NamedTuple):
    """A bundle at given pressures: forces of its `units` [N], a row each, and of all of them, over
    `strain` [-]; its `equilibria` without load [-], and True for each that is `stable`;
    `point_force` [N] and drawing (`scene`) at the view's strain.
    """

    strain: np.ndarray
    units: np.ndarray
    force: np.ndarray
    equilibria: np.ndarray
    stable: np.ndarray
    point_force: float
    scene: BundleSolids


class Recruitment(NamedTuple):
    """A recruitment `state`, counted from 1, under a load.

    The `pressures` [Pa] of all units that give the `force` [N], the load or the nearest to it;
    `stable`: the force falls with strain; `fluid` [m³] taken in from rest length on, NaN if it
    depends on more; `efficiency` [-], NaN at rest length.
    """

    state: int
    force: float
    pressures: tuple[float, ...]
    stable: bool
    fluid: float
    efficiency: float


class FreeStrainCurve(NamedTuple):
    """Free strain over the second unit's `pressure` [Pa]: with resistance, `resisted`, and `free`
    of it [-]; and the `turn` of the former.
    """

    pressure: np.ndarray
    resisted: np.ndarray
    free: np.ndarray
    turn: Reversal


def second_unit_curve(bundle: Bundle, first: float) -> FreeStrainCurve:
    """Free strain over unit 2's pressure with and without resistance, and its reversal; unit 1 at
    `first` [Pa], later units vented.
    """
    pressure = np.linspace(0.0, first, _PRESSURES)
    resisted = free_strain_curve(bundle, 2, pressure, first, True)
    free = free_strain_curve(bundle, 2, pressure, first, False)
    return FreeStrainCurve(pressure, resisted, free, reversal(bundle, 2, first))


def bundle_workspace(bundle: Bundle, resistance: bool) -> BundleWorkspace:
    """Workspace of a `bundle` and the overlap of its states, with `resistance` or without."""
    space = recruitment.workspace(bundle, levels=LEVELS, resistance=resistance)
    return BundleWorkspace(space, recruitment.overlap(space), float(space.strain[-1]) * 1.15)


def bundle_state(view: View, top: float) -> BundleState:
    """State of a view's bundle at its pressures, up to the strain `top` [-]."""
    bundle, strain, P = view.bundle, np.linspace(0.0, top, POINTS), np.array(view.pressures)
    units = np.asarray(bundle.unit_forces(P, strain, view.resistance)).T
    roots = bundle.equilibria(P, view.resistance)
    exists = np.isfinite(roots.strain)
    equilibria, stable = np.asarray(roots.strain)[exists], np.asarray(roots.stable)[exists]
    force = float(bundle.force(P, min(view.strain, top), view.resistance))
    scene = bundle_solids(view, top)
    return BundleState(strain, units, units.sum(axis=0), equilibria, stable, force, scene)


def recruitments(
    bundle: Bundle, load: float, strain: float, resistance: bool, path: str
) -> tuple[int, list[Recruitment]]:
    """Status of `bundle.recruit` for a `load` [N] at a `strain` [-], and all pressures that carry
    it, the cheapest first; or those of the nearest force. The efficiency is that along a `path`.
    """
    result = bundle.recruit(load, strain, resistance=resistance)
    status, states = int(result.status), states_of(bundle.scheme, len(bundle.motor_units))
    supply = resolve_supply_pressure(bundle)
    try:
        volumes = unit_volume_change(bundle, strain)
    except InvalidInputError:  # compliant ends: it depends on the load, too
        volumes = np.full(len(bundle.motor_units), np.nan)

    def row(state: int, P: np.ndarray, stable: bool) -> Recruitment:
        pressurized = P > 0 if states.independent else states.pressurized[state - 1]
        fluid, force = float(volumes[pressurized].sum()), float(bundle.force(P, strain, resistance))
        W = force * strain * float(bundle.length)  # along an isotonic path
        if path == "isobaric":
            W = float(work(bundle, P, strain, resistance))
        efficiency = W / (supply * fluid) if fluid > 0 else np.nan
        return Recruitment(state, force, tuple(map(float, P)), stable, fluid, efficiency)

    if status or states.independent:  # or one of a continuum: the cheapest
        return status, [row(int(result.state), np.asarray(result.pressures), bool(result.stable))]
    rows = [
        row(int(state), states.pressures(state - 1, level, supply), bool(stable))
        for level, state, stable in zip(*map(np.asarray, result.solutions), strict=True)
        if state > 0
    ]
    return status, sorted(rows, key=lambda row: np.nan_to_num(row.fluid))


def bundle_solids(view: View, top: float) -> BundleSolids:
    """Muscles of a bundle at the view's pressures and strain, at most `top` [-]."""
    bundle = view.bundle
    counts = [int(unit.count) for unit in bundle.motor_units]
    fibers = next((number for limit, number in _FIBERS.items() if sum(counts) <= limit), 0)
    solids, owners, shortening = [], [], min(view.strain, top)
    for i, unit in enumerate(bundle.motor_units):
        strain = shortening
        if bundle.ratios is not None:
            strain = float(muscle_strain(bundle.ratios[i], np.asarray(strain)))
        curves = muscle_curves(unit.muscle, view.pressures[i], strain, top)
        solids += [muscle_solid(unit.muscle, curves, strain, fibers)] * counts[i]
        owners += [i] * counts[i]
    widest = max(float(unit.muscle.outer_radius) for unit in bundle.motor_units)
    positions = muscle_positions(len(solids), _SPACING * widest)
    pairs = zip(solids, positions, strict=True)
    tubes = [solid.transform(*position)[0][: RINGS * AROUND] for solid, position in pairs]
    envelope = max(float(np.hypot(tube[:, 0], tube[:, 1]).max()) for tube in tubes)
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
        (float(np.arctan2(-np.cos(turn), -np.sin(turn))), r * np.cos(turn), r * np.sin(turn))
        for r, turn in polar
    ]
