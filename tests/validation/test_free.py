"""Free recruitment against a search that tries every unit at every pressure of a grid."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.bundle.energetics import unit_volume_change
from fascicle.design import Designs, Task, evaluate
from fascicle.design.summary import cases
from refusing import refuses

from . import oracle_free as oracle


SUPPLY = 413.7e3
FINE = np.linspace(0.0, SUPPLY, 40_001)
SLACK = 0.02  # N: what the fine grid may miss of an extremum between two of its pressures


def muscle(radius: float, angle: float = 33.0) -> fs.Muscle:
    return fs.Muscle(0.127, radius, 0.25 * radius, math.radians(angle), "silicone_kim2021")


def unlike(counts=(1, 2, 3)) -> fs.Bundle:
    """Three unlike motor units: the cheapest for a force isn't always the first."""
    units = [fs.MotorUnit(muscle(r), n) for r, n in zip((9e-3, 5e-3, 6.35e-3), counts, strict=True)]
    return fs.Bundle(units, SUPPLY, "free")


def grid(unit: fs.MotorUnit, strain: float) -> np.ndarray:
    """Some even pressures [Pa], and those of a fine grid at which it pulls least and most."""
    force = unit.muscle.force(FINE, strain)
    return np.union1d(FINE[::1000], FINE[[force.argmin(), force.argmax()]])


def tables(bundle: fs.Bundle, strain: float) -> tuple[list[np.ndarray], list[float]]:
    """Forces [N] of each unit over its grid, and what it takes in [m³]."""
    forces = [
        unit.count * unit.muscle.force(grid(unit, strain), strain) for unit in bundle.motor_units
    ]
    return forces, unit_volume_change(bundle, strain).tolist()


@pytest.mark.parametrize(
    "strain", [-0.02, 0.05, *(pytest.param(x, marks=pytest.mark.slow) for x in (0.15, 0.22))]
)
def test_the_cheapest_is_taken(strain):
    bundle = unlike()
    forces, taken = tables(bundle, strain)
    low, high = oracle.region(forces)
    assert low < 0 if strain > 0 else low >= 0
    wanted = np.linspace(low - 20.0, high + 20.0, 31)
    found = fs.recruitment.recruit(bundle, wanted, strain)
    assert_allclose(bundle.force(found.pressures, strain), found.force, rtol=0, atol=1e-9)
    for F, P, force, status in zip(wanted, found.pressures, found.force, found.status, strict=True):
        best = oracle.cheapest(forces, taken, F)
        if best is None:
            # the grid may miss a little of the edge
            assert (
                status == (1 if 0.5 * (low + high) < F else 2)
                or min(abs(F - low), abs(F - high)) < SLACK
            )
            continue
        assert status == 0 and abs(force - F) < 1e-9
        own = sum(max(v, 0.0) for v, p in zip(taken, P, strict=True) if p > 0)
        assert own <= best * (1 + 1e-12), (F, P, own, best)
        # the grid can't be better than what may be anywhere between its pressures either
        if min(abs(F - edge) for edge in _edges(forces)) > SLACK:
            assert own == pytest.approx(best, rel=1e-12)


def _edges(forces: list[np.ndarray]) -> list[float]:
    """Forces [N] at which another choice of fed units comes to reach."""
    found = []
    for mask in range(1, 2 ** len(forces)):
        some = [one if mask >> i & 1 else one[:1] for i, one in enumerate(forces)]
        found += oracle.region(some)
    return found


def test_a_later_unit_alone_where_that_is_cheaper():
    """Three muscles of the last unit pull as much with less fluid than the first one's."""
    found = fs.recruitment.recruit(unlike(), 150.0, 0.05)
    orderly = fs.recruitment.recruit(unlike(), 150.0, 0.05, scheme="orderly")
    taken = unit_volume_change(unlike(), 0.05)
    assert taken[found.pressures > 0].sum() < taken[orderly.pressures > 0].sum()


def test_out_of_reach_the_nearest_is_given():
    bundle = unlike()
    forces, _ = tables(bundle, 0.15)
    low, high = oracle.region(forces)
    found = fs.recruitment.recruit(bundle, [high + 50.0, low - 50.0], 0.15)
    assert found.status.tolist() == [1, 2] and found.count.tolist() == [0, 0]
    # at least as far out as the grid sees, and hardly farther
    assert high - 1e-9 <= found.force[0] <= high + SLACK
    assert low - SLACK <= found.force[1] <= low + 1e-9


def test_equal_units_are_recruited_in_their_order():
    """Then nothing is cheaper than orderly recruitment, and that is what comes out."""
    bundle = fs.Bundle([fs.MotorUnit(muscle(6.35e-3))] * 4, SUPPLY)
    force = np.linspace(1.0, 430.0, 9)
    free = fs.recruitment.recruit(bundle, force, 0.08, scheme="free")
    orderly = fs.recruitment.recruit(bundle, force, 0.08)
    assert_allclose(free.pressures, orderly.pressures, rtol=0, atol=1e-3)


def test_the_space_is_all_that_any_pressures_reach():
    bundle = unlike()
    strains = [0.05, 0.22]
    levels = np.unique([P for eps in strains for u in bundle.motor_units for P in grid(u, eps)])
    found = fs.recruitment.workspace(bundle, strain=strains, levels=levels)
    assert found.scheme == "free" and found.low.shape == (1, 2)
    for j, strain in enumerate(strains):
        low, high = oracle.region(tables(bundle, strain)[0])
        assert low - SLACK <= found.low[0, j] <= low + 1e-9
        assert high - 1e-9 <= found.high[0, j] <= high + SLACK
    assert not fs.recruitment.overlap(found).states


def test_efficiency_is_that_of_the_least_fluid():
    bundle = unlike()
    force, strain = np.array([20.0, 80.0, 150.0, 300.0]), np.array([0.05, 0.15])
    found = fs.energetics.efficiency_map(bundle, SUPPLY, "isotonic", force, strain)
    for j, eps in enumerate(strain):
        forces, taken = tables(bundle, eps)
        for i, F in enumerate(force):
            best = oracle.cheapest(forces, taken, F)
            if best is None:
                assert math.isnan(found.efficiency[i, j])
            else:
                want = F * eps * 0.127 / (SUPPLY * best)
                assert found.efficiency[i, j] == pytest.approx(want, rel=1e-9)
    with refuses("path"):
        fs.energetics.efficiency_map(bundle, SUPPLY, "isobaric")


@pytest.mark.parametrize("alike", [True, False])
def test_designs_are_judged_by_the_cheapest_units(alike):
    if alike:
        one = muscle(6.35e-3)
        designs = Designs.of(one, [(1, 2, 3), (4, 1)])
    else:
        like = Designs.of(muscle(6.35e-3), [(1, 2, 3)])
        radius = like.radius * np.array([1.4, 0.8, 1.0])
        designs = Designs(
            like.drawings, like.kind, like.counts, like.length, radius, 0.25 * radius, like.angle
        )
    task = Task.of([60.0, 150.0, 250.0, 2e3], [0.15, 0.1, 0.05, 0.02], SUPPLY, scheme="free")
    values = evaluate(designs, task, ["mean_energy", "peak_energy", "not_reached", "margin"])
    for place in range(len(designs)):
        bundle = designs.bundle(place, task)
        costs, spare = [], []
        for F, eps in zip(task.force, task.strain, strict=True):
            forces, taken = tables(bundle, eps)
            best = oracle.cheapest(forces, taken, F)
            costs.append(SUPPLY * (sum(taken) if best is None else best))
            spare.append(oracle.region(forces)[1] - F)
        assert values["mean_energy"][place] == pytest.approx(np.mean(costs), rel=1e-9)
        assert values["peak_energy"][place] == pytest.approx(max(costs), rel=1e-9)
        assert values["not_reached"][place] == 0.25
        assert values["margin"][place] == pytest.approx(min(spare), rel=1e-9)
        # what it does at each load case: the pressures give the force
        found = cases(designs, place, task)
        assert found.reached.tolist() == [True, True, True, False]
        exact = fs.recruitment.recruit(bundle, task.force, task.strain)
        assert_allclose(found.pressures[:3], exact.pressures[:3], rtol=1e-9)
        assert np.array_equal(found.content > 0, exact.pressures > 0)


def test_what_turns_tell_can_not_be_asked():
    task = Task.of([60.0], [0.1], SUPPLY, scheme="free")
    with refuses("objectives"):
        evaluate(Designs.of(muscle(6e-3), [(1, 2)]), task, ["valves", "reversal_depth"])
    with refuses("prefer"):
        fs.recruitment.recruit(unlike(), 50.0, 0.1, prefer="nearest", present=[0.0] * 3)
    many = [fs.MotorUnit(muscle(4e-3 + 1e-4 * i)) for i in range(13)]
    with refuses("scheme"):
        fs.recruitment.recruit(fs.Bundle(many, SUPPLY, "free"), 50.0, 0.1)
