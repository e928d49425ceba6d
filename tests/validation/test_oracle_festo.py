"""Laws published for Festo's muscles, against their formulas in their own units."""

import math

import jax
import numpy as np
import oracle_festo
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.design.designs import Designs
from fascicle.muscle.tension import TENSION_LAWS
from refusing import refuses


MADE = {name: law for name, law in TENSION_LAWS.items() if law.reference_muscle}
WALL, ANGLE = 1.8e-3, math.radians(28.6)


def muscle(name, bore=0.010, length=0.25, **laws):
    return fs.Muscle(length, bore / 2 + WALL, WALL, ANGLE, tension=MADE[name](), **laws)


def test_numbers_asked_for():
    assert_allclose(muscle("martens2017").force(400e3, 1 - 0.23 / 0.25), 81.280215, atol=5e-7)
    assert_allclose(muscle("sarosi").force(3e5, 0.1), 332.010007, atol=5e-7)


@pytest.mark.parametrize("name", oracle_festo.SAROSI)
def test_sarosi(name):
    for bar in (0.5, 2.0, 6.0):
        for percent in (-1.0, 0.0, 3.0, 10.0):
            expected = oracle_festo.sarosi(name, bar, percent)
            found = MADE[name]().components(muscle(name).bladder, bar * 1e5, percent / 100)
            assert_allclose(sum(found), expected, rtol=1e-12, atol=1e-10)


@pytest.mark.parametrize("name", oracle_festo.MARTENS)
def test_martens(name):
    *_, bore, length = oracle_festo.MARTENS[name]
    made = muscle(name, bore, length)
    for P in (5e4, 3e5, 6.5e5):
        for strain in (0.0, 0.02, 0.08):
            expected = oracle_festo.martens(name, P, length * (1 - strain))
            pull = made.law.tension.pull(P, strain)
            assert_allclose(pull.force, expected, rtol=1e-12, atol=1e-10)


@pytest.mark.parametrize("name", oracle_festo.BOLEN)
def test_bolen(name):
    law = MADE[name]()
    for length in (0.1, 0.25, 0.45):
        made = muscle(name, length=length)
        for kPa in (0.0, 200.0, 620.0):
            for strain in (0.0, 0.05, 0.12):
                expected = oracle_festo.bolen(name, kPa, strain, law.largest_strain, length)
                found = made.law.tension.pull(1e3 * kPa, strain).force
                assert_allclose(found, expected, rtol=1e-11, atol=1e-10)


def test_bolens_short_muscles_hold_less():
    forces = [float(muscle("bolen", length=L).blocked_force(620e3)) for L in (0.083, 0.2, 0.382)]
    assert forces[0] < forces[1] < forces[2]


STRAINS = np.linspace(-0.05, 0.5, 111)
PRESSURES = np.array([0.0, 5e4, 2e5, 6e5, 1e6])


@pytest.mark.parametrize(
    ("name", "buckling"),
    [
        *((name, "kim2021") for name in MADE),
        *(pytest.param(name, "elastica", marks=pytest.mark.slow) for name in MADE),
    ],
)
def test_they_are_laws_of_a_muscle(name, buckling):
    """Components, sign, continuity and slopes, for muscles of the maker's geometry."""
    made = muscle(name, 0.02 if "20" in name else 0.01, buckling=buckling)
    for P in PRESSURES:
        free = made.free_strain(P)
        found = made.response(P, STRAINS)
        assert np.all(np.isfinite(found.force))
        assert_allclose(found.mesh + found.bladder + found.bending, found.force, atol=1e-9)
        assert np.all(found.force[free + 1e-9 < STRAINS] <= 1e-9)
        assert np.all(found.force[free - 1e-9 > STRAINS] >= -1e-9)
        if buckling == "kim2021":
            # steps of 1e-9, slopes up to 1e5 N in extension
            apart = made.force(P, STRAINS + 1e-9) - found.force
            assert np.all(np.abs(apart) < 1e-3)
        pull = made.law.tension.pull(P, STRAINS)
        step = 1e-6
        near = [made.law.tension.pull(P, STRAINS + side * step).force for side in (-1, 1)]
        measured = (near[1] - near[0]) / (2 * step)
        assert_allclose(pull.slope, measured, rtol=1e-4, atol=1e-2)
    slopes = jax.jit(jax.grad(lambda muscle, P: muscle.force(P, 0.05)))
    for P in PRESSURES:
        assert all(np.all(np.isfinite(leaf)) for leaf in jax.tree.leaves(slopes(made, P)))


@pytest.mark.parametrize("name", MADE)
def test_designs_refuse_it(name):
    with refuses("tension"):
        Designs.of(muscle(name), [[1, 2]])


@pytest.mark.parametrize("name", MADE)
def test_files_and_fits_know_it(name, tmp_path):
    made = muscle(name)
    fs.save(made, tmp_path / "m.toml")
    assert f'tension = "{name}"' in (tmp_path / "m.toml").read_text()
    assert fs.load(tmp_path / "m.toml") == made
    law, first = MADE[name](), MADE[name].constants()[0]
    other = made.replace(tension=MADE[name](**{first.name: 1.01 * getattr(law, first.name)}))
    fs.save(other, tmp_path / "other.toml")
    assert fs.load(tmp_path / "other.toml") == other
