"""What one design does at each load case, against the bundle's own laws."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle import recruitment
from fascicle.design import Designs, Task, evaluate
from fascicle.design.summary import ATMOSPHERE, cases


SUPPLY = 413.7e3


@pytest.fixture(scope="module")
def designs(muscle):
    return Designs.of(muscle, [(1, 2), (3,)])


@pytest.mark.parametrize("scheme", ["orderly", "batch"])
def test_margin_equals_the_objective(designs, scheme):
    task = Task.of([40.0, 150.0, 300.0, 900.0], [0.2, 0.1, 0.05, 0.02], SUPPLY, scheme=scheme)
    names = ["margin", "relative_shortfall", "points_not_reached"]
    judged = evaluate(designs, task, names)
    for index in range(2):
        load_cases = cases(designs, index, task)
        assert_allclose(load_cases.spare.min(), judged["margin"][index], rtol=1e-9)
        assert_allclose(-load_cases.relative.min(), judged["relative_shortfall"][index], rtol=1e-9)
        assert load_cases.reached.tolist() == [True, True, True, False]
        assert np.argmin(load_cases.relative) == 3


def test_different_units(muscle):
    same = Designs.of(muscle, [(2, 1)])
    radius = same.radius * np.array([[1.0, 1.3]])
    other = replace(same, radius=radius, wall=0.25 * radius)
    task = Task.of([40.0, 150.0, 300.0], [0.2, 0.1, 0.05], SUPPLY)
    margin = evaluate(other, task, ["margin"])["margin"][0]
    assert_allclose(cases(other, 0, task).spare.min(), margin, rtol=1e-9)


def test_states_and_pressures_equal_recruit(designs):
    """Where the muscle pulls its force is linear in pressure, so levels in between are exact."""
    task = Task.of([60.0, 150.0, 320.0], [0.1, 0.1, 0.04], SUPPLY)
    load_cases = cases(designs, 0, task)
    bundle = designs.bundle(0, task)
    exact = recruitment.recruit(bundle, task.force, task.strain)
    assert load_cases.state.tolist() == np.asarray(exact.state).tolist()
    assert_allclose(load_cases.pressures, exact.pressures, rtol=1e-9)
    # they give the demanded force
    force = [bundle.force(P, eps) for P, eps in zip(load_cases.pressures, task.strain, strict=True)]
    assert_allclose(force, task.force, rtol=1e-9)


def test_air_fills_each_unit_at_its_pressure(muscle, designs):
    task = Task.of([60.0, 320.0], [0.1, 0.04], SUPPLY, weight=[3, 1])
    load_cases = cases(designs, 0, task)
    full, rest = (np.asarray(muscle.volume(np.array(e))) for e in ([0.1, 0.04], [0.0, 0.0]))
    # the first alone; then it at full pressure, and two throttled
    p = load_cases.pressures[[0, 1], [0, 1]] + ATMOSPHERE
    filled = (p * full - ATMOSPHERE * rest) / ATMOSPHERE
    first = ((SUPPLY + ATMOSPHERE) * full - ATMOSPHERE * rest) / ATMOSPHERE
    assert_allclose(load_cases.fluid, [filled[0], first[1] + 2 * filled[1]], rtol=1e-12)
    assert_allclose(
        load_cases.fluid_of_a_cycle, (3 * load_cases.fluid[0] + load_cases.fluid[1]) / 4, rtol=1e-12
    )


def test_liquid_is_the_volume_change(muscle, designs):
    task = Task.of([60.0, 320.0], [0.1, 0.04], SUPPLY, fluid="liquid")
    gain = np.asarray(muscle.volume(np.array([0.1, 0.04]))) - float(muscle.volume(0.0))
    assert_allclose(cases(designs, 0, task).fluid, [1, 3] * gain, rtol=1e-12)
    # (29): what it takes times the supply's pressure is the energy that designs are judged by
    energy = evaluate(designs, task, ["mean_energy"])["mean_energy"][0]
    assert_allclose(cases(designs, 0, task).fluid_of_a_cycle * SUPPLY, energy, rtol=1e-9)


def test_cycle_in_time_covers_all_cases(muscle, designs):
    """Content rises from the first to the second, falls to the third, and rises to the first."""
    task = Task.in_time([0.0, 1.0, 2.0], [150.0, 150.0, 20.0], [0.05, 0.1, 0.02], SUPPLY)
    load_cases = cases(designs, 1, task)
    a, b, c = load_cases.content[:, 0]
    assert b > a > c
    assert_allclose(load_cases.fluid_of_a_cycle, (b - a) + (a - c), rtol=1e-12)


def test_many_points_are_computed_in_batches(designs):
    generator = np.random.default_rng(1)
    strain = generator.uniform(0.01, 0.2, 700)
    task = Task.of(generator.uniform(0, 400, 700) * (1 - strain / 0.25), strain, SUPPLY)
    load_cases = cases(designs, 1, task)
    for i in (0, 300, 699):
        alone = Task.of([task.force[i] + 1.0], [strain[i]], SUPPLY)
        assert_allclose(cases(designs, 1, alone).spare[0], load_cases.spare[i] - 1.0, atol=1e-9)


def test_a_stroke_longer_than_the_bundle(designs):
    task = Task.of([0.0, 10.0], None, SUPPLY, stroke=[0.2, 0.01])
    load_cases = cases(designs, 0, task)
    assert load_cases.reached.tolist() == [False, True] and np.all(np.isfinite(load_cases.fluid))
