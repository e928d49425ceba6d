"""What is asked of a muscle, as functions of it and of arrays.

They stand in a module, since what was compiled for a function is found again by its identity.
"""

from typing import Any

import numpy as np

from ..core.module import tree_leaves
from ..core.types import Batch
from .column import Centerline
from .piecewise import Response


Muscle = Any  # the class, which imports this


def force_of(muscle: Muscle, pressure: Batch, strain: Batch) -> Batch:
    """Pulling force [N] at `pressure` [Pa] and `strain` [-]."""
    return muscle.law.at(pressure).force(strain)[0]


def rows_of(muscle: Muscle) -> list[int]:
    """Which of its leaves hold one number for each of several muscles [-]: a tuning's don't."""
    return _rows(muscle, tables_of(muscle))


def batch_of(muscle: Muscle) -> tuple[int, ...]:
    """The shape of a row of muscles [-]; `()` of a single one, and where a law holds arrays of its
    own that are none.
    """
    tables = tables_of(muscle)
    shapes = ((np.shape(leaf), id(leaf) in tables) for leaf in tree_leaves(muscle))
    try:
        return np.broadcast_shapes(*(shape[:-1] if table else shape for shape, table in shapes))
    except ValueError:
        return ()


def tables_of(muscle: Muscle) -> set[int]:
    """Identities [-] of its tuning's columns, whose last axis is their own."""
    return {id(table) for table in (muscle.tuning.pressures, muscle.tuning.c1, muscle.tuning.c2)}


def _rows(part: Any, tables: set[int]) -> list[int]:
    leaves = enumerate(tree_leaves(part))
    return [i for i, leaf in leaves if np.ndim(leaf) and id(leaf) not in tables]


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
