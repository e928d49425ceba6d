"""Muscles, points and bundles that the benchmarks share."""

import math
from typing import Any

import jax
import numpy as np

import fascicle as fs
import fascicle.jax


MAX_PRESSURE, MAX_STRAIN = 413.7e3, 0.33  # Pa, -: Fig. 6's tests
LENGTH, MATERIAL = 0.127, "silicone_kim2021"


def wait(value: Any) -> Any:
    """Result of JAX when it is computed."""
    return jax.block_until_ready(value)


def make_muscle() -> fs.Muscle:
    """Fig. 6's muscle; all three regions of its law lie within the points below."""
    return fs.Muscle(LENGTH, 6.35e-3, 1.6e-3, math.radians(33), MATERIAL)


def field(pressures: int, strains: int) -> tuple[np.ndarray, np.ndarray]:
    """Column of pressures [Pa], row of strains [-]."""
    column = np.linspace(0.0, MAX_PRESSURE, pressures)[:, None]
    return column, np.linspace(0.0, MAX_STRAIN, strains)


def unlike_bundle(units: int) -> fs.Bundle:
    """Bundle of equally long, otherwise different motor units."""
    sizes = np.random.default_rng(2).uniform([4e-3, 0.15, 25.0], [8e-3, 0.3, 38.0], (units, 3))
    muscles = [
        fs.Muscle(LENGTH, r, ratio * r, math.radians(angle), MATERIAL) for r, ratio, angle in sizes
    ]
    return fs.Bundle([fs.MotorUnit(m) for m in muscles], supply_pressure=MAX_PRESSURE)


def unit_pressures(count: int, units: int) -> np.ndarray:
    """Random pressures [Pa] of each unit, a row for each vector."""
    return MAX_PRESSURE * np.random.default_rng(3).uniform(size=(count, units))
