"""Conductance from the figures of data sheets."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle import fluid
from fascicle.core.errors import InvalidInputError


LITER_PER_SECOND_BAR = 1e-8
CUBIC_METERS_PER_HOUR = 1 / 3600


def test_nominal_flow_of_a_printed_example():
    """SMC prints: C = 2 dm³/(s·bar), b = 0.3, 0.4 to 0.3 MPa in a room of 0.1 MPa: 420 dm³/min."""
    C = fluid.conductance_from_nominal_flow(420e-3 / 60, 0.3, 4e5, 3e5, room_pressure=1e5)
    # the example reads the share of the flow from a graph, as 0.7
    assert_allclose(C, 2 * LITER_PER_SECOND_BAR, rtol=1e-3)


def test_nominal_flows_at_several_inlet_pressures_broadcast():
    inlets, outlets = [4e5, 6e5], [[3e5], [1e5]]
    C = fluid.conductance_from_nominal_flow(7e-3, 0.3, inlets, outlets)
    for (i, j), value in np.ndenumerate(C):
        single = fluid.conductance_from_nominal_flow(7e-3, 0.3, inlets[j], outlets[i][0])
        assert value == single
    with pytest.raises(InvalidInputError) as caught:
        fluid.conductance_from_nominal_flow(7e-3, 0.3, inlets, 5e5)
    assert caught.value.argument == "outlet"


@pytest.mark.parametrize("b", [0.1, 0.3, 0.5])
def test_valve_with_the_conductance_passes_its_nominal_flow(b):
    C = fluid.conductance_from_nominal_flow("100 L/min", b)
    room, T = 101325.0, 293.15
    flow = fluid.SonicValve(C, b).flow(6e5 + room, 5e5 + room, T, T)
    assert_allclose(flow, 1.185 * 0.1 / 60, rtol=1e-12)
    # the same liters hold more air at 0 °C and 101 325 Pa: p/T of both, in air of 65 % humidity
    normal = fluid.conductance_from_nominal_flow("100 L/min", b, reference="din1343")
    assert_allclose(normal / C, 101325 / 273.15 / (1e5 / 293.15), rtol=0.015)


@pytest.mark.parametrize("b", [0.1, 0.3, 0.5])
def test_gas_flows_as_water_does_at_a_small_difference(b):
    """By the definition of Kv, worked out for 1 kPa at 6 bar gauge in plain numbers."""
    Kv, drop, high, T = 0.07, 1e3, 6e5 + 101325, 293.15
    density = 1.185 * high / 1e5  # of the gas, upstream
    liters = Kv / 3600 * math.sqrt(drop / 1e5 * 998.2 / density)  # m³/s of it
    C = fluid.conductance_from_kv("0.07 m^3/h", b)
    flow = fluid.SonicValve(C, b).flow(high, high - drop, T, T)
    # the parabola of (F4) is flatter by a share x/4/(1-b) of the ratio's distance x from 1, 0.0014;
    # at 0.9986 the linear end isn't reached
    assert_allclose(flow, liters * density, rtol=2e-3)


def test_coefficients_agree_with_each_other_and_with_choked_flow_of_iec_60534():
    C = fluid.conductance_from_kv(1 * CUBIC_METERS_PER_HOUR, 0.3)
    assert_allclose(C / LITER_PER_SECOND_BAR, 4.77, atol=0.01)  # as the docstring says
    # Kv = 0.865 Cv, rounded
    assert_allclose(fluid.conductance_from_cv(1.0, 0.3) / C, 0.865, atol=5e-4)
    # IEC 60534: w = 31.6 Kv 2/3 sqrt(xT p ρ) in kg/h, bar and kg/m³; xT = 0.72 of a globe valve
    choked = 31.6 * (2 / 3) * math.sqrt(0.72 * 1.185) / 3600 / 1.185  # m³/(s·bar) for Kv = 1
    # another law, with an xT for a b: they agree within ten percent, not in digits
    assert_allclose(C * 1e5, choked, rtol=0.1)


def test_arrays_and_invalid_figures():
    assert np.shape(fluid.conductance_from_kv(np.array([1e-5, 2e-5]), 0.3)) == (2,)
    for call, name in (
        (lambda: fluid.conductance_from_kv(-1.0, 0.3), "Kv"),
        (lambda: fluid.conductance_from_cv(1.0, 1.2), "b"),
        (lambda: fluid.conductance_from_nominal_flow(1e-3, 0.3, 5e5, 6e5), "outlet"),
        (lambda: fluid.conductance_from_nominal_flow(1e-3, 0.3, reference="ntp"), "reference"),
    ):
        with pytest.raises(InvalidInputError) as refused:
            call()
        assert refused.value.argument == name
