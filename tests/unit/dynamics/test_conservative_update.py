"""What a chamber holds besides the work of its wall: by hand, its rates, and setting right."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle import fluid
from fascicle.dynamics import equilibrium_state
from fascicle.dynamics.chamber_pressure import (
    conserved_rates,
    conserved_state,
    evaluate_chambers,
    project_chambers,
)


WALL = fluid.AdiabaticWall(0.5, dead_volume=3e-6)
ROOM = 101325.0


def test_gas_behind_a_wall_conserves_enthalpy():
    s = WALL.state_at(2e5, 1e-5)
    assert_allclose(conserved_state(WALL, s, np.array(2e5), np.array(1e-5)), [s[0], s[1] + 3.01325])


def test_chambers_without_a_wall_conserve_their_state():
    for one in (fluid.Isothermal(dead_volume=3e-6), fluid.LiquidChamber(dead_volume=3e-6)):
        s = one.state_at(2e5, 1e-5)
        assert_allclose(conserved_state(one, s, np.array(2e5), np.array(1e-5)), s, rtol=0)


def test_conserved_rates_are_derivatives_of_the_conserved_state():
    # along a path on which pressure and volume both change, gas flows in and heat out
    s, P, V = WALL.state_at(2e5, 1e-5), np.array(2e5), np.array(1e-5)
    P_dot, V_dot, flow, energy = np.array(3e6), np.array(2e-4), 1e-4, 40.0
    rate = WALL.rates(s, P, flow, energy, V_dot)
    still = WALL.rates(s, P, flow, energy, 0.0)
    h = 1e-6
    ends = [
        conserved_state(WALL, s + k * h * rate, P + k * h * P_dot, V + k * h * V_dot)
        for k in (-1, 1)
    ]
    result = conserved_rates(WALL, s, still, P_dot, V)
    # rounding of U over 2 h
    assert_allclose(result, (ends[1] - ends[0]) / (2 * h), rtol=1e-8)


@pytest.mark.parametrize("off", [-3e3, 0.0, 3e3])
def test_corrected_pressures_include_the_work_of_the_wall(lift, off):
    P = np.array([1.5e5, 0.8e5])
    at = equilibrium_state(lift, P)
    eps, s = lift.strains(at.position), at.chambers
    near = P + off
    there = evaluate_chambers(lift, s, eps, near).volume
    result = project_chambers(lift, conserved_state(lift.chamber, s, near, there), eps, near, 6)
    end = evaluate_chambers(lift, result.chambers, eps, result.pressures)
    assert np.all(np.abs(end.newton_step) < 1e-9 * P)
    assert np.all(np.sign(near - result.pressures) == np.sign(off) * np.ones(2)) or off == 0
    # the first law: energy that the gas lost is what its wall did on the way from `there`
    work = ((near + result.pressures) / 2 + ROOM) * (end.volume - there)
    assert_allclose(s[:, 1] - result.chambers[:, 1], work, rtol=1e-9, atol=1e-14)
    # and the same by parts
    gauge = np.sum(work - ROOM * (end.volume - there))
    by_parts = np.sum(result.pressures * end.volume - near * there) + result.work
    assert_allclose(by_parts, gauge, rtol=1e-9, atol=1e-14)
    assert_allclose(result.mismatch, 0, rtol=0, atol=1e-15)
