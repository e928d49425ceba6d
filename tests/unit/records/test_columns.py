import numpy as np
import pytest
from numpy.testing import assert_array_equal

from fascicle.records.headers import choose_columns, is_unit, unit_factor
from fascicle.records.quantities import to_si_units
from fascicle.records.tables import open_table


def chosen(header, columns=None, units=None):
    table = open_table(header.encode() + b"\n", "m.csv")
    return choose_columns(table, columns or {}, units or {})[0]


@pytest.mark.parametrize(
    ("header", "unit", "si"),
    [
        ("pressure [kPa]", "kPa", 1e3),
        ("Pressure (psi)", "psi", 6894.757293168361),
        ("PRESSURE [PSI]", "PSI", 6894.757293168361),
        ("pressure_Pa", "Pa", 1.0),
        ("p_kPa", "kPa", 1e3),
        ("p/bar", "bar", 1e5),
        ("P / MPa", "MPa", 1e6),
        ('"Pressure, kPa"', "kPa", 1e3),
        ("pressure in mbar", "mbar", 100.0),
        ("Pressure kPa", "kPa", 1e3),
        ("Muscle pressure {bar(g)}", "bar(g)", 1e5),
        ("gauge pressure [psig]", "psig", 6894.757293168361),
        ("Pressure (gauge) [kPa]", "kPa", 1e3),
        ("MusclePressure [kPa]", "kPa", 1e3),
        ("Druck [bar]", "bar", 1e5),
        ("pressure <N/mm²>", "N/mm²", 1e6),
    ],
)
def test_pressures(header, unit, si):
    found = chosen(f"{header},strain,force [N]")["pressure"]
    assert (found.index, found.unit, found.factor) == (0, unit, pytest.approx(si, rel=1e-15))


@pytest.mark.parametrize(
    ("header", "si"),
    [
        ("force [N]", 1.0), ("Force/N", 1.0), ("force_N", 1.0), ("F (kN)", 1e3),
        ("Load [lbf]", 4.4482216152605), ("load cell (lbs)", 4.4482216152605),
        ("Force, mN", 1e-3), ("Kraft [Newton]", 1.0), ("axial_force_N", 1.0),
        ("force [kgf]", 9.80665),
    ],
)  # fmt: skip
def test_forces(header, si):
    found = chosen(f'pressure [Pa],strain,"{header}"')["force"]
    assert (found.index, found.factor) == (2, pytest.approx(si, rel=1e-14))


@pytest.mark.parametrize(
    ("header", "role", "si", "sign"),
    [
        ("length_m", "length", 1.0, 1), ("Length (in)", "length", 0.0254, 1),
        ("L [mm]", "length", 1e-3, 1), ("Länge [cm]", "length", 1e-2, 1),
        ("strain", "strain", 1.0, 1), ("strain [-]", "strain", 1.0, 1),
        ("strain (%)", "strain", 1e-2, 1), ("contraction_pct", "strain", 1e-2, 1),
        ("ε [%]", "strain", 1e-2, 1), ("contraction", "strain", 1.0, 1),
        ("strain [mm/mm]", "strain", 1.0, 1), ("extension [%]", "strain", 1e-2, -1),
        ("strain (measured)", "strain", 1.0, 1),
        ("contraction [mm]", "displacement", 1e-3, 1), ("stroke/mm", "displacement", 1e-3, 1),
        ("displacement_in", "displacement", 0.0254, 1), ("x [mm]", "displacement", 1e-3, 1),
        ("extension [mm]", "displacement", 1e-3, -1), ("Length (in.)", "length", 0.0254, 1),
        ("Verlängerung [mm]", "displacement", 1e-3, -1),
        ("Kolbenweg [mm]", "displacement", 1e-3, 1),
    ],
)  # fmt: skip
def test_positions(header, role, si, sign):
    found = chosen(f"pressure [Pa],{header},force [N]")[role]
    assert (found.index, found.factor, found.sign) == (1, pytest.approx(si), sign)


def test_setpoints_and_rates_are_no_readings():
    found = chosen("pressure setpoint [kPa],pressure sensor [kPa],strain rate,strain,force [N]")
    assert (found["pressure"].index, found["strain"].index) == (1, 3)
    # named in so many words, they are
    given = chosen("pressure setpoint [kPa],strain,force [N]", {"pressure": "pressure setpoint"})
    assert given["pressure"].index == 0


def test_raw_signals_stresses_and_gauge_lengths_are_no_readings():
    assert chosen("pressure [Pa],F [V],load cell [N],strain")["force"].index == 2
    with pytest.raises(ValueError, match="no column of pressure found"):
        chosen("sigma [MPa],force [N],strain")
    found = chosen("pressure [Pa],force [N],gauge length [mm],extension [mm]")
    assert found["displacement"].index == 3
    assert "length" not in found


def test_a_remark_beside_a_name_and_a_unit_that_is_unknown():
    text = "pressure,position (laser),force (load cell)\nkPa,mm,N\n100,5,20\n"
    columns, _ = choose_columns(open_table(text.encode(), "m.csv"), {}, {})
    assert {role: column.unit for role, column in columns.items()} == {
        "pressure": "kPa", "displacement": "mm", "force": "N",
    }  # fmt: skip
    with pytest.raises(ValueError, match="'thou' is no unit of length: convert its numbers"):
        chosen("pressure [Pa],displacement [thou],force [N]")


def test_strain_goes_before_length():
    found = chosen("length [mm],strain,pressure [Pa],force [N]")
    assert "length" not in found


def test_flags_branches_and_times():
    found = chosen("length_m,pressure_Pa,force_N,zero_is_no_tension,t [ms],direction,T [degC]")
    places = [found[role].index for role in ("clipped", "time", "branch")]
    assert places == [3, 4, 5]
    assert found["time"].factor == 1e-3


@pytest.mark.parametrize(
    ("unit", "dimension", "said"),
    [
        ("psia", "pressure", "absolute"), ("bar abs", "pressure", "absolute"),
        ("kPa (a)", "pressure", "absolute"), ("N", "pressure", "no unit of pressure"),
        ("kg", "force", "no unit of force"), ("%", "length", "no unit of length"),
        ("", "force", "no unit of force"),
    ],
)  # fmt: skip
def test_what_is_no_such_unit(unit, dimension, said):
    with pytest.raises(ValueError, match=said):
        unit_factor(unit, dimension)


def test_case_counts_where_it_can():
    assert unit_factor("mN", "force") == 1e-3
    assert unit_factor("MPa", "pressure") == 1e6
    assert unit_factor("bar", "pressure") == unit_factor("BAR", "pressure") == 1e5
    assert is_unit("[kPa]")
    assert not is_unit("gauge")


def test_thousandths_are_divided_by():
    millimeters = np.arange(1000.0)
    assert_array_equal(to_si_units(millimeters, 1e-3), [float(f"{i}e-3") for i in range(1000)])
    assert to_si_units(np.array([413.7]), 1e3) == 413700
