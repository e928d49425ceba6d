r"""Equilibria of a bundle: strains at which its force equals a load, stable or not.

A bundle's force at fixed pressures is smooth between the kinks of its units (free strain, onset of
buckling, jump, collapse). After collapse it changes within a few lengths of its decay: these are
stretches of their own. In a stretch each unit's force lies, with a margin, among the control points
of the cubic through its values and slopes at the stretch's two ends; if their sums leave out the
load, nothing crosses it. The other stretches are cut into cells, whose nodes are joined by the
extrema that may reach the load. A change of sign between two nodes, within a stretch or from it to
the next, brackets an equilibrium, and `find_root` finds all of them at once. If the force jumps
past the load, the jump is reported.

Without a load all units pull before the least free strain: stretches begin there. With one, they
begin where the domain does, beside straight fibers, where a bladder's force has no bound.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..core.array_namespace import isfinite, slices, stack, where
from ..core.module import tree_map
from ..core.roots import find_root, refine_root
from ..core.types import AnyArray, Bool, Float, Int, Numbers, PerUnit
from ..core.validation import LARGEST_STRAIN
from ..muscle.piecewise import PressurizedMuscle
from ..muscle.validation import lowest_strain
from ..repr_table import with_table_repr
from .force_curves import insert_extrema
from .pressurized import PressurizedBundle, flatten_batch, pressurize
from .printing import equilibria_table


if TYPE_CHECKING:
    from .bundle import Bundle


_CELLS = 16  # of a stretch that may hold an equilibrium: enough to separate its extrema
_DECAYS = (1, 2, 4, 8)  # lengths 1/β of (26): each stretch has its own cells
_MARGIN = 0.25  # of a unit's span over a stretch, beyond its control points
_WIDTH = 1e-13  # strains closer than this are equal: some 100 units in the last place
_INSET = 1e-7  # of a stretch: its ends are evaluated inside, where kinks have one slope
_BATCH = 2**8  # bundles searched at once: arrays of more leave the cache
_PAIRS = 2**16  # pairs of units in them, which take memory: 0.2 GB


@with_table_repr(equilibria_table)
class Equilibria(NamedTuple):
    """Strains [-] at which the force is zero or equals the load, rising along the last axis, which
    ends in NaN where there are fewer. `stable`: the force falls with strain there, or jumps down
    past the load. `count`: their number. JAX's arrays, of a fixed shape, have room for the
    first 2 · units + 1; more are rare, and counted.
    """

    strain: Float[AnyArray, "*#points zero"]
    stable: Bool[AnyArray, "*#points zero"]
    count: Int[AnyArray, "*#points"]


def find_equilibria(bundle: "Bundle", pressures: PerUnit, *force: Numbers) -> Equilibria:
    """All equilibria of a bundle or a batch at `pressures` [Pa], under a `force` [N] if given."""
    arrays, shape = flatten_batch(bundle, pressures, *force)
    count, _, units = arrays[1].shape
    parts = []
    with np.errstate(all="ignore"):  # of branches that aren't taken
        for i in slices(count, max(1, min(_BATCH, _PAIRS // units**2))):
            block, P, load = tree_map(lambda x, i=i: x[i] if np.ndim(x) > 1 else x, arrays)
            parts.append(_equilibria_of_block(pressurize(block, P), load if force else None))
    found, strain, falls = (np.concatenate(x) for x in zip(*parts, strict=True))
    slots = max(usual_count(units), int(found.max(initial=0)))
    exists = np.arange(slots) < found[:, None]
    table, stable = np.full(exists.shape, np.nan), np.zeros(exists.shape, bool)
    table[exists], stable[exists] = strain, falls
    return Equilibria(*(x.reshape((*shape, *x.shape[1:])) for x in (table, stable, found)))


def find_first_equilibria(bundle: "Bundle", pressures: PerUnit, *force: Numbers) -> Equilibria:
    """As `find_equilibria`, in arrays of a fixed shape, as JAX needs: those beyond `usual_count`
    are left out, and counted all the same.
    """
    roots = find_equilibria(bundle, pressures, *force)
    slots = slice(usual_count(np.shape(pressures)[-1]))
    return roots._replace(strain=roots.strain[..., slots], stable=roots.stable[..., slots])


def usual_count(units: int) -> int:
    """Least number of equilibria that a result has room for: each unit adds a dip, with two."""
    return 2 * units + 1


def attach_derivatives(
    bundle: "Bundle", strain: Numbers, pressures: PerUnit, force: Numbers = 0.0
) -> Numbers:
    """Equilibria [-] with their derivatives, from `strain` [-] without them, which is not finite
    where there are none; `bundle`, `pressures` [Pa] and `force` [N] as of `find_equilibria`.
    """
    (bundle, P, load), _ = flatten_batch(bundle, pressures, force)
    exists = isfinite(strain)
    start = where(exists, strain, 0.0).reshape(len(load), -1)
    roots = refine_root(_falling_force, (pressurize(bundle, P), 1.0, load), start)
    return where(exists, roots.reshape(strain.shape), strain)


def _equilibria_of_block(
    pressurized: PressurizedBundle, load: Numbers | None
) -> tuple[Numbers, Numbers, Numbers]:
    """Number of equilibria of each bundle of a batch that fits the memory, with an axis of one
    ahead of units; and of all in order their strains [-], and whether the force falls there.
    """

    def strains(function: Callable[[PressurizedMuscle], Numbers]) -> Numbers:
        return pressurized.plate_strains(function)[..., 0, :]

    kinks = np.concatenate([strains(lambda muscle: muscle.kinks), strains(_smooth_ends)])
    lowest_free, highest_free = (pick(kinks[0], axis=1, keepdims=True) for pick in (np.min, np.max))
    # the domain of all muscles' laws
    end = strains(lambda _: LARGEST_STRAIN).min(axis=1, keepdims=True)
    end, start = np.maximum(end, highest_free), lowest_free
    if load is not None:
        lowest = strains(lambda muscle: lowest_strain(muscle.law))
        start = lowest.max(axis=1, keepdims=True)
    target = 0.0 * lowest_free if load is None else load
    ends = np.sort(np.concatenate([start, *np.clip(kinks, start, end), end], axis=1), axis=1)
    batch, nodes, force = _separating_nodes(pressurized, target[:, 0], ends)

    def excess(strain: Numbers, index: Numbers) -> Numbers:
        return pressurized.take(index).force_and_slope(strain[:, None])[0][:, 0] - target[index, 0]

    smooth = np.ones(len(nodes), bool)
    batch, nodes, force = insert_extrema(excess, batch, nodes, force, 0.0, smooth)
    pulls = force > 0
    if load is None:
        # all units pull up to the least free strain, by definition; rounding may differ there
        pulls |= nodes <= lowest_free[batch, 0]

    change = np.flatnonzero((pulls[1:] != pulls[:-1]) & (batch[1:] == batch[:-1]))
    batch, falls = batch[change], pulls[change]
    low, high = nodes[change, None], nodes[change + 1, None]
    theta = (pressurized.take(batch), np.where(falls, 1.0, -1.0)[:, None], target[batch])
    strain = find_root(_falling_force, theta, low, high, 0.5 * (low + high))
    if load is None:
        # equal units all vanish at their free strain
        equal = (low <= lowest_free[batch]) & ((highest_free - lowest_free)[batch] <= _WIDTH)
        strain = np.where(equal, lowest_free[batch], strain)
    strain = refine_root(_falling_force, theta, strain)[:, 0]

    return np.bincount(batch, minlength=len(ends)), strain, falls


def _smooth_ends(muscle: PressurizedMuscle) -> Numbers:
    """Strains [-] of a buckled muscle, on a new first axis, between which cells of a stretch
    resolve its force: that of a jump, inf without one, and some of the decay after collapse.
    """
    fold = next(iter(muscle.law.buckling.folds(muscle.column)), np.inf)
    decays = [muscle.collapse_strain + count / muscle.law.rate for count in _DECAYS]
    return stack([fold, *decays])


def _separating_nodes(
    bundles: PressurizedBundle, load: Numbers, ends: Numbers
) -> tuple[Numbers, Numbers, Numbers]:
    """Nodes with at most one equilibrium between two, in order: index of the bundle, strain [-],
    and force beyond its `load` [N]; `ends`: of the stretches of each bundle, rising [-].
    """
    left, right = ends[:, :-1], ends[:, 1:]
    wide, inset = right - left > _WIDTH, _INSET * (right - left)
    # the first and the last end have no other side
    low = np.where(left > ends[:, :1], left + inset, left)
    high = np.where(right < ends[:, -1:], right - inset, right)
    batch, column = np.nonzero(wide)
    low, high, load = low[batch, column], high[batch, column], load[batch]

    forces, slopes = bundles.take(batch).unit_forces_and_slopes(np.stack([low, high], axis=1))
    third = (high - low)[:, None] / 3
    control = (forces[:, 0] + slopes[:, 0] * third, forces[:, 1] - slopes[:, 1] * third)
    control = np.stack([forces[:, 0], forces[:, 1], *control])
    margin = _MARGIN * np.ptp(control, axis=0)
    lowest = (control.min(axis=0) - margin).sum(axis=-1) - load
    highest = (control.max(axis=0) + margin).sum(axis=-1) - load

    # without an equilibrium the force keeps the sign of its ends
    strains = low[:, None] + (high - low)[:, None] * np.linspace(0, 1, _CELLS + 1)
    values = np.zeros(strains.shape)
    values[:, [0, -1]] = forces.sum(axis=-1) - load[:, None]
    row = np.flatnonzero((lowest <= 0) & (highest >= 0))
    inner = bundles.take(batch[row]).force_and_slope(strains[row, 1:-1])[0]
    values[row, 1:-1] = inner - load[row, None]
    is_node = np.zeros(strains.shape, bool)
    is_node[row], is_node[:, [0, -1]] = True, True
    return batch[np.nonzero(is_node)[0]], strains[is_node], values[is_node]


def _falling_force(theta: tuple, strain: Numbers) -> tuple[Numbers, Numbers]:
    """Force of bundles beyond a load [N], times the sign with which it falls, and its slope [N]."""
    bundles, sign, load = theta
    force, slope = bundles.force_and_slope(strain)
    return sign * (force - load), sign * slope
