"""Springs that slip, found again in the two branches that they were walked round."""

import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.calibrate.friction import fit_friction
from fascicle.records import Record, VirtualDynamometer


sys.path.insert(0, str(Path(__file__).parents[2] / "validation"))
from oracle_slip import walked


SIX = fs.example("kim2021_figure_6")
L = 0.127
STIFFNESS, SLIP, SLOPE = np.array([4e3, 500.0]), np.array([0.6, 0.3]), np.array([6e-6, 4e-6])


def looped(noise, steps=80, pressures=6):
    """A record of both ways, its friction walked by the oracle; synthetic."""
    rng, rows = np.random.default_rng(5), []
    there = np.linspace(0, 0.2, steps)
    loop = np.concatenate([there, there[::-1]])
    for P in np.linspace(5e4, 4e5, pressures):
        forces = walked(STIFFNESS, SLIP + SLOPE * P, [*(L * np.tile(loop, 3))])[-2 * steps :]
        pull = SIX.law.tension.force(P, loop) - forces
        rows.append((np.full(loop.size, P), loop, pull + noise * rng.normal(size=loop.size)))
    P, eps, F = map(np.concatenate, zip(*rows, strict=True))
    ways = np.tile(np.repeat([1, -1], steps), pressures)
    return Record.of(P, eps, F, branch=ways, rest_length=L, synthetic=True)


@pytest.mark.parametrize(("noise", "within"), [(0.0, 0.01), (0.1, 0.05)])
def test_springs_are_found_again(noise, within):
    found = fit_friction(looped(noise), L)
    assert found.resolved == (True, True) and found.pressures == 6
    # one rise with pressure stands for both springs' own, 1.0e-5 and 1.3e-5 of their slips
    assert_allclose(found.law.stiffness, STIFFNESS, rtol=within)
    for P in (1e5, 4e5):
        assert_allclose(found.half_width(P), np.sum(SLIP + SLOPE * P), rtol=0.02)
    # a width is of two readings, and what is left of it is their noise
    assert found.rmse < 0.03 + 1.5 * noise


@pytest.mark.parametrize("clip", [False, True])
def test_the_dynamometer_s_loops_have_their_width_and_no_build_up(clip):
    record = VirtualDynamometer(hysteresis=0.08, samples=100, clip=clip).record(SIX, seed=3)
    found = fit_friction(record, L)
    # half a percent of the largest force is noise: 0.7 N a reading, over a thousand of them
    for P in (1e5, 4e5):
        assert_allclose(found.half_width(P), 0.04 * SIX.blocked_force(P), rtol=0.03, atol=0.1)
    assert found.resolved == (False,)


@pytest.mark.parametrize("seed", range(5))
def test_noise_alone_is_no_friction(seed):
    found = fit_friction(VirtualDynamometer(samples=60).record(SIX, seed=seed), L)
    assert found.law is None and found.half_width(4e5) == 0


def test_one_way_says_nothing():
    record = VirtualDynamometer(samples=60, both_ways=False).record(SIX)
    assert fit_friction(record, L) is None


def test_lengths_are_those_of_the_strain():
    # half the length: half the way, twice the stiffness, the same slip
    one, half = fit_friction(looped(0.0), L), fit_friction(looped(0.0), L / 2)
    assert_allclose(half.law.stiffness, 2 * one.law.stiffness, rtol=1e-3)
    assert_allclose(half.half_width(2e5), one.half_width(2e5), rtol=1e-4)
