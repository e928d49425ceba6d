"""Invalid values of fluid components raise an error with the argument's name."""

import jax
import numpy as np
import pytest

import fascicle as fs
from fascicle import fluid
from refusing import refuses


LINE = fluid.Line(1.0, 0.004)
GAS = fluid.Isothermal()
CASES = [
    (lambda: fluid.SonicValve(1e-8, 1.0), "b"),
    (lambda: fluid.SonicValve(0.0, 0.3), "C"),
    (lambda: fluid.SonicValve(1.2, 0.3), "C"),
    (lambda: fluid.SonicValve(1e-8, 0.3, 0.0), "m"),
    (lambda: fluid.SonicValve(1e-8, 0.3, 0.6, LINE), "m"),
    (lambda: fluid.SonicValve("1e-8", 0.3), "C"),
    (lambda: fluid.Orifice(0.0), "area"),
    (lambda: fluid.Orifice(1e-6, discharge_coefficient=1.1), "discharge_coefficient"),
    (lambda: fluid.Orifice(1e-6, critical_pressure_difference=0), "critical_pressure_difference"),
    (lambda: fluid.Line(1.0, 4.0), "diameter"),
    (lambda: fluid.SonicValve(1e-8, 0.3, line=1.0), "line"),
    (lambda: fluid.Isothermal(gas=fluid.OIL), "gas"),
    (lambda: fluid.Tank(fluid.LiquidChamber(), 0.01, 6e5), "chamber"),
    (lambda: fluid.Servovalve(0.0), "time_constant"),
    (lambda: fluid.Direct(1.0), "overlap"),
    (lambda: fluid.validate_commands([0.5, 1.2]), "command"),
    (lambda: fluid.AdiabaticWall(-1.0), "conductance"),
    (lambda: fluid.Isothermal(dead_volume=-1e-6), "dead_volume"),
    (lambda: fluid.LiquidChamber(compliance=-1e-12), "compliance"),
    (lambda: fluid.Isothermal(room_pressure=0.0), "room_pressure"),
    (lambda: fluid.Isothermal(room_temperature=20.0), "room_temperature"),
    (lambda: fluid.Gas(287.0, 1.0), "heat_capacity_ratio"),
    (lambda: fluid.Liquid(850.0, -1.0, 1.0), "bulk_modulus"),
    (lambda: fluid.ConstantSupply(0.0), "pressure"),
    (lambda: fluid.Tank(GAS, 0.01, 0.0), "pressure"),
    (lambda: fluid.Accumulator(1e-3, 2e5, 6e5, 0.9), "exponent"),
    (lambda: fluid.Accumulator(1e-3, 6e5, 2e5), "pressure"),
    (lambda: fluid.FixedPump(1e-6, 25.0, 0.0), "volumetric_efficiency"),
    (lambda: fluid.FixedPump(1e-6, 25.0, 0.9, 1.1), "mechanical_efficiency"),
    (lambda: fluid.FixedPump(1e-6, 25.0, switch_on=6e5, switch_off=4e5), "switch_off"),
]


@pytest.mark.parametrize(("create", "argument"), CASES, ids=range(len(CASES)))
def test_an_invalid_value_is_refused_by_its_name(create, argument):
    with pytest.raises(fs.InvalidInputError) as error:
        create()
    assert error.value.argument == argument and "\n" not in str(error.value)


def test_one_bad_number_of_many_is_enough():
    with refuses("b"):
        fluid.SonicValve(1e-8, np.array([0.3, 1.5]))


def test_what_is_traced_is_the_callers():
    # a fit may pass through anywhere; laws raise nothing
    flow = jax.jit(lambda C: fluid.SonicValve(C, 0.3).flow(6e5, 1e5, 293.15, 293.15))
    assert flow(0.0) == 0
