"""The tension law alone: all of the model where a muscle pulls.

Up to the free strain no law of buckling or collapse has a say, and a reading that was clipped at
zero beyond it only says "not above", which the tension law says there as well. A record without
any push is therefore fitted by the tension law alone, which compiles much faster.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from .._math import guarded
from .._types import Batch
from ..muscle import Muscle
from ..muscle.tuning import TunedTension, Tuning


_SHORTEST = 0.8  # of strain, where every mesh pushes hard
_STEPS, _NEAR = 60, 1e-13  # bisection alone would need 45 steps to get as near


def tension_of(muscle: Muscle) -> TunedTension:
    """The tension law of a `muscle` [-], corrected by its tuning."""
    return TunedTension(muscle.tension, muscle.bladder, muscle.tuning)


def untuned(muscle: Muscle) -> Muscle:
    """The `muscle` [-] without its tuning, its dead band kept: that is no correction."""
    tuning = Tuning(dead_band=muscle.tuning.dead_band)
    return eqx.tree_at(lambda m: m.tuning, muscle, tuning)


def free_strain_at(muscle: Muscle, pressure: Batch, force: Batch) -> Batch:
    """Strain [-] at which an untuned `muscle` [-] pulls with `force` [N] at `pressure` [Pa];
    0 where the dead band leaves no pressure.
    """
    law = tension_of(muscle)
    P = law.tuning.effective_pressure(pressure)
    found = law.law.free_strain(law.bladder, guarded(P > 0, P, 1e5), lambda _: force)
    return jnp.where(P > 0, found, 0.0)


def force_of(
    muscle: Muscle, pressure: np.ndarray, strain: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Force [N] of the tension law at any `pressure` [Pa] and `strain` [-] that broadcast, and
    its slope with strain [N].
    """
    return _force_of(_in_numbers(muscle), np.asarray(pressure, float), np.asarray(strain, float))


def _in_numbers(muscle: Muscle) -> TunedTension:
    return tension_of(jax.tree.map(np.asarray, muscle))


def _force_of(
    law: TunedTension, pressure: np.ndarray, strain: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    pull = law.pull(pressure, strain)
    force, slope, *_ = np.broadcast_arrays(pull.force, pull.slope, pressure, strain)
    return force, slope


def strain_of(muscle: Muscle, pressure: np.ndarray, force: np.ndarray) -> np.ndarray:
    """`free_strain_at` any `pressure` [Pa] and `force` [N] that broadcast [-], by Newton's steps
    inside a shrinking bracket.
    """
    P, F = np.broadcast_arrays(np.asarray(pressure, float), np.asarray(force, float))
    # as the law's own search: at twice `low` the fibers would be straight
    low = np.full(P.shape, 0.5 * (1 - 1 / np.cos(float(muscle.braid_angle))))
    high = np.full(P.shape, _SHORTEST)
    strain, law = np.full(P.shape, 0.1), _in_numbers(muscle)
    for _ in range(_STEPS):
        at, slope = _force_of(law, P, strain)
        above = at - F
        low, high = np.where(above > 0, strain, low), np.where(above > 0, high, strain)
        with np.errstate(divide="ignore", invalid="ignore"):
            step = strain - above / slope
        inside = np.isfinite(step) & (low <= step) & (step <= high)
        new = np.where(inside, step, 0.5 * (low + high))
        done = np.all(np.abs(new - strain) <= _NEAR)
        strain = new
        if done:
            break
    return np.where(float(muscle.tuning.dead_band) < P, strain, 0.0)
