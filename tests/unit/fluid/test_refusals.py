"""What can't be is refused in one line: the name, the rule, the value and what to do."""

import jax
import numpy as np
import pytest

import fascicle as fs
from fascicle import fluid


LINE = fluid.Line(1.0, 0.004)
GAS = fluid.Isothermal()
SHEET = "take it from the valve's data sheet"
CASES = [
    (lambda: fluid.SonicValve(1e-8, 1.0), f"`b` must lie in (0, 1), got 1: {SHEET}."),
    (lambda: fluid.SonicValve(1e-8, 0.0), f"`b` must lie in (0, 1), got 0: {SHEET}."),
    (lambda: fluid.SonicValve(0.0, 0.3), "`C` must be positive and finite, got 0 "
     f"m³/(s·Pa): {SHEET}."),
    (lambda: fluid.SonicValve(-1e-8, 0.3), "`C` must be positive and finite, got -1e-08 "
     f"m³/(s·Pa): {SHEET}."),
    (lambda: fluid.SonicValve(1.2, 0.3), "`C` must lie in [1e-15, 0.001] m³/(s·Pa), got 1.2 "
     "m³/(s·Pa): check its unit."),
    (lambda: fluid.SonicValve(1e-8, 0.3, 0.0), "`m` must lie in (0, 1], got 0."),
    (lambda: fluid.SonicValve(1e-8, 0.3, 0.6, LINE), "`m` must be 0.5 with a `line`, got 0.6: "
     "leave `m` or `line` out."),
    (lambda: fluid.SonicValve("1e-8", 0.3),
        '`C` must be a sonic conductance, such as "0.1 L/(s*bar)", got the bare number 1e-8: write'
        " it with its unit.",
    ),
    (lambda: fluid.Orifice(0.0), "`area` must be positive and finite, got 0 m²."),
    (lambda: fluid.Orifice(1e-6, discharge_coefficient=1.1), "`discharge_coefficient` must lie in "
     "(0, 1], got 1.1."),
    (lambda: fluid.Orifice(1e-6, critical_pressure_difference=0), "`critical_pressure_difference` "
     "must be positive and finite, got 0 Pa."),
    (lambda: fluid.Line(-1.0, 0.004), "`length` must be positive and finite, got -1 m."),
    (lambda: fluid.Line(1.0, 4.0), "`diameter` must lie in [1e-05, 1] m, got 4 m: check its unit."),
    (lambda: fluid.SonicValve(1e-8, 0.3, line=1.0), "`line` must be `Line`, got `float`."),
    (lambda: fluid.Isothermal(fluid.OIL), "`gas` must be `Gas`, got `Liquid`."),
    (lambda: fluid.LiquidChamber(None), "`liquid` must be `Liquid`, got `NoneType`."),
    (lambda: fluid.Tank(fluid.LiquidChamber(), 0.01, 6e5), "`chamber` must be `AdiabaticWall` or "
     "`Isothermal` or `Polytropic`, got `LiquidChamber`."),
    (lambda: fluid.Servovalve(0.0), "`time_constant` must be positive and finite, got 0 s."),
    (lambda: fluid.Direct(1.0), "`overlap` must lie in [0, 1), got 1."),
    (lambda: fluid.Direct(-0.1), "`overlap` must lie in [0, 1), got -0.1."),
    (lambda: fluid.OrderlyValve(0, 0.01), "`units` must be a whole number of at least 1, got 0."),
    (lambda: fluid.OrderlyValve(3, 0.01).states(2), "`units` must be the bundle's number of motor "
     "units, 2, got 3: give the valve a port for each."),
    (lambda: fluid.OrderlyValve(3, 0.01).middle(3), "`unit` must lie in [0, 2], got 3."),
    (lambda: fluid.validate_commands([0.5, 1.2]), "`command` must lie in [-1, 1] from open exhaust "
     "to open supply, got 1.2."),
    (lambda: fluid.validate_commands(float("nan")), "`command` must lie in [-1, 1] from open "
     "exhaust "
     "to open supply, got nan."),
    (lambda: fluid.AdiabaticWall(-1.0), "`conductance` must lie in [0, inf) W/K, got -1 W/K."),
    (lambda: fluid.Isothermal(dead_volume=-1e-6), "`dead_volume` must lie in [0, inf) m³, got "
     "-1e-06 m³: leave it out where there is none."),
    (lambda: fluid.LiquidChamber(compliance=-1e-12), "`compliance` must lie in [0, inf) m³/Pa, got "
     "-1e-12 m³/Pa."),
    (lambda: fluid.Isothermal(room_pressure=0.0), "`room_pressure` is absolute and must be at "
     "least "
     "10000 Pa, got 0 Pa: at sea level it is 101325 Pa."),
    (lambda: fluid.Isothermal(room_temperature=20.0), "`room_temperature` must lie in [100, "
     "1500] K, "
     "got 20 K: check its unit."),
    (lambda: fluid.Polytropic(0.9), "`exponent` must lie in [1, 2], got 0.9: 1 is isothermal, 1.4 "
     "adiabatic air."),
    (lambda: fluid.Polytropic(2.5), "`exponent` must lie in [1, 2], got 2.5: 1 is isothermal, 1.4 "
     "adiabatic air."),
    (lambda: fluid.Gas(287.0, 1.0), "`heat_capacity_ratio` must lie in [1.001, 2], got 1: check "
     "its "
     "unit."),
    (lambda: fluid.Liquid(850.0, -1.0, 1.0), "`bulk_modulus` must be positive and finite, got -1 "
     "Pa."),
    (lambda: fluid.ConstantSupply(0.0), "`pressure` must lie above the room's, which is 0 Pa "
     "gauge, "
     "got 0 Pa: raise it."),
    (lambda: fluid.ConstantSupply(-2e4), "`pressure` must lie above the room's, which is 0 Pa "
     "gauge, got -20000 Pa: raise it."),
    (lambda: fluid.ConstantSupply.from_absolute(5e4), "`absolute` must lie above the room's 101325 "
     "Pa, got 50000 Pa: give an absolute pressure here, or a gauge pressure as `pressure`."),
    (lambda: fluid.ConstantSupply.from_absolute(5e5, 6e5), "`absolute` must lie above the room's "
     "600000 Pa, got 500000 Pa: give an absolute pressure here, or a gauge pressure as "
     "`pressure`."),
    (lambda: fluid.Tank(GAS, 0.0, 6e5), "`volume` must be positive and finite, got 0 m³."),
    (lambda: fluid.Tank(GAS, 0.01, 0.0), "`pressure` must lie above the room's, which is 0 Pa "
     "gauge, got 0 Pa: raise it."),
    (lambda: fluid.Accumulator(1e-3, 2e5, 6e5, 0.9), "`exponent` must lie in [1, 2], got 0.9: 1 is "
     "isothermal, 1.4 adiabatic nitrogen."),
    (lambda: fluid.Accumulator(1e-3, 6e5, 2e5), "`pressure` must lie above the `precharge` of "
     "600000 Pa, got 200000 Pa: below it there is no liquid."),
    (lambda: fluid.Accumulator(1e-3, 1e3, 9e7, 1.0), "`pressure` must leave the gas 0.01 of "
     "`volume`, got a share of 0.00114: raise the `precharge`."),
    (lambda: fluid.FixedPump(1e-6, 25.0, 0.0), "`volumetric_efficiency` must lie in (0, 1], got "
     "0: 1 is without loss."),
    (lambda: fluid.FixedPump(1e-6, 25.0, 0.9, 1.1), "`mechanical_efficiency` must lie in (0, 1], "
     "got 1.1: 1 is without loss."),
    (lambda: fluid.VariablePump(1e-6, 25.0, 1e6, 0.0), "`band` must be positive and finite, got 0 "
     "Pa."),
    (lambda: fluid.PressureBand(6e5, 4e5), "`high` must lie above `low`, 600000 Pa, got 400000 Pa: "
     "widen the band."),
    (lambda: fluid.Relief(1e6, 0.0), "`slope` must be positive and finite, got 0 kg/(s·Pa)."),
]  # fmt: skip


@pytest.mark.parametrize(("made", "line"), CASES, ids=range(len(CASES)))
def test_refused_in_a_line(made, line):
    with pytest.raises(fs.InvalidInputError) as caught:
        made()
    assert str(caught.value) == line


def test_one_bad_number_of_many_is_enough():
    with pytest.raises(fs.InvalidInputError, match=r"`b` must lie in \(0, 1\), got 1.5"):
        fluid.SonicValve(1e-8, np.array([0.3, 1.5]))


def test_the_unusual_is_warned_about():
    with pytest.warns(UserWarning, match="`C` of 0.0001 m³/"):
        fluid.SonicValve(1e-4, 0.3)


def test_what_is_traced_is_the_callers():
    # a fit may pass through anywhere; laws raise nothing
    flow = jax.jit(lambda C: fluid.SonicValve(C, 0.3).flow(6e5, 1e5, 293.15, 293.15))
    assert flow(0.0) == 0
