r"""The volume that goes with the force: co-energy, and energy that is nobody's gift.

A muscle takes in fluid at pressure $P$ and moves its ends with the force $F(P, \varepsilon)$.
What it stores can come back and no more, only if pressure and force have one potential, the
co-energy

$$\Pi^*(P, \varepsilon) = P V(0) + L_0 \int_0^\varepsilon F(P, \varepsilon')
  \,\mathrm{d}\varepsilon', \qquad
  F = \frac{1}{L_0} \frac{\partial \Pi^*}{\partial \varepsilon}, \qquad
  V^* = \frac{\partial \Pi^*}{\partial P} = V(0)
    + L_0 \frac{\partial}{\partial P} \int_0^\varepsilon F \,\mathrm{d}\varepsilon'. \tag{V2}$$

Up to the free strain $V^*$ is the braid's volume, as (3) says. Past it the force follows a
bowed, then a hinged bladder, and the straight braid's volume at that strain is not what its
pressure works on: round a cycle it would make energy from nothing. Where the force jumps, as
`elastica`'s does at a fold, the integral's slope holds the jump, too. A braid that stretches
swells at rest length as well: what it takes up there counts beside $P V(0)$.

**Quadrature:** Gauss-Legendre on each stretch between a force's kinks. The kinks move with
pressure, and so do the stretches: their slopes are part of $V^*$.
**Sign:** work done by the ends counts positive. **Source:** derived here; co-energy of lossless
two-ports: Lanczos (1970), chapter VI, as for any force that has a potential.
"""

from functools import cache
from typing import Any

import numpy as np

from ..core.array_namespace import minimum, node_axis, stack, sum_nodes, where
from ..core.errors import require
from ..core.types import Batch, BatchLike
from .piecewise import Pressurized


# between two kinks a force is smooth: 16 points leave 1e-11 of the volume, 8 leave 1e-8
@cache
def _quadrature() -> tuple[np.ndarray, np.ndarray]:
    return np.polynomial.legendre.leggauss(16)


def contraction_work(
    muscle: Pressurized, strain: BatchLike, rest: BatchLike = 0.0, resistance: bool = True
) -> Batch:
    """Work of the ends [J] from the strain `rest` to `strain` [-], at the muscle's pressure; with
    `resistance` [-] past the free strain, too.
    """
    # no stretch starts below rest or ends past the strain asked for, either way
    back = strain < rest
    low, high = where(back, strain, rest), where(back, rest, strain)
    free, onset, collapse = muscle.kinks
    folds = [minimum(fold, collapse) for fold in muscle.law.buckling.folds(muscle.column)]
    kinks = [free, onset, *folds, collapse] if resistance else [free]
    # at a kink slopes are those of smaller strains, where a minimum would share them out
    stops = [where(kink >= high, high, where(kink > low, kink, low)) for kink in kinks]
    ends = stack([low, *stops, high] if resistance else [low, *stops])
    # all stretches as one row of nodes: the law is asked once
    middle, half = ((ends[1:] + sign * ends[:-1]) / 2 for sign in (1, -1))
    node, weight = (node_axis(x, low + 0.0 * muscle.collapse) for x in _quadrature())
    shape = (-1, *ends.shape[1:])
    at = (middle[:, None] + half[:, None] * node).reshape(shape)
    done = sum_nodes((half[:, None] * weight).reshape(shape) * muscle.force(at)[0])
    return muscle.column.rest_length * where(back, -done, done)


def coenergy_at_rest(muscle: Pressurized) -> Batch:
    """Co-energy [J] of a muscle at rest length and its pressure, besides $P V(0)$: where
    its ends give, its bladder has contracted.
    """
    return muscle.law.tension.ends.coenergy_at_rest(muscle.law.tension, muscle.column.pressure)


def conjugate_volume(muscle: Any, pressure: Batch, strain: Batch) -> Batch:
    """$V^*$ [m³] at `pressure` [Pa] and `strain` [-], (V2): a derivative, so JAX computes it."""
    require("jax")
    from ..core.jax_backend import compile_law

    return compile_law(_conjugate_volume)(muscle, pressure, strain)


def _conjugate_volume(muscle: Any, pressure: Batch, strain: Batch) -> Batch:
    from ..core.jax_backend import derivative

    def work(P: Batch) -> Batch:
        at = muscle.law.at(P)
        done = contraction_work(at, strain)
        return done + coenergy_at_rest(at) if muscle.ends.gives else done

    P = pressure + 0.0 * strain
    _, swept = derivative(work, P)
    _, swollen = muscle.law.tension.rest(P)
    return muscle.braid.volume(0.0) - muscle.bladder.volume + swollen + swept
