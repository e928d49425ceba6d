"""Files in the manner of instruments and loggers, all with the same four readings."""

import sys
import tomllib
import zipfile
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from asked import asked
from fascicle.core.errors import InvalidInputError, MissingExtraError
from fascicle.records import load, loads, runs
from refusing import refuses, refuses_at


TIME = [0.0, 0.1, 0.2, 0.3]
PRESSURE = [200.1, 200.3, 199.9, 200.0]  # kPa
FORCE = [118.4, 95.2, 70.8, 48.9]  # N
LENGTH = [180.0, 176.0, 171.9, 168.0]  # mm
REST = 0.18  # m
GIVEN = {"rest_length": REST, "constants": {"pressure": "200 kPa"}}
CONTRACTION = [180 - x for x in LENGTH]  # mm
ROWS = list(zip(TIME, PRESSURE, FORCE, LENGTH, strict=True))


def table(separator, columns, header="", decimal="."):
    rows = zip(*columns, strict=True)
    lines = [separator.join(str(x).replace(".", decimal) for x in row) for row in rows]
    return "\n".join([*([header] if header else []), *lines, ""])


def check(record, *, pressure=True, time=True):
    assert_allclose(record.force, FORCE, rtol=1e-9)
    assert_allclose(record.strain, np.array(CONTRACTION) / 180, atol=1e-9)
    if pressure:
        assert_allclose(record.pressure, np.array(PRESSURE) * 1e3, rtol=1e-9)
    if time:
        assert_allclose(record.time, TIME, atol=1e-9)


FORMATS = Path(__file__).parent / "formats"
OPTIONS = tomllib.loads((FORMATS / "options.toml").read_text())
FILES = sorted(path.name for path in FORMATS.iterdir() if path.suffix != ".toml")


@pytest.mark.parametrize("name", FILES)
def test_exports_of_instruments(tmp_path, name):
    options = OPTIONS.get(name, {})
    text = (FORMATS / name).read_text().replace("\n", "\r\n")
    for encoding in ("utf-8-sig", "utf-16", "cp1252"):
        path = tmp_path / name
        path.write_bytes(text.encode(encoding))
        check(load(path, rest_length=REST, **options), pressure="constants" not in options)


def test_unmarked_encodings_and_a_reserved_end():
    text = "t [s],p [kPa],F [N],Länge [mm]\n" + table(",", [TIME, PRESSURE, FORCE, LENGTH])
    for raw in (text.encode("utf-16-le"), text.encode("utf-16-be"), text.encode() + b"\0" * 64):
        check(loads(raw, rest_length=REST))


def found(record, code):
    """Data of the record's finding of a code."""
    return next(x.data for x in record.findings if x.code == f"record.{code}")


def test_rows_with_holes_are_left_out_and_counted():
    rows = "0,100,50,180\n1,,49,179\n2,100,NaN,178\n3,100,40\n4,100,30,170\n5,100,20,165\n"
    text = "t [s],p [kPa],F [N],L [mm]\n" + rows
    record = loads(text, rest_length=REST)
    assert record.force.tolist() == [50, 30, 20]
    assert found(record, "rows_with_holes")["count"] == 3
    mostly = text.replace("20,165", ",165").removesuffix("\n")
    for wrong in (mostly, "p [kPa],F [N],L [mm]\n100,,180\n100,40,\n"):
        with refuses_at("<text>"):
            loads(wrong, rest_length=REST)


@pytest.mark.parametrize("blanks", ["  ", "          "])
def test_a_missing_cell_between_blanks_moves_no_others(blanks):
    rows = [f"{t} {p} {f} {x} 21.5" for t, p, f, x in ROWS]
    short = f"0.4{blanks}{FORCE[0]} {LENGTH[0]} 21.5"  # a force would be a pressure
    for odd in ([*rows, short], [*rows[:2], short, *rows[2:]]):
        record = loads("\n".join(["t_s p_kPa F_N L_mm T_degC", *odd]), rest_length=REST)
        check(record)
        assert found(record, "rows_with_holes")["count"] == 1


@pytest.mark.parametrize("name", ["labview", "labview_a_time_for_each", "labview_without_times"])
def test_segments_of_labview_are_read_if_their_units_and_names_are_those_of_the_first(name):
    text = (FORMATS / f"{name}.lvm").read_text()
    segment = text[text.index("Channels") :]
    record = loads(f"{text}\n{segment}", rest_length=REST)
    assert_allclose(record.force, FORCE * 2)
    assert_allclose(record.pressure, np.array(PRESSURE * 2) * 1e3)
    for old, new in (("\tN\t", "\tkN\t"), ("Force", "Torque")):
        choices = asked(f"{text}\n{segment.replace(old, new)}", rest_length=REST)
        first = loads(text + segment.replace(old, new), rest_length=REST, rows=choices[0][2])
        check(first, time=name != "labview_without_times")


def test_cells_without_a_value_are_holes():
    odd = ("#DIV/0!", "-nan(ind)", "1.#QNAN", "---", "?", "***", "ERR", "over", ".", "OVERLOAD")
    text = "t [s],p [kPa],F [N],L [mm]\n" + table(",", [TIME, PRESSURE, FORCE, LENGTH])
    for cell in odd:
        check(loads(text + f"1,200,{cell},170\n", rest_length=REST))


@pytest.mark.parametrize(
    ("header", "scale", "role", "unit"),
    [("stretch [%]", 1 / 1.8, "strain", "%"), ("grip [mm]", 1, "displacement", "mm")],
)
def test_an_unknown_name_is_offered_as_the_quantities_of_its_unit(header, scale, role, unit):
    columns = [PRESSURE, FORCE, [scale * x for x in CONTRACTION]]
    text = f"p [kPa],F [N],{header}\n" + table(",", columns)
    assert ("columns", role, header) in asked(text, rest_length=REST)
    check(loads(text, rest_length=REST, columns={role: header}), time=False)


def test_columns_by_place():
    text = table(",", [FORCE, PRESSURE, TIME, [1] * 4, LENGTH])
    assert asked(text, rest_length=REST)[0][:2] == ("columns", "")
    record = loads(text, columns="force[N],pressure[kPa],time,branch,length[mm]", rest_length=REST)
    check(record)
    assert record.branch.tolist() == [1] * 4
    units = {"force": "N", "pressure": "kPa", "length": "mm"}
    given = ["force", "pressure", "-", "-", "length"]
    check(loads(text, columns=given, units=units, rest_length=REST), time=False)
    # of a file with a header, whose units stay
    head = "load (N),P (kPa),t,up,grip (mm)\n"
    check(loads(head + text, columns="force,pressure,time,-,length", rest_length=REST))
    two = "force[N],pressure[kPa]"
    for wrong in ("force[N],voltage,-", "force[N],force,-", f"{two},-,-,length[mm],time",
                  f"{two},-", two):  # fmt: skip
        with refuses_at(""):
            loads(text, columns=wrong, rest_length=REST)


def test_constants_come_from_options_sidecar_and_name(tmp_path):
    text = "force [N],pressure [kPa]\n" + table(",", [FORCE, PRESSURE])
    path = tmp_path / "run_16.7cm_up.csv"
    path.write_text(text)
    strain = (180 - 167) / 180
    for options in (
        {"constants": {"length": 0.167}}, {"constants": {"length": "167 mm"}},
        {"name_pattern": "{length}cm"}, {"name_pattern": "run_{length:cm}*up"},
    ):  # fmt: skip
        assert_allclose(load(path, rest_length=REST, **options).strain, strain)
    path.with_suffix(".toml").write_text('rest_length = "180 mm"\nlength = "167 mm"\n')
    assert_allclose(load(path).strain, strain)
    for options in (
        {"name_pattern": "{pressure}kPa"}, {"name_pattern": "{mass}kg"},
        {"constants": {"pressure": "3 MPa"}},
    ):  # fmt: skip
        with refuses_at(""):
            load(path, **options)
    columns = 'columns = ["force [N]", "pressure [kPa]"]\n'
    path.with_suffix(".toml").write_text(columns + 'strain = 0.1\nrows = "2:"\n')
    path.write_text(text.partition("\n")[2])
    record = load(path)
    assert_allclose(record.strain, 0.1)
    assert record.force.tolist() == FORCE[1:]


def test_grams_in_a_name_are_a_weight(tmp_path):
    path = tmp_path / "m=500g.csv"
    path.write_text("P [kPa],x [mm]\n" + table(",", [PRESSURE, CONTRACTION]))
    record = load(path, name_pattern="m={force}g", rest_length=REST)
    assert_allclose(record.force, 4.903325)


def test_files_by_pattern(tmp_path):
    for length in (180, 170):
        for pressure in (100, 200):
            path = tmp_path / f"{length}mm_{pressure}kPa.csv"
            path.write_text(table(",", [TIME, [f + length + pressure for f in FORCE]]))
    how = {"columns": "time,force[N]", "name_pattern": "{length}mm_{pressure}kPa"}
    record = load(str(tmp_path / "*.csv"), rest_length=REST, **how)
    assert len(record) == 16 and len(record.sources) == 4
    assert sorted(set(record.pressure)) == [100e3, 200e3]
    assert_allclose(sorted(set(record.strain)), [0, 10 / 180])
    with refuses_at(f"{tmp_path / '*.txt'}: "):
        load(str(tmp_path / "*.txt"))


def test_rows_are_selected_before_they_are_read():
    readings = table(",", [PRESSURE, FORCE, LENGTH])
    text = "p [kPa],F [N],L [mm]\n100,warming,180\n100,x,180\n" + readings
    check(loads(text, rows="3:", rest_length=REST), time=False)
    assert loads(text, rows="4:5", rest_length=REST).force.tolist() == FORCE[1:3]
    for rows in ("9:", "3", "5:3"):
        with refuses_at(""):
            loads(text, rows=rows, rest_length=REST)


def test_absolute_pressures_and_zeros_of_gauges():
    text = "P (kPa abs),F [N],L [mm]\n" + table(",", [[x + 101.3 for x in PRESSURE], FORCE, LENGTH])
    check(loads(text, rest_length=REST, atmosphere="101.3 kPa"), time=False)
    shifted = [np.add(PRESSURE, 1.5), np.add(FORCE, 8), np.add(CONTRACTION, 2)]
    text = "P [kPa],F [N],x [mm]\n" + table(",", shifted)
    zeros = {"pressure": "1.5 kPa", "force": 8.0, "displacement": "2 mm"}
    check(loads(text, rest_length=REST, zeros=zeros), time=False)
    with refuses("zeros"):
        loads(text, rest_length=REST, zeros={"mass": 1})


def test_directions():
    turned = [PRESSURE, np.negative(FORCE), np.negative(CONTRACTION)]
    text = "P [kPa],F [N],position [mm]\n" + table(",", turned)
    assert asked(text, rest_length=REST)[0][:2] == ("signs", "displacement")
    signs = {"displacement": "extension", "force": "pushing positive"}
    check(loads(text, rest_length=REST, signs=signs), time=False)
    with refuses("signs"):
        loads(text, rest_length=REST, signs={"force": "up"})


@pytest.mark.parametrize(
    "columns",
    [
        [PRESSURE, [-x for x in FORCE], LENGTH],  # a sweep that begins at rest
        [[200] * 6, np.linspace(-90, 10, 6), np.linspace(170, 140, 6)],  # and one further on
        [[0, 100, 200], [0.2, -40, -80], [180] * 3],  # at one length
    ],
)
def test_a_muscle_that_pushes_where_all_pull_is_refused(columns):
    text = "P [kPa],F [N],L [mm]\n" + table(",", columns)
    assert asked(text, rest_length=REST)[0] == ("signs", "force", "pushing positive")
    for sign, direction in ((-1, "pushing"), (1, "pulling")):
        record = loads(text, rest_length=REST, signs={"force": direction})
        assert_allclose(record.force, sign * np.array(columns[1]))


@pytest.mark.parametrize(
    ("name", "role"),
    [("strain [%]", "strain"), ("Dehnung [%]", "strain"), ("displacement [mm]", "displacement"),
     ("length change [mm]", "displacement"), ("change of length [%]", "strain")],
)  # fmt: skip
def test_most_positions_that_stretch_a_muscle_and_let_it_pull_less_are_refused(name, role):
    stroke = np.linspace(-0.4, 12, 8)
    force = 120 - 8 * stroke
    text = f"P [kPa],F [N],{name}\n" + table(",", [[200] * 8, force, -stroke])
    assert asked(text, rest_length=0.1)[0] == ("signs", role, "extension positive")
    record = loads(text, rest_length=0.1, signs={role: "extension"})
    assert_allclose(record.strain, stroke / 100, atol=1e-12)
    # a muscle that is stretched pulls harder
    harder = "P [kPa],F [N],strain [%]\n" + table(",", [[200] * 8, 240 - force, -stroke])
    assert loads(harder).strain.min() == pytest.approx(-0.12)
    # tensile strain grows as the muscle lengthens, by its name
    tensile = text.replace(name, "Tensile strain [%]")
    assert_allclose(loads(tensile).strain, stroke / 100, atol=1e-12)


def test_a_muscle_that_lengthens_with_pressure_under_one_load_is_refused():
    pressure, position = np.linspace(50, 250, 6), np.linspace(57, 37, 6)
    columns = [pressure, position, [20.1, 20, 19.9] * 2]
    text = "p [kPa],position [mm],load [N]\n" + table(",", columns)
    given: dict = {"rest_length": REST}
    for argument, role in (("signs", "displacement"), ("zeros", "displacement")):
        choices = asked(text, **given)
        assert choices[0][:2] == (argument, role)
        given[argument] = {role: choices[0][2]}
    assert_allclose(loads(text, **given).strain, (57 - position) / 180)
    steady = "p [kPa],position [mm],load [N]\n" + table(",", [200 - position / 57, *columns[1:]])
    assert len(loads(steady, rest_length=REST)) == 6  # its pressure is constant


@pytest.mark.parametrize("zero", ["512.4 mm", "80 mm"])
def test_a_position_that_counts_from_elsewhere_offers_its_zero(zero):
    position = [float(zero.removesuffix(" mm")) + x for x in CONTRACTION]
    text = "P [kPa],F [N],position [mm]\n" + table(",", [PRESSURE, FORCE, position])
    assert asked(text, rest_length=REST)[0] == ("zeros", "displacement", zero)
    check(loads(text, rest_length=REST, zeros={"displacement": zero}), time=False)


@pytest.mark.parametrize("other", ["Barometric pressure", "p_atm", "Supply pressure", "Luftdruck"])
def test_a_pressure_around_or_before_the_muscle_is_not_its_own(other):
    header = f"{other} (kPa),P2 (kPa),F (N),L (mm)"
    text = table(",", [[98.7] * 4, PRESSURE, FORCE, LENGTH], header)
    check(loads(text, rest_length=REST), time=False)
    choices = asked(table(",", [[98.7] * 4, FORCE, LENGTH], f"{other} (kPa),F (N),L (mm)"))
    assert choices[0] == ("columns", "pressure", f"{other} (kPa)")


def test_a_missing_column_is_offered_only_what_could_be_it():
    choices = asked("Cell [V],junk,T [°C],L [mm],p [kPa]\n1,2,3,180,100\n2,3,4,170,100\n")
    assert [choice[2] for choice in choices] == ["junk", "20 N"]


def asked_decimals(text):
    choices = asked(text, rest_length=REST)
    assert {choice[0] for choice in choices} == {"decimal"}
    return {choice[2] for choice in choices}


def test_thousands_that_may_be_decimals_are_refused():
    text = "t [s];p [mbar];F [N];L [mm]\n0;2.000;{};180\n1;2.001;95,2;176\n"
    assert asked_decimals(text.format("118,4")) == {","}
    record = loads(text.format("118,4"), rest_length=REST, decimal=",")
    assert_allclose(record.pressure, [200e3, 200.1e3])
    assert_allclose(record.force, [118.4, 95.2])
    # a number with both signs makes it clear, and so does one that can't be of thousands
    record = loads(text.format("1.118,4"), rest_length=REST)
    assert_allclose(record.pressure, [200e3, 200.1e3])
    assert_allclose(record.force[0], 1118.4)
    clear = text.format("118.4").replace("2.00", "200.").replace("mbar", "kPa")
    assert_allclose(loads(clear, rest_length=REST).pressure, [200e3, 200.1e3])
    assert asked_decimals("t [s];p [kPa];F [mN];L [mm]\n0.5;200.1;1,118;180\n") == {"."}
    assert asked_decimals('t [s],p [kPa],F [mN],L [mm]\n0,200,"1,118",180\n') == {".", ","}
    with pytest.raises(InvalidInputError) as error:
        loads(clear, rest_length=REST, decimal="'")
    assert error.value.argument == "decimal"


def test_thousands_beside_integers_are_refused_until_the_decimal_sign_is_given():
    falling = ["1.180", "1.050", "980", "750"]
    head = "p [kPa];L [mm];F [N]\n"
    rows = list(zip([200] * 4, [180, 176, 172, 168], falling, strict=True))
    grouped = table(";", list(zip(*rows, strict=True)))
    assert asked_decimals(head + grouped) == {".", ","}
    # the first of them may stand far below the start
    assert asked_decimals(head + "200;180;980\n" * 5000 + grouped) == {".", ","}
    for sign, expected in ((",", [1180, 1050, 980, 750]), (".", [1.18, 1.05, 980, 750])):
        record = loads(head + grouped, rest_length=REST, decimal=sign)
        assert_allclose(record.force, expected)
    only = "p [Pa];L [mm];F [N]\n100.010;180;118\n100.020;176;98\n"
    assert asked_decimals(only) == {".", ","}
    assert_allclose(loads(only, rest_length=REST, decimal=",").pressure, [100010, 100020])
    # two columns of three decimals are no thousands, nor are decimals that begin with a zero
    for row in ("200;180.125;118.401\n", "200;180;118.401\n200;170;0.250\n"):
        assert loads(head + row, rest_length=REST).force[0] == 118.401


def test_specimens_of_one_file_are_not_mixed():
    block = '"Specimen {}"\n"Time","Extension","Load"\n"(s)","(mm)","(N)"\n' + table(
        ",", [TIME, [-x for x in CONTRACTION], FORCE]
    )
    text = '"Results"\n"1",118.4\n\n' + "\n".join(block.format(i) for i in (1, 2, 3))
    assert asked(text, **GIVEN) == [("rows", "", "1:4")]
    for rows in ("1:4", "6:9"):
        check(loads(text, rows=rows, **GIVEN), pressure=False)
    assert len(loads(text, rows="1:", **GIVEN)) == 12
    # a name in each row is no name of a block
    named = "id,p [kPa],F [N],L [mm]\n" + "".join(
        f"Sample {i},{p},{f},{x}\n" for i, (_, p, f, x) in enumerate(ROWS)
    )
    check(loads(named, rest_length=REST), time=False)


def test_one_of_two_specimens_side_by_side_is_chosen():
    names = "Time [s],Verlängerung [mm],Load [N]"
    columns = [TIME, [-x for x in CONTRACTION], FORCE]
    other = [TIME, columns[1], [2 * f for f in FORCE]]
    text = f"Specimen 1,,,Specimen 2,,\n{names},{names}\n{table(',', [*columns, *other])}"
    assert asked(text, **GIVEN)[0][0] == "columns"
    named, given = (
        "time,displacement[mm],force[N]",
        {"signs": {"displacement": "extension"}, **GIVEN},
    )
    first = loads(text, columns=f"{named},-,-,-", **given)
    second = loads(text, columns=f"-,-,-,{named}", **given)
    check(first, pressure=False)
    assert_allclose(second.force, other[2])
    assert_allclose(second.strain, first.strain)


def test_channels_at_two_rates_are_refused(tmp_path):
    sampled = (FORMATS / "labview_without_times.lvm").read_text()
    assert_allclose(loads(sampled, rest_length=REST, rows="2:3").time, TIME[1:3])
    half = [2 * t for t in TIME]
    names = "X_Value\tPressure [kPa]\tX_Value\tForce [N]\tX_Value\tLength [mm]\tX_Value\tT [degC]\n"
    columns = [TIME, PRESSURE, TIME, FORCE, TIME, LENGTH, half, FORCE]
    check(loads(names + table("\t", columns), rest_length=REST))  # the slow one isn't needed
    late = [t + 0.04 for t in TIME]
    check(loads(names + table("\t", [*columns[:2], late, *columns[3:]]), rest_length=REST))
    for text in (
        sampled.replace("Delta_X\t0.1\t0.1", "Delta_X\t0.1\t0.2"),
        names + table("\t", [*columns[:2], half, *columns[3:]]),
    ):
        with refuses_at("<text>"):
            loads(text, rest_length=REST)

    nptdms = pytest.importorskip("nptdms")
    channels = {"p_kPa": (PRESSURE, 0.1), "F_N": (FORCE, 0.1), "L_mm": (LENGTH, 0.1),
                "T_degC": (FORCE, 0.2), "x_V": (FORCE, 0.2)}  # fmt: skip
    with nptdms.TdmsWriter(tmp_path / "m.tdms") as writer:
        writer.write_segment([
            nptdms.ChannelObject("Log", name, np.array(values), {"wf_increment": step})
            for name, (values, step) in channels.items()
        ])  # fmt: skip
    choices = asked(tmp_path / "m.tdms", rest_length=REST)
    check(load(tmp_path / "m.tdms", rest_length=REST, table=choices[0][2]))


def test_channels_with_clocks_of_their_own_are_interpolated_on_one():
    slow = [0.0, 0.2, 0.4, ""]  # s: its last row has no reading
    pressure = [200.0, 202.0, 204.0, ""]
    text = "time F [ms],F [N],time L [s],L [mm],time p [s],p [kPa]\n" + table(
        ",", [[0, 100, 200, 300], FORCE, TIME, LENGTH, slow, pressure]
    )
    record = loads(text, rest_length=REST, resample="50 ms")
    assert_allclose(record.time, 0.05 * np.arange(7), atol=1e-12)
    assert_allclose(record.force, np.interp(record.time, TIME, FORCE))
    assert_allclose(record.pressure, 200e3 + 10e3 * record.time)
    for step in ("0 s", "1 s", "1 kPa", "1 ns"):
        with refuses("resample"):
            loads(text, rest_length=REST, resample=step)
    without = "F [N],p [kPa],L [mm]\n" + table(",", [FORCE, PRESSURE, LENGTH])
    with refuses_at("<text>, line 1"):
        loads(without, rest_length=REST, resample="50 ms")


def test_signals_of_gauges_have_scales(tmp_path):
    volts = [0.2 + x / 147.5 for x in PRESSURE]
    text = "P_sens [V],F_sens [V],L [mm]\n" + table(",", [volts, [x / 12 for x in FORCE], LENGTH])
    scales = {"pressure": "1.475bar/V", "force": "12N/V"}
    given = {"rest_length": REST, "zeros": {"pressure": "0.2V"}}
    check(loads(text, scales=scales, **given), time=False)
    path = tmp_path / "m.csv"
    path.write_text(text)
    path.with_suffix(".toml").write_text(
        'rest_length = "180 mm"\npressure_at_rest = "0.2 V"\n[scales]\n'
        'pressure = "1.475 bar/V"\nforce = "12 N/V"\n'
    )
    check(load(path), time=False)
    choices = asked(text, scales={"pressure": scales["pressure"]}, **given)
    assert choices[0][:2] == ("scales", "force")
    named = text.replace("P_sens [V]", "P [kPa]")
    with refuses_at("<text>, line 1"):
        loads(named, columns={"pressure": "P"}, scales=scales, **given)
    for wrong in ("1.475bar", "V", "1.475N/V", 3):
        with pytest.raises(InvalidInputError) as error:
            loads(text, scales={"pressure": wrong}, **given)
        assert error.value.argument.startswith("scale")


def test_a_mat_file_with_a_bare_matrix_or_a_constant(tmp_path):
    from scipy.io import savemat

    path = tmp_path / "m.mat"
    savemat(path, {"d": np.array([TIME, PRESSURE, FORCE, LENGTH]).T})
    check(load(path, rest_length=REST, columns="time[s],pressure[kPa],force[N],length[mm]"))
    savemat(path, {"force_N": FORCE, "pressure_kPa": PRESSURE, "length_mm": 171.0})
    assert_allclose(load(path, rest_length=REST).strain, 0.05)
    named = {"force_N": FORCE, "pressure_kPa": PRESSURE, "length_mm": LENGTH}
    savemat(path, named)
    check(load(path, rest_length=REST), time=False)
    matrix = np.array([PRESSURE, FORCE, LENGTH]).T
    two = {"up": matrix, "down": matrix}
    for refused in ({"rec": named}, {"log": {"Y": [{"Name": "p", "Data": PRESSURE}]}},
                    named | {"force_N": FORCE[1:]}, two):  # fmt: skip
        savemat(path, refused)
        with refuses_at(f"{path}: "):
            load(path, rest_length=REST)
    columns = "pressure[kPa],force[N],length[mm]"
    check(load(path, rest_length=REST, table="down", columns=columns), time=False)


def test_cells_that_excel_shows_in_percent(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    strain = np.array(CONTRACTION) / 180
    percent = [("strain [%]", 1, "0.0%"), ("strain", 1, "0.0%"), ("strain [%]", 100, "General")]
    for header, factor, form in percent:
        book = openpyxl.Workbook()
        rows = [[header, "p [kPa]", "F [N]"], *zip(strain * factor, PRESSURE, FORCE, strict=True)]
        for row in rows:
            book.active.append(list(row))
        for cell in book.active["A"]:
            cell.number_format = form
        book.save(tmp_path / "m.xlsx")
        check(load(tmp_path / "m.xlsx"), time=False)


def test_xlsx_files(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.title = "Info"
    book.active.append(["made by", "a bench"])
    sheet = book.create_sheet("Data")
    for row in (["Tensile test"], [], ["Operator", "K. Müller"], ["Gauges", None, "Frame", None],
                ["Time\n[s]", "Pressure", "Force", "Length", "Remark"], ["s", "kPa", "N", "mm"],
                *ROWS, ["Mean", 200.1, 83.3, 174.0]):  # fmt: skip
        sheet.append(list(row))
    for cells in ("A1:D1", "A4:B4", "C4:D4"):
        sheet.merge_cells(cells)
    path = tmp_path / "m.xlsx"
    book.save(path)
    check(load(path, rest_length=REST))
    book.copy_worksheet(sheet).title = "Data 2"
    book.save(path)
    assert asked(path, rest_length=REST)[0][::2] == ("table", "Data")
    check(load(path, rest_length=REST, table="data 2"))


def change_part(path, part, change):
    """Apply a function to a part of a workbook."""
    with zipfile.ZipFile(path) as source:
        parts = {name: source.read(name) for name in source.namelist()}
    parts[part] = change(parts[part])
    with zipfile.ZipFile(path, "w") as changed:
        for name, content in parts.items():
            changed.writestr(name, content)


def test_a_sheet_whose_formats_are_too_long_is_refused_at_once(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    openpyxl.Workbook().save(tmp_path / "m.xlsx")
    form = b'<numFmt formatCode="' + b"[" * 300 + b'"/>'
    change_part(tmp_path / "m.xlsx", "xl/styles.xml", lambda text: text + form)
    with refuses_at(f"{tmp_path / 'm.xlsx'}: "):
        load(tmp_path / "m.xlsx")


@pytest.mark.parametrize("number", [b"-3", b"0", b"2"])
def test_a_row_whose_number_does_not_rise_is_refused(tmp_path, number):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for row in (["Time [s]", "P [kPa]", "F [N]", "L [mm]"], *ROWS):
        book.active.append(list(row))
    book.save(path := tmp_path / "m.xlsx")
    check(load(path, rest_length=REST))

    def renumber(text):
        assert b'<row r="3"' in text
        return text.replace(b'<row r="3"', b'<row r="%s"' % number)

    change_part(path, "xl/worksheets/sheet1.xml", renumber)
    with refuses_at(f"{path}") as error:
        load(path, rest_length=REST)
    assert number.decode() in str(error.value)


@pytest.mark.parametrize(
    "start", [b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", b"\x89HDF\r\n\x1a\n", b"\x1f\x8b", b"%PDF-1.4",
              b"PK\3\4broken", b"TDSmbroken", b"MATLAB 5.0 broken"],
)  # fmt: skip
def test_binary_files_that_cannot_be_read(tmp_path, start):
    path = tmp_path / "m.bin"
    path.write_bytes(start + bytes(200))
    with refuses_at(f"{path}: "):
        load(path)


def test_a_missing_reader_is_named(tmp_path, monkeypatch):
    path = tmp_path / "m.bin"
    path.write_bytes(b"PK\3\4" + bytes(200))
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    with pytest.raises(MissingExtraError) as error:
        load(path)
    assert error.value.name == "openpyxl"


def test_isometric_and_isotonic_records_have_runs():
    P = np.r_[np.linspace(0, 400, 30), np.linspace(400, 0, 30)]
    length, p = (x.ravel() for x in np.meshgrid([180, 170, 160], P, indexing="ij"))
    isometric = table(",", [p + 0.1, length, 0.3 * p * (length - 150) / 30], "p [kPa],L [mm],F [N]")
    found = runs(loads(isometric, rest_length=REST))
    assert [(run.kind, run.branch) for run in found] == [("strain", 1), ("strain", -1)] * 3
    mass, p = (x.ravel() for x in np.meshgrid([200, 500], P, indexing="ij"))
    isotonic = table(",", [p, mass, 180 - p / 8 + mass / 100], "p [kPa],load [gf],L [mm]")
    found = runs(loads(isotonic, rest_length=REST))
    assert [(run.kind, run.branch) for run in found] == [("force", 1), ("force", -1)] * 2
    assert found[0].level == pytest.approx(0.2 * 9.80665)


def test_words_between_numbers_are_no_units():
    rows = zip(FORCE, ["up"] * 4, CONTRACTION, ["ok"] * 4, strict=True)
    text = "F_N branch x_mm state\n" + "".join(f"{f} {a} {x} {b}\n" for f, a, x, b in rows)
    record = loads(text, **GIVEN)
    check(record, pressure=False, time=False)
    assert record.branch.tolist() == [1] * 4


def test_an_odd_row_leaves_out_no_others():
    rows = table(",", [FORCE, PRESSURE, LENGTH]).splitlines()
    for odd in ("60.1,", "Force,Pressure,Length"):
        text = "\n".join([*rows[:3], odd, *[rows[3]] * 4])
        record = loads(text, columns="force[N],pressure[kPa],length[mm]", rest_length=REST)
        assert record.force.tolist() == FORCE[:3] + [FORCE[3]] * 4
        data = [finding.data for finding in record.findings]
        assert (1, 4) in [(x["count"], x["line"]) for x in data if "line" in x]


def test_a_minus_of_typesetters():
    rows = [PRESSURE, FORCE, [f"\u2212{x}" for x in CONTRACTION]]
    text = "P [kPa],F [N],extension [mm]\n" + table(",", rows)
    check(loads(text, rest_length=REST), time=False)


@pytest.mark.parametrize(
    "other",
    ["P [bar],F [N],x [mm]", "F [N],P [kPa],x [mm]", "P,F,x\nbar,N,mm", "P,F,x\nkPa,N,cm"],
)
def test_another_header_further_down_is_refused(other):
    block = table(",", [PRESSURE, FORCE, CONTRACTION])
    text = "P [kPa],F [N],x [mm]\n" + block + "Cycle 2\n"
    assert len(loads(f"{text}P,F,x\nkPa,N,mm\n{block}", rest_length=REST)) == 8
    text = f"{text}{other}\n{block}"
    choices = asked(text, rest_length=REST)
    assert choices[0][0] == "rows"
    check(loads(text, rest_length=REST, rows=choices[0][2]), time=False)


def test_groups_that_state_pressures_are_one_record(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    path = tmp_path / "run_180mm.tdms"
    with nptdms.TdmsWriter(path) as writer:
        for P in (100, 200):
            writer.write_segment([
                nptdms.ChannelObject(f"P={P}kPa", name, np.array(values), {"unit_string": unit})
                for name, values, unit in (
                    ("Force", np.add(FORCE, P), "N"), ("Length", LENGTH, "mm"))
            ])  # fmt: skip
    assert [choice[2] for choice in asked(path, rest_length=REST)] == ["P=100kPa", "*"]
    record = load(path, rest_length=REST, table="*", name_pattern="{pressure}kPa")
    assert_allclose(record.pressure, [1e5] * 4 + [2e5] * 4)
    assert_allclose(record.force, [*np.add(FORCE, 100), *np.add(FORCE, 200)])
    # the pattern may begin in the file's name
    record = load(path, table="P=2*", name_pattern="{rest_length}mm P={pressure}kPa")
    assert (record.rest_length, set(record.pressure)) == (REST, {2e5})
    for wrong in ({"table": "*", "name_pattern": "{pressure}bar"}, {"table": "Q*"}):
        with refuses_at(f"{path}: "):
            load(path, rest_length=REST, **wrong)


def test_a_board_that_starts_again_loses_no_readings():
    head, boot = "ms,pressure_kPa,force_N,length_mm", "rst:0x1 (POWERON_RESET),boot:0x13"
    rows = table(",", [range(4), PRESSURE, FORCE, LENGTH]).splitlines()
    for first in (1, 3):  # readings before it
        text = "\n".join([boot, head, *rows[:first], boot, head, *rows[first:]])
        record = loads(text, rest_length=REST)
        check(record, time=False)
        assert_allclose(record.time, [0, 1e-3, 2e-3, 3e-3])


def test_columns_that_are_named_by_their_units_alone():
    text = "ms,kPa,N,mm\n" + table(",", [range(0, 400, 100), PRESSURE, FORCE, LENGTH])
    given = asked(text, rest_length=REST)
    assert given == [("columns", "length", "mm"), ("columns", "displacement", "mm")]
    check(loads(text, rest_length=REST, columns={"length": "mm"}))


@pytest.mark.parametrize(
    "text",
    ["strain [%],100 kPa,200 kPa\n0,50,100\n5,25,60\n",
     "100 kPa,,200 kPa,\nX,Y,X,Y\n0,50,0,100\n5,25,5,60\n",
     "Pressure [kPa],100,200\nstrain [%],F [N],F [N]\n0,50,100\n5,25,60\n",
     "p [kPa],F at 180 mm [N],F at 170 mm [N]\n0,0,0\n100,50,25\n"],
)  # fmt: skip
def test_a_column_for_each_pressure_is_refused(text):
    with refuses_at("<text>"):
        loads(text, rest_length=REST)
