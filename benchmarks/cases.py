"""The muscles, points and bundles that the benchmarks share, and the floors under them."""

import math
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

import fascicle as fs


LARGEST_PRESSURE, LARGEST_STRAIN = 413.7e3, 0.33  # Pa, -: Fig. 6's tests
LENGTH, MATERIAL = 0.127, "silicone_kim2021"


# the floors: plain passes over as many float64 values, into a new array
stream = jax.jit(lambda x: x + 1)
exponential = jax.jit(jnp.exp)


def done(value: Any) -> Any:
    return jax.block_until_ready(value)


def muscle() -> fs.Muscle:
    """Fig. 6's muscle, at which all three regions lie within the points below."""
    return fs.Muscle.from_dimensions(LENGTH, 6.35e-3, 1.6e-3, math.radians(33), MATERIAL)


def field(pressures: int, strains: int) -> tuple[jax.Array, jax.Array]:
    """Pressures down, strains across."""
    down = jnp.linspace(0.0, LARGEST_PRESSURE, pressures)[:, None]
    return down, jnp.linspace(0.0, LARGEST_STRAIN, strains)


def scattered(*shape: int) -> tuple[jax.Array, jax.Array]:
    """Points with a pressure and strain of their own, evenly over the same rectangle."""
    random = np.random.default_rng(0)
    P, eps = random.uniform(size=(2, *shape))
    return jnp.asarray(LARGEST_PRESSURE * P), jnp.asarray(LARGEST_STRAIN * eps)


def unlike_muscles(count: int) -> fs.Muscle:
    """Different muscles, as one whose sizes are columns; points go along the rows."""
    random = np.random.default_rng(1)
    length, radius, thin, angle = random.uniform(
        [[0.08], [4e-3], [0.15], [25.0]], [[0.2], [10e-3], [0.3], [40.0]], (4, count)
    )[..., None]
    return fs.Muscle.from_dimensions(length, radius, thin * radius, np.radians(angle), MATERIAL)


def unlike_bundle(units: int) -> fs.Bundle:
    """A bundle of motor units of which no two are alike, all equally long."""
    random = np.random.default_rng(2)
    made = []
    for radius, thin, angle in random.uniform([4e-3, 0.15, 25.0], [8e-3, 0.3, 38.0], (units, 3)):
        one = fs.Muscle.from_dimensions(
            LENGTH, radius, thin * radius, math.radians(angle), MATERIAL
        )
        made.append(fs.MotorUnit(one))
    return fs.Bundle(made, supply_pressure=LARGEST_PRESSURE)


def unit_pressures(count: int, units: int) -> jax.Array:
    """Pressure vectors, each unit's its own."""
    random = np.random.default_rng(3)
    return jnp.asarray(LARGEST_PRESSURE * random.uniform(size=(count, units)))
