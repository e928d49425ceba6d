r"""Recruitment: the pressures and the workspace of each recruitment state, and overlaps of two.

A scheme says which units are held at supply pressure in recruitment state $k$ and which are
throttled: *orderly* recruitment holds $1 \dots k-1$ and throttles unit $k$, *batch* recruitment
gives all of $1 \dots k$ one pressure, *free* recruitment has one state, in which each unit has a
pressure of its own. As the throttled pressure goes from zero to the supply's, a state sweeps a
region of the force-strain plane; together the regions are the bundle's workspace. With resistance
the force isn't monotone in that pressure, so a region's edges are the least and the largest force
over all pressures, and regions of different states overlap: points that two states reach.

**Resolution:** regions are taken over a fixed number of pressures; their edges are exact
where the force is linear in pressure, that is, wherever the muscle pulls.
**Source:** Kim, Mazzoleni and Bryant (2021), sections 4 and 4.1, Figs. 8 and 9.
"""

from dataclasses import dataclass, field
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from ..core.types import Float, Marks, Values
from ..core.validation import (
    check_gauge_pressure,
    check_interval,
    check_scalar,
    check_whole_number,
    has_units,
    to_si,
)
from .inverse import RecruitmentResult, Solutions, recruit
from .schemes import AbstractScheme, scheme_of
from .states import overlap_edges, resolve_scheme, resolve_supply_pressure, states_of


if TYPE_CHECKING:
    from .bundle import Bundle


__all__ = [
    "Overlap",
    "RecruitmentResult",
    "Solutions",
    "Workspace",
    "overlap",
    "pressures_of",
    "recruit",
    "workspace",
]

_LEVELS = 241  # pressures over which a region's edges are taken: 0.4 % of the supply apart
_TOUCH = 1e-9  # of the largest force: regions that share an edge alone differ by rounding
Forces = Float[np.ndarray, "state strain"]
Outline = tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]


def pressures_of(
    state: int,
    level: Values,
    supply_pressure: Values,
    units: int,
    scheme: AbstractScheme | str = "orderly",
) -> Float[np.ndarray, "*levels unit"]:
    """Pressures of all units [Pa], on a new last axis, in a recruitment `state`, counted from 1, of
    so many `units` with a `scheme`.

    `level`: the throttled pressure [Pa], of any shape; `supply_pressure` [Pa]: of the units that
    the state holds full. `ValueError` for a state or scheme that doesn't exist.
    """
    states = states_of(scheme_of(scheme), units)
    state = check_whole_number(state, "state", 1, states.size)
    level, name = check_gauge_pressure(level, "level"), "supply_pressure"
    supply = check_scalar(check_gauge_pressure(supply_pressure, name), name)
    return states.pressures(state - 1, level, supply)


@dataclass(frozen=True)
class Workspace:
    """Region of forces and strains that each recruitment state of a bundle reaches.

    `force` [N] at constant throttled pressures, over state, `level` [Pa] and `strain` [-]; `low`
    and `high` [N], over state and strain: the edges of each state's region.
    """

    scheme: str
    supply_pressure: float
    strain: Float[np.ndarray, " strain"] = field(repr=False)
    level: Float[np.ndarray, " level"]
    force: Float[np.ndarray, "state level strain"] = field(repr=False)
    low: Forces = field(repr=False)
    high: Forces = field(repr=False)

    def outline(self, state: int) -> Outline:
        """Outline of the region of a `state`, counted from 1: strain [-] and force [N]; at zero
        force where the bundle would push.
        """
        low, high = (np.maximum(edge[state - 1], 0.0) for edge in (self.low, self.high))
        return boundary(self.strain, low, high, self.high[state - 1] >= 0)


@dataclass(frozen=True)
class Overlap:
    """Points that two states reach, a row for each pair of `states`, counted from 1: edges `low`
    and `high` [N] over `strain` [-] (NaN where there is no overlap), and the `area` [N].
    """

    states: tuple[tuple[int, int], ...]
    strain: Float[np.ndarray, " strain"]
    low: Float[np.ndarray, "pair strain"]
    high: Float[np.ndarray, "pair strain"]
    area: Float[np.ndarray, " pair"]

    def outline(self, pair: int) -> Outline:
        """Outline of the overlap in row `pair`: strain [-] and force [N]; empty without one."""
        low, high = self.low[pair], self.high[pair]
        return boundary(self.strain, low, high, np.isfinite(low))


def boundary(strain: np.ndarray, low: np.ndarray, high: np.ndarray, inside: Marks) -> Outline:
    """Strains [-] there and back, with the `high` edge [N] there and the `low` one back."""
    strain, low, high = strain[inside], low[inside], high[inside]
    return np.r_[strain, strain[::-1]], np.r_[high, low[::-1]]


def workspace(
    bundle: "Bundle",
    supply_pressure: Values = None,
    levels: Values = 7,
    strain: Values = None,
    resistance: bool = True,
    scheme: AbstractScheme | str | None = None,
) -> Workspace:
    """Region of forces [N] and strains [-] that every recruitment state of a `bundle` reaches, and
    curves at the throttled pressures `levels` [Pa], or at so many from zero to the supply's.

    `strain`: rising strains [-]; by default 201 from zero to the largest free strain.
    `supply_pressure` [Pa], `resistance` and `scheme` as of `Bundle.recruit`. `ValueError` for no
    supply pressure and values off the domain.
    """
    supply = resolve_supply_pressure(bundle, supply_pressure)
    scheme = resolve_scheme(bundle, scheme)
    if has_units(levels):
        levels = np.atleast_1d(to_si(levels, "levels", "Pa"))
    if np.ndim(levels) == 0:
        levels = np.linspace(0.0, supply, check_whole_number(levels, "levels", 1))
    levels = np.asarray(check_interval(levels, 0.0, supply, "levels", "Pa", closed=(True, True)))
    if strain is None:
        full = np.full(len(bundle.motor_units), supply)
        strain = np.linspace(0.0, float(bundle.free_strain(full, resistance=False)), 201)
    strain = np.asarray(to_si(strain, "strain", "-"), dtype=float)
    states = states_of(scheme, len(bundle.motor_units))
    # a level may occur twice: `np.union1d` imports masked arrays, which takes 10 ms
    fine = np.sort(np.append(np.linspace(0.0, supply, _LEVELS), levels))
    forces, *ends = unit_tables(bundle, supply, fine, strain, resistance)
    curves = states.sums(forces[np.searchsorted(fine, levels)], *ends)
    return Workspace(scheme.name, supply, strain, levels, curves, *states.edges(forces, *ends))


def overlap(workspace: Workspace) -> Overlap:
    """Overlaps of the regions of two states of a `workspace`, at forces of zero and above: forces
    [N] and areas [N], a row for each pair of states.
    """
    pairs = tuple(combinations(range(1, len(workspace.low) + 1), 2))
    first, second = np.array(pairs, int).reshape(-1, 2).T - 1
    low, high = workspace.low, workspace.high
    low, high = overlap_edges((low[first], high[first]), (low[second], high[second]))
    inside = high - low > _TOUCH * np.abs(workspace.high).max()
    low, high = (np.where(inside, edge, np.nan) for edge in (low, high))
    area = np.trapezoid(np.nan_to_num(high - low), workspace.strain, axis=1)
    return Overlap(pairs, workspace.strain, low, high, area)


def unit_tables(
    bundle: "Bundle",
    supply_pressure: float,
    levels: Float[np.ndarray, " level"],
    strain: Float[np.ndarray, " strain"],
    resistance: bool,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Force of every unit [N] at each of `levels` [Pa], with level, strain and unit axes, and at no
    and at full pressure, without levels: the arguments of `States.sums` and `States.edges`.
    """
    distinct, inverse = bundle.distinct_units()
    pressures = np.r_[levels, 0.0, supply_pressure][:, None, None]
    pressures = pressures * np.ones(len(distinct.motor_units))
    table = np.asarray(distinct.unit_forces(pressures, strain, resistance))[..., inverse]
    return table[:-2], table[-2], table[-1]
