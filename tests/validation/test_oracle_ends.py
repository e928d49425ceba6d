"""Ends that take length and give, against an oracle that bisects and integrates."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import oracle_ends
import pytest
from from_oracle import library_muscle
from numpy.testing import assert_allclose
from oracle_random import random_cases

import fascicle as fs
from fascicle.muscle.ends import Compliant
from refusing import refuses


def cases(count, seed):
    """Random muscles with ends, at pressures and strains up to their free ones."""
    rng = np.random.default_rng(seed)
    for muscle in (case.muscle for case in random_cases(seed, count)):
        ends = (rng.uniform(0.0, 0.2) * muscle.length, rng.uniform(0.0, 4e-5))
        library = library_muscle(muscle).replace(ends=Compliant(*ends))
        P = rng.uniform(2e4, 1e6)
        low = -0.3 * (1 / math.cos(muscle.braid_angle) - 1)
        strain = low + rng.uniform(0.0, 1.0) * (float(library.free_strain(P)) - low)
        yield muscle, library, ends, P, strain


def test_the_force_is_the_oracles():
    for muscle, library, ends, P, strain in cases(150, 1):
        expected = oracle_ends.force(muscle, P, strain, *ends)
        # strains are bisected to 1e-15, forces of 1e3 N and slopes of 1e5 N
        assert_allclose(library.force(P, strain), expected, rtol=1e-10, atol=1e-9)


def test_the_volume_is_that_of_the_oracles_energy():
    conjugate_volume = jax.jit(fs.Muscle.conjugate_volume)
    for muscle, library, ends, P, strain in cases(12, 2):
        # by JAX: NumPy's is a difference quotient, exact to 1e-9
        swept = conjugate_volume(library, P, strain) - library.volume(0.0)
        expected = oracle_ends.volume_swept(muscle, P, strain, *ends)
        # quadrature to 1e-13 J over 50 Pa
        assert_allclose(swept, expected, rtol=1e-6, atol=1e-13)
        # and the braid's own, of the part that contracts
        y = oracle_ends.bladder_strain(muscle, P, strain, *ends)
        active = 1 - ends[0] / muscle.length
        braid = library.braid.volume(y) - library.braid.volume(0.0)
        assert_allclose(swept, active * braid, rtol=1e-9, atol=1e-15)


MUSCLE = fs.Muscle(0.25, 6.8e-3, 1.8e-3, math.radians(28.6))
GRID = np.array([0.0, 5e4, 3e5, 8e5])[:, None], np.linspace(-0.1, 0.55, 80)


def neutral_and_rigid(buckling):
    """A muscle whose ends neither take length nor give, and one of rigid ends."""
    rigid = MUSCLE.replace(buckling=buckling)
    return rigid.replace(ends=Compliant(0.0, 0.0)), rigid


@pytest.mark.parametrize("buckling", ["kim2021", "elastica"])
def test_neither_length_nor_give_is_the_muscle_of_rigid_ends(buckling):
    neutral, rigid = neutral_and_rigid(buckling)
    for mine, theirs in zip(neutral.response(*GRID), rigid.response(*GRID), strict=True):
        assert np.array_equal(mine, theirs)
    assert np.array_equal(neutral.collapse_strain(GRID[0]), rigid.collapse_strain(GRID[0]))


@pytest.mark.slow  # JAX compiles a conjugate volume for each law: for an elastica half a minute
@pytest.mark.parametrize("buckling", ["kim2021", "elastica"])
def test_nor_has_it_another_volume(buckling):
    neutral, rigid = neutral_and_rigid(buckling)
    P, eps = jnp.asarray(3e5), np.linspace(-0.05, 0.5, 12)
    assert_allclose(neutral.conjugate_volume(P, eps), rigid.conjugate_volume(P, eps), rtol=1e-14)


def test_one_compliance_tells_short_muscles_from_long_ones():
    """As measured: muscles of one kind, one pressure, blocked at unlike lengths."""
    ends = Compliant(0.0, 2e-5)
    blocked = [
        float(MUSCLE.replace(length=L, ends=ends).blocked_force(6e5)) for L in (0.08, 0.2, 0.4)
    ]
    rigid = [float(MUSCLE.replace(length=L).blocked_force(6e5)) for L in (0.08, 0.2, 0.4)]
    assert blocked[0] < blocked[1] < blocked[2] < rigid[2]
    assert_allclose(rigid, rigid[0], rtol=1e-12)


@pytest.mark.slow
def test_a_cycle_makes_no_energy():
    """Round a rectangle of pressure and strain: what pressure gives, the ends take."""
    muscle = MUSCLE.replace(ends=Compliant(0.02, 3e-5), buckling="elastica")
    node, weight = np.polynomial.legendre.leggauss(40)
    P, eps = (1e5, 4e5), (0.02, 0.12)
    along = lambda ends: sum(ends) / 2 + (ends[1] - ends[0]) / 2 * node  # noqa: E731
    pulled = [
        np.sum(weight * muscle.force(p, along(eps))) * (eps[1] - eps[0]) / 2 * 0.25 for p in P
    ]
    filled = [
        np.sum(weight * muscle.conjugate_volume(jnp.asarray(along(P)), e)) * (P[1] - P[0]) / 2
        for e in eps
    ]
    # co-energy: its change around the rectangle is none
    assert_allclose(pulled[1] - pulled[0], filled[1] - filled[0], rtol=1e-9)


@pytest.mark.slow
def test_a_table_of_it_holds_the_same_energy():
    muscle = MUSCLE.replace(ends=Compliant(0.01, 2e-5))
    table = muscle.table(6e5, shape=(61, 81))
    P, eps = np.array([1.1e5, 3.3e5, 5.2e5]), np.array([0.02, 0.07, 0.11])
    assert_allclose(table.force(P, eps), muscle.force(P, eps), rtol=2e-3)
    assert_allclose(table.conjugate_volume(P, eps), muscle.conjugate_volume(P, eps), rtol=1e-3)


def test_what_ends_cannot_be():
    with refuses("inactive_length"):
        MUSCLE.replace(ends=Compliant(0.1, 0.0))
    with refuses("end_compliance"):
        Compliant(0.0, -1e-6)
    # the bladder's fibers are straight sooner than the ends tell
    muscle = MUSCLE.replace(ends=Compliant(0.06, 0.0))
    lowest = 1 - 1 / math.cos(math.radians(28.6))
    with refuses("strain"):
        muscle.force(1e5, lowest * 0.9)
    assert np.isfinite(muscle.force(1e5, lowest * 0.75))


def test_files_write_it_and_leave_rigid_ends_unsaid(tmp_path):
    muscle = MUSCLE.replace(ends=Compliant(0.012, 2.5e-5))
    fs.save(muscle, tmp_path / "m.toml")
    text = (tmp_path / "m.toml").read_text()
    lines = ('law = "compliant"', 'inactive_length = "12 mm"', 'end_compliance = "25 mm/kN"')
    assert "\n".join(["[muscle.ends]", *lines]) in text
    assert fs.load(tmp_path / "m.toml") == muscle
    fs.save(MUSCLE, tmp_path / "rigid.toml")
    assert "ends" not in (tmp_path / "rigid.toml").read_text()
    assert "compliant: inactive length 12 mm, end compliance 25 mm/kN" in str(muscle)
    assert "rigid" not in str(MUSCLE)
