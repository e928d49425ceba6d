import math

import pytest

import fascicle as fs
from fascicle.design import Task


@pytest.fixture(scope="session")
def muscle():
    return fs.Muscle(0.127, 6.35e-3, 1.6e-3, math.radians(33), "silicone_kim2021")


@pytest.fixture(scope="session")
def task():
    """Four points: the last is beyond what five muscles give."""
    return Task.of([40.0, 150.0, 300.0, 2e3], [0.2, 0.1, 0.05, 0.02], 413.7e3, [1, 2, 1, 1])
