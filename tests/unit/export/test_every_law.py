"""The docs' table of laws: each law has what the table says."""

import importlib.util
from pathlib import Path

import jax
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.muscle import LAWS


SIX = fs.example("kim2021_figure_6")
every_law = pytest.mark.parametrize(
    ("kind", "name"), [(kind, name) for kind, laws in LAWS.items() for name in laws]
)


@pytest.fixture(scope="module")
def abilities():
    """The docs' table by kind and law."""
    path = Path(__file__).parents[3] / "docs" / "_ext" / "laws.py"
    spec = importlib.util.spec_from_file_location("laws_of_docs", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    lines = [[cell.strip() for cell in line.split("|")[1:-1]] for line in
             module.abilities().splitlines()[2:]]  # fmt: skip
    return {(kind.replace(" ", "_"), law.strip("`")): cells for kind, law, *cells in lines}


@pytest.mark.parametrize("name", LAWS["buckling"])
def test_shear_and_braid_share_are_as_the_table_says(name, abilities):
    options = {"shear": "engesser"}, {"braid_share": 0.5}
    for cell, option in zip(abilities["buckling", name][:2], options, strict=True):
        if cell == "yes":
            assert LAWS["buckling"][name](**option) is not None
        else:
            with pytest.raises(TypeError):
                LAWS["buckling"][name](**option)


@pytest.mark.slow
@every_law
def test_second_derivatives_are_those_of_the_first(kind, name):
    """By pressure, pulling and pushing, away from kinks."""
    muscle = SIX.replace(**{kind: name})
    first, h = jax.jit(jax.grad(muscle.force)), 10.0
    second = jax.jit(jax.grad(jax.grad(muscle.force)))
    for P, eps in ((2e5, 0.05), (6e4, 0.2)):
        difference = (first(P + h, eps) - first(P - h, eps)) / (2 * h)
        # differences of slopes of some 1e-4 N/Pa over 20 Pa are exact to 1e-17 or so
        assert_allclose(second(P, eps), difference, rtol=1e-4, atol=1e-14)
