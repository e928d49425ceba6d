"""Plants that many tests share, since each kind of plant is compiled once."""

import numpy as np
import pytest

import fascicle as fs
from fascicle import dynamics, fluid


SUPPLY = 413.7e3


@pytest.fixture(scope="session")
def muscle():
    """That of figure 6."""
    return fs.example("kim2021_figure_6")


@pytest.fixture(scope="session")
def air():
    """Parts of a plant of two units that are filled with air."""
    return {
        "supply": fluid.ConstantSupply(SUPPLY),
        "chamber": fluid.AdiabaticWall(0.5, dead_volume=np.array([2e-6, 8e-6])),
        "valve": fluid.SonicValve(2e-9, 0.3),
    }


@pytest.fixture(scope="session")
def bundle(muscle):
    """One muscle, and four."""
    return fs.Bundle([fs.MotorUnit(muscle, 1), fs.MotorUnit(muscle, 4)])


@pytest.fixture(scope="session")
def lift(bundle, air):
    """A mass on a bundle of real muscles, air, valves that are where commands are."""
    return dynamics.Plant(bundle, dynamics.HangingMass(12.0, damping=300.0), **air)


@pytest.fixture(scope="session")
def ideal(muscle, air):
    """The same with ideal muscles, whose table is exact where none buckles."""
    mesh = muscle.replace(tension="ideal")
    bundle = fs.Bundle([fs.MotorUnit(mesh, 1), fs.MotorUnit(mesh, 4)])
    return dynamics.Plant(bundle, dynamics.HangingMass(12.0, damping=300.0), **air)
