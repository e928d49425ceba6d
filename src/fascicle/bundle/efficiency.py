r"""Work, fluid energy and efficiency of a bundle.

$$W = L_0 \int_0^\varepsilon F \,\mathrm{d}\varepsilon', \qquad
  E = P_s \sum_{active} n_i (V_i(\varepsilon) - V_i(0)), \qquad
  \eta = W/E. \tag{28-30}$$

The supply's pressure $P_s$ counts, also for a unit that is throttled below it, and the
volume is the fluid's: the bladder is incompressible, so its own volume cancels [R17]. Where
muscles are of unlike length, $L_0$ is the distance between the plates at rest, and each
muscle's volume is taken at its own strain.

**Quadrature:** Gauss-Legendre on each stretch between a muscle's kinks, where its force is
smooth. The work to a strain is that to the strain before it and a little more, so works along a
whole path are sums over its pieces,

$$W(\varepsilon_j) = L_0 \sum_{i \le j} \int_{\varepsilon_{i-1}}^{\varepsilon_i}
  F \,\mathrm{d}\varepsilon'. \tag{28a}$$

*Isobaric:* pressures are constant along the path from $\varepsilon = 0$, so the work is
the area under that state's curve. *Isotonic:* the load is constant, so
$W = F \varepsilon L_0$. Where several states, or several pressures of one, reach a point,
the highest efficiency counts. The average is over the points of an even grid, forces
$F_{max} i/80$ and strains $j/375$, that the bundle reaches [R18].

**Resolution:** pressures that reach a force are interpolated linearly between levels,
which is exact wherever the muscle pulls: its force and work are linear in pressure there.
**Source:** Kim, Mazzoleni and Bryant (2021), section 4.2 and Fig. 10.
"""

import warnings
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..core.array_namespace import array_namespace, maximum, minimum, node_axis, sum_nodes, where
from ..core.errors import InvalidInputError
from ..core.module import evaluate, with_fields
from ..core.types import AnyArray, Batch, Float, Int, Numbers, PerUnit, Values
from ..core.validation import check_choice, check_finite, is_concrete, to_si
from ..muscle import Muscle
from ..muscle.coenergy import contraction_work
from ..muscle.piecewise import Pressurized
from ..repr_table import ReprTable, format_number, format_range, with_table_repr
from .bundle import (
    Bundle,
    MotorUnit,
    distinct_units,
    resolve_scheme,
    resolve_supply_pressure,
)
from .pressurized import muscle_strain, pressurized
from .schemes import AbstractScheme
from .states import states_of


PATHS = ("isobaric", "isotonic")
_LEVELS = 129  # throttled pressures between which a force is looked for
_FORCES, _STRAIN_STEP = 80, 1 / 375  # the even grid of the average [R18]
_ROUNDING = 1e-9  # of an efficiency of 1, which an ideal mesh has
_PIECE = 1 / 50  # of strain: the fastest decay in use, 100, falls to exp(-2) over it
# nodes of Gauss's rule on a piece, and on one that is no wider than `_NARROW`: error below 1e-13
_NODES, _NARROW, _NODES_NARROW = 6, 1 / 250, 4

Grid = Float[np.ndarray, "force strain"]


def check_volume_by_strain(muscles: Iterable[Muscle]) -> None:
    """Refuse `muscles` [-] whose ends give: what fluid they take in depends on their force, too.
    Warn of those whose braid swells by its pressure.
    """
    for muscle in muscles:
        if muscle.tension.stretches:
            warnings.warn(
                "fluid is counted in the braid as it is without pressure: what fibers that"
                " stretch let it swell by isn't in it.",
                stacklevel=3,
            )
        give = muscle.ends.compliance
        if is_concrete(give) and np.any(np.asarray(give) > 0):
            raise InvalidInputError(
                "end_compliance",
                "must be 0 where strain alone says what fluid a muscle takes in, as for"
                " efficiencies, designs and the least fluid",
                float(np.max(np.asarray(give))),
                "leave it out there; simulations and `conjugate_volume` count fluid at its"
                " pressure",
                shown=f"{1e6 * float(np.max(np.asarray(give))):g} mm/kN",
            )


def unit_volume_change(bundle: Bundle, strain: Values) -> PerUnit:
    """Fluid taken in by each motor unit from rest length on.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `strain`: contraction [-].

    **Returns:** $n_i (V_i(\\varepsilon) - V_i(0))$ [m³], motor units on the last axis.

    **Raises:** `ValueError` for muscles whose ends give under load.
    """
    check_volume_by_strain(unit.muscle for unit in bundle.motor_units)
    rests, ends = [0.0] * len(bundle.motor_units), [strain] * len(bundle.motor_units)
    if bundle.ratios is not None:
        eps = bundle._strain(strain)
        ratios = [bundle.ratios[..., i] for i in range(len(bundle.motor_units))]
        rests = [muscle_strain(ratio, 0.0) for ratio in ratios]
        ends = [muscle_strain(ratio, eps) for ratio in ratios]
    taken = [
        unit.count * (unit.muscle.volume(end) - unit.muscle.volume(rest))
        for unit, rest, end in zip(bundle.motor_units, rests, ends, strict=True)
    ]
    return array_namespace(*taken).stack(taken, axis=-1)


def work(bundle: Bundle, pressures: Values, strain: Values, resistance: bool = True) -> Batch:
    """Work of a contraction from rest length at constant pressures, (28).

    **Arguments:**

    - `bundle`: the bundle [-].
    - `pressures`: gauge pressures [Pa], one for each motor unit on the last axis.
    - `strain`: contraction at the end [-]; broadcasts against the rest of `pressures`.
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** $W$ [J].

    **Raises:** `ValueError` for a wrong number of pressures and values off the domain.
    """
    works = unit_work(bundle, pressures, strain, resistance)
    return array_namespace(works).sum(works, axis=-1)


def unit_work(
    bundle: Bundle, pressures: Values, strain: Values, resistance: bool = True
) -> PerUnit:
    """Work of each motor unit, its muscles together; arguments as of `work`.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `pressures`: gauge pressures [Pa], one for each motor unit on the last axis.
    - `strain`: contraction at the end [-]; broadcasts against the rest of `pressures`.
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** works [J], motor units on the last axis.
    """
    P, eps = bundle._pressures(pressures), bundle._strain(strain)
    return evaluate(_unit_work, bundle, P, eps, static=(bool(resistance),))


def fluid_energy(bundle: Bundle, strain: Values, supply_pressure: Values, active: Values) -> Batch:
    """Energy drawn from the supply by a contraction from rest length, (29).

    **Arguments:**

    - `bundle`: the bundle [-].
    - `strain`: contraction at the end [-].
    - `supply_pressure`: $P_s$ [Pa].
    - `active`: which motor units are fed [-], 0 or 1 each, on the last axis.

    **Returns:** $E$ [J].
    """
    taken = unit_volume_change(bundle, strain)
    supply_pressure = to_si(supply_pressure, "supply_pressure", "Pa")
    at_work = array_namespace(taken, supply_pressure)
    return supply_pressure * at_work.sum(at_work.asarray(active) * taken, axis=-1)


def _unit_work(bundle: Bundle, pressures: Numbers, strain: Numbers, resistance: bool) -> Numbers:
    def one(muscle: Pressurized, strain: Numbers, rest: Numbers) -> Numbers:
        return contraction_work(muscle, strain, rest, resistance)

    # of a muscle that isn't as long as the plates are apart, the strain at rest isn't zero;
    # its own length times its own strain is the plates' way all the same
    at = pressurized(bundle, pressures)
    return bundle.counts * at.map_units_over_strain(one, strain, 0.0 * strain)


def unit_work_along(
    bundle: Bundle, pressures: Values, strain: Values, resistance: bool = True
) -> Float[AnyArray, "level strain unit"]:
    """Work of each motor unit from rest length to every strain, at constant pressures.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `pressures`: gauge pressures [Pa], a row for each level, one for each unit in it.
    - `strain`: a list of contractions [-].
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** works [J].

    **Raises:** `ValueError` for a wrong number of pressures and values off the domain.
    """
    P, eps = bundle._pressures(pressures), bundle._strain(strain)
    low, high = (float(pick(np.asarray(eps), initial=0.0)) for pick in (np.min, np.max))
    even = np.linspace(low, high, int(np.ceil((high - low) / _PIECE)) + 1)
    stops = np.concatenate([[0.0], np.asarray(eps, float), even])
    widest = float(np.max(np.diff(np.sort(stops)), initial=0.0))
    static = (int(np.size(eps)), _NODES_NARROW if widest <= _NARROW else _NODES, bool(resistance))
    return evaluate(_along, bundle, P, stops, static=static)


def _along(
    bundle: Bundle, pressures: Numbers, stops: Numbers, wanted: int, count: int, resistance: bool
) -> Numbers:
    x, weights = np.polynomial.legendre.leggauss(count)

    def one(muscle: Pressurized, stops: Numbers) -> Numbers:
        at_work = array_namespace(stops, muscle.collapse)
        kinks = at_work.moveaxis(muscle.kinks[:, :, 0], 0, 1)  # level, kind, unit
        stops = stops + 0.0 * kinks[:, :1]
        low, high = (pick(stops, axis=1, keepdims=True) for pick in (at_work.min, at_work.max))
        ends = at_work.concatenate([stops, minimum(maximum(kinks, low), high)], axis=1)
        order = at_work.argsort(ends, axis=1)
        ends = at_work.take_along_axis(ends, order, axis=1)
        middle, half = (ends[:, 1:] + ends[:, :-1]) / 2, (ends[:, 1:] - ends[:, :-1]) / 2
        eps = middle + half * node_axis(x, middle)
        F = muscle.force(eps)[0]
        if not resistance:
            F = where(eps <= muscle.column.free_strain, F, 0.0)
        pieces = half * sum_nodes(node_axis(weights, middle) * F)
        sums = at_work.cumsum(pieces, axis=1)
        sums = at_work.concatenate([0.0 * ends[:, :1], sums], axis=1)
        # where each stop has come to lie: exactly at an end, so nothing is interpolated
        place = at_work.argsort(order, axis=1)[:, : 1 + wanted]
        works = at_work.take_along_axis(sums, place, axis=1)
        return muscle.column.rest_length * (works[:, 1:] - works[:, :1])

    return bundle.counts * pressurized(bundle, pressures[:, None, :]).map_units_over_strain(
        one, stops
    )


def constant_cross_section(
    muscle: Muscle,
    units: int,
    supply_pressure: Values = None,
    scheme: AbstractScheme | str = "orderly",
) -> Bundle:
    r"""A muscle's section split evenly into motor units of one muscle each.

    $N$ units of radius $r = R/\sqrt N$ take the section of one muscle of radius $R$, with
    $t_0/r_0$, length and braid angle unchanged. $N = 1$ is the single equivalent motor
    unit (SEMU) that a bundle is compared with.

    **Arguments:**

    - `muscle`: the single equivalent motor unit's, of radius $R$ [-].
    - `units`: $N$ [-], at least 1.
    - `supply_pressure`: the bundle's [Pa], if it is known.
    - `scheme`: one of `fascicle.schemes`, by name or as an object [-].

    **Returns:** a bundle [-] of $N$ units.

    **Raises:** `ValueError` for less than one unit.
    """
    if units < 1:
        raise InvalidInputError("units", "must be at least 1", units)
    sizes = (muscle.outer_radius / np.sqrt(units), muscle.wall_thickness / np.sqrt(units))
    thin = with_fields(muscle, outer_radius=sizes[0], wall_thickness=sizes[1])
    return Bundle([MotorUnit(thin)] * units, supply_pressure, scheme)


def _sheet(found: "EfficiencyMap") -> ReprTable:
    """How well a bundle did on the map that was `found` [-]."""
    eta, reached = found.efficiency, np.isfinite(found.efficiency)
    facts = [
        ("path", found.path),
        ("reached", f"{np.sum(reached)} of {eta.size} points"),
        ("forces", format_range(found.force, lambda F: f"{format_number(F)} N")),
        ("strains", format_range(found.strain, lambda strain: f"{strain:.4f}")),
    ]
    if np.any(reached):
        row, column = np.unravel_index(np.nanargmax(eta), eta.shape)
        where = f"at {format_number(found.force[row])} N, strain {found.strain[column]:.4f}"
        facts += [("average", f"{found.average:.4f}"), ("best", f"{np.nanmax(eta):.4f} {where}")]
    return ReprTable("Efficiency", facts)


@with_table_repr(_sheet)
@dataclass(frozen=True)
class EfficiencyMap:
    """`efficiency` [-] over `force` [N] (rows) and `strain` [-] (columns), NaN where the
    bundle doesn't reach; `state`: the recruitment state it is reached in, 0 for none.
    """

    path: str
    force: Float[np.ndarray, " force"]
    strain: Float[np.ndarray, " strain"]
    efficiency: Grid
    state: Int[np.ndarray, "force strain"]

    @property
    def average(self) -> float:
        """Mean efficiency [-] over the points that are reached."""
        return float(np.nanmean(self.efficiency))


def efficiency_map(
    bundle: Bundle,
    supply_pressure: Values = None,
    path: str = "isobaric",
    force: Values = None,
    strain: Values = None,
    resistance: bool = True,
    scheme: AbstractScheme | str | None = None,
) -> EfficiencyMap:
    """Efficiency over the force-strain space.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `supply_pressure`: $P_s$ [Pa]; left out, the bundle's own.
    - `path`: "isobaric" or "isotonic" [-].
    - `force`: forces [N]; left out, 80 even ones up to the blocked force of all units.
    - `strain`: positive strains [-]; left out, multiples of 1/375 to the free strain.
    - `resistance`: whether units past their own free strain push back [-].
    - `scheme`: one of `fascicle.schemes`, by name or as an object [-]; left out, the bundle's own.

    **Returns:** an `EfficiencyMap`: efficiencies [-] over forces [N] and strains [-].

    **Raises:** `ValueError` for an unknown path or scheme and values off the domain.
    """
    supply = resolve_supply_pressure(bundle, supply_pressure)
    scheme = resolve_scheme(bundle, scheme)
    check_choice(path, PATHS, "path")
    if path == "isobaric" and scheme.independent:
        raise InvalidInputError(
            "path",
            f"must be 'isotonic' with scheme {scheme.name!r}",
            path,
            "its units may be at any of many pressures at one force and strain, each with a work of"
            ' its own on the way; ask for path="isotonic" (--path isotonic)',
        )
    few, inverse = distinct_units(bundle)
    states, owner = states_of(scheme, len(bundle.motor_units)).sets(inverse.tolist())
    full = np.full(len(few.motor_units), supply)
    if force is None:
        blocked = np.asarray(few.unit_forces(full, 0.0))[inverse]
        largest = float(blocked.sum())
        force = largest * np.arange(1, _FORCES + 1) / _FORCES
    if strain is None:
        reach = float(few.free_strain(full, resistance=False))
        strain = np.arange(1, int(reach / _STRAIN_STEP) + 1) * _STRAIN_STEP
    force, strain = (
        np.atleast_1d(check_finite(x, name, unit))
        for x, name, unit in ((force, "force", "N"), (strain, "strain", "-"))
    )
    if np.any(strain <= 0):
        raise InvalidInputError(
            "strain", "must be positive", strain.min(), shown=f"{strain.min():g}"
        )

    levels = np.linspace(0.0, supply, _LEVELS)
    pressures = np.r_[levels, 0.0][:, None] * np.ones(len(few.motor_units))
    forces = np.asarray(few.unit_forces(pressures[:, None, :], strain, resistance))[..., inverse]
    table = (forces[:-1], forces[-1], forces[-2])
    taken = np.asarray(unit_volume_change(few, strain))[..., inverse]
    energy = supply * (states.fed.astype(float) @ taken.T)  # state, strain
    if path == "isobaric":
        works = np.asarray(unit_work_along(few, pressures, strain, resistance))[..., inverse]
        reached = states.sums(*table), states.sums(works[:-1], works[-1], works[-2])
    else:
        reached = states.edges(*table)

    best, state = (
        np.full((force.size, strain.size), np.nan),
        np.zeros((force.size, strain.size), int),
    )
    for k, (first, second) in enumerate(zip(*reached, strict=True)):
        work = force[:, None] * strain * float(bundle.length)
        if path == "isobaric":
            work = _best_work(first, second, force)
        else:
            low, high = first, second
            work = np.where((low <= force[:, None]) & (force[:, None] <= high), work, np.nan)
        better = np.fmax(best, work / energy[k]) != best
        better &= np.isfinite(work)
        best = np.where(better, work / energy[k], best)
        state = np.where(better, owner[k] + 1, state)
    _possible(bundle, best)
    return EfficiencyMap(path, force, strain, best, state)


def average_efficiency(
    bundle: Bundle,
    supply_pressure: Values = None,
    path: str = "isobaric",
    resistance: bool = True,
    scheme: AbstractScheme | str | None = None,
) -> float:
    """Mean efficiency over the force-strain space that the bundle reaches [R18].

    **Arguments:**

    - `bundle`: the bundle [-].
    - `supply_pressure`: $P_s$ [Pa]; left out, the bundle's own.
    - `path`: "isobaric" or "isotonic" [-].
    - `resistance`: whether units past their own free strain push back [-].
    - `scheme`: one of `fascicle.schemes`, by name or as an object [-]; left out, the bundle's own.

    **Returns:** efficiency [-].

    **Raises:** `ValueError` for an unknown path or scheme and values off the domain.
    """
    return efficiency_map(
        bundle, supply_pressure, path, resistance=resistance, scheme=scheme
    ).average


def _possible(bundle: Bundle, efficiency: Grid) -> None:
    """Warn of an `efficiency` [-] above 1, which laws that are fits and nothing else may say."""
    most = float(np.nanmax(efficiency, initial=0.0))
    if most <= 1 + _ROUNDING:
        return
    laws = dict.fromkeys(unit.muscle.tension.name for unit in bundle.motor_units)
    warnings.warn(
        f"an efficiency of {most:.3g} can't be: {' and '.join(laws)} does more work than the fluid"
        " in a braid of these sizes brings; as a law of another muscle, or one that is only"
        " fitted, may. The average means as little.",
        stacklevel=3,
    )


def _best_work(
    forces: Float[np.ndarray, "level strain"],
    works: Float[np.ndarray, "level strain"],
    wanted: Float[np.ndarray, " force"],
) -> Grid:
    """Largest work of the pressures that give a `wanted` force; NaN where none does."""
    order = np.argsort(wanted)
    rising, best = wanted[order, None], np.full((len(wanted), forces.shape[1]), -np.inf)
    least, most = np.minimum(forces[:-1], forces[1:]), np.maximum(forces[:-1], forces[1:])
    first = np.searchsorted(rising[:, 0], least.min(axis=1))
    last = np.searchsorted(rising[:, 0], most.max(axis=1), side="right")
    # level by level: few forces lie between two, and all at once don't fit into the cache
    for n, (start, stop) in enumerate(zip(first, last, strict=True)):
        target, rise = rising[start:stop], forces[n + 1] - forces[n]
        slope = (works[n + 1] - works[n]) / np.where(rise == 0, 1.0, rise)
        between = (least[n] <= target) & (target <= most[n])
        there = np.where(between, works[n] + (target - forces[n]) * slope, -np.inf)
        np.maximum(best[start:stop], there, out=best[start:stop])
    found = np.empty_like(best)
    found[order] = best
    return np.where(np.isfinite(found), found, np.nan)
