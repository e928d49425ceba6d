"""Schemes: lists of states, taken by name or as objects, and what is made of them."""

import copy
import math

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import fascicle as fs
from fascicle.bundle.schemes import AbstractScheme, Batch, Free, Orderly, State
from fascicle.design import Designs, Task, evaluate
from refusing import refuses


SUPPLY = 413.7e3
thin, thick = (
    fs.Muscle(0.127, r, 0.25 * r, math.radians(33), "silicone_kim2021") for r in (5e-3, 9e-3)
)
three = fs.Bundle([fs.MotorUnit(thin), fs.MotorUnit(thick), fs.MotorUnit(thin, 2)], SUPPLY)


class LastFirst(AbstractScheme):
    """From the last unit to the first."""

    name = "last first"

    def states(self, units):
        return [State(full=range(k + 1, units), throttled=[k]) for k in reversed(range(units))]


class Given(AbstractScheme):
    """States that are given."""

    name = "given by hand"

    def __init__(self, states):
        self.given = states

    def states(self, units):
        return self.given[:units]


def test_a_scheme_equals_its_name_and_is_copied():
    assert three.scheme == "orderly" == str(three.scheme)
    assert three.scheme == Orderly() != Batch() and three.scheme != "batch"
    assert {"orderly": 1}[three.scheme] == 1
    for copied in (copy.deepcopy(three), copy.copy(three)):
        assert copied == three and copied.scheme == "orderly"


class Listed(AbstractScheme):
    """Units in the order of an array."""

    name = "listed"

    def __init__(self, order):
        self.order = np.asarray(order)

    def states(self, units):
        return [State(self.order[:k].tolist(), [int(self.order[k])]) for k in range(units)]


def test_a_scheme_may_hold_an_array():
    bundle = fs.Bundle(three.motor_units, SUPPLY, Listed([2, 0, 1]))
    first, again = (fs.Bundle(three.motor_units, SUPPLY, Listed([2, 0, 1])) for _ in range(2))
    for one in (bundle, bundle, first, again):
        assert one.recruit(20.0, 0.05).unit == 3
    assert Listed([2, 0, 1]) == Listed([2, 0, 1]) != Listed([0, 1, 2])
    assert Listed([0, 1]) != Listed([0, 1, 2])
    bundle.scheme.order[:] = [1, 0, 2]  # nothing remembers the states of before
    assert bundle.recruit(20.0, 0.05).unit == 2


def test_of_several_states_the_one_of_least_fluid_is_selected():
    # a later state takes less fluid where its unit does
    force, one_or_other = [2.0, 5.0], Given([State([], [0]), State([], [1])])
    for units, best in (((thick, thin), 2), ((thin, thick), 1)):
        bundle = fs.Bundle([fs.MotorUnit(one) for one in units], SUPPLY, one_or_other)
        result = fs.recruitment.recruit(bundle, force, 0.1)
        assert result.state.tolist() == [best, best] and np.all(result.count >= 2)
    free = fs.recruitment.recruit(bundle, force, 0.1, scheme="free")
    assert free.solutions.state.tolist() == [[1], [1]] == free.state[:, None].tolist()


def test_a_user_s_scheme_in_all_functions():
    """From the last to the first is orderly recruitment of the bundle turned around."""
    turned = fs.Bundle(three.motor_units[::-1], SUPPLY)
    mine = three.replace(scheme=LastFirst())
    force, strain = np.array([15.0, 60.0, 150.0, 400.0]), 0.1
    own, other = (fs.recruitment.recruit(one, force, strain) for one in (mine, turned))
    assert_allclose(own.pressures, other.pressures[:, ::-1], rtol=1e-9)
    assert_array_equal(own.state, other.state)
    assert_array_equal(own.unit, 4 - other.unit)
    by_argument = fs.recruitment.recruit(three, force, strain, scheme=LastFirst())
    assert_array_equal(own.pressures, by_argument.pressures)
    grid = [0.0, 0.1, 0.2]
    assert_allclose(
        fs.recruitment.workspace(mine, strain=grid).high,
        fs.recruitment.workspace(turned, strain=grid).high, rtol=1e-12,
    )  # fmt: skip
    for path in fs.energetics.PATHS:
        assert fs.energetics.average_efficiency(mine, path=path) == pytest.approx(
            fs.energetics.average_efficiency(turned, path=path), rel=1e-9
        )


@pytest.mark.parametrize("alike", [True, False])
def test_designs_are_evaluated_by_a_user_s_scheme(alike):
    """Also designs of fewer units than others, which begin with another state."""
    counts = [(1, 2, 3), (3, 1, 0), (4, 0, 0)]
    back = [(3, 2, 1), (1, 3, 0), (4, 0, 0)]
    made, turned = (Designs.of(thin, rows) for rows in (counts, back))
    if not alike:
        made, turned = made.take(np.array([0])), turned.take(np.array([0]))
        made.radius[:], turned.radius[:] = [[4e-3, 6e-3, 5e-3]], [[5e-3, 6e-3, 4e-3]]
    names = ["mean_energy", "margin", "mean_efficiency", "valves"]
    names += ["reversal_depth", "overlap_width"] if alike else []
    force, strain = [20.0, 60.0, 120.0], [0.15, 0.1, 0.05]
    own = evaluate(made, Task.of(force, strain, SUPPLY, scheme=LastFirst()), names)
    other = evaluate(turned, Task.of(force, strain, SUPPLY), names)
    for name in names:
        # shared tables and a design's own are of unlike resolution where curves are asked for
        assert_allclose(own[name], other[name], rtol=1e-9, atol=1e-9)


def test_forces_in_a_gap_between_states_are_unreachable():
    one_or_all = Given([State([], [0]), State([0, 1], [2])])
    bundle = three.replace(scheme=one_or_all)
    (low, high) = (
        getattr(fs.recruitment.workspace(bundle, strain=[0.1]), x)[:, 0] for x in ("low", "high")
    )
    assert high[0] < low[1]
    between = 0.5 * (high[0] + low[1])
    result = fs.recruitment.recruit(bundle, [between, 0.5 * high[0], 0.5 * (low[1] + high[1])], 0.1)
    assert result.status.tolist() == [1 if result.force[0] < between else 2, 0, 0]
    task = Task.of([between, 0.5 * high[0]], [0.1, 0.1], SUPPLY, scheme=one_or_all)
    designs = Designs.of(thin, [(1, 2, 3)])
    design = designs.bundle(0, task)
    edges = fs.recruitment.workspace(design, strain=[0.1])
    asked = Task.of([0.5 * (edges.high[0, 0] + edges.low[1, 0])], [0.1], SUPPLY, scheme=one_or_all)
    values = evaluate(designs, asked, ["not_reached", "shortfall", "margin"])
    half = 0.5 * (edges.low[1, 0] - edges.high[0, 0])
    assert values["not_reached"] == 1 and half > 0
    assert_allclose(values["shortfall"], half, rtol=1e-6)
    assert_allclose(values["margin"], -half, rtol=1e-6)


def test_files_hold_registered_schemes_only(tmp_path):
    fs.save(three.replace(scheme="free"), str(tmp_path / "free.toml"))
    assert fs.load(str(tmp_path / "free.toml")).scheme == Free()
    with pytest.raises(fs.InvalidInputError):
        fs.save(three.replace(scheme=LastFirst()), str(tmp_path / "mine.toml"))
    assert not (tmp_path / "mine.toml").exists()


@pytest.mark.parametrize(
    "states", [[], [State([], [])], [State([0], [0])], [State([], [3])]],
)  # fmt: skip
def test_impossible_states_are_refused(states):
    with refuses("scheme"):
        fs.recruitment.recruit(three, 10.0, 0.1, scheme=Given(states))


def test_a_class_and_another_schemes_name_are_refused():
    with pytest.raises(fs.InvalidInputError):
        three.replace(scheme=LastFirst)
    with refuses("name"):

        @fs.schemes.register
        class Mine(LastFirst):
            name = "batch"
