"""A link reproduces a view, and can hold nothing else."""

import base64
import zlib
from dataclasses import replace

import pytest

import fascicle as fs
from fascicle.explorer.link import LONGEST, from_query, pack, to_query, unpack
from fascicle.explorer.state import CHANGED, Session, Unit, view_of
from fascicle.files import dumps, loads
from fascicle.muscle.validation import FittedLength
from refusing import refuses, warns


SIX = view_of(fs.example("kim2021_figure_6"), "kim2021_figure_6")
MANY = dumps(fs.example("kim2021_bundle_1_1")) + 100 * "[[bundle.motor_unit]]\ncount = 1\n"
OWN_MUSCLE = replace(SIX, muscle=SIX.muscle.replace(length=0.2), name="mine")


def read(query):
    """View of a link without an error."""
    view, _, errors = from_query(query, SIX)
    assert not errors
    return view


def test_a_view_comes_back_from_its_address():
    view = replace(
        SIX, units=(Unit(1), Unit(4)), supply=344.7e3, scheme="batch", pressure=69e3,
        strain=0.123, load=12.5, pressures=(3e5, 1e5), resistance=False,
        path="isotonic", tab="bundle",
        display_units={"pressure": "psi", "length": "in", "force": "lbf"},
    )  # fmt: skip
    result = read(to_query(view))
    assert replace(result, muscle=view.muscle) == view
    assert dumps(result.bundle) == dumps(view.bundle)


def test_changed_and_unequal_muscles_are_in_the_address_itself():
    other = fs.example("kim2021_slenderness_10").replace(length=0.127)
    for view in (OWN_MUSCLE, replace(SIX, units=(Unit(1), Unit(2, own=other)))):
        query = to_query(view)
        assert "muscle" not in query
        assert dumps(read(query).bundle) == dumps(view.bundle)


def test_the_length_of_a_fit_comes_back():
    fitted = SIX.muscle.replace(fitted_length=FittedLength(0.127, with_ends=True))
    result = read(to_query(replace(SIX, muscle=fitted.replace(outer_radius=7e-3), name="tuned")))
    with warns("127 mm"):
        result.muscle.replace(length=0.2)
    # as a bundle, which a file is where there are several units
    with warns("127 mm"):
        loads(result.text).motor_units[1].muscle.replace(length=0.2)


@pytest.mark.parametrize(
    "query",
    [{"muscle": "../../etc/passwd"}, {"file": "no base64!"}, {"file": "A" * (LONGEST + 1)},
     {"file": pack("format = 1\nimport os")}, {"file": pack("a." * 15_000 + "a = 1")},
     {"file": pack("format = 1\nx = " + "9" * 5000)}, {"file": pack("x")[:-4]}, {"file": "ä"},
     {"file": pack("#" * 40_000)}, {"file": pack(MANY)}, {"strain": "2"}, {"strain": "9e9999"},
     {"pressure": "137.9"}, {"pressure": "nan kPa"}, {"pressure": "9 MPa"}, {"load": "nan N"},
     {"supply": "1e-400 Pa"}, {"units": "1,x"}, {"units": "99999"}, {"units": "9" * 5000},
     {"units": "-1,2"}, {"units": "1," * 9 + "1"},
     {"pressures": "9" * 5000, "units": "1"}, {"scheme": "<script>"}, {"show": "furlong,mm,N"},
     {"tab": "x"}, {"scenario": "lift"}, {"policies": "threshold", "scenario": "lift_gas"},
     {"scenario": "mine", "scenario_file": "AAAA"}],
    ids=str,
)  # fmt: skip
def test_a_bad_key_gives_a_message_and_the_other_keys_are_read(query):
    result, _, (error,) = from_query(query | {"path": "isotonic"}, SIX)
    assert "\n" not in error and error.startswith(next(iter(query)))
    assert result.path == "isotonic"
    assert dumps(result.muscle) == dumps(SIX.muscle)


@pytest.mark.parametrize("size", [32_001, 10_000_000])
def test_a_bomb_is_not_inflated(size):
    bomb = base64.urlsafe_b64encode(zlib.compress(b"#" * size, 9)).decode().rstrip("=")
    assert len(bomb) < LONGEST
    with refuses("file"):
        unpack(bomb)


def test_the_page_opens_with_any_error_in_a_link(monkeypatch):
    monkeypatch.setattr("fascicle.explorer.link.loads", lambda *_, **__: 1 / 0)
    result, _, errors = from_query({"file": pack("x"), "path": "isotonic"}, SIX)
    assert len(errors) == 1
    assert result.path == "isotonic"


def test_pressures_of_a_link_are_limited_by_its_supply():
    view = read({"supply": "100 kPa", "pressure": "300 kPa", "pressures": "90 kPa,200 kPa"})
    assert (view.pressure, view.pressures) == (1e5, (9e4, 1e5))
    assert read({"supply": "100 kPa"}).pressure == 1e5


def test_reset_after_a_reload_returns_to_the_example():
    changed = replace(SIX, muscle=SIX.muscle.replace(length=0.2), name=f"{SIX.name}{CHANGED}")
    view, opened, _ = from_query(to_query(changed), SIX)
    session = Session(view, opened)
    session.reset()
    assert dumps(session.view.muscle) == dumps(SIX.muscle) and session.view.name == SIX.name


def test_undo_and_reset(monkeypatch):
    now = [0.0]
    monkeypatch.setattr("fascicle.explorer.state.time.monotonic", lambda: now[0])
    session = Session(SIX)
    for strain in (0.2, 0.21, 0.22):  # a slider's steps are one change
        now[0] += 0.2
        session.change(strain=strain)
    now[0] += 0.1
    session.change(pressure=2e5, tab="bundle")
    now[0] += 10
    session.change(pressure=3e5)
    other = view_of(fs.example("kim2021_figure_9"), "kim2021_figure_9", session.view)
    session.open(other)
    session.change(strain=0.05)
    session.reset()
    assert session.view == other
    session.undo()
    assert session.view.strain == 0.05
    session.redo()
    assert session.view == other
    seen = []
    while session.changes[0]:
        session.undo()
        seen.append((session.view.name[-1], session.view.strain, session.view.pressure))
    assert seen == [("9", 0.05, other.pressure), ("9", other.strain, other.pressure),
                    ("6", 0.22, 3e5), ("6", 0.22, 2e5), ("6", 0.22, SIX.pressure),
                    ("6", SIX.strain, SIX.pressure)]  # fmt: skip
    assert session.view.tab == "bundle"
    session.change(strain=0.3)
    assert not session.changes[1]


@pytest.mark.parametrize("name", fs.catalog)
def test_measured_muscles_have_short_links(name):
    view = view_of(fs.catalog[name].muscle, name)
    query = to_query(view)
    assert query["muscle"] == name and "file" not in query
    assert dumps(read(query).muscle) == dumps(view.muscle)


def test_a_bundle_opens_with_its_units_and_a_muscle_as_two():
    view = view_of(fs.example("kim2021_bundle_1_4"), "b")
    assert [unit.count for unit in view.units] == [1, 4]
    assert view.supply == pytest.approx(413.7e3)
    assert [unit.count for unit in SIX.units] == [1, 4] and SIX.pressures == (413.7e3, 60e3)
