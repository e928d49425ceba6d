r"""The volume that goes with the force: co-energy, from which no cycle makes energy.

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

from collections.abc import Callable

import numpy as np

from ..core.array_namespace import array_namespace, stack, where
from ..core.module import tree_leaves
from ..core.types import Batch, BatchLike, Numbers
from .ends import integrate_pieces
from .piecewise import Piecewise, PressurizedMuscle


# Pa, between five pressures: rounding leaves 1e-9 of a slope, and a kink is missed by 2 Pa at most
_PRESSURE_STEP = 0.5
_FORWARD = np.array([-25, 48, -36, 16, -3]) / (12 * _PRESSURE_STEP)


def contraction_work(
    muscle: PressurizedMuscle, strain: BatchLike, start: BatchLike = 0.0, resistance: bool = True
) -> Batch:
    """Work of the ends [J] from the strain `start` to `strain` [-] at the muscle's pressure;
    `resistance`: true to count it past the free strain, too.
    """
    zero = 0.0 * muscle.column.free_strain
    sums = integrate_force(muscle, stack([start + zero, strain + zero]), resistance=resistance)
    return muscle.column.rest_length * (sums[1] - sums[0])


def integrate_force(
    muscle: PressurizedMuscle, stops: Numbers, points: int = 16, resistance: bool = True
) -> Numbers:
    """Integral of the force over strain [N] from the least of the `stops` [-] to each of them, on
    the first axis, with Gauss `points` on each piece between two stops or kinks; `resistance`: true
    to count forces past the free strain.
    """
    xp = array_namespace(stops, muscle.collapse_strain)
    low, high = xp.min(stops, axis=0), xp.max(stops, axis=0)
    kinks = [*muscle.kinks, *muscle.law.buckling.folds(muscle.column)]
    # at a kink slopes are those of smaller strains, of which a minimum would take half
    kinks = stack([where(kink >= high, high, where(kink > low, kink, low)) for kink in kinks])
    ends = xp.concatenate([xp.broadcast_to(stops, (len(stops), *kinks.shape[1:])), kinks])
    order = xp.argsort(ends, axis=0)
    ends = xp.take_along_axis(ends, order, axis=0)
    start, end = ends[:-1], ends[1:]
    pieces = integrate_pieces(muscle.pulling_force, start, end, points)
    if not resistance:  # free strain is an end of pieces
        pieces = where(start < muscle.column.free_strain, pieces, 0.0)
    sums = xp.concatenate([0.0 * ends[:1], xp.cumsum(pieces, axis=0)])
    # each stop is exactly an end, so nothing is interpolated
    return xp.take_along_axis(sums, xp.argsort(order, axis=0)[: len(stops)], axis=0)


def coenergy_at_rest(muscle: PressurizedMuscle) -> Batch:
    """Co-energy [J] at rest length: $P V(0)$, and that of fibers that stretch, ends that yield."""
    tension, P = muscle.law.tension, muscle.column.pressure
    volume = tension.bladder.braid.volume(0.0) - tension.bladder.volume
    yielding = tension.ends.coenergy_at_rest(muscle.column.tension)
    return P * volume + tension.rest_coenergy(P) + yielding


def coenergy(muscle: PressurizedMuscle, strain: BatchLike) -> Batch:
    """Co-energy $\\Pi^*$ [J] at the muscle's pressure and `strain` [-], (V2)."""
    return coenergy_at_rest(muscle) + contraction_work(muscle, strain)


def conjugate_volume(law: Piecewise, pressure: Batch, strain: Batch) -> Batch:
    """Conjugate volume $V^*$ [m³] at `pressure` [Pa] and `strain` [-], (V2)."""
    point = pressure + 0.0 * strain

    def potential(P: Batch) -> Batch:
        return coenergy(law.at(P), strain)

    if array_namespace(point, *tree_leaves(law)) is np:
        return pressure_derivative(potential, point)
    from ..core.jax_backend import derivative

    return derivative(potential, point)[1]


def pressure_derivative(function: Callable[[Batch], Batch], pressure: Batch) -> Batch:
    """Derivative by pressure [1/Pa] of a `function` at `pressure` [Pa], by its values at five
    pressures from there on. At a kink it is that of higher pressures, as a law's slopes are.
    """
    values = [function(pressure + k * _PRESSURE_STEP) for k in range(len(_FORWARD))]
    return np.tensordot(_FORWARD, values, 1)[()]
