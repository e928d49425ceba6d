"""Bundles that many tests share."""

import pytest

import fascicle as fs


SUPPLY = 413.7e3


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
