r"""Reversal and overlap of a bundle's units, from the force curves of their muscles.

While a unit's pressure rises from zero, earlier ones at the supply's, the free strain may fall: a
*reversal*. It is computed on force curves at even strains and every level of the throttled
pressure, linear between two strains. The first strain at which the least force of all levels
vanishes is located first; levels are compared at that strain alone.

Where all muscles of a design are equal, its force

$$F = a F_{full}(\varepsilon) + n F(p, \varepsilon) + r F_{none}(\varepsilon) \tag{G2}$$

with $a$ muscles at full supply, $n$ throttled and $r$ vented makes the depth one of $(a, n, r)$
alone, which many designs share.
"""

import numpy as np

from ..bundle.states import States, overlap_edges
from ..core.array_namespace import array_namespace, minimum, where
from ..core.types import AnyArray, Float, Int, Marks, Numbers, Whole


_BATCH = 2**20  # numbers computed together, some ten megabytes


def free_strain_falls(
    other_force: Numbers, count: Numbers, force: Numbers, last_strain: Numbers
) -> Numbers:
    """Largest fall of a bundle's free strain while one unit's pressure rises from zero to the
    supply's, the other units' being constant [-]; one value for each unit that rises.

    `other_force`: of all other units at even strains [N], a row for each unit; `count`: muscles of
    the unit; `force`: of one of them at every pressure level [N], levels first, strains last;
    `last_strain`: the last of the even strains from zero [-].
    """
    xp, last = array_namespace(other_force, force), other_force.shape[-1] - 1

    def total(index: Whole, level: Numbers) -> Numbers:
        """Force at the strain with an index for each unit, levels first."""
        other_units, unit = (
            xp.take_along_axis(x, index, axis=-1)[..., 0] for x in (other_force[None], level)
        )
        return other_units + count * unit

    def first_zero(force: Numbers) -> Numbers:
        """First strain at which the force of any level vanishes, in steps of the strain."""
        right = first_push(other_force + count[:, None] * force.min(axis=0))
        ahead, behind = (total(right[None, :, None] + step, force) for step in (-1, 0))
        vanishes = (behind <= 0) | (right == last)
        return right - 1 + where(vanishes, chord_zero(ahead, behind), 1.0).min(axis=0)

    return last_strain * (first_zero(force[:1]) - first_zero(force)) / last


def reversal_depth(counts: Whole, curves: Numbers, top: Numbers, states: States) -> Numbers:
    """Reversal depth of one design [-]: unit after unit in the order of their recruitment.

    `counts`: muscles in each unit; `curves`: force of a muscle of each at every level and even
    strain [N], units last; `top`: the last of the strains [-].
    """
    xp, n = array_namespace(curves), counts[states.order]
    force = xp.moveaxis(curves, -1, 1)[:, states.order]
    vented, full = n[:, None] * force[0], n[:, None] * force[-1]
    before = full.cumsum(axis=0) - full
    after = vented.sum(axis=0) - vented.cumsum(axis=0)
    falls = free_strain_falls(before + after, n, force, top)
    later = (np.arange(len(n)) > 0) & (n > 0)
    return where(later, falls, 0.0).max()


def uniform_reversal_depths(
    counts: Int[np.ndarray, "unit design"],
    curves: Float[np.ndarray, "level strain"],
    top: float,
    states: States,
) -> Float[np.ndarray, " design"]:
    """Reversal depth of designs of one muscle [-].

    `counts`: muscles in each unit; `curves`: force of a muscle at every level and even strain [N];
    `top`: the last of the strains [-].
    """
    n = counts[states.order]
    before = n.cumsum(axis=0) - n
    vented = n.sum(axis=0) - before - n
    # a fall depends on (a, n, r) alone
    shape = (int(n.sum(axis=0).max()) + 1,) * 3
    code, index = np.unique(np.ravel_multi_index((before, n, vented), shape), return_inverse=True)
    transitions = np.stack(np.unravel_index(code, shape))
    falls = np.zeros(transitions.shape[1])
    (later,) = np.nonzero((transitions[0] > 0) & (transitions[1] > 0))
    step = max(1, _BATCH // curves.shape[1])
    for start in range(0, later.size, step):
        portion = later[start : start + step]
        a, m, r = transitions[:, portion]
        other_force = a[:, None] * curves[-1] + r[:, None] * curves[0]
        falls[portion] = free_strain_falls(other_force, m, curves[:, None], top)
    return falls[index.reshape(n.shape)].max(axis=0)


def largest_overlap(
    counts: Whole, curves: Numbers, levels: Numbers, states: States, exists: Marks
) -> Numbers:
    """Overlap of the force ranges of two successive states, of each design [N]: the largest over
    all strains and pairs of states, forces below zero left out.

    `counts`: muscles in each unit, units first, designs last; `curves`: force of a muscle of each
    unit at every level and even strain [N]; `levels`: the curves; where all units have one muscle,
    least and largest are enough [N]; `exists`: mask of the states that designs have.
    """
    xp = array_namespace(counts, curves)
    vented, full, throttled = (
        xp.moveaxis(counts * x, -counts.ndim, -1) for x in (curves[0], curves[-1], levels)
    )
    low, high = states.edges(throttled, vented, full)
    bottom, top = overlap_edges((low[:-1], high[:-1]), (low[1:], high[1:]))
    height = (top - bottom).max(axis=1, initial=0.0)
    return where(exists[1:], height, 0.0).max(axis=0, initial=0.0)


def first_push(force: Float[AnyArray, "*any strain"]) -> Int[AnyArray, "*any"]:
    """Index of the first strain after rest at which a `force` [N] over strains, on the last axis,
    doesn't pull; else of the last strain.
    """
    xp = array_namespace(force)
    index = xp.arange(force.shape[-1])
    pushes = ((force <= 0) & (index > 0)) | (index == force.shape[-1] - 1)
    return xp.argmax(pushes, axis=-1)


def chord_zero(left: Numbers, right: Numbers) -> Numbers:
    """Share of the way from a strain to the next at which a force vanishes [-]; `left`, `right`:
    the force at both [N].
    """
    # the last of all may still pull by rounding: it is the zero itself
    drop = left - minimum(right, 0.0)
    return where(left > 0, left / where(drop > 0, drop, 1.0), 0.0)
