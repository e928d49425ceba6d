r"""Equilibria of a bundle: strains at which its force equals a load, stable or not.

A bundle's force at fixed pressures is smooth between the kinks of its units (free strain, onset of
buckling, collapse). In such a stretch each unit's force lies, with a margin, among the control
points of the cubic through its values and slopes at the stretch's two ends; if their sums leave
out the load, nothing crosses it. The other stretches are cut into cells, and each cell once more at
the extremum of its own cubic. A change of sign between two nodes, within a stretch or from it to
the next, brackets an equilibrium, and `find_root` finds all of them at once. A pair that is missed
lies in a dip shallower than that cubic's error, of fourth order in the cell. If the force jumps
past the load, the jump is reported.

Without a load all units pull before the least free strain: stretches begin there. With one, they
begin where the fibers of a muscle are straight.
"""

from typing import Any, NamedTuple

import numpy as np

from ..core.array_namespace import (
    array_namespace,
    isfinite,
    maximum,
    minimum,
    running_max,
    sqrt,
    where,
)
from ..core.module import tree_map
from ..core.roots import find_root, refine_root, stop_gradient
from ..core.types import AnyArray, Bool, Float, Int, Numbers, PerUnit
from ..repr_table import with_table_repr
from .pressurized import BundleBatch, Pressurized
from .printing import equilibria_table


_CELLS = 8  # of a stretch that may hold an equilibrium: a dip between two nodes is of fourth order
_MARGIN = 0.25  # of a unit's span over a stretch, beyond its control points
_WIDTH = 1e-13  # strains closer than this are equal: some 100 units in the last place
_INSET = 1e-7  # of a stretch: its ends are evaluated inside, where kinks have one slope
_BATCH = 2**12  # bundles searched at once
_PAIRS = 2**16  # pairs of units in them, which take memory: 0.2 GB


@with_table_repr(equilibria_table)
class Equilibria(NamedTuple):
    """Strains of zero force [-], rising along the last axis, which ends in NaN where there
    are fewer. `stable`: the force falls with strain there. `count`: their number.
    """

    strain: Float[AnyArray, "*#points zero"]
    stable: Bool[AnyArray, "*#points zero"]
    count: Int[AnyArray, "*#points"]


def find_equilibria(bundles: BundleBatch, load: PerUnit | None = None) -> Equilibria:
    """All equilibria of each bundle of a batch under its `load` [N]; without one, stretches begin
    at the free strain.
    """
    count, units = bundles.pressures.shape
    size = max(1, min(_BATCH, _PAIRS // units**2))
    if count <= size:
        return _equilibria_of_block(bundles, load)

    def search(index: Any) -> Equilibria:
        return _equilibria_of_block(bundles.take(index), None if load is None else load[index])

    if bundles.is_numpy and isinstance(load, np.ndarray | None):
        parts = [search(slice(start, start + size)) for start in range(0, count, size)]
        return Equilibria(*map(np.concatenate, zip(*parts, strict=True)))
    from ..core.jax_backend import jnp, lax

    # one compiled search, called block after block, so that memory doesn't grow with the batch
    index = jnp.minimum(jnp.arange(-(-count // size) * size), count - 1).reshape(-1, size)
    return tree_map(lambda x: x.reshape(-1, *x.shape[2:])[:count], lax.map(search, index))


def attach_derivatives(pressurized: Pressurized, load: Numbers, strain: Numbers) -> Numbers:
    """Equilibria [-] with their derivatives, from `strain` [-] without them, which is not finite
    where there are none; `load`: force of the bundles [N]. Both have an axis of one ahead of units.
    """
    exists = isfinite(strain)
    roots = refine_root(_falling_force, (pressurized, 1.0, load), where(exists, strain, 0.0))
    return where(exists, roots, strain)


def _equilibria_of_block(bundles: BundleBatch, load: Numbers | None) -> Equilibria:
    """As `find_equilibria`, of a batch that fits the memory."""
    pressurized = bundles.pressurized()
    constant = stop_gradient(pressurized)
    free_strains = constant.free_strains[:, 0]
    xp = array_namespace(free_strains) if load is None else array_namespace(free_strains, load)
    lowest_free, highest_free = xp.min(free_strains, axis=1), xp.max(free_strains, axis=1)
    zero = 0.0 * free_strains[:, 0]
    end = maximum(constant.largest_strain + zero[:, None], highest_free[:, None])
    start = lowest_free[:, None] if load is None else constant.least_strain + zero[:, None]
    constant_load = zero if load is None else stop_gradient(load)
    kinks = minimum(maximum(constant.kinks[:, :, 0], start), end)
    nodes, force = _nodes(
        constant, constant_load, xp.sort(xp.concatenate([start, *kinks, end], axis=1), axis=1)
    )
    pulls = force > 0
    if load is None:
        # all units pull up to the least free strain, by definition; rounding may differ there
        pulls = pulls | (nodes <= lowest_free[:, None])

    change = pulls[:, 1:] != pulls[:, :-1]
    slots = 2 * len(bundles.bundle.motor_units) + 1  # a unit adds one dip, so two roots at most
    count = minimum(change.sum(axis=1), slots)
    columns = int(count.max(initial=1)) if xp is np else slots
    index = xp.argsort(~change, axis=1, stable=True)[:, :columns]
    exists = np.arange(index.shape[1]) < count[:, None]
    falls = xp.take_along_axis(pulls, index, axis=1) & exists
    low = xp.take_along_axis(nodes, index, axis=1)
    high = where(exists, xp.take_along_axis(nodes, index + 1, axis=1), low)
    sign = where(falls, 1.0, -1.0)
    theta = (constant, sign, constant_load[:, None])
    strain = find_root(_falling_force, theta, low, high, 0.5 * (low + high))
    if load is None:
        # equal units all vanish at their free strain
        equal = (low <= lowest_free[:, None]) & ((highest_free - lowest_free) <= _WIDTH)[:, None]
        strain = where(equal, lowest_free[:, None], strain)
    target: Any = constant_load if load is None else load
    strain = refine_root(_falling_force, (pressurized, sign, target[:, None]), strain)
    padding = [(0, 0), (0, slots - index.shape[1])]
    strain = xp.pad(where(exists, strain, np.nan), padding, constant_values=np.nan)
    return Equilibria(strain, xp.pad(falls, padding), count)


def _nodes(bundles: Pressurized, load: Numbers, ends: Numbers) -> tuple[Numbers, Numbers]:
    """Strains [-] of nodes with one equilibrium at most between two, and the force beyond a `load`
    [N] there, for each bundle in order; `ends`: of its stretches, rising [-].
    """
    xp = array_namespace(ends)
    left, right = ends[:, :-1], ends[:, 1:]
    wide, inset = right - left > _WIDTH, _INSET * (right - left)
    # the first and the last end have no other side
    low = where(left > ends[:, :1], left + inset, left)
    high = where(right < ends[:, -1:], right - inset, right)
    batch, column = _indices(wide)
    low, high, load = low[batch, column], high[batch, column], load[batch]

    forces, slopes = bundles.take(batch).unit_forces(xp.stack([low, high], axis=1))
    third = (high - low)[:, None] / 3
    control = (forces[:, 0] + slopes[:, 0] * third, forces[:, 1] - slopes[:, 1] * third)
    bounds = [pick(pick(forces[:, 0], forces[:, 1]), pick(*control)) for pick in (minimum, maximum)]
    margin = _MARGIN * (bounds[1] - bounds[0])
    lowest = (bounds[0] - margin).sum(axis=-1) - load
    highest = (bounds[1] + margin).sum(axis=-1) - load
    force, slope = forces.sum(axis=-1) - load[:, None], slopes.sum(axis=-1)

    # without an equilibrium the force keeps the sign of its ends
    strains = low[:, None] + (high - low)[:, None] * np.linspace(0, 1, 2 * _CELLS + 1)
    values = force[:, :1] + 0.0 * strains
    (row,) = _indices((lowest <= 0) & (highest >= 0))
    x, cut = strains[row, ::2], bundles.take(batch[row])
    value, by_strain = (y.sum(axis=-1) for y in cut.unit_forces(x[:, 1:-1]))
    value = value - load[row, None]
    value = xp.concatenate([force[row, :1], value, force[row, 1:]], axis=1)
    by_strain = xp.concatenate([slope[row, :1], by_strain, slope[row, 1:]], axis=1)
    step = x[:, 1:] - x[:, :-1]
    by_cell = (by_strain[:, :-1] * step, by_strain[:, 1:] * step)
    middle = x[:, :-1] + step * _extremum(value[:, :-1], value[:, 1:], *by_cell)
    middle_value = cut.unit_forces(middle)[0].sum(axis=-1) - load[row, None]
    strains = _put(strains, (row,), _interleave(x, middle))
    values = _put(values, (row,), _interleave(value, middle_value))

    shape = (*wide.shape, 2 * _CELLS + 1)
    flat = (len(ends), shape[1] * shape[2])
    exists = xp.broadcast_to(wide[..., None], shape).reshape(flat)
    # stretches without a width take the node before them, at the beginning the first that is wide
    before = where(exists, np.arange(flat[1]), exists.argmax(axis=1)[:, None])
    before = running_max(before, 1)
    tables = (_put(xp.zeros(shape), (batch, column), x) for x in (strains, values))
    strains, values = (xp.take_along_axis(x.reshape(flat), before, axis=1) for x in tables)
    return strains, values


def _falling_force(theta: tuple, strain: Numbers) -> tuple[Numbers, Numbers]:
    """Force of bundles beyond a load [N], times the sign with which it falls, and its slope [N]."""
    bundles, sign, load = theta
    force, slope = bundles.force(strain)
    return sign * (force - load), sign * slope


def _indices(mask: Any) -> tuple[Any, ...]:
    """Indices where a mask is true; under JAX, whose arrays have fixed lengths, all indices."""
    if array_namespace(mask) is np:
        return np.nonzero(mask)
    return tuple(x.reshape(-1) for x in np.indices(mask.shape))


def _put(table: Any, index: tuple, values: Any) -> Any:
    """A `table` with `values` at an index."""
    if array_namespace(table, values) is np:
        table[index] = values
        return table
    return array_namespace(table, values).asarray(table).at[index].set(values)


def _interleave(ends: Numbers, middle: Numbers) -> Numbers:
    xp = array_namespace(ends, middle)
    pairs = xp.stack([ends[:, :-1], middle], axis=-1).reshape(len(ends), 2 * _CELLS)
    return xp.concatenate([pairs, ends[:, -1:]], axis=1)


def _extremum(left: Numbers, right: Numbers, left_slope: Numbers, right_slope: Numbers) -> Numbers:
    """Extremum in (0, 1) of the cubic of these values and slopes; the middle if there is none."""
    c3 = 2 * (left - right) + left_slope + right_slope
    c2 = 3 * (right - left) - 2 * left_slope - right_slope
    # 3 c3 t² + 2 c2 t + left_slope = 0, by the form that doesn't cancel
    inside = sqrt(maximum(c2**2 - 3 * c3 * left_slope, 0.0))
    q = -(c2 + where(c2 < 0, -inside, inside))
    t1 = q / where(c3 == 0, np.inf, 3 * c3)
    t2 = left_slope / where(q == 0, np.inf, q)
    return where((t1 > 0) & (t1 < 1), t1, where((t2 > 0) & (t2 < 1), t2, 0.5))
