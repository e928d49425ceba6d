"""What the tabs show is what the library's public methods give, and is drawn to scale."""

from dataclasses import replace

import numpy as np
import pytest

import fascicle as fs
from fascicle.bundle import reversal
from fascicle.explorer import bundle_curves, efficiency_tab, reversal_tab
from fascicle.explorer.muscle_curves import (
    FAMILY,
    alternative_laws,
    muscle_curves,
    strain_limit,
    with_alternative,
)
from fascicle.explorer.solid import AROUND, RINGS, face_corners, muscle_solid
from fascicle.explorer.state import Unit, scaled, view_of
from fascicle.muscle import LAWS


SIX = fs.example("kim2021_figure_6")
VIEW = view_of(fs.example("kim2021_bundle_1_4"), "kim2021_bundle_1_4")
P, TOP, SUPPLY = 137.9e3, 0.4, 413.7e3


@pytest.mark.parametrize("strain", [0.1, 0.25, 0.3])
def test_a_picture_holds_what_the_methods_give(strain):
    found = muscle_curves(SIX, P, strain, SUPPLY, TOP)
    np.testing.assert_allclose(
        found.force[-1], SIX.force(P, found.strain[-1]), rtol=1e-9, atol=1e-9
    )
    response = SIX.response(P, found.strain[-1])
    np.testing.assert_allclose(found.mesh[-1], response.mesh, rtol=1e-9, atol=1e-9)
    for i, pressure in enumerate(np.linspace(0, SUPPLY, FAMILY)):
        there = SIX.force(pressure, found.strain[i])
        np.testing.assert_allclose(found.force[i], there, rtol=1e-9, atol=1e-9)
    here = SIX.response(P, strain)
    assert found.force_here == pytest.approx(float(here.force), abs=1e-9)
    assert found.region == int(here.region)
    assert found.free_strain[-1] == pytest.approx(float(SIX.free_strain(P)))
    assert found.collapse_strain[-1] == pytest.approx(float(SIX.collapse_strain(P)))
    assert found.blocked[-1] == pytest.approx(float(SIX.blocked_force(P)))
    assert found.deflection == pytest.approx(float(SIX.deflection(P, strain)))
    assert found.moment == pytest.approx(float(SIX.moment(P, strain)))
    assert found.volume == pytest.approx(float(SIX.volume(strain)))


def test_no_slider_compiles_anything(monkeypatch):
    from jax._src import compiler

    def refuse(*_, **__):
        raise AssertionError("something is compiled")

    monkeypatch.setattr(compiler, "compile_or_get_cached", refuse)
    for pressure, strain, supply, top in ((0.0, 0.0, 2e5, 0.3), (4e5, 0.35, 4e5, 0.6)):
        muscle_curves(scaled(SIX, 1.3), pressure, strain, supply, top)


def test_a_straight_muscle_has_the_braids_radius_and_its_fibers_their_angle():
    strain = 0.1
    made = muscle_solid(SIX, muscle_curves(SIX, P, strain, SUPPLY, TOP), strain)
    tube = made.points[: RINGS * AROUND]
    np.testing.assert_allclose(
        np.hypot(tube[:, 0], tube[:, 1]), float(SIX.radius(strain)), rtol=1e-9
    )
    assert tube[:, 2].max() - tube[:, 2].min() == pytest.approx(float(SIX.length) * (1 - strain))
    assert made.angle == pytest.approx(float(SIX.braid.angle_at(strain)))
    # along a fiber: how far it turns for how far it goes
    step = np.diff(made.fibers[0], axis=0)
    turned = np.diff(np.unwrap(np.arctan2(made.fibers[0][:, 0], made.fibers[0][:, 1])))
    drawn = np.arctan2(np.abs(turned) * made.radius, step[:, 2])
    np.testing.assert_allclose(drawn, made.angle, rtol=1e-6)


def test_a_collapsed_muscle_folds_flat_at_its_hinge():
    strain = 0.32
    made = muscle_solid(SIX, muscle_curves(SIX, P, strain, SUPPLY, TOP), strain)
    rings = made.points[: RINGS * AROUND].reshape(RINGS, AROUND, 3)
    across = np.linalg.norm(rings[:, 0] - rings[:, AROUND // 2], axis=1)
    assert across[RINGS // 2] < 0.5 * across[0]
    # the wall, twice
    assert across.min() == pytest.approx(2 * float(SIX.wall_thickness), rel=0.35)


def test_faces_use_every_point():
    made = muscle_solid(SIX, muscle_curves(SIX, P, 0.1, SUPPLY, TOP), 0.1)
    assert face_corners().max() + 1 == len(made.points)


def test_the_drawn_strains_reach_past_the_free_strain():
    assert float(SIX.free_strain(SUPPLY)) < strain_limit(SIX, SUPPLY) <= 0.6


@pytest.mark.parametrize("key", alternative_laws(SIX))
def test_each_alternative_is_another_law(key):
    kind, _, name = key.partition(":")
    other = with_alternative(SIX, key)
    assert type(getattr(other, kind)) is LAWS[kind][name]
    assert float(other.length) == float(SIX.length)


def test_untuned_is_offered_for_a_tuned_muscle_alone():
    tuned = fs.example("kim2021_slenderness_10")
    assert "untuned" in alternative_laws(tuned)
    assert "untuned" not in alternative_laws(SIX)
    assert float(with_alternative(tuned, "untuned").tuning.youngs_modulus_factor) == 1.0


def test_the_bundles_curves_are_the_laws():
    state = bundle_curves.bundle_state(VIEW.bundle, (3e5, 7e4), 0.3, True)
    force = VIEW.bundle.force([3e5, 7e4], state.strain)
    np.testing.assert_allclose(state.force, force, rtol=1e-9, atol=1e-9)
    assert state.zeros[0] == pytest.approx(float(VIEW.bundle.free_strain([3e5, 7e4])))


def test_a_point_of_the_overlap_has_a_way_in_each_state():
    shown = bundle_curves.drawn_space(VIEW.bundle, True)
    widest_at = int(np.argmax(shown.overlap.width[0]))
    strain = float(shown.overlap.strain[widest_at])
    force = float(shown.overlap.low[0, widest_at] + shown.overlap.high[0, widest_at]) / 2
    found, remark = bundle_curves.solutions(VIEW.bundle, force, strain, True)
    assert not remark
    assert {way.state for way in found} == {1, 2}
    for way in found:
        reached = float(VIEW.bundle.force(way.pressures, strain))
        assert reached == pytest.approx(force, rel=1e-6, abs=1e-6)


def test_a_point_out_of_reach_says_so():
    found, remark = bundle_curves.solutions(VIEW.bundle, 1e4, 0.1, True)
    assert "above what is reachable" in remark
    assert len(found) == 1


def test_the_envelope_holds_every_muscle_and_they_stand_apart():
    view = replace(VIEW, units=(Unit(1), Unit(6)), pressures=(4e5, 0.0), strain=0.2)
    drawn, owner, places, reach = bundle_curves.bundle_solids(view, 0.3)
    assert len(drawn) == len(places) == 7
    assert owner == [0, *[1] * 6]
    spots = np.array([(x, y) for _, x, y in places])
    apart = np.linalg.norm(spots[:, None] - spots, axis=-1)[np.triu_indices(7, 1)]
    assert apart.min() > 2 * float(view.muscle.outer_radius)
    bowed = float(view.muscle.deflection(0.0, 0.2))
    assert reach > np.hypot(*spots.T).max() + bowed


def test_splits_are_the_reversals_of_the_library():
    (one,) = reversal_tab.split_curves(SIX, ((1, 2),), 344.7e3)
    bundle = fs.Bundle([fs.MotorUnit(SIX, 1), fs.MotorUnit(SIX, 2)], 344.7e3)
    assert one.turn == reversal.reversal(bundle)
    assert one.resisted.min() == pytest.approx(one.turn.free_strain, abs=2e-3)
    assert (one.free >= one.resisted - 1e-9).all()


def test_the_semu_has_the_bundles_cross_section():
    whole = efficiency_tab.equivalent_muscle(VIEW)
    assert float(whole.outer_radius) == pytest.approx(np.sqrt(5) * float(VIEW.muscle.outer_radius))
    found = efficiency_tab.efficiency_maps(VIEW.bundle, "isotonic")
    assert found.difference.shape == found.resisted.efficiency.shape
    average = fs.energetics.average_efficiency(VIEW.bundle, path="isotonic")
    assert found.resisted.average == pytest.approx(average)


def test_a_records_reason_names_the_length_that_was_assumed():
    from fascicle.explorer.measured import ReadOptions, example_record, mismatch_reason, read_record

    muscle = VIEW.muscle
    raw = example_record(muscle)
    record = read_record(raw, "example.csv", float(muscle.length))
    assert record.synthetic and mismatch_reason(muscle, record) == ""
    half = b"pressure [kPa],displacement [mm],force [N]\n200,0,90\n200,40,70\n200,80,50\n"
    told = mismatch_reason(muscle, read_record(half, "a.csv", float(muscle.length)))
    assert "over 127 mm" in told and "give the rest length" in told
    assert (
        mismatch_reason(muscle, read_record(half, "a.csv", 0.127, ReadOptions(rest_length=1.0)))
        == ""
    )
    far = half.replace(b"200,80,50", b"200,200,50")
    with pytest.raises(ValueError, match="taken over the muscle's length, 127 mm"):
        read_record(far, "a.csv", float(muscle.length))
