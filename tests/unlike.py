"""Bundles of unlike motor units for tests that draw them at random."""

import math
from typing import Any

import numpy as np

import fascicle as fs


SUPPLY = 413.7e3
LAWS: dict[str, dict[str, Any]] = {
    "plain": {},
    "elastica": {"buckling": "elastica"},
    "tuned": {"tuning": fs.Tuning([5e4, 2e5, 4.2e5], [1, 4, 6], [0.9, 0.95, 1.1], dead_band=5e3)},
}


def random_bundle(
    random: np.random.Generator,
    units: int = 3,
    *,
    most: int = 4,
    rates: tuple[float, ...] = (25.0, 100.0, 300.0),
    supply: float | None = SUPPLY,
    scheme: str = "orderly",
    **laws: Any,
) -> fs.Bundle:
    """Unlike motor units of up to so many muscles each; collapsed ones go over to their hinge
    slowly and at once.
    """
    made = []
    for _ in range(units):
        radius = random.uniform(4e-3, 10e-3)
        muscle = fs.Muscle(
            0.127,
            radius,
            radius * random.uniform(0.15, 0.35),
            math.radians(random.uniform(25, 40)),
            "silicone_kim2021",
            transition_rate=random.choice(rates),
            **laws,
        )
        made.append(fs.MotorUnit(muscle, int(random.integers(1, most + 1))))
    return fs.Bundle(made, supply, scheme)
