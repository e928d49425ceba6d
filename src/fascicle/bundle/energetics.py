r"""Work, fluid energy and efficiency of a bundle.

$$W = L_0 \int_0^\varepsilon F \,\mathrm{d}\varepsilon', \qquad
  E = P_s \sum_{active} n_i (V_i(\varepsilon) - V_i(0)), \qquad
  \eta = W/E. \tag{28-30}$$

The supply's pressure $P_s$ counts, also for a unit that is throttled below it, and the
volume is the fluid's: the bladder is incompressible, so its own volume cancels [R17]. If
muscles are of unequal length, $L_0$ is the distance between the plates at rest, and each
muscle's volume is taken at its own strain.

**Quadrature:** Gauss-Legendre on each stretch between a muscle's kinks, where its force is
smooth. The work to a strain is that to the strain before it and a little more, so works along a
whole path are sums over its pieces,

$$W(\varepsilon_j) = L_0 \sum_{i \le j} \int_{\varepsilon_{i-1}}^{\varepsilon_i}
  F \,\mathrm{d}\varepsilon'. \tag{28a}$$

*Isobaric:* pressures are constant along the path from $\varepsilon = 0$, so the work is
the area under that state's curve. *Isotonic:* the load is constant, so
$W = F \varepsilon L_0$. If several states, or several pressures of one, reach a point,
the highest efficiency counts. The average is over the points of an even grid, forces
$F_{max} i/80$ and strains $j/375$, that the bundle reaches [R18].

**Resolution:** pressures that reach a force are interpolated linearly between levels,
which is exact wherever the muscle pulls: its force and work are linear in pressure there.
**Source:** Kim, Mazzoleni and Bryant (2021), section 4.2 and Fig. 10.
"""

from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ..core.array_namespace import array_namespace
from ..core.errors import InvalidInputError
from ..core.types import Batch, Float, Int, Numbers, PerUnit, Values
from ..core.validation import (
    check_choice,
    check_finite,
    check_gauge_pressure,
    check_positive,
    warn_user,
)
from ..muscle.coenergy import contraction_work, integrate_force
from ..muscle.piecewise import PressurizedMuscle
from .pressurized import pressurize, unit_volume_change
from .recruitment import unit_tables
from .schemes import AbstractScheme
from .states import resolve_scheme, resolve_supply_pressure, states_of


if TYPE_CHECKING:
    from .bundle import Bundle


PATHS = ("isobaric", "isotonic")  # values of the argument `path`
_LEVELS = 129  # throttled pressures, between which forces and works are interpolated
_FORCES, _STRAIN_STEP = 80, 1 / 375  # the even grid of the average [R18]
_ROUNDING = 1e-9  # of an efficiency of 1, which an ideal mesh has
_PIECE = 1 / 50  # of strain: the fastest decay in use, 100, falls to exp(-2) over it
_NODES = 6  # of Gauss's rule on a piece: error below 1e-13

Grid = Float[np.ndarray, "force strain"]


def work(bundle: "Bundle", pressures: Values, strain: Values, resistance: bool = True) -> Batch:
    """Work $W$ [J] of a contraction from rest length to `strain` [-] at constant `pressures` [Pa],
    (28); arguments and errors are those of `Bundle.force`.
    """
    works = unit_work(bundle, pressures, strain, resistance)
    return array_namespace(works).sum(works, axis=-1)


def unit_work(
    bundle: "Bundle", pressures: Values, strain: Values, resistance: bool = True
) -> PerUnit:
    """Work of each motor unit [J], units on the last axis; arguments are those of `work`:
    `pressures` [Pa] and `strain` [-].
    """
    P, eps = bundle._check_pressures(pressures), bundle._check_strain(strain)

    def muscle_work(muscle: PressurizedMuscle, strain: Numbers, start: Numbers) -> Numbers:
        return contraction_work(muscle, strain, start, resistance)

    # a muscle that isn't as long as the plates are apart has a strain at rest; its own length
    # times its change of strain is the plates' way all the same
    return bundle.counts * pressurize(bundle, P).map_units_over_strain(muscle_work, eps, 0.0 * eps)


def fluid_energy(
    bundle: "Bundle", strain: Values, supply_pressure: Values, active: Values
) -> Batch:
    """Energy $E$ [J] drawn from a supply at `supply_pressure` [Pa] by a contraction from rest
    length to `strain` [-], (29); `active`: 1 for pressurized units [-], 0 for others, units last.
    """
    volumes = unit_volume_change(bundle, strain)
    supply_pressure = check_gauge_pressure(supply_pressure, "supply_pressure")
    xp, units = array_namespace(volumes, supply_pressure), len(bundle.motor_units)
    if np.shape(active)[-1:] != (units,):
        rule = f"must hold one number for each of the {units} motor units on the last axis"
        raise InvalidInputError("active", rule, active)
    return supply_pressure * xp.sum(xp.asarray(active) * volumes, axis=-1)


def unit_work_along(
    bundle: "Bundle", pressures: Numbers, strain: Numbers, resistance: bool
) -> Float[np.ndarray, "level strain unit"]:
    """Work of each motor unit [J] from rest length to every `strain` of a list [-], at constant
    `pressures` [Pa], a row for each level; `resistance` as for `work`. By NumPy, unchecked.
    """
    low, high = strain.min(initial=0.0), strain.max(initial=0.0)
    even = np.linspace(low, high, int(np.ceil((high - low) / _PIECE)) + 1)
    stops = np.concatenate([[0.0], strain, even])

    def muscle_work(muscle: PressurizedMuscle, stops: Numbers) -> Numbers:
        sums = integrate_force(muscle, stops, _NODES, resistance)
        return muscle.column.rest_length * (sums[1 : 1 + strain.size] - sums[:1])

    with np.errstate(all="ignore"):  # of branches that aren't taken
        muscles = pressurize(bundle, pressures)
        works = bundle.counts * muscles.map_units_over_strain(muscle_work, stops[:, None])
    return np.moveaxis(np.asarray(works), 0, 1)


@dataclass(frozen=True)
class EfficiencyMap:
    """Efficiency of a bundle over `force` [N] (rows) and `strain` [-] (columns).

    `efficiency` [-]: NaN where the bundle doesn't reach; `state`: recruitment state of the highest
    efficiency, 0 for none; `path`: "isobaric" or "isotonic".
    """

    path: str
    force: Float[np.ndarray, " force"] = field(repr=False)
    strain: Float[np.ndarray, " strain"] = field(repr=False)
    efficiency: Grid
    state: Int[np.ndarray, "force strain"] = field(repr=False)

    @property
    def average(self) -> float:
        """Plain mean of the efficiency [-] over the points that are reached."""
        return float(np.nanmean(self.efficiency))


def efficiency_map(
    bundle: "Bundle",
    supply_pressure: Values = None,
    path: str = "isobaric",
    force: Values = None,
    strain: Values = None,
    resistance: bool = True,
    scheme: AbstractScheme | str | None = None,
) -> EfficiencyMap:
    """Efficiency [-] over forces and strains that a `bundle` reaches.

    `path`: "isobaric" or "isotonic"; `force`: forces [N], by default 80 even ones up to the blocked
    force of all units; `strain`: positive strains [-], by default multiples of 1/375 to the free
    strain. `supply_pressure` [Pa], `resistance` and `scheme` as of `Bundle.recruit`. `ValueError`
    for an unknown path or scheme and values off the domain.
    """
    supply = resolve_supply_pressure(bundle, supply_pressure)
    scheme = resolve_scheme(bundle, scheme)
    is_isobaric = check_choice(path, PATHS, "path") == "isobaric"
    if is_isobaric and scheme.independent:
        rule = f"must be 'isotonic' with scheme {scheme.name!r}"
        remedy = (
            "many pressures of its units give one force and strain, each with its own work on the"
            ' way; ask for path="isotonic" (--path isotonic)'
        )
        raise InvalidInputError("path", rule, path, remedy)
    distinct, inverse = bundle.distinct_units()
    states, owner = states_of(scheme, len(bundle.motor_units)).sets(inverse.tolist())
    full = np.full(len(distinct.motor_units), supply)
    if force is None:
        blocked = np.asarray(distinct.unit_forces(full, 0.0))[inverse]
        force = float(blocked.sum()) * np.arange(1, _FORCES + 1) / _FORCES
    if strain is None:
        largest = float(distinct.free_strain(full, resistance=False))
        strain = np.arange(1, int(largest / _STRAIN_STEP) + 1) * _STRAIN_STEP
    force = np.atleast_1d(check_finite(force, "force", "N"))
    strain = np.atleast_1d(check_positive(strain, "strain", "-"))

    levels = np.linspace(0.0, supply, _LEVELS)
    forces = unit_tables(bundle, supply, levels, strain, resistance)
    volumes = np.asarray(unit_volume_change(distinct, strain))[..., inverse]
    energy = supply * (states.pressurized.astype(float) @ volumes.T)  # state, strain
    if is_isobaric:
        pressures = levels[:, None] * np.ones(len(distinct.motor_units))
        works = unit_work_along(distinct, pressures, strain, resistance)[..., inverse]
        tables = states.sums(*forces), states.sums(works, works[0], works[-1])
    else:
        tables = states.edges(*forces)

    best = np.full((force.size, strain.size), np.nan)
    state = np.zeros(best.shape, int)
    for first, second, fluid, number in zip(*tables, energy, owner + 1, strict=True):
        if is_isobaric:
            work = _largest_work(first, second, force)
        else:
            covered = (first <= force[:, None]) & (force[:, None] <= second)
            work = np.where(covered, force[:, None] * strain * float(bundle.length), np.nan)
        efficiency = work / fluid
        # also a first value: comparisons with NaN are false
        better = np.isfinite(efficiency) & ~(efficiency <= best)
        best, state = np.where(better, efficiency, best), np.where(better, number, state)
    highest = float(np.nanmax(best, initial=0.0))
    if highest > 1 + _ROUNDING:
        laws = dict.fromkeys(unit.muscle.tension.name for unit in bundle.motor_units)
        warn_user(
            f"an efficiency of {highest:.3g} is impossible: {' and '.join(laws)} does more work"
            " than the fluid in a braid of these sizes brings, which a law that is only fitted, or"
            " was fitted to another muscle, may do. Don't rely on the average either."
        )
    return EfficiencyMap(path, force, strain, best, state)


def average_efficiency(
    bundle: "Bundle",
    supply_pressure: Values = None,
    path: str = "isobaric",
    resistance: bool = True,
    scheme: AbstractScheme | str | None = None,
) -> float:
    """Plain mean of the efficiency [-] over the points of its map that a bundle reaches [R18];
    arguments and errors are those of `efficiency_map`: `supply_pressure` [Pa].
    """
    options = {"resistance": resistance, "scheme": scheme}
    return efficiency_map(bundle, supply_pressure, path, **options).average


def _largest_work(forces: np.ndarray, works: np.ndarray, target: np.ndarray) -> Grid:
    """Largest work [J] of the pressures that give a `target` force [N], NaN if none does, from
    `forces` [N] and `works` [J] over level and strain.
    """
    force, best = target[:, None], np.full((len(target), forces.shape[1]), -np.inf)
    # level by level: all at once don't fit into the cache
    for (low, high), (start, end) in zip(pairwise(forces), pairwise(works), strict=True):
        between = (np.minimum(low, high) <= force) & (force <= np.maximum(low, high))
        slope = (end - start) / np.where(high == low, 1.0, high - low)
        np.maximum(best, start + (force - low) * slope, out=best, where=between)
    return np.where(np.isfinite(best), best, np.nan)
