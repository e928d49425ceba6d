"""Bundles that many tests share."""

import pytest

import fascicle as fs
from fascicle import dynamics, fluid


SUPPLY = 413.7e3


@pytest.fixture(scope="session")
def plant_of():
    """A plant of a bundle that is held at a `strain`, with air."""

    def make(bundle, strain=0.2, conductance=1e-9, spool=None):
        return dynamics.Plant(
            bundle, dynamics.PrescribedMotion(strain * 0.127), fluid.ConstantSupply(SUPPLY),
            fluid.Isothermal(), fluid.SonicValve(conductance, 0.3), spool=spool,
        )  # fmt: skip

    return make


@pytest.fixture(scope="session")
def muscle():
    """That of figure 6, of the paper's silicone."""
    found = fs.example("kim2021_figure_6")
    return found.replace(material=fs.materials.SILICONE_KIM2021)


@pytest.fixture(scope="session")
def pair(muscle):
    """One muscle and one."""
    return fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle)], SUPPLY)


@pytest.fixture(scope="session")
def five(muscle):
    """One muscle and four."""
    return fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle, 4)], SUPPLY)
