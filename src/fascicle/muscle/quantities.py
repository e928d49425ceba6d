"""What is asked of a muscle, as functions of it and of arrays.

They stand in a module, since what was compiled for a function is found again by its identity.
"""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from ..core.arrays import library
from ..core.blocks import in_blocks
from ..core.types import Batch
from .column import Centerline
from .laws import LAWS
from .piecewise import Response


Muscle = Any  # the class, which imports this


def force_of(muscle: Muscle, pressure: Batch, strain: Batch) -> Batch:
    """Pulling force [N] at `pressure` [Pa] and `strain` [-]; of many points block by block."""
    whole = muscle.tuning.pressures.ndim > 1  # a table for each muscle isn't cut
    if whole or library(pressure, strain) is not jnp:
        return _force(muscle, pressure, strain)
    leaves, tree = jax.tree.flatten(muscle)
    columns = rows_of(muscle)
    if columns and not _ours(muscle):  # somebody's own law may hold rows that aren't of muscles
        return _force(muscle, pressure, strain)

    def force(*arrays: Batch) -> Batch:
        *parts, pressure, strain = arrays
        cut = dict(zip(columns, parts, strict=True))
        some = tree.unflatten([cut.get(i, x) for i, x in enumerate(leaves)]) if cut else muscle
        return _force(some, pressure, strain)

    return in_blocks(force, *(leaves[i] for i in columns), pressure, strain)


def rows_of(muscle: Muscle) -> list[int]:
    """Which of its leaves hold one number for each of several muscles [-]: a tuning's don't."""
    t = muscle.tuning
    tables = {id(table) for table in (t.pressures, t.c1, t.c2)}
    leaves = enumerate(jax.tree.leaves(muscle))
    return [i for i, leaf in leaves if np.ndim(leaf) and id(leaf) not in tables]


def _ours(muscle: Muscle) -> bool:
    return all(type(getattr(muscle, kind)) in known.values() for kind, known in LAWS.items())


def _force(muscle: Muscle, pressure: Batch, strain: Batch) -> Batch:
    return muscle.law.at(pressure).force(strain)[0]


def stiffness_of(muscle: Muscle, pressure: Batch, strain: Batch) -> Batch:
    """By how much more it pulls a meter longer [N/m] at `pressure` [Pa] and `strain` [-]."""
    return -muscle.law.at(pressure).force(strain)[1] / muscle.length


def response_of(muscle: Muscle, pressure: Batch, strain: Batch) -> Response:
    """Force in its components [N] at `pressure` [Pa] and `strain` [-]."""
    return muscle.law.at(pressure).response(strain)


def free_strain_of(muscle: Muscle, pressure: Batch) -> Batch:
    """Strain [-] at which the force vanishes at `pressure` [Pa]."""
    return muscle.law.tension.free_strain(pressure)


def blocked_force_of(muscle: Muscle, pressure: Batch) -> Batch:
    """Force [N] at rest length at `pressure` [Pa]."""
    return muscle.law.tension.force(pressure, 0.0 * pressure)


def collapse_moment_of(muscle: Muscle, pressure: Batch) -> Batch:
    """Moment [N·m] of collapse at `pressure` [Pa]."""
    return muscle.law.collapse_moment(pressure)


def collapse_strain_of(muscle: Muscle, pressure: Batch) -> Batch:
    """Strain [-] of collapse at `pressure` [Pa]."""
    return muscle.law.at(pressure).collapse


def volume_of(muscle: Muscle, strain: Batch) -> Batch:
    """Volume of fluid [m³] at `strain` [-]."""
    if muscle.ends.gives:
        s, rest = muscle.ends.stretch(muscle.length), muscle.braid.volume(0.0)
        return rest + (muscle.braid.volume(s * strain) - rest) / s - muscle.bladder.volume
    return muscle.braid.volume(strain) - muscle.bladder.volume


def radius_of(muscle: Muscle, strain: Batch) -> Batch:
    """Outer radius [m] at `strain` [-] while straight."""
    return muscle.braid.radius_at(muscle.ends.stretch(muscle.length) * strain)


def deflection_of(muscle: Muscle, pressure: Batch, strain: Batch) -> Batch:
    """How far the axis bows out [m] at `pressure` [Pa] and `strain` [-]."""
    return muscle.law.at(pressure).deflection(strain)


def moment_of(muscle: Muscle, pressure: Batch, strain: Batch) -> Batch:
    """Largest bending moment [N·m] at `pressure` [Pa] and `strain` [-]."""
    return muscle.law.at(pressure).moment(strain)


def shape_of(muscle: Muscle, pressure: Batch, strain: Batch, points: int) -> Centerline:
    """Centerline [m] of `points` [-] at `pressure` [Pa] and `strain` [-]."""
    return muscle.law.at(pressure).shape(strain, points)
