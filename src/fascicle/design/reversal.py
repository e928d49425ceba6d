r"""Reversal and overlap of a bundle's units, from the force curves of their muscles.

While a unit's pressure rises from zero, earlier ones at the supply's, the free strain may fall: a
*reversal*. It is computed on force curves at even strains and every level of the throttled
pressure, linear between two strains. The first strain at which the least force of all levels
vanishes is located first; levels are compared at that strain alone.

Where all muscles of a design are equal, its force

$$F = a F_{full}(\varepsilon) + n F(p, \varepsilon) + r F_{none}(\varepsilon) \tag{G2}$$

with $a$ muscles at full supply, $n$ throttled and $r$ unfed makes the depth one of $(a, n, r)$
alone, which many designs share.
"""

import numpy as np

from ..bundle.states import States, overlap_edges
from ..core.array_namespace import array_namespace, minimum, where
from ..core.types import AnyArray, Float, Int, Marks, Numbers, Whole


_BATCH = 2**20  # numbers computed together, some ten megabytes


def free_strain_falls(offset: Numbers, number: Numbers, force: Numbers, top: Numbers) -> Numbers:
    """Largest fall of the free strain while a unit's pressure rises from zero [-], for each unit.

    `offset`: force of all other units at even strains [N], a row for each unit; `number`: muscles
    of the unit; `force`: of one of them at every level [N], levels first, strains last; `top`: the
    last of the strains [-].
    """
    xp, last = array_namespace(offset, force), offset.shape[-1] - 1

    def total(index: Whole, level: Numbers) -> Numbers:
        """Force at the strain with an index for each unit, levels first."""
        other_units, unit = (
            xp.take_along_axis(x, index, axis=-1)[..., 0] for x in (offset[None], level)
        )
        return other_units + number * unit

    def first_zero(force: Numbers) -> Numbers:
        """First strain at which the force of any level vanishes, in steps of the strain."""
        right = first_push(offset + number[:, None] * force.min(axis=0))
        ahead, behind = (total(right[None, :, None] + step, force) for step in (-1, 0))
        vanishes = (behind <= 0) | (right == last)
        return right - 1 + where(vanishes, chord_zero(ahead, behind), 1.0).min(axis=0)

    return top * (first_zero(force[:1]) - first_zero(force)) / last


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
        offset = a[:, None] * curves[-1] + r[:, None] * curves[0]
        falls[portion] = free_strain_falls(offset, m, curves[:, None], top)
    return falls[index.reshape(n.shape)].max(axis=0)


def overlap_width(
    counts: Whole, curves: Numbers, levels: Numbers, states: States, exists: Marks
) -> Numbers:
    """For each design, largest range of forces, zero and above, that two successive states both
    reach at one strain [N].

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
