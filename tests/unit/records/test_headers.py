"""Names and units of headers: read, or refused with a hint that is right."""

import tomllib
from pathlib import Path

import pytest

from fascicle.records import loads
from fascicle.records.headers import choose_columns, unit_factor
from fascicle.records.sidecar import Sidecar
from fascicle.records.tables import open_table
from refusing import refuses, refuses_at


def table(pressure="P [kPa]", force="F [N]", position="L [mm]", values="200,50,190"):
    return f'"{pressure}","{force}","{position}"\n{values}\n'


HEADERS = tomllib.loads((Path(__file__).parent / "headers.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("dimension", HEADERS["units"])
def test_spellings(dimension):
    for unit, si in HEADERS["units"][dimension].items():
        # inHg has six digits in pint, all others are exact but for rounding
        rel = 1e-6 if unit == "inHg" else 1e-12
        assert unit_factor(unit, dimension) == pytest.approx(si, rel=rel), unit


@pytest.mark.parametrize(
    ("code", "rows", "is_doubtful"),
    [
        # it pulls at rest, more so at a higher pressure; contracts under a load, or without any
        ("atmosphere", "98.9,40,200\n98.9,20,190\n300,90,200", False),
        ("atmosphere", "98.9,20,190\n98.9,15,185\n300,60,190", False),
        ("atmosphere", "98.9,0,180\n300,0,160", False),
        # a mass that hangs at rest shows nothing, nor does a slack muscle
        ("atmosphere", "98.9,20,200\n300,20,160", True),
        ("atmosphere", "98.9,0,180\n300,60,180", True),
        # no load at all, and masses of a set, are no clipping
        ("zero_forces", "100,0,190\n200,0,180\n300,0,170", False),
        ("zero_forces", "200,0,190\n200,5,185\n200,9,180\n" * 3, False),
        ("zero_forces", "200,0,160\n" * 3 + "200,50,190", True),
    ],
)
def test_doubts_are_raised_where_the_readings_leave_them(code, rows, is_doubtful):
    codes = [x.code for x in loads(table(values=rows), rest_length=0.2).findings]
    assert (f"record.{code}" in codes) == is_doubtful


def test_a_hint_is_left_out_where_it_is_not_known():
    for tables, hint in (
        ({"position": "strain", "values": "200,50,12"}, "%"), ({"pressure": "P [bar]"}, "kPa"),
        ({"values": "3,120,190"}, "bar"), ({"position": "strain [ue]", "values": "200,50,12"}, ""),
    ):  # fmt: skip
        with refuses_at("<text>, line 2") as error:
            loads(table(**tables), rest_length=0.2)
        assert f"did you mean {hint}" in str(error.value) or not hint
        assert hint or "did you mean" not in str(error.value)
    assert len(loads(table(values="8,20,190"), rest_length=0.2)) == 1


def chosen(header, columns=None, units=None):
    table = open_table(header.encode() + b"\n", "m.csv")
    return choose_columns(table, Sidecar(columns=columns or {}, units=units or {}))[0]


@pytest.mark.parametrize("role", HEADERS["columns"])
def test_names_and_units_of_columns(role):
    others = {"pressure": "p [Pa]", "force": "F [N]", "strain": "strain"}
    others.pop(role if role in others else "strain")
    for header, si in HEADERS["columns"][role].items():
        found = chosen(",".join([header, *others.values()]))[role]
        assert (found.index, found.factor * found.sign) == (0, pytest.approx(si, rel=1e-14)), header


@pytest.mark.parametrize(
    ("header", "places"),
    [
        ("pressure setpoint [kPa],pressure sensor [kPa],strain rate,strain,force [N]",
         {"pressure": 1, "strain": 3, "force": 4}),
        ("P [Pa],F [V],load cell [N],strain", {"pressure": 0, "force": 2, "strain": 3}),
        ("P [Pa],F [N],gauge length [mm],extension [mm]",
         {"pressure": 0, "force": 1, "displacement": 3}),
        ("P [kPa],F [N],L [mm],Strain [µm/m]", {"pressure": 0, "force": 1, "length": 2}),
        *((f"P [Pa],L [mm],{name} (N),Measured force (N)", {"pressure": 0, "length": 1, "force": 3})
          for name in ("Theoretical force", "Force model", "F simulated")),
    ],
)  # fmt: skip
def test_setpoints_signals_gauges_and_models_are_no_readings(header, places):
    assert {role: column.index for role, column in chosen(header).items()} == places


def test_a_setpoint_that_is_named_is_read_and_a_stress_is_no_pressure():
    given = chosen("pressure setpoint [kPa],strain,force [N]", {"pressure": "pressure setpoint"})
    assert given["pressure"].index == 0
    with refuses("columns"):
        chosen("sigma [MPa],force [N],strain")


def test_a_remark_beside_a_name_and_a_unit_that_is_unknown():
    found = chosen("pressure,position (laser),force (load cell)\nkPa,mm,N\n100,5,20")
    units = {role: column.unit for role, column in found.items()}
    assert units == {"pressure": "kPa", "displacement": "mm", "force": "N"}
    with refuses_at("m.csv, line 1"):
        chosen("pressure [Pa],displacement [thou],force [N]")


def test_flags_branches_and_times():
    found = chosen("length_m,pressure_Pa,force_N,zero_is_no_tension,t [ms],direction,T [degC]")
    assert [found[role].index for role in ("clipped", "time", "branch")] == [3, 4, 5]
    assert found["time"].factor == 1e-3
