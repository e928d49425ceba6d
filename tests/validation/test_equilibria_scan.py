"""Strains under a load against a plain scan of 40 000 strains, which knows the force alone."""

import math

import numpy as np
import pytest

import fascicle as fs
from fascicle.muscle.validation import lowest_strain


LAWS = (fs.tension.TENSION_LAWS, fs.buckling.BUCKLING_LAWS, fs.collapse.COLLAPSE_LAWS,
        fs.post_collapse.POST_COLLAPSE_LAWS)  # fmt: skip
KINDS = ("tension", "buckling", "collapse", "post_collapse")
STRAINS = 40_000
pytestmark = [
    pytest.mark.filterwarnings(f"ignore:{text}")
    for text in ("the tuning was measured", ".* was fitted to", ".* is valid up to", "Strain ")
]


def random_muscle(rng, length, laws):
    """A muscle of any law; nearly half have the default laws, a quarter a tuning."""
    radius, tuning = rng.uniform(3e-3, 15e-3), None
    if rng.random() < 0.25:
        pressures = np.sort(rng.uniform(20e3, 420e3, 3))
        tuning = fs.Tuning(
            pressures, rng.uniform(0.01, 0.06, 3) * pressures * 3e-5, rng.uniform(0.7, 1.3, 3),
            collapse_moment_factor=rng.uniform(0.6, 1.2),
        )  # fmt: skip
    c10, c01 = rng.uniform(60e3, 200e3), rng.uniform(20e3, 160e3)
    rubber = fs.MooneyRivlin(c10, c01, rng.uniform(4, 9) * (c10 + c01))
    return fs.Muscle(
        length, radius, radius * rng.uniform(0.12, 0.35), math.radians(rng.uniform(20, 45)),
        rubber, tuning=tuning, transition_rate=rng.uniform(5, 120), **laws,
    )  # fmt: skip


def random_bundle(rng):
    """One to four units, some of unequal length."""
    length, count = rng.uniform(0.06, 0.4), int(rng.choice([1, 1, 2, 3, 4]))
    default, stretch = rng.random() < 0.4, 0.02 * (rng.random() < 0.15)
    units = []
    for _ in range(count):
        laws = {}
        if not default:
            names = [str(rng.choice(sorted(registry.shipped))) for registry in LAWS]
            laws = dict(zip(KINDS, names, strict=True))
        muscle = random_muscle(rng, length * (1 + stretch * rng.random()), laws)
        units.append(fs.MotorUnit(muscle, int(rng.integers(1, 5))))
    return fs.Bundle(units, length=length)


def random_load(rng, bundle, pressures):
    """Pulling and pushing loads [N], none, and small ones."""
    full = abs(float(bundle.force(pressures, 0.0)))
    loads = [rng.uniform(0, 1.2) * full, -rng.uniform(0, 60) * rng.choice([1, 0.1]), 0.0]
    return float(rng.choice([*loads, rng.uniform(-5, 5)]))


def scan(bundle, pressures, load):
    """Cells of the domain in which the force passes the load."""
    muscles = [unit.muscle for unit in bundle.motor_units]
    ratios = np.ones(len(muscles)) if bundle.ratios is None else bundle.ratios
    ends = [(float(lowest_strain(muscle.law)), 0.6) for muscle in muscles]
    low, high = (1 - (1 - np.array(end)) / ratios for end in zip(*ends, strict=True))
    strain = np.linspace(low.max(), high.min(), STRAINS)
    force = sum(
        unit.count * unit.muscle.law.at(P).pulling_force(1 - ratio * (1 - strain))
        for unit, ratio, P in zip(bundle.motor_units, ratios, pressures, strict=True)
    )
    assert np.all(np.isfinite(force))
    above = force > load
    change = np.flatnonzero(above[1:] != above[:-1])
    return [(strain[i], strain[i + 1]) for i in change]


def holds(bundle, pressures, load, strain):
    """Whether the bundle pulls with the load at a strain, or its force jumps past it there."""
    miss = float(bundle.force(pressures, strain)) - load
    if abs(miss) <= 1e-6 * (1 + abs(load)):
        return True
    beside = [float(bundle.force(pressures, strain + step)) - load for step in (-1e-9, 1e-9)]
    return beside[0] * beside[1] <= 0


@pytest.mark.parametrize(("seed", "count"), [(0, 8), pytest.param(1, 500, marks=pytest.mark.slow)])
def test_strains_under_a_load_are_those_of_a_scan(seed, count):
    rng, crossings = np.random.default_rng(seed), 0
    for _ in range(count):
        bundle = random_bundle(rng)
        units = len(bundle.motor_units)
        P = rng.uniform(0, 6e5, units) * (rng.random(units) > 0.3) * rng.choice([1, 0.1])
        load = random_load(rng, bundle, P)
        result = bundle.strain_at(load, P)
        strains = result.strain[np.isfinite(result.strain)]
        assert result.count == len(strains)
        for low, high in scan(bundle, P, load):
            crossings += 1
            inside = (strains >= low - 1e-9) & (strains <= high + 1e-9)
            assert np.any(inside), (bundle, P, load, low)
        for strain in strains:
            assert holds(bundle, P, load, strain), (bundle, P, load, strain)
    assert crossings > count / 2
