"""Invalid tasks, spaces, searches and cycles are refused with the argument's name."""

import numpy as np
import pytest

from fascicle.core.errors import InvalidInputError
from fascicle.design import Limit, Space, Task, search
from fascicle.design.cycle import Cycle


ONE, EMPTY = {"valves": "min"}, Limit(2.0, 1.0)


def points(make=Task.of, **changed):
    return make(**{"force": [1.0, 2.0], "strain": [0.1, 0.2], "supply_pressure": 4e5} | changed)


def in_time(time):
    return points(Task.in_time, time=time)


CASES = [
    ("force", lambda _: points(force=[-1.0, 1.0])),
    ("weight", lambda _: points(weight=[1.0, np.nan])),
    ("force", lambda _: points(weight=[1.0])),
    ("force", lambda _: points(force=[0.0, 5.0], strain=[0.1, 0.0])),
    ("time", lambda _: in_time([0.0, 0.0])),
    ("time", lambda _: in_time([1.0, 0.0])),
    ("time", lambda _: in_time([0.0])),
    ("muscles", lambda m: Space({"m": m}, (0,))),
    ("muscles", lambda m: Space({"m": m}, (31,))),
    ("radius", lambda m: Space({"m": m}, (3,), radius_rule="packing")),
    ("wall_ratio", lambda m: Space({"m": m}, (3,), wall_ratio=(1.0,))),
    ("unit_factors", lambda m: Space({"m": m}, (18,), unit_factors=(1.0, 2.0, 3.0))),
    ("objectives", lambda m: search(Space({"m": m}, (2,)), points(), {"valve": "min"})),
    ("envelope", lambda m: search(Space({"m": m}, (2,)), points(), ONE, {"envelope": EMPTY})),
    ("per_minute", lambda _: Cycle(0.5, 0.5, 61.0)),
    ("hose_length", lambda _: Cycle(0.5, 0.5, 60.0, -1.0)),
]


@pytest.mark.parametrize(("argument", "call"), CASES)
def test_what_cannot_be_is_refused(muscle, argument, call):
    with pytest.raises(InvalidInputError) as error:
        call(muscle)
    assert error.value.argument == argument
