"""Curves, solids and labels are what the library's public methods give, drawn to scale."""

import math
from dataclasses import replace

import numpy as np
import pytest

import fascicle as fs
from fascicle.bundle import reversal
from fascicle.bundle.inverse import ABOVE, BELOW
from fascicle.explorer import bundle_curves
from fascicle.explorer.bundle_tab import BundleView
from fascicle.explorer.muscle_curves import (
    alternative_laws,
    muscle_curves,
    region_strips,
    strain_limit,
    with_alternative,
)
from fascicle.explorer.solid import AROUND, RINGS, face_corners, muscle_solid
from fascicle.explorer.state import Session, Unit, view_of
from fascicle.muscle import LAWS
from fascicle.muscle.ends import Compliant
from fascicle.plot.theme import LIGHT


SIX = fs.example("kim2021_figure_6")
VIEW = view_of(fs.example("kim2021_bundle_1_4"), "kim2021_bundle_1_4")
P, TOP, SUPPLY = 137.9e3, 0.4, 413.7e3


@pytest.mark.parametrize("strain", [0.1, 0.25, 0.3])
def test_curves_are_what_the_methods_give(strain):
    curves = muscle_curves(SIX, P, strain, TOP)
    response, point = SIX.response(P, curves.strain), SIX.response(P, strain)
    close = {"rtol": 1e-9, "atol": 1e-9}
    np.testing.assert_allclose(curves.force, SIX.force(P, curves.strain), **close)
    np.testing.assert_allclose(curves.mesh, response.mesh, **close)
    assert curves.point_force == pytest.approx(float(point.force), abs=1e-9)
    assert curves.region == int(point.region)
    assert curves.free_strain == pytest.approx(float(SIX.free_strain(P)))
    assert curves.collapse_strain == pytest.approx(float(SIX.collapse_strain(P)))
    assert curves.blocked == pytest.approx(float(SIX.blocked_force(P)))
    assert curves.deflection == pytest.approx(float(SIX.deflection(P, strain)))
    assert curves.moment == pytest.approx(float(SIX.moment(P, strain)))
    assert curves.volume == pytest.approx(float(SIX.volume(strain)))


# it shortens straight past its free strain: that isn't buckled
STUBBY = SIX.replace(length=0.03, braid_angle=math.radians(22), buckling="elastica")


@pytest.mark.parametrize(
    ("muscle", "pressure", "region"), [(STUBBY, 0.0, 3), (STUBBY, 34.5e3, 3), (SIX, P, 1)]
)
def test_strips_are_the_regions_of_the_law(muscle, pressure, region):
    top = strain_limit(muscle, SUPPLY)
    curves = muscle_curves(muscle, pressure, 0.2, top)
    strips = region_strips(curves.strain, curves.regions)
    assert strips[0][0] == 0 and strips[-1][1] == top
    for left, right, number in strips:
        assert int(muscle.response(pressure, (left + right) / 2).region) == number
    assert region in [number for _, _, number in strips]
    if muscle is SIX:  # they begin at the law's kinks
        kinks = float(SIX.free_strain(P)), float(SIX.collapse_strain(P))
        assert [left for left, *_ in strips[1:]] == pytest.approx(kinks, abs=1e-9)


def test_a_straight_muscle_has_the_braids_radius_and_its_fibers_their_angle():
    strain = 0.1
    solid = muscle_solid(SIX, muscle_curves(SIX, P, strain, TOP), strain)
    tube = solid.points[: RINGS * AROUND]
    radius = np.hypot(tube[:, 0], tube[:, 1])
    np.testing.assert_allclose(radius, float(SIX.radius(strain)), rtol=1e-9)
    assert np.ptp(tube[:, 2]) == pytest.approx(float(SIX.length) * (1 - strain))
    assert solid.angle == pytest.approx(float(SIX.braid.angle_at(strain)))
    # along a fiber: how far it turns for how far it goes
    fiber = solid.fibers[0]
    turn = np.abs(np.diff(np.unwrap(np.arctan2(fiber[:, 0], fiber[:, 1]))))
    drawn = np.arctan2(turn * solid.radius, np.diff(fiber[:, 2]))
    np.testing.assert_allclose(drawn, solid.angle, rtol=1e-6)
    assert face_corners().max() + 1 == len(solid.points)


def test_a_collapsed_muscle_folds_flat_at_its_hinge():
    strain = 0.32
    solid = muscle_solid(SIX, muscle_curves(SIX, P, strain, TOP), strain)
    rings = solid.points[: RINGS * AROUND].reshape(RINGS, AROUND, 3)
    across = np.linalg.norm(rings[:, 0] - rings[:, AROUND // 2], axis=1)
    assert across[RINGS // 2] < 0.5 * across[0]
    # the wall, twice
    assert across.min() == pytest.approx(2 * float(SIX.wall_thickness), rel=0.35)


@pytest.mark.parametrize("key", alternative_laws(SIX))
def test_each_alternative_is_another_law(key):
    kind, _, name = key.partition(":")
    other = with_alternative(SIX, key)
    assert type(getattr(other, kind)) is LAWS[kind][name]
    assert float(other.length) == float(SIX.length)


def test_the_bundles_curves_are_the_laws():
    state = bundle_curves.bundle_state(replace(VIEW, pressures=(3e5, 7e4)), 0.3)
    force = VIEW.bundle.force([3e5, 7e4], state.strain)
    np.testing.assert_allclose(state.force, force, rtol=1e-9, atol=1e-9)
    assert state.equilibria[0] == pytest.approx(float(VIEW.bundle.free_strain([3e5, 7e4])))


@pytest.mark.parametrize("path", ["isobaric", "isotonic"])
def test_a_load_in_the_overlap_has_pressures_in_each_state_the_cheapest_first(path):
    bundle, overlap = VIEW.bundle, bundle_curves.bundle_workspace(VIEW.bundle, True).overlap
    widest = int(np.nanargmax(overlap.high[0] - overlap.low[0]))
    strain = float(overlap.strain[widest])
    load = float(overlap.low[0, widest] + overlap.high[0, widest]) / 2
    status, rows = bundle_curves.recruitments(bundle, load, strain, True, path)
    assert {row.state for row in rows} == {1, 2} and not status
    fluid = [row.fluid for row in rows]
    assert fluid == sorted(fluid)
    result = bundle.recruit(load, strain)
    assert rows[0].state == result.state
    np.testing.assert_allclose(rows[0].pressures, result.pressures, rtol=1e-12)
    for row in rows:
        assert float(bundle.force(row.pressures, strain)) == pytest.approx(load, rel=1e-6)
        # volumes of all muscles with pressure, at the strain less at rest
        volume = sum(
            unit.count * (float(unit.muscle.volume(strain)) - float(unit.muscle.volume(0.0)))
            for unit, P in zip(bundle.motor_units, row.pressures, strict=True) if P > 0
        )  # fmt: skip
        assert row.fluid == pytest.approx(volume, rel=1e-12)
        # the area under the curve, by its trapezoids: their error falls with their number squared
        strains = np.linspace(0.0, strain, 4001)
        forces = np.full(4001, load)
        if path == "isobaric":
            forces = bundle.force(np.array(row.pressures), strains)
        area = np.trapezoid(forces, strains) * float(bundle.length)
        expected = area / (float(bundle.supply_pressure) * volume)
        assert row.efficiency == pytest.approx(expected, rel=1e-5)


def test_a_load_out_of_reach_has_the_nearest_force():
    bundle, strain = VIEW.bundle, 0.2
    levels = np.linspace(0.0, float(bundle.supply_pressure), 20_001)
    forces = np.asarray(bundle.force(np.c_[np.full_like(levels, levels[-1]), levels], strain))
    status, (row,) = bundle_curves.recruitments(bundle, 1e4, strain, True, "isobaric")
    assert (status, row.pressures) == (ABOVE, (levels[-1],) * 2)
    assert row.force == pytest.approx(forces.max(), rel=1e-12)
    first = np.asarray(bundle.force(np.c_[levels, np.zeros_like(levels)], strain))
    least = min(forces.min(), first.min())
    status, (row,) = bundle_curves.recruitments(bundle, least - 5, strain, True, "isobaric")
    assert status == BELOW
    # N: the scan's own step, below which the search goes
    assert least - 5e-3 < row.force <= least


def test_rest_length_takes_no_fluid_and_that_of_compliant_ends_is_not_known():
    status, (row, *_) = bundle_curves.recruitments(VIEW.bundle, 50.0, 0.0, True, "isobaric")
    assert not status and row.fluid == 0 and np.isnan(row.efficiency)
    muscle = SIX.replace(ends=Compliant(end_compliance=1e-6))
    bundle = fs.Bundle([fs.MotorUnit(muscle)], SUPPLY)
    status, (row,) = bundle_curves.recruitments(bundle, 20.0, 0.05, True, "isobaric")
    assert not status and np.isnan(row.fluid) and np.isnan(row.efficiency)


def test_muscles_stand_apart_inside_their_envelope():
    view = replace(VIEW, units=(Unit(1), Unit(6)), pressures=(4e5, 0.0), strain=0.2)
    scene = bundle_curves.bundle_solids(view, 0.3)
    assert len(scene.solids) == len(scene.positions) == 7
    assert scene.owners == [0, *[1] * 6]
    centers = np.array([(x, y) for _, x, y in scene.positions])
    distances = np.linalg.norm(centers[:, None] - centers, axis=-1)[np.triu_indices(7, 1)]
    assert distances.min() > 2 * float(view.muscle.outer_radius)
    deflection = float(view.muscle.deflection(0.0, 0.2))
    assert scene.envelope > np.hypot(*centers.T).max() + deflection


def test_the_free_strain_over_the_second_pressure_is_the_librarys():
    curve = bundle_curves.second_unit_curve(VIEW.bundle, 344.7e3)
    assert curve.turn == reversal.reversal(VIEW.bundle, 2, 344.7e3)
    assert curve.resisted.min() == pytest.approx(curve.turn.free_strain, abs=2e-3)
    assert (curve.free >= curve.resisted - 1e-9).all()


def test_the_maps_of_efficiency_are_shown_when_they_are_asked_for():
    tab = BundleView(Session(replace(VIEW, tab="bundle")), LIGHT)
    tab.refresh()
    assert tab.efficiency.pictures[0].object is None
    tab.efficiency.toggle.value = True
    average = VIEW.bundle.average_efficiency(path="isobaric")
    assert f"<td>{average:.4f}</td>" in tab.efficiency._numbers.object
    assert all(picture.object.startswith(b"\x89PNG") for picture in tab.efficiency.pictures)
    tab.session.change(scheme="free")
    assert tab.efficiency._message.text and tab.efficiency.pictures[0].object is None
