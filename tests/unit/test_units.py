import contextlib
import math

import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fascicle.core.errors import InvalidInputError
from fascicle.units import DIMENSIONS, exact, format_digits, parse, parse_list, pretty


REGISTRY = pint.UnitRegistry()
# pint takes turns for radians: an rpm is 2π/60 1/s there, 1/60 Hz here; it knows N*m, but no Nm
OTHERS = {"rpm", "Nm", "mNm", "kNm", "Nmm"}


@pytest.mark.parametrize("kind", DIMENSIONS)
def test_the_table_agrees_with_pint(kind):
    si = DIMENSIONS[kind].si.replace("^", "**") or "dimensionless"
    for unit in DIMENSIONS[kind].factors.keys() - OTHERS:
        theirs = REGISTRY.Quantity(1.0, REGISTRY.parse_units(unit.replace("^", "**"))).to(si)
        # pint multiplies a few rounded floats: some last bits apart, no more
        assert parse(f"1 {unit}", kind) == pytest.approx(theirs.magnitude, rel=1e-14), unit


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("34.5kPa", "pressure", 34.5e3), ("2 Nm", "moment", 2.0), ("2Nmm", "moment", 2e-3),
        ("5 psi", "pressure", 34473.78646584),  # pint's own digits, to the last one given
        ("30 rpm", "frequency", 0.5), ("-20 degC", "temperature", 253.15),
        ("0.1 L/(s·bar)", "sonic_conductance", 1e-9), ("6 L/(min*bar)", "sonic_conductance", 1e-9),
        ("50 N s/m", "damping", 50.0), ("0.25in", "length", 0.00635),
        ("33°", "angle", math.radians(33)), ("-2 lbf", "force", -8.896443230521),
        ("1e-5 m**3", "volume", 1e-5), ("0.033 N·m", "moment", 0.033),
        ("0.92 / bar", "inverse_pressure", 0.92e-5), ("0.92 bar^-1", "inverse_pressure", 0.92e-5),
        ("12 %", "strain", 0.12), ("0.12", "strain", 0.12), (0.12, "strain", 0.12),
        ("30 kgf", "force", 294.1995),
        ("2 yard", "length", 1.8288),  # not in the table: pint's
        ("3 dyn/cm^2", "pressure", 0.3),
    ],
)  # fmt: skip
def test_reads_what_people_write(text, kind, value):
    assert parse(text, kind) == pytest.approx(value, rel=1e-13)


def test_rounds_once():
    # 6.35 × 0.001 in floats is 6.35e-3 only by luck; as a rational it always is
    for mantissa in range(1, 2000):
        assert parse(f"{mantissa / 100} mm", "length") == float(f"{mantissa / 100}e-3")


@pytest.mark.parametrize(
    ("text", "kind", "remedy"),
    [
        ("34.5", "pressure", "unit"), (34.5, "pressure", "unit"), (0, "length", "unit"),
        ("34.5 mm", "pressure", "'mm'"), ("5 psig", "pressure", "'psig'"),
        ("200Kpa", "pressure", "'kPa'"), ("30PSI", "pressure", "'psi'"), ("1 KN", "force", "'kN'"),
        # of units that differ in case alone, the one that pint would take is a slip
        ("5 Mm", "length", "'mm'"), ("0.3mPa", "pressure", "'MPa'"), ("2 MN", "force", "'mN'"),
        ("30 kg", "force", "kgf"), ("100 L/min", "sonic_conductance", "Kv"),
        ("nan Pa", "pressure", ""), (math.nan, "strain", ""), ("-inf kPa", "pressure", ""),
        ("1e400 Pa", "pressure", ""), ("1e308 kPa", "pressure", ""),
        ("34,5 kPa", "pressure", ""), ("kPa", "pressure", ""), ("", "strain", ""),
        ("1" * 101 + " Pa", "pressure", ""), ("2 m**(9**9**9)", "length", ""),
        ("2 __import__('os')", "length", ""), ("2 m\nm", "length", ""),
        (True, "strain", ""), (None, "length", ""), ([1], "strain", ""),
        # what trips pint
        ("1 cp^0", "pressure", ""), ("1 absiemens^2*dBW^2", "pressure", ""),
        ("1 lambda", "pressure", ""), ("1 ΔdegRe", "pressure", ""), ("1 None", "pressure", ""),
    ],
)  # fmt: skip
def test_refuses_in_one_line_what_it_cannot_read(text, kind, remedy):
    with pytest.raises(InvalidInputError) as caught:
        parse(text, kind, "it")
    assert caught.value.argument == "it" and remedy in caught.value.remedy
    assert "\n" not in str(caught.value)


@given(st.floats(allow_nan=False, allow_infinity=False), st.sampled_from(sorted(DIMENSIONS)))
def test_exact_text_reads_back_bitwise(value, kind):
    again = parse(exact(value, kind), kind)
    assert again == value
    assert math.copysign(1, again) == math.copysign(1, value)


def test_exact_text_is_handy_where_it_can_be():
    assert exact(0.00635, "length") == "6.35 mm"
    assert exact(math.radians(33), "angle") == "33 deg"
    assert exact(0.92e-5, "inverse_pressure") == "0.92 1/bar"
    assert exact(0.1 + 0.2, "length") == "0.30000000000000004 m"


@pytest.mark.parametrize(
    ("value", "dimension", "text"),
    [
        (10.0, "length", "10 m"),  # not 1e+04 mm
        (9.99, "length", "9990 mm"), (-12.345, "length", "-12.35 m"), (2e-8, "length", "0.02 µm"),
        (34.5e3, "pressure", "34.5 kPa"), (1e-5, "pressure", "1e-05 Pa"),
        (98764.0, "mass", "98760 kg"),  # there is no larger unit
        (1e7, "number", "1e+07"), (0.0, "length", "0 mm"), (math.inf, "strain", "-"),
    ],
)  # fmt: skip
def test_a_reader_gets_the_unit_that_needs_no_exponent(value, dimension, text):
    assert pretty(value, dimension) == text


@pytest.mark.parametrize("dimension", sorted(DIMENSIONS))
def test_what_is_shown_reads_back(dimension):
    for power in range(-6, 7):
        value = 1.234 * 10.0**power
        # of four figures the last may be rounded
        assert parse(pretty(value, dimension), dimension) == pytest.approx(value, rel=5e-4)


def test_figures_are_plain_up_to_ten_million():
    assert [format_digits(x, 3) for x in (999.6, 9.87e6, 2e7, 0.5, -2345.0)] == [
        "1000", "9870000", "2e+07", "0.5", "-2340"
    ]  # fmt: skip


def test_a_range_holds_both_ends_and_the_numbers_written():
    assert parse_list("0:0.33:0.03", "strain") == [float(f"0.{3 * i:02d}") for i in range(12)]
    pressures = parse_list("0kPa:413.7kPa:68.95kPa", "pressure")
    assert pressures == [0, 68.95e3, 137.9e3, 206.85e3, 275.8e3, 344.75e3, 413.7e3]


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("0.1", [0.1]), ("0.2, 0.1", [0.2, 0.1]), ("0.1:0:-0.05", [0.1, 0.05, 0]),
        ("0:0.1:0.03", [0, 0.03, 0.06, 0.09, 0.1]),  # the last step is the shorter one
        ("0.1:0.1:0.3", [0.1]), ("0:0.1:0.3", [0, 0.1]), ("0:10%:5%", [0, 0.05, 0.1]),
        ("0.5,0:0.2:0.1", [0.5, 0, 0.1, 0.2]),
    ],
)  # fmt: skip
def test_lists_and_ranges(text, values):
    assert parse_list(text, "strain") == values


def test_a_range_in_rounded_units_has_no_point_too_many():
    assert len(parse_list("0deg:33deg:11deg", "angle")) == 4
    assert len(parse_list("0yard:3yard:0.1yard", "length")) == 31


@pytest.mark.parametrize(
    "text", ["0:0.1", "0:1:2:3", "0:1:0", "0:1:-0.1", "1:0:0.1", "0:1:nan", "0:1:1e-9",
             "0:1:1e-300", ",".join(["0:1:2e-5"] * 3), "0.1,", ""],
)  # fmt: skip
def test_refuses_a_bad_list(text):
    with pytest.raises(InvalidInputError) as caught:
        parse_list(text, "strain", "--strain")
    assert caught.value.argument == "--strain" and "\n" not in str(caught.value)


@given(st.text(st.characters(codec="utf-8"), max_size=12))
def test_never_fails_in_another_way(unit):
    with contextlib.suppress(ValueError):
        parse(f"1 {unit}", "pressure")
