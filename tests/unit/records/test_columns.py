import pytest

from fascicle.records.headers import choose_columns, unit_factor
from fascicle.records.sidecar import Sidecar
from fascicle.records.tables import open_table


def chosen(header, columns=None, units=None):
    table = open_table(header.encode() + b"\n", "m.csv")
    return choose_columns(table, Sidecar(columns=columns or {}, units=units or {}))[0]


COLUMNS = {
    "pressure": {
        "pressure [kPa]": 1e3, "PRESSURE [PSI]": 6894.757293168361, "p_kPa": 1e3, "p/bar": 1e5,
        "P / MPa": 1e6, '"Pressure, kPa"': 1e3, "pressure in mbar": 100.0, "Pressure kPa": 1e3,
        "Muscle pressure {bar(g)}": 1e5, "gauge pressure [psig]": 6894.757293168361,
        "Pressure (gauge) [kPa]": 1e3, "MusclePressure [kPa]": 1e3, "Druck [bar]": 1e5,
        "pressure <N/mm²>": 1e6,
    },
    "force": {
        "Force/N": 1.0, "F (kN)": 1e3, "load cell (lbs)": 4.4482216152605, '"Force, mN"': 1e-3,
        "Kraft [Newton]": 1.0, "axial_force_N": 1.0, "force [kgf]": 9.80665,
    },
    "length": {
        "length_m": 1.0, "Length (in.)": 0.0254, "L [mm]": 1e-3, "Länge [cm]": 1e-2,
    },
    "strain": {
        "strain": 1.0, "strain [-]": 1.0, "strain (%)": 1e-2, "contraction_pct": 1e-2,
        "ε [%]": 1e-2, "contraction": 1.0, "strain [mm/mm]": 1.0, "strain (measured)": 1.0,
        "extension [%]": -1e-2,
    },
    "displacement": {
        "contraction [mm]": 1e-3, "stroke/mm": 1e-3, "displacement_in": 0.0254, "x [mm]": 1e-3,
        "Kolbenweg [mm]": 1e-3, "extension [mm]": -1e-3, "Verlängerung [mm]": -1e-3,
    },
}  # fmt: skip


@pytest.mark.parametrize(
    ("role", "header", "si"),
    [(role, header, si) for role, group in COLUMNS.items() for header, si in group.items()],
)
def test_names_and_units_of_columns(role, header, si):
    others = {"pressure": "p [Pa]", "force": "F [N]", "strain": "strain"}
    others.pop(role if role in others else "strain")
    found = chosen(",".join([header, *others.values()]))[role]
    assert (found.index, found.factor * found.sign) == (0, pytest.approx(si, rel=1e-14))


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
    found = chosen("pressure,position (laser),force (load cell)\nkPa,mm,N\n100,5,20")
    units = {role: column.unit for role, column in found.items()}
    assert units == {"pressure": "kPa", "displacement": "mm", "force": "N"}
    with pytest.raises(ValueError, match="'thou'"):
        chosen("pressure [Pa],displacement [thou],force [N]")


def test_flags_branches_and_times():
    found = chosen("length_m,pressure_Pa,force_N,zero_is_no_tension,t [ms],direction,T [degC]")
    places = [found[role].index for role in ("clipped", "time", "branch")]
    assert places == [3, 4, 5]
    assert found["time"].factor == 1e-3


def test_case_counts_where_it_can():
    assert unit_factor("mN", "force") == 1e-3
    assert unit_factor("MPa", "pressure") == 1e6
    assert unit_factor("bar", "pressure") == unit_factor("BAR", "pressure") == 1e5
