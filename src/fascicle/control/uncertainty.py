"""Bundles drawn at random around a model, for what a controller doesn't know of its muscles."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..bundle.bundle import Bundle, MotorUnit
from ..core.errors import InvalidInputError
from ..core.module import unique_indices
from ..muscle import Muscle


_LARGEST = 3.0  # standard deviations: rarer muscles would be no tubes
DRAWS = 40  # of bundles: a share of 95 % is then known within 3 %, a standard error


class ModelScatter(NamedTuple):
    """Standard deviations of a muscle from its model: of Young's `modulus`, `collapse_moment`,
    `wall_thickness` and `outer_radius`, over their values [-], of the `braid_angle` [rad], and of
    the logarithm of the `transition_rate` [-]. The defaults are assumed, not measured.
    """

    modulus: float = 0.1
    collapse_moment: float = 0.1
    wall_thickness: float = 0.05
    outer_radius: float = 0.02
    braid_angle: float = float(np.radians(1.0))
    transition_rate: float = 0.4


def draw_bundles(
    bundle: Bundle, count: int = DRAWS, seed: int = 0, scatter: ModelScatter | None = None
) -> tuple[Bundle, ...]:
    """Draw bundles around a model.

    The muscles of a bundle deviate alike, as those of one lot do, and as a model's error does.

    **Arguments:**

    - `bundle`: the model.
    - `count`: number of bundles.
    - `seed`: random seed.
    - `scatter`: standard deviations; left out, those of `ModelScatter`.

    **Raises:** `InvalidInputError` for fewer than two.
    """
    if count != int(count) or count < 2:
        raise InvalidInputError("count", "must be a whole number of at least 2", count)
    generator = np.random.default_rng(seed)
    scatter = scatter or ModelScatter()
    rows = np.clip(generator.standard_normal((int(count), len(scatter))), -_LARGEST, _LARGEST)
    unique, indices = unique_indices([unit.muscle for unit in bundle.motor_units])
    bundles = []
    for row in rows * np.array(scatter):
        muscles = [_deviate(bundle.motor_units[i].muscle, row) for i in unique]
        units = zip(bundle.motor_units, indices, strict=True)
        motor_units = [MotorUnit(muscles[index], unit.count) for unit, index in units]
        bundles.append(bundle.replace(motor_units=motor_units))
    return tuple(bundles)


def _deviate(muscle: Muscle, deviations: np.ndarray) -> Muscle:
    """Copy of a `muscle` whose parameters differ by `deviations`.

    `deviations`, in the order of `ModelScatter`: relative [-], but of the braid's angle added [rad]
    and of the transition's rate a difference of logarithms [-].
    """
    modulus, moment, wall, radius, braid, rate = deviations
    tuning = muscle.tuning
    return muscle.replace(
        wall_thickness=float(muscle.wall_thickness) * (1 + wall),
        outer_radius=float(muscle.outer_radius) * (1 + radius),
        braid_angle=float(muscle.braid_angle) + braid,
        transition_rate=float(muscle.transition_rate) * np.exp(rate),
        tuning=replace(
            tuning,
            youngs_modulus_factor=float(tuning.youngs_modulus_factor) * (1 + modulus),
            collapse_moment_factor=float(tuning.collapse_moment_factor) * (1 + moment),
        ),
    )
