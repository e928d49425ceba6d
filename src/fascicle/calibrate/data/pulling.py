"""The tension law alone: all of the model where a muscle pulls.

Up to the free strain no law of buckling or collapse has a say, and a reading that was clipped at
zero beyond it only says "not above", which the tension law says there as well. A record without
any push is therefore fitted by the tension law alone, which is much faster.
"""

import equinox as eqx
import numpy as np

from ...core.array_namespace import where
from ...core.module import to_numpy
from ...core.roots import guarded
from ...core.types import Batch
from ...muscle import Muscle
from ...muscle.tuning import TunedTension, Tuning


_SHORTEST = 0.8  # of strain, where every mesh pushes hard


def tension_of(muscle: Muscle) -> TunedTension:
    """The tension law of a `muscle` [-], corrected by its tuning."""
    return TunedTension(muscle.tension, muscle.bladder, muscle.tuning, muscle.ends)


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
    return where(P > 0, found, 0.0)


def force_of(
    muscle: Muscle, pressure: np.ndarray, strain: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Force [N] of the tension law at any `pressure` [Pa] and `strain` [-] that broadcast, and
    its slope with strain [N].
    """
    P, eps = np.asarray(pressure, float), np.asarray(strain, float)
    pull = tension_of(to_numpy(muscle)).pull(P, eps)
    found, slope, *_ = np.broadcast_arrays(pull.force, pull.slope, P, eps)
    return found, slope


def strain_of(muscle: Muscle, pressure: np.ndarray, force: np.ndarray) -> np.ndarray:
    """`free_strain_at` any `pressure` [Pa] and `force` [N] that broadcast [-]; where it can't pull
    so hard or push so hard, an end of the strains that are looked at.
    """
    P, F = np.broadcast_arrays(np.asarray(pressure, float), np.asarray(force, float))
    low = 0.5 * (1 - 1 / np.cos(float(muscle.braid_angle)))  # as the law's own search
    with np.errstate(all="ignore"):  # of branches that aren't taken
        strain = free_strain_at(to_numpy(muscle), P, F)
    # some laws have no number where nothing pushes so hard
    return np.where(np.isnan(strain), _SHORTEST, np.clip(strain, low, _SHORTEST))
