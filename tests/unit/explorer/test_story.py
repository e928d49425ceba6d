"""The story's scenes show their point with the library's numbers, and follow the view."""

import re
from dataclasses import replace

import numpy as np
import pytest

import fascicle as fs
from fascicle.bundle.reversal import reversal
from fascicle.explorer.state import Session, Unit, view_of
from fascicle.explorer.story import TITLES, Story, scene_text, scene_view


SIX = fs.example("kim2021_figure_6")
VIEW = view_of(SIX, "kim2021_figure_6")
ANY_MUSCLES = ("kim2021_figure_6", "kim2021_bundle_1_4", "kim2021_bundle_five",
               "festo-dmsp-20-300", "festo-dmsp-10-250")  # fmt: skip


def numbers(text):
    return [float(number) for number in re.findall(r"\d+\.?\d*", text)]


@pytest.mark.parametrize("name", ANY_MUSCLES)
def test_each_scene_sets_inputs_that_show_its_point(name):
    view = view_of(fs.example(name), name)
    for scene, region in ((1, 0), (2, 1), (3, 2)):
        shown = scene_view(view, scene)
        assert shown.tab == "muscle"
        response = shown.muscle.response(shown.pressure, shown.strain)
        assert int(response.region) == region
        assert (float(response.force) > 0) == (scene == 1)
    shown = scene_view(view, 4)
    assert shown.tab == "bundle"
    alone = (shown.pressures[0], *(0.0,) * (len(shown.units) - 1))
    reach = float(shown.bundle.free_strain(shown.pressures))
    assert reach < float(shown.bundle.free_strain(alone)) - 0.01  # of strain: seen in the figure
    assert shown.strain == pytest.approx(reach, abs=1e-4)


def test_sentences_have_the_librarys_numbers():
    pull, buckle, fold, reach = (
        numbers(scene_text(scene_view(VIEW, scene), scene)) for scene in (1, 2, 3, 4)
    )
    digits = {"rel": 5e-3}  # three significant digits
    P = 137.9e3
    free, collapse = float(SIX.free_strain(P)), float(SIX.collapse_strain(P))
    force = lambda strain: float(SIX.force(P, strain))  # noqa: E731 short
    assert pull == pytest.approx([P / 1e3, free / 2, force(free / 2), force(0), free], **digits)
    middle = (free + collapse) / 2
    bow = float(SIX.deflection(P, middle)) * 1e3
    assert buckle == pytest.approx([free, middle, bow, -force(middle)], **digits)
    end = scene_view(VIEW, 3).strain
    assert fold == pytest.approx([collapse, end, -force(collapse), -force(end)], **digits)
    bundle = fs.Bundle([fs.MotorUnit(SIX, 1), fs.MotorUnit(SIX, 4)], 413.7e3)
    turn = reversal(bundle)
    second = np.ceil(turn.pressure / 1e3)
    now = float(bundle.free_strain([413.7e3, second * 1e3]))
    push = -4 * float(SIX.force(second * 1e3, now))
    alone = float(bundle.free_strain([413.7e3, 0.0]))
    expected = [413.7, 1, 2, alone, second, 2, now, push]
    assert reach == pytest.approx(expected, **digits)


def test_the_inputs_come_back_at_the_end_and_pins_and_units_stay():
    before = replace(VIEW, strain=0.07, pressure=9e4, tab="compare", pressures=(4e5, 1e5))
    for leave in ("skip", "back", "done"):
        session = Session(before)
        story = Story(session)
        story.start()
        assert session.view.tab == "muscle" and story._running.visible
        session.change(display_units={**before.display_units, "force": "lbf"})
        if leave == "skip":
            story.end()
        elif leave == "back":
            story._move(-1)
        else:
            for _ in TITLES:
                story._move(1)
        assert not story._running.visible
        assert session.view == replace(before, display_units=session.view.display_units)
        assert session.view.display_units["force"] == "lbf"


def test_a_muscle_that_is_opened_meanwhile_stays():
    session = Session(VIEW)
    story = Story(session)
    story.start()
    other = view_of(fs.example("festo-dmsp-20-300"), "festo", session.view)
    session.open(other)
    story.end()
    assert session.view is other


def test_the_story_leaves_no_step_to_undo():
    session = Session(VIEW)
    session.change(muscle=VIEW.muscle.replace(braid_angle=0.5))
    own = session.view
    story = Story(session)
    story.start()
    assert session.changes[0] == 2  # with the scene's own inputs
    session.undo()
    assert session.view.muscle is own.muscle and session.changes == (1, 1)
    session.change(muscle=VIEW.muscle.replace(braid_angle=0.6))
    story.end()
    assert session.view == own and session.changes[0] == 1
    session.undo()
    assert session.view == VIEW


def test_a_reach_that_is_less_by_rounding_is_not_called_shorter():
    view = replace(scene_view(VIEW, 4), units=(Unit(1), Unit(1)))
    vented, filled = (view.supply, 0.0), (view.supply, 1e3)
    before, reach = (float(view.bundle.free_strain(P)) for P in (vented, filled))
    assert 0 < before - reach < 5e-4  # the same three digits
    shown = numbers(scene_text(replace(view, pressures=filled), 4))
    assert shown[-1] == shown[3] == pytest.approx(reach, abs=5e-4)  # no push follows
