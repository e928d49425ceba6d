"""The guide only says where to look: with and without it the same is found."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.bundle import recruitment
from fascicle.bundle.recruit import levels
from fascicle.bundle.recruitment import recruit
from unlike import LAWS, SUPPLY, random_bundle


def demands(random: np.random.Generator, one: fs.Bundle, count: int) -> tuple:
    """Forces and strains; many small forces, where states overlap and dip, some out of reach."""
    strain = random.uniform(-0.02, 0.33, count)
    full = np.abs(one.force(np.full(3, SUPPLY), strain))
    size = random.choice([1.0, 0.1, 0.01], count) * np.where(random.random(count) < 0.5, full, 300)
    return random.uniform(-0.3, 1.1, count) * size, strain


@pytest.mark.parametrize(
    ("laws", "scheme", "count"),
    [
        ("plain", "orderly", 400),
        ("plain", "batch", 250),
        ("tuned", "orderly", 250),
        pytest.param("elastica", "orderly", 40, marks=pytest.mark.slow),
        pytest.param("plain", "free", 100, marks=pytest.mark.slow),
        pytest.param("tuned", "batch", 500, marks=pytest.mark.slow),
        pytest.param("elastica", "batch", 200, marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize("resistance", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_what_is_found_is_what_a_look_at_every_stretch_finds(
    monkeypatch, laws, scheme, count, resistance
):
    random = np.random.default_rng(1)
    one = random_bundle(random, **LAWS[laws])
    force, strain = demands(random, one, count)
    guided = recruit(one, force, strain, scheme=scheme, resistance=resistance)
    made = recruitment._bank
    monkeypatch.setattr(recruitment, "_bank", lambda *x: made(*x)._replace(guide=None))
    every = recruit(one, force, strain, scheme=scheme, resistance=resistance)
    assert guided.count.tolist() == every.count.tolist()
    assert guided.status.tolist() == every.status.tolist()
    assert guided.state.tolist() == every.state.tolist()
    assert (every.count > 1).any() or scheme == "free" or not resistance
    assert_allclose(guided.solutions.pressure, every.solutions.pressure, rtol=0, atol=1e-9 * SUPPLY)
    assert guided.solutions.stable.tolist() == every.solutions.stable.tolist()
    assert_allclose(guided.force, every.force, rtol=0, atol=1e-9)


def test_few_demands_are_left_to_the_search(monkeypatch):
    random = np.random.default_rng(2)
    one = random_bundle(random)
    strain = random.uniform(0, 0.25, 500)
    force = random.uniform(0, 1, 500) * one.force(np.full(3, SUPPLY), strain)
    searched = []
    search = levels._searched
    monkeypatch.setattr(
        levels,
        "_searched",
        lambda lanes, some, *x: searched.append(some) or search(lanes, some, *x),
    )
    assert np.all(recruit(one, force, strain).count > 0)
    assert sum(map(len, searched)) < 0.005 * 3 * 500
