r"""Efficiency of reaching a point of the force-strain space, isobaric or isotonic.

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
from dataclasses import dataclass

import numpy as np

from ..bundle import Bundle
from ..bundle.own import scheme_used, supply_of
from ..bundle.schemes import AbstractScheme
from ..bundle.states import states_of
from ..bundle.unit_tables import distinct
from ..bundle.volumes import unit_volume_change
from ..core.errors import InvalidInputError
from ..core.types import Float, Int, Values
from ..core.validation import check_choice, check_finite
from ..repr_table import ReprTable, format_number, format_range, with_table_repr
from .paths import unit_work_along


PATHS = ("isobaric", "isotonic")
_LEVELS = 129  # throttled pressures between which a force is looked for
_FORCES, _STRAIN_STEP = 80, 1 / 375  # the even grid of the average [R18]
_ROUNDING = 1e-9  # of an efficiency of 1, which an ideal mesh has

Grid = Float[np.ndarray, "force strain"]


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
    supply = supply_of(bundle, supply_pressure)
    scheme = scheme_used(bundle, scheme)
    check_choice(path, PATHS, "path")
    if path == "isobaric" and scheme.independent:
        raise InvalidInputError(
            "path",
            f"must be 'isotonic' with scheme {scheme.name!r}",
            path,
            "its units may be at any of many pressures at one force and strain, each with a work of"
            ' its own on the way; ask for path="isotonic" (--path isotonic)',
        )
    few, places = distinct(bundle)
    states, owner = states_of(scheme, len(bundle.motor_units)).sets(places.tolist())
    full = np.full(len(few.motor_units), supply)
    if force is None:
        blocked = np.asarray(few.unit_forces(full, 0.0))[places]
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
    forces = np.asarray(few.unit_forces(pressures[:, None, :], strain, resistance))[..., places]
    table = (forces[:-1], forces[-1], forces[-2])
    taken = np.asarray(unit_volume_change(few, strain))[..., places]
    energy = supply * (states.fed.astype(float) @ taken.T)  # state, strain
    if path == "isobaric":
        works = np.asarray(unit_work_along(few, pressures, strain, resistance))[..., places]
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
