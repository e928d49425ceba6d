"""Random muscles over the ranges that the model is asked to cover."""

import math
from dataclasses import dataclass, replace

import numpy as np
from oracle_muscle import LATEX, SILICONE, Material, Muscle, Tuning, lowest_strain


# each collapse law and each post-collapse reading, in few enough pairs to compile quickly
PAIRS = (
    ("kim2021", "derived"),
    ("wood1958", "consistent"),
    ("brazier1927", "printed"),
    ("stein_hedgepeth1961", "derived"),
)


@dataclass(frozen=True)
class Case:
    """A muscle, one pressure [Pa] and the strains at which it is asked."""

    muscle: Muscle
    pressure: float
    strains: tuple[float, ...]


def random_tuning(rng):
    """A tuning as section 5 fits them: C1 a few newtons, C2 near 1, factors of Table 1's size."""
    P = np.sort(rng.uniform(20e3, 420e3, 4))
    return Tuning(
        pressures=tuple(P.tolist()),
        c1=tuple((rng.uniform(0.01, 0.06, 4) * P * 3e-5).tolist()),
        c2=tuple(rng.uniform(0.7, 1.3, 4).tolist()),
        youngs_modulus_factor=rng.uniform(0.8, 1.4),
        collapse_moment_factor=rng.uniform(0.6, 1.2),
        hinge_stiffness_factor=rng.uniform(0.5, 1.5),
        hinge_stiffness_slope=rng.uniform(0, 1) / 1e5,
        transition_rate=rng.uniform(5, 120),
    )


def random_cases(seed, n, strains=6, tuned=False, pairs=PAIRS, **laws):
    """n muscles: 3-15 mm radius, wall 0.12-0.35 of it, 60-400 mm, 20-42 deg, 0-400 kPa.

    Strains run from just above straight fibers to 0.6. One case in eight has no pressure.
    The material, and the collapse and post-collapse laws (through `pairs`), change from one
    muscle to the next, unless `laws` fixes them.
    """
    rng = np.random.default_rng(seed)
    cases = []
    for i in range(n):
        radius = rng.uniform(3e-3, 15e-3)
        c10, c01 = rng.uniform(60e3, 200e3), rng.uniform(20e3, 160e3)
        other = Material(c10, c01, rng.uniform(4, 9) * (c10 + c01), rng.uniform(0.3, 0.5))
        muscle = Muscle(
            length=rng.uniform(60e-3, 400e-3),
            outer_radius=radius,
            wall_thickness=radius * rng.uniform(0.12, 0.35),
            braid_angle=math.radians(rng.uniform(20, 42)),
            material=(LATEX, SILICONE, other)[rng.integers(3)],
            collapse=pairs[i % len(pairs)][0],
            collapse_factor=rng.uniform(0.6, 1.2),
            post_collapse=pairs[i % len(pairs)][1],
            transition_rate=rng.uniform(5, 120),
            tuning=random_tuning(rng) if tuned else Tuning(),
        )
        pressure = 0.0 if rng.integers(8) == 0 else rng.uniform(0, 400e3)
        # just above straight fibers the bladder's force has no bound: 0.95 keeps it finite
        low = 0.95 * lowest_strain(muscle)
        where = np.sort(rng.uniform(low, 0.6, strains))
        cases.append(Case(replace(muscle, **laws), pressure, tuple(where.tolist())))
    return cases
