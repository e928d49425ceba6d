"""Mutated muscle, bundle and task files: each is read, or refused in one line that names it."""

import warnings
from pathlib import Path

import numpy as np
import pytest
from mutations import mutated

from fascicle.cli.muscle import template
from fascicle.files import dumps, example_text, loads
from fascicle.files.task import loads_task
from refusing import refuses_at


UNLIKE, GRIPPER = (
    (Path(__file__).parent / name).read_text(encoding="utf-8")
    for name in ("unlike_muscles.toml", "gripper.toml")
)
MUSCLES = [*map(example_text, ("kim2021_slenderness_8", "kim2021_bundle_1_4")), UNLIKE]
TASKS = [template("task"), GRIPPER]


def refused_kindly(error):
    text = str(error)
    assert text.startswith("x.toml: "), text
    assert "\n" not in text, text
    return text


def read(function, text):
    """What `function` makes of a text, or `None` if it refuses it as it should."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return function(text, "x.toml")
    except (ValueError, OSError) as error:
        refused_kindly(error)
        return None


def muscles_of(found):
    return [unit.muscle for unit in getattr(found, "motor_units", [])] or [found]


def check_muscles(seed, count):
    rng = np.random.default_rng(seed)
    taken = 0
    for i in range(count):
        found = read(loads, mutated(MUSCLES[i % len(MUSCLES)], rng))
        if found is None:
            continue
        taken += 1
        text = dumps(found)
        assert dumps(read(loads, text)) == text
        if i % 50 == 0:
            for muscle in muscles_of(found):
                assert np.isfinite(muscle.force(1e5, 0.1)), text
    # were all refused, or none, then this would test nothing
    assert 0.01 * count < taken < 0.9 * count


def check_tasks(seed, count):
    rng = np.random.default_rng(seed)
    taken = sum(
        read(loads_task, mutated(TASKS[i % len(TASKS)], rng)) is not None for i in range(count)
    )
    assert 0.01 * count < taken < 0.9 * count


MANY = pytest.param(1, 12, marks=pytest.mark.slow)


@pytest.mark.parametrize(("seed", "times"), [(0, 1), MANY])
def test_muscle_files(seed, times):
    check_muscles(seed, 400 * times)


@pytest.mark.parametrize(("seed", "times"), [(0, 1), MANY])
def test_task_files(seed, times):
    check_tasks(seed, 200 * times)


@pytest.mark.parametrize(
    "text",
    [
        'format = 1\n"" = 1', f"format = {'1' * 5000}", f"a = 1\nformat = 0x{'f' * 9000}",
        f"format = {'1' * 4300}", "format = 9223372036854775808", "a." * 20000 + "a = 1",
        "format = 1\nx = 1987-13-99", '[muscle.material]\n"(plain)" = 1',
    ],
)  # fmt: skip
def test_what_a_hostile_trial_found(text):
    for function in (loads, loads_task):
        with refuses_at("x.toml: "):
            function(text, "x.toml")


@pytest.mark.parametrize("count", [2**63 - 1, 2**63, 2**64, 10**4000, -1, 0])
def test_counts_that_nobody_builds(count):
    text = example_text("kim2021_bundle_1_4").replace("count = 4", f"count = {count}")
    with refuses_at("x.toml: bundle.motor_unit"):
        loads(text, "x.toml")
