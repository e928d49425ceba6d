"""The data's tab: what is live belongs to the record that was opened last, or to none."""

from types import SimpleNamespace

import pytest

import fascicle as fs
from fascicle.explorer.background import LatestResult
from fascicle.explorer.data_tab import DataView
from fascicle.explorer.measured import MOST_CURVES, read_record
from fascicle.explorer.state import Session, view_of
from fascicle.explorer.theme import LIGHT


SIX = view_of(fs.example("kim2021_figure_6"), "kim2021_figure_6")
HEAD = b"pressure [kPa],strain [-],force [N]\n"
GOOD = HEAD + b"".join(b"%d,%g,%d\n" % (P, i / 50, P // 4) for P in (100, 200) for i in range(5))


@pytest.fixture
def tab():
    made = DataView(Session(SIX), LIGHT)
    made.refresh()
    return made


def send(tab, raw, name="a.csv"):
    """A file comes, as Panel tells it: one of no bytes has a name alone."""
    tab.file.param.update(value=raw or None, filename=name)


def live(tab):
    """Whether there are points, what can be fitted and given away, and the invitation."""
    return (
        len(tab.readings.data["x"]) > 0, not tab.calibrate.disabled,
        all(not one.disabled for one in tab.downloads), not tab.empty_state.visible,
    )  # fmt: skip


def test_a_record_is_live(tab):
    assert live(tab) == (False,) * 4
    send(tab, GOOD)
    assert live(tab) == (True,) * 4
    assert "10 readings." in tab.notes.object
    send(tab, HEAD + b"100,0,40\n", "one.csv")
    assert "1 reading." in tab.notes.object


@pytest.mark.parametrize(
    ("raw", "told"),
    [
        (b"pressure [kPa],strain [-]\n100,0\n", "no column of force"),
        (HEAD + b"100,0,40\n100,-0.2,40\n", "this muscle has no curve at its strains"),
        (b"", "bad.csv: the file is empty, 0 bytes."),
        (b" \n", "bad.csv: the file is empty, 2 bytes."),
    ],
)
def test_a_refused_file_leaves_nothing_of_the_one_before(tab, raw, told):
    send(tab, GOOD)
    tab.table.object = tab.fit_notes.object = "what was fitted"
    for one in (tab.use, *tab.saves):
        one.disabled = False
    send(tab, raw, "bad.csv")
    assert told in tab.message.text
    assert live(tab) == (False,) * 4
    assert tab.record is None and not tab.notes.object
    assert all(one.disabled for one in (tab.use, *tab.saves))
    assert not tab.table.object and not tab.fit_notes.object
    # and is mended by the next good one
    send(tab, GOOD, "again.csv")
    assert live(tab) == (True,) * 4 and not tab.message.text


@pytest.mark.parametrize("name", ["data.csv", "muscle.toml.csv", "report.txt"])
def test_downloads_are_named_after_the_record_and_never_as_it(tab, name):
    send(tab, GOOD, name)
    stem = name.rpartition(".")[0]
    for button in tab.downloads:
        button.callback()
    names = [button.filename for button in tab.downloads]
    assert len({*names, name}) == len(names) + 1
    assert all(each.startswith(f"{stem}_comparison.") for each in names)


def test_a_record_that_stretches_the_muscle_is_warned_of(tab):
    send(tab, GOOD + b"100,-0.019,60\n")
    assert not tab.message.text
    send(tab, GOOD + b"100,-0.05,60\n")
    assert "-0.05" in tab.message.text and live(tab) == (True,) * 4


def test_a_field_that_cannot_be_leaves_the_record(tab):
    send(tab, GOOD)
    tab.read_inputs.length.value = "nonsense"
    assert "Rest length" in tab.message.text
    assert live(tab) == (True,) * 4


def test_a_fit_to_a_record_that_is_gone_is_not_shown(tab, monkeypatch):
    send(tab, GOOD)
    asked = []
    monkeypatch.setattr(
        LatestResult, "request", lambda self, compute: asked.append((self, compute))
    )
    tab.start_fit()
    assert tab.calibrate.disabled and tab.bar.visible
    send(tab, GOOD.replace(b"200", b"300"), "b.csv")
    assert not tab.calibrate.disabled and not tab.bar.visible
    latest, _ = asked[0]
    latest._show((SimpleNamespace(made=None), "of the one before"))
    assert tab.fit is None and tab.use.disabled
    latest._fail("of the one before")
    assert not tab.message.text


def test_the_example_is_named_and_another_file_takes_its_place(tab):
    tab.open_example()
    assert "300 synthetic readings." in tab.notes.object
    assert tab.file_name == "example.csv"
    send(tab, GOOD, "mine.csv")
    assert "10 readings." in tab.notes.object and tab.file_name == "mine.csv"


def test_the_answer_of_a_fit_stands_before_its_remarks(tab):
    tab.message.show("wrong")
    shown = list(tab.panel[0])
    assert shown.index(tab.table) < shown.index(tab.use) < shown.index(tab.fit_notes)
    # what is wrong with a file is said above the fields that help
    assert shown.index(tab.message._pane) < shown.index(tab.read_inputs.panel)


@pytest.mark.parametrize(
    ("head", "told"),
    [
        (b"A,B,C", "name it with the fields below, pressure `A` for instance, if it is one of"),
        (b"pressure,strain [-],force [N]",
         "or give its unit in the fields below, pressure `kPa` for instance."),
    ],
)  # fmt: skip
def test_what_a_file_does_not_say_is_asked_for_in_a_sentence(head, told):
    with pytest.raises(ValueError, match="fields below") as refused:
        read_record(head + b"\n100,0,40\n", "w.csv", 0.127)
    assert told in str(refused.value)


def test_every_pressure_has_its_curve_and_few_are_labeled(tab):
    rows = b"".join(
        b"%d,%g,%d\n" % (P, i / 50, P // 4) for P in range(20, 400, 20) for i in range(5)
    )
    send(tab, HEAD + rows)
    assert len(tab._before.data["ys"]) == 19 < MOST_CURVES
    assert len(tab._labels.data["label"]) == 8
