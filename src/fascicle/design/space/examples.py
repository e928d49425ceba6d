"""Named tasks. All figures are made up: shapes as such motions have, scaled to bundles of a
handful of half-inch muscles. None was measured, and none should be cited as if it were.
"""

import numpy as np

from ...core.validation import check_choice
from .task import Task


_MADE_UP = "made up, no measurement"


def sit_to_stand_knee(supply_pressure: float = 413.7e3) -> Task:
    """A knee that rises from a seat: most force at the start, less as the leg straightens.

    **Arguments:** `supply_pressure`: the supply's [Pa].

    **Returns:** the task [-]; its figures are made up.
    """
    time = np.linspace(0.0, 1.5, 16)  # s
    done = np.sin(0.5 * np.pi * time / time[-1]) ** 2  # share of the way
    force = 80.0 + 420.0 * (1 - done) ** 1.5
    return _in_time("sit_to_stand_knee", time, force, 0.02 + 0.16 * done, supply_pressure)


def pick_and_place_arm(supply_pressure: float = 413.7e3) -> Task:
    """An arm that lifts loads of three sizes to three heights, mostly small ones.

    **Arguments:** `supply_pressure`: the supply's [Pa].

    **Returns:** the task [-]; its figures are made up.
    """
    force = np.repeat([60.0, 150.0, 280.0], 3)
    strain = np.tile([0.06, 0.11, 0.16], 3) - np.repeat([0.0, 0.01, 0.03], 3)
    weight = np.repeat([6.0, 3.0, 1.0], 3)
    name, source = "pick_and_place_arm", _MADE_UP
    return Task.of(force, strain, supply_pressure, weight, name=name, source=source)


def walking_ankle(supply_pressure: float = 413.7e3) -> Task:
    """An ankle over one stride: the load builds up, pushes off, and the foot swings.

    **Arguments:** `supply_pressure`: the supply's [Pa].

    **Returns:** the task [-]; its figures are made up.
    """
    time = np.linspace(0.0, 1.1, 23)  # s
    s = time / time[-1]
    force = 20.0 + 430.0 * np.exp(-(((s - 0.48) / 0.12) ** 2)) + 60.0 * np.exp(-((s / 0.2) ** 2))
    strain = 0.03 + 0.11 / (1 + np.exp(-(s - 0.55) / 0.035)) * np.exp(-(((s - 0.6) / 0.3) ** 2))
    return _in_time("walking_ankle", time, force, strain, supply_pressure)


TASKS = {
    "sit_to_stand_knee": sit_to_stand_knee,
    "pick_and_place_arm": pick_and_place_arm,
    "walking_ankle": walking_ankle,
}


def example_task(name: str, supply_pressure: float = 413.7e3) -> Task:
    """A named task.

    **Arguments:**

    - `name`: a key of `TASKS` [-].
    - `supply_pressure`: the supply's [Pa].

    **Returns:** the task [-]; its figures are made up.

    **Raises:** `ValueError` for an unknown name; the nearest is suggested.
    """
    return TASKS[check_choice(name, TASKS, "example")](supply_pressure)


def _in_time(
    name: str, time: np.ndarray, force: np.ndarray, strain: np.ndarray, supply_pressure: float
) -> Task:
    return Task.in_time(time, force, strain, supply_pressure, name=name, source=_MADE_UP)
