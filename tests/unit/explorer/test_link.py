"""A link reproduces a view, and nothing else can be smuggled in by one."""

import base64
import re
import zlib
from dataclasses import replace

import pytest

import fascicle as fs
from fascicle.explorer.link import (
    LONGEST,
    from_query,
    pack,
    parse_splits,
    to_query,
    unpack,
)
from fascicle.explorer.state import Session, Unit, view_of
from fascicle.files import dumps, loads
from fascicle.io.sanitize import sanitize_line
from fascicle.muscle.fitted_length import with_fitted_length
from fascicle.units import parse


SIX = view_of(fs.example("kim2021_figure_6"), "kim2021_figure_6")


MANY = dumps(fs.example("kim2021_bundle_1_1")) + 100 * "[[bundle.motor_unit]]\ncount = 1\n"


def full(view):
    return {name: value for name, value in vars(view).items() if name not in ("muscle", "units")}


def test_a_view_comes_back_from_its_address():
    view = replace(
        SIX, units=(Unit(1), Unit(4, 0.5)), supply=344.7e3, scheme="batch", pressure=69e3,
        strain=0.123, pressures=(3e5, 1e5), resistance=False, compared=("buckling:elastica",),
        path="isotonic", splits=((1, 4), (2, 3)),
        shown={"pressure": "psi", "length": "in", "force": "lbf"},
        tab="bundle",
    )  # fmt: skip
    found, refused = from_query(to_query(view), SIX)
    assert not refused
    assert full(found) == full(view)
    assert found.units == view.units
    assert dumps(found.bundle) == dumps(view.bundle)


def test_a_changed_muscle_goes_into_the_address_itself():
    view = replace(SIX, muscle=SIX.muscle.replace(length=0.2), name="mine")
    query = to_query(view)
    assert "muscle" not in query
    found, refused = from_query(query, SIX)
    assert not refused
    assert dumps(found.muscle) == dumps(view.muscle)


def test_the_length_of_a_fit_comes_back_too():
    fitted = with_fitted_length(SIX.muscle.replace(), 0.127, ends=True)
    view = replace(SIX, muscle=fitted.replace(outer_radius=7e-3), name="tuned")
    query = to_query(view)
    found, _ = from_query(query, SIX)
    with pytest.warns(UserWarning, match="fitted at a length of 127 mm .*, with its ends"):
        found.muscle.replace(length=0.2)
    # as a bundle, which a file is where there are several units
    with pytest.warns(UserWarning, match="fitted at a length of 127 mm"):
        loads(found.text).motor_units[1].muscle.replace(length=0.2)


def test_unlike_muscles_go_into_the_address_too():
    other = fs.example("kim2021_slenderness_10")
    view = replace(SIX, units=(Unit(1), Unit(2, own=other.replace(length=0.127))))
    found, refused = from_query(to_query(view), SIX)
    assert not refused
    assert dumps(found.bundle) == dumps(view.bundle)


@pytest.mark.parametrize(
    ("query", "word"),
    [
        ({"muscle": "../../etc/passwd"}, "no example is named"),
        ({"file": "no base64!"}, "no file that this explorer has packed"),
        ({"file": "A" * (LONGEST + 1)}, "at most"),
        ({"file": pack("format = 1\nimport os")}, ""),
        ({"strain": "2"}, r"must lie in \[0, 0.6\]"),
        ({"pressure": "137.9"}, "write it with its unit"),
        ({"pressure": "9 MPa"}, "must lie in"),
        ({"units": "1,x"}, "must be like"),
        ({"units": "99999"}, "60 in all"),
        ({"scheme": "<script>"}, "must be one of"),
        ({"compare": "buckling:os.system"}, "must name laws"),
        ({"compare": ",".join(["buckling:elastica"] * 5)}, "4 laws at most"),
        ({"splits": "4"}, "two motor units or more"),
        ({"show": "furlong,mm,N"}, "must be units"),
        ({"tab": "x"}, "must be one of"),
        ({"units": "9" * 5000}, "must be like 1,4@0.5"),
        ({"units": "9" * 4000}, "60 in all"),
        ({"units": "1@nan"}, "must lie in"),
        ({"units": "1@1e999"}, "must lie in"),
        ({"units": ","}, "must be like"),
        ({"units": "-1,2"}, "1 or more"),
        ({"units": "1," * 9 + "1"}, "1 to 8 motor units"),
        ({"pressures": "9" * 5000, "units": "1"}, "pressure"),
        ({"pressure": "nan kPa"}, "pressure"),
        ({"pressure": "inf Pa"}, "must lie in|pressure"),
        ({"strain": "9e9999"}, "strain"),
        ({"strain": "-0.1"}, "must lie in"),
        ({"supply": "1e-400 Pa"}, "must be positive"),
        ({"splits": "1+1," * 3000 + "1+1"}, "four at most"),
        ({"splits": "1+" + "9" * 5000}, "must be like"),
        ({"file": pack("a." * 15_000 + "a = 1")}, "nested too deep"),
        ({"file": pack("format = 1\nx = " + "9" * 5000)}, ""),
        ({"file": pack("x")[:-4]}, "no file that this explorer has packed"),
        ({"file": "ä"}, "no file that this explorer has packed"),
        ({"file": pack("#" * 40_000)}, "too large for a link"),
        ({"file": pack(MANY)}, "1 to 8 motor units"),
    ],
)  # fmt: skip
def test_a_bad_address_is_refused_in_words_and_the_rest_is_shown(query, word):
    found, refused = from_query(query | {"path": "isotonic"}, SIX)
    assert len(refused) == 1
    assert "\n" not in refused[0]
    assert len(sanitize_line(refused[0])) < 410
    assert re.search(word, refused[0])
    assert found.path == "isotonic"
    assert dumps(found.muscle) == dumps(SIX.muscle)


@pytest.mark.parametrize("size", [32_001, 100_000, 10_000_000])
def test_a_bomb_is_not_inflated(size):
    bomb = base64.urlsafe_b64encode(zlib.compress(b"#" * size, 9)).decode().rstrip("=")
    assert len(bomb) < LONGEST
    with pytest.raises(ValueError, match="must hold at most 32000 bytes"):
        unpack(bomb)


def test_a_file_that_is_too_large_for_a_link_is_not_silently_another_one():
    """The link says so when it is opened, rather than show what it doesn't hold."""
    view = replace(SIX, muscle=SIX.muscle.replace(length=0.2), name="mine")
    query = to_query(view) | {"file": pack(dumps(view.muscle) + "#" * 40_000)}
    _, refused = from_query(query, SIX)
    assert refused == ["link: `file` was too large for a link: open the file itself."]


def test_whatever_breaks_in_a_link_the_page_opens(monkeypatch):
    def broken(*_):
        raise ZeroDivisionError

    monkeypatch.setattr("fascicle.explorer.link.loads", broken)
    found, refused = from_query({"file": pack("x"), "path": "isotonic"}, SIX)
    assert refused == ["link: `file` can't be read."]
    assert found.path == "isotonic"


def test_splits_are_read_both_ways():
    assert parse_splits("1+4, 2+3") == ((1, 4), (2, 3)) == parse_splits("1-4,2-3")


@pytest.mark.parametrize(
    ("shown", "pressure", "supply"), [("psi", "20.2psi", "90psi"), ("bar", "1.37bar", "4.1bar")]
)
def test_a_link_has_the_digits_that_were_typed(shown, pressure, supply):
    P, most = parse(pressure, "pressure"), parse(supply, "pressure")
    units = dict(SIX.shown) | {"pressure": shown}
    view = replace(SIX, pressure=P, supply=most, pressures=(P, 137.9e3), shown=units)
    query = to_query(view)
    assert (query["pressure"], query["supply"]) == (pressure, supply)
    assert query["pressures"].startswith(f"{pressure},")
    # and few of them where it is looked at in another unit
    assert to_query(replace(view, shown=SIX.shown))["pressure"] in (pressure, "137kPa")
    found, _ = from_query(query, SIX)
    assert (found.pressure, found.supply, found.pressures) == (P, most, (P, 137.9e3))


def test_a_link_is_refused_in_the_units_that_it_shows():
    _, (message,) = from_query({"pressure": "9 MPa", "show": "psi,in,lbf"}, SIX)
    assert message.endswith("psi (gauge), got 1305.34 psi.")


def test_a_link_has_every_digit_where_no_unit_has_few():
    view = replace(SIX, pressure=123456.78901234567)
    assert from_query(to_query(view), SIX)[0].pressure == view.pressure


def test_callbacks_hear_of_a_change():
    session, calls = Session(SIX), []
    session.watch(lambda before, after: calls.append((before.strain, after.strain)))
    session.change(strain=0.2)
    assert calls == [(SIX.strain, 0.2)]


def test_a_bundle_opens_with_its_units_and_a_muscle_alone_as_two():
    view = view_of(fs.example("kim2021_bundle_1_4"), "b")
    assert [unit.count for unit in view.units] == [1, 4]
    assert view.supply == pytest.approx(413.7e3)
    assert len(SIX.units) == 2
