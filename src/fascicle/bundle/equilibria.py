r"""Equilibria of a bundle: strains at which its force equals a load, stable or not.

A bundle's force at fixed pressures is smooth between the kinks of its units (free strain, onset of
buckling, collapse). In such a stretch each unit's force lies, with a margin, among the control
points of the cubic through its values and slopes at the stretch's two ends; where their sums leave
out the load, nothing crosses it. The other stretches are cut into cells, and each of these once
more at the extremum of its own cubic. A change of sign between two nodes, within a stretch or from
it to the next, brackets an equilibrium, and `find_root` finds all of them at once. A pair that is
missed lies in a dip shallower than that cubic's error, of fourth order in the cell. Where the
force jumps past the load, the jump is reported.

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
from .pressurized import BundleBatch, Pressurized


CELLS = 8  # of a stretch that may hold an equilibrium
_MARGIN = 0.25  # of a unit's span over a stretch, beyond its control points
_WIDTH = 1e-13  # strains closer than this are one: some 100 units in the last place
_INSET = 1e-7  # of a stretch: its ends are seen from inside, where kinks have one slope
_LARGEST_BATCH = 2**12  # searches at once
_LARGEST_PAIRS = 2**16  # pairs of units in them, which take memory: 0.2 GB


class Roots(NamedTuple):
    """Equilibria, rising along the last axis and NaN where there are fewer; whether the force
    falls there; how many there are.
    """

    strain: Float[AnyArray, "batch root"]
    falls: Bool[AnyArray, "batch root"]
    count: Int[AnyArray, " batch"]


class Stretches(NamedTuple):
    """Strains [-] of nodes in the order of each bundle's stretches, and the force beyond the load
    there [N].
    """

    strain: Float[AnyArray, "batch node"]
    force: Float[AnyArray, "batch node"]


def batch_size(units: int) -> int:
    """How many bundles of so many `units` are searched at once."""
    return max(1, min(_LARGEST_BATCH, _LARGEST_PAIRS // units**2))


def equilibria(bundles: BundleBatch, load: PerUnit | None = None) -> Roots:
    """All equilibria of each bundle of a batch.

    **Arguments:**

    - `bundles`: at pressures.
    - `load`: force of each [N]; `None` for no force, where stretches begin at the free strain.

    **Returns:** strains [-], whether stable, and how many.
    """
    count, units = bundles.pressures.shape
    size = batch_size(units)
    if count <= size:
        return _equilibria(bundles, load)

    def search(index: Any) -> Roots:
        return _equilibria(bundles.take(index), None if load is None else load[index])

    if bundles.is_numpy and isinstance(load, np.ndarray | None):
        parts = [search(slice(start, start + size)) for start in range(0, count, size)]
        return Roots(*map(np.concatenate, zip(*parts, strict=True)))
    from ..core.jax_backend import jnp, lax

    # one compiled search, called block after block, so that memory doesn't grow with the batch
    index = jnp.minimum(jnp.arange(-(-count // size) * size), count - 1).reshape(-1, size)
    return tree_map(lambda x: x.reshape(-1, *x.shape[2:])[:count], lax.map(search, index))


def first_equilibrium(bundles: BundleBatch) -> Float[AnyArray, " batch"]:
    """The smallest strain without force [-], inf where there is none."""
    roots = equilibria(bundles)
    return where(roots.count > 0, roots.strain[:, 0], np.inf)


def attach_derivatives(live: Pressurized, load: Numbers, strain: Numbers) -> Numbers:
    """Equilibria with their derivatives.

    **Arguments:**

    - `live`: the bundles at pressures, with an axis of one ahead of units.
    - `load`: their force [N], with an axis of one.
    - `strain`: equilibria without derivatives [-]; where one is not finite there is none.

    **Returns:** the strains [-].
    """
    exists = isfinite(strain)
    roots = refine_root(_falling_force, (live, 1.0, load), where(exists, strain, 0.0))
    return where(exists, roots, strain)


def _equilibria(bundles: BundleBatch, load: Numbers | None) -> Roots:
    live = bundles.pressurized()
    here = stop_gradient(live)
    free = here.free_strains[:, 0]
    xp = array_namespace(free) if load is None else array_namespace(free, load)
    least, largest = xp.min(free, axis=1), xp.max(free, axis=1)
    top = maximum((here.farthest + 0.0 * here.free_strains[..., 0])[:, 0], largest)
    if load is None:
        bottom, held = least, 0.0 * least
    else:
        held = stop_gradient(load)
        bottom = (here.nearest + 0.0 * here.free_strains[..., 0])[:, 0]
    kinks = minimum(maximum(here.kinks[:, :, 0], bottom[:, None]), top[:, None])
    ends = xp.sort(xp.concatenate([bottom[:, None], *kinks, top[:, None]], axis=1), axis=1)
    nodes = _nodes(here, held, ends)
    above = nodes.force > 0
    if load is None:
        # at the least free strain all pull, by definition; rounding may say otherwise there
        above = above | (nodes.strain <= least[:, None])

    change = above[:, 1:] != above[:, :-1]
    room = 2 * len(bundles.bundle.motor_units) + 1  # a unit adds one dip, so two roots at most
    count = minimum(change.sum(axis=1), room)
    columns = int(count.max(initial=1)) if xp is np else room
    index = xp.argsort(~change, axis=1, stable=True)[:, :columns]
    exists = np.arange(index.shape[1]) < count[:, None]
    falls = xp.take_along_axis(above, index, axis=1) & exists
    low = xp.take_along_axis(nodes.strain, index, axis=1)
    high = where(exists, xp.take_along_axis(nodes.strain, index + 1, axis=1), low)
    sense = where(falls, 1.0, -1.0)
    strain = find_root(_falling_force, (here, sense, held[:, None]), low, high, 0.5 * (low + high))
    if load is None:
        # equal units vanish together, where they do
        alike = (low <= least[:, None]) & ((largest - least) <= _WIDTH)[:, None]
        strain = where(alike, least[:, None], strain)
    target: Any = held if load is None else load
    strain = refine_root(_falling_force, (live, sense, target[:, None]), strain)
    more = [(0, 0), (0, room - index.shape[1])]
    strain = xp.pad(where(exists, strain, np.nan), more, constant_values=np.nan)
    return Roots(strain, xp.pad(falls, more), count)


def _nodes(here: Pressurized, load: Numbers, ends: Numbers) -> Stretches:
    """Nodes that leave one equilibrium at most between two, and the force beyond a `load` [N].

    **Arguments:**

    - `here`: bundles at pressures.
    - `load`: of each [N].
    - `ends`: of their stretches, rising [-].
    """
    xp = array_namespace(ends)
    left, right = ends[:, :-1], ends[:, 1:]
    wide, inset = right - left > _WIDTH, _INSET * (right - left)
    # the first and the last end have no other side
    low = where(left > ends[:, :1], left + inset, left)
    high = where(right < ends[:, -1:], right - inset, right)
    batch, column = _indices(wide)
    low, high, load = low[batch, column], high[batch, column], load[batch]

    forces, slopes = here.take(batch).unit_forces(xp.stack([low, high], axis=1))
    third = (high - low)[:, None] / 3
    control = (forces[:, 0] + slopes[:, 0] * third, forces[:, 1] - slopes[:, 1] * third)
    bounds = [pick(pick(forces[:, 0], forces[:, 1]), pick(*control)) for pick in (minimum, maximum)]
    margin = _MARGIN * (bounds[1] - bounds[0])
    least = (bounds[0] - margin).sum(axis=-1) - load
    most = (bounds[1] + margin).sum(axis=-1) - load
    force, slope = forces.sum(axis=-1) - load[:, None], slopes.sum(axis=-1)

    # without an equilibrium the force keeps the sign of its ends
    strains = low[:, None] + (high - low)[:, None] * np.linspace(0, 1, 2 * CELLS + 1)
    values = force[:, :1] + 0.0 * strains
    (row,) = _indices((least <= 0) & (most >= 0))
    x, inside = strains[row, ::2], here.take(batch[row])
    value, by = (y.sum(axis=-1) for y in inside.unit_forces(x[:, 1:-1]))
    value = value - load[row, None]
    value = xp.concatenate([force[row, :1], value, force[row, 1:]], axis=1)
    by = xp.concatenate([slope[row, :1], by, slope[row, 1:]], axis=1)
    step = x[:, 1:] - x[:, :-1]
    turn = _extremum(value[:, :-1], value[:, 1:], by[:, :-1] * step, by[:, 1:] * step)
    between = x[:, :-1] + step * turn
    turned = inside.unit_forces(between)[0].sum(axis=-1) - load[row, None]
    strains = _put(strains, (row,), _interleave(x, between))
    values = _put(values, (row,), _interleave(value, turned))

    shape = (*wide.shape, 2 * CELLS + 1)
    flat = (len(ends), shape[1] * shape[2])
    exists = xp.broadcast_to(wide[..., None], shape).reshape(flat)
    # stretches without a width take the node before them, at the beginning the first that is wide
    before = where(exists, np.arange(flat[1]), exists.argmax(axis=1)[:, None])
    before = running_max(before, 1)
    tables = (_put(xp.zeros(shape), (batch, column), x) for x in (strains, values))
    return Stretches(*(xp.take_along_axis(x.reshape(flat), before, axis=1) for x in tables))


def _falling_force(theta: tuple, strain: Numbers) -> tuple[Numbers, Numbers]:
    """The bundle's force beyond a load [N], turned so that it falls, and its slope [N]."""
    here, sense, load = theta
    force, slope = here.force(strain)
    return sense * (force - load), sense * slope


def _indices(marks: Any) -> tuple[Any, ...]:
    """Indices of what is marked; under JAX, which knows no lists of unknown length, of all."""
    if array_namespace(marks) is np:
        return np.nonzero(marks)
    return tuple(x.reshape(-1) for x in np.indices(marks.shape))


def _put(table: Any, index: tuple, values: Any) -> Any:
    """A `table` with other `values` at an index."""
    if array_namespace(table, values) is np:
        table[index] = values
        return table
    return array_namespace(table, values).asarray(table).at[index].set(values)


def _interleave(ends: Numbers, between: Numbers) -> Numbers:
    xp = array_namespace(ends, between)
    pairs = xp.stack([ends[:, :-1], between], axis=-1).reshape(len(ends), 2 * CELLS)
    return xp.concatenate([pairs, ends[:, -1:]], axis=1)


def _extremum(left: Numbers, right: Numbers, left_slope: Numbers, right_slope: Numbers) -> Numbers:
    """Where in (0, 1) the cubic of these values and slopes turns; the middle if nowhere."""
    c3 = 2 * (left - right) + left_slope + right_slope
    c2 = 3 * (right - left) - 2 * left_slope - right_slope
    # 3 c3 t² + 2 c2 t + left_slope = 0, by the form that doesn't cancel
    inside = sqrt(maximum(c2**2 - 3 * c3 * left_slope, 0.0))
    q = -(c2 + where(c2 < 0, -inside, inside))
    t1 = q / where(c3 == 0, np.inf, 3 * c3)
    t2 = left_slope / where(q == 0, np.inf, q)
    good1, good2 = (t1 > 0) & (t1 < 1), (t2 > 0) & (t2 < 1)
    return where(good1, t1, where(good2, t2, 0.5))
