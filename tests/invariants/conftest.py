"""Random muscles over the model's domain, stacked on a leading axis for `jax.vmap`."""

import equinox as eqx
import jax
import numpy as np
import pytest

import fascicle as fs


def stack(seed, n, tuned=False, **laws):
    """`n` muscles of 3-15 mm radius, wall 0.12-0.35 of it, 60-400 mm, 20-42 deg, as one."""
    rng = np.random.default_rng(seed)
    radius = rng.uniform(3e-3, 15e-3, n)
    c10, c01 = rng.uniform(60e3, 200e3, n), rng.uniform(20e3, 160e3, n)
    table = np.sort(rng.uniform(20e3, 420e3, (n, 3)), axis=1)
    values = {
        "length": rng.uniform(60e-3, 400e-3, n),
        "outer_radius": radius,
        "wall_thickness": radius * rng.uniform(0.12, 0.35, n),
        "braid_angle": np.radians(rng.uniform(20, 42, n)),
        "transition_rate": rng.uniform(5, 120, n),
    }
    rubber = (c10, c01, rng.uniform(4, 9, n) * (c10 + c01), rng.uniform(0.3, 0.5, n))
    corrections = {
        "pressures": table,
        "c1": rng.uniform(0.01, 0.06, (n, 3)) * table * 3e-5,
        "c2": rng.uniform(0.7, 1.3, (n, 3)),
        "youngs_modulus_factor": rng.uniform(0.8, 1.4, n),
        "collapse_moment_factor": rng.uniform(0.6, 1.2, n),
        "hinge_stiffness_factor": rng.uniform(0.5, 1.5, n),
        "hinge_stiffness_slope": rng.uniform(0, 1e-5, n),
        "transition_rate": rng.uniform(5, 120, n),
    }

    # one is made, and checked, and its numbers are then those of all
    first = {name: value[0] for name, value in values.items()}
    tuning = fs.Tuning(**{name: x[0] for name, x in corrections.items()}) if tuned else None
    one = fs.Muscle(
        **first, material=fs.MooneyRivlin(*(x[0] for x in rubber)), tuning=tuning, **laws
    )
    one = eqx.tree_at(lambda m: [getattr(m, name) for name in values], one, [*values.values()])
    named = ("c10", "c01", "youngs_modulus", "poisson_ratio")
    one = eqx.tree_at(lambda m: [getattr(m.material, name) for name in named], one, rubber)
    if tuned:
        of = lambda m: [getattr(m.tuning, name) for name in corrections]  # noqa: E731
        # a tuning begins without pressure, where there is nothing to correct
        begin = {"pressures": 0.0, "c1": 0.0, "c2": 1.0}
        for name, value in begin.items():
            corrections[name] = np.insert(corrections[name], 0, value, axis=1)
        one = eqx.tree_at(of, one, [*corrections.values()])
    every = lambda x: x if np.shape(x)[:1] == (n,) else np.broadcast_to(x, (n, *np.shape(x)))  # noqa: E731
    return jax.tree.map(every, one)


def points(seed, muscles):
    """A pressure and a strain on the domain for each of the muscles, one in eight at P = 0."""
    rng = np.random.default_rng(seed)
    n = muscles.length.shape[0]
    P = np.where(rng.integers(8, size=n) == 0, 0.0, rng.uniform(0, 1e6, n))
    low = np.asarray(1 - 1 / np.cos(muscles.braid_angle))
    return P, low + (0.6 - low) * rng.uniform(1e-6, 1, n)


@pytest.fixture
def random_muscles():
    """`random_muscles(seed, n, tuned=False, **laws)`: stacked muscles."""
    return stack


@pytest.fixture
def random_points():
    """`random_points(seed, muscles)`: a pressure [Pa] and a strain [-] for each."""
    return points
