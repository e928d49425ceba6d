"""The data's tab: what is live belongs to the record that was opened last, or to none."""

from types import SimpleNamespace

import pytest

import fascicle as fs
from fascicle.explorer.background import Latest
from fascicle.explorer.data_tab import DataView
from fascicle.explorer.measured import read
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


def sent(tab, raw, name="a.csv"):
    """A file comes, as Panel tells it: one of no bytes has a name alone."""
    tab._file.param.update(value=raw or None, filename=name)


def live(tab):
    """Whether there are points, what can be fitted and given away, and the invitation."""
    return (
        len(tab._points.data["x"]) > 0, not tab._calibrate.disabled,
        all(not one.disabled for one in tab._given), not tab._invitation.visible,
    )  # fmt: skip


def test_a_record_is_live(tab):
    assert live(tab) == (False,) * 4
    sent(tab, GOOD)
    assert live(tab) == (True,) * 4
    assert "10 readings." in tab._notes.object
    sent(tab, HEAD + b"100,0,40\n", "one.csv")
    assert "1 reading." in tab._notes.object


@pytest.mark.parametrize(
    ("raw", "told"),
    [
        (b"pressure [kPa],strain [-]\n100,0\n", "no column of force"),
        (HEAD + b"100,0,40\n100,-0.2,40\n", "no curve of this muscle can lie beside it"),
        (b"", "bad.csv: the file is empty, 0 bytes."),
        (b" \n", "bad.csv: the file is empty, 2 bytes."),
    ],
)
def test_a_refused_file_leaves_nothing_of_the_one_before(tab, raw, told):
    sent(tab, GOOD)
    tab._table.object = tab._told.object = "what was fitted"
    for one in (tab._take, *tab._saves):
        one.disabled = False
    sent(tab, raw, "bad.csv")
    assert told in tab.message.text
    assert live(tab) == (False,) * 4
    assert tab.record is None and not tab._notes.object
    assert all(one.disabled for one in (tab._take, *tab._saves))
    assert not tab._table.object and not tab._told.object
    # and is mended by the next good one
    sent(tab, GOOD, "again.csv")
    assert live(tab) == (True,) * 4 and not tab.message.text


@pytest.mark.parametrize("name", ["data.csv", "muscle.toml.csv", "report.txt"])
def test_downloads_are_named_after_the_record_and_never_as_it(tab, name):
    sent(tab, GOOD, name)
    stem = name.rpartition(".")[0]
    names = [one.filename for one in (*tab._given, *tab._saves)]
    assert len({*names, name}) == len(names) + 1
    assert all(one.startswith(f"{stem}_") for one in names)
    assert tab._export().stem == f"{stem}_comparison"


def test_a_record_that_stretches_the_muscle_is_warned_of(tab):
    sent(tab, GOOD + b"100,-0.019,60\n")
    assert not tab.message.text
    sent(tab, GOOD + b"100,-0.05,60\n")
    assert "-0.05" in tab.message.text and live(tab) == (True,) * 4


def test_a_field_that_cannot_be_leaves_the_record(tab):
    sent(tab, GOOD)
    tab._how.length.value = "nonsense"
    assert "rest_length" in tab.message.text
    assert live(tab) == (True,) * 4


def test_a_fit_to_a_record_that_is_gone_is_not_shown(tab, monkeypatch):
    sent(tab, GOOD)
    asked = []
    monkeypatch.setattr(Latest, "ask", lambda self, compute: asked.append((self, compute)))
    tab._fit()
    assert tab._calibrate.disabled and tab._bar.visible
    sent(tab, GOOD.replace(b"200", b"300"), "b.csv")
    assert not tab._calibrate.disabled and not tab._bar.visible
    latest, _ = asked[0]
    latest._show((SimpleNamespace(made=None), "of the one before"))
    assert tab.made is None and tab._take.disabled
    latest._fail("of the one before")
    assert not tab.message.text


def test_the_example_is_named_and_another_file_takes_its_place(tab):
    tab._tried()
    assert "300 synthetic readings." in tab._notes.object
    assert tab._name == "example.csv"
    sent(tab, GOOD, "mine.csv")
    assert "10 readings." in tab._notes.object and tab._name == "mine.csv"


def test_the_answer_of_a_fit_stands_before_its_remarks(tab):
    shown = list(tab.panel[0])
    assert shown.index(tab._table) < shown.index(tab._take) < shown.index(tab._told)
    # what is wrong with a file is said above the fields that help
    assert shown.index(tab.message.pane) < shown.index(tab._how.panel)


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
        read(head + b"\n100,0,40\n", "w.csv", 0.127)
    assert told in str(refused.value)
