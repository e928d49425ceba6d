"""Damping by speed: what a prescribed motion loses to it, and that it never gives energy."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle import dynamics
from fascicle.dynamics import Damping
from fascicle.dynamics.outputs import LEDGER


STEPS, MUSCLES = 120, 5


def test_it_opposes_either_direction_and_never_drives():
    law = Damping(40.0, 25.0, 1e-4, -1e-4)
    assert_allclose(law.force(0.02, 1e5), 50 * 0.02)
    assert_allclose(law.force(-0.02, 1e5), 15 * -0.02)
    assert law.force(-0.02, 4e5) == 0  # where the line is below zero
    v, P = np.meshgrid(np.linspace(-1, 1, 21), np.linspace(0, 8e5, 9))
    assert np.all(law.force(v, P) * v >= 0)


@pytest.mark.parametrize("law", [Damping(60.0, 20.0), Damping(10.0, 40.0, 2e-4, -1e-4)])
def test_a_cycle_loses_what_the_damper_takes(bundle, air, law):
    amplitude, frequency = 0.01, 25.0
    load = dynamics.PrescribedMotion(0.012, amplitude, frequency)
    plant = dynamics.Plant(bundle, load, **air, damping=law)
    start = dynamics.equilibrium_state(plant, 1e5)
    run = dynamics.simulate(plant, np.zeros((STEPS, 2)), dt=1e-3, start=start, substeps=8)
    assert dynamics.audit(plant, run).closes
    lost = run.ledger[:, LEDGER.index("friction")]
    # by trapezoids over the steps, of which a cycle has 40: exact for sines but for the kinks of
    # the damping and the pressures' swing
    v, counts = run.outputs.velocity, np.array([1, 4])
    power = np.zeros(v.size)
    for unit, count in enumerate(counts):
        P = run.outputs.pressures[:, unit]
        up = np.maximum(law.shortening + law.shortening_slope * P, 0)
        down = np.maximum(law.lengthening + law.lengthening_slope * P, 0)
        power += count * np.where(v >= 0, up, down) * v**2
    total = np.sum((power[1:] + power[:-1]) / 2 * np.diff(run.time))
    assert_allclose(lost[-1], total, rtol=5e-3)
    if not law.shortening_slope:  # n (B + B')/2 ∫v² dt over three cycles
        mean_square = (2 * np.pi * frequency * amplitude) ** 2 / 2
        closed = MUSCLES * (law.shortening + law.lengthening) / 2 * mean_square * 3 / frequency
        assert_allclose(lost[-1], closed, rtol=1e-4)
    assert np.all(np.diff(lost) >= 0)


def lifting(bundle, air, damping):
    return dynamics.Plant(bundle, dynamics.HangingMass(12.0, damping=300.0), **air, damping=damping)


def test_a_damped_lift_keeps_its_energy_and_is_slower(bundle, air, lift):
    damped = lifting(bundle, air, Damping(300.0, 200.0, 1e-3, 1e-3))
    runs = []
    for plant in (lift, damped):
        start = dynamics.equilibrium_state(plant, 1.5e5)
        command = np.repeat([[1.0, 0.5], [-1.0, -1.0]], STEPS // 2, axis=0)
        runs.append(dynamics.simulate(plant, command, start=start, substeps=8))
        assert dynamics.audit(plant, runs[-1]).closes
    plain, slowed = (np.max(np.abs(run.outputs.velocity)) for run in runs)
    assert slowed < 0.8 * plain


def test_a_strong_damper_takes_smaller_steps(bundle, air):
    # an explicit step of 1 ms bears a rate of 2.8/ms: this one has 5 * 4e4 / 12 kg = 17/ms
    damped = lifting(bundle, air, Damping(4e4, 0.0))
    assert dynamics.estimate_substeps(damped, 1e-3).substeps > 5
