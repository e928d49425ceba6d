"""A joint that tests of its inverse share, in Python and in C."""

import math

import pytest

import fascicle as fs


@pytest.fixture(scope="session")
def thick():
    return fs.Muscle(0.3, 20e-3, 2e-3, math.radians(25), "latex")


@pytest.fixture(scope="session")
def joint(thick):
    return fs.Joint(thick, thick, 0.05, strain=0.12)
