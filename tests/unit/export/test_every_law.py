"""What the docs' table of laws says: each can be written in C, or says that it can't."""

import importlib.util
from pathlib import Path

import jax
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.export import c_code
from fascicle.muscle import LAWS


EVERY = [(kind, name) for kind, laws in LAWS.items() for name in laws]
SIX = fs.example("kim2021_figure_6")
every = pytest.mark.parametrize(("kind", "name"), EVERY)


def rows():
    """The docs' table by kind and law."""
    path = Path(__file__).parents[3] / "docs" / "_ext" / "laws.py"
    spec = importlib.util.spec_from_file_location("laws_of_docs", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    lines = [[cell.strip() for cell in line.split("|")[1:-1]] for line in
             module.abilities().splitlines()[2:]]  # fmt: skip
    return {(kind.replace(" ", "_"), law.strip("`")): cells for kind, law, *cells in lines}


TOLD = rows()


@every
def test_c_is_written_where_the_table_says_so(kind, name):
    muscle = SIX.replace(**{kind: name})
    if TOLD[kind, name][0] == "yes":
        assert "muscle_force" in c_code(muscle)[1]
        return
    with pytest.raises(ValueError, match=r"can't be written in C.*--table"):
        c_code(muscle)


@pytest.mark.parametrize("name", LAWS["buckling"])
def test_shear_and_braid_share_are_where_the_table_says_so(name):
    asked = {"shear": "engesser"}, {"braid_share": 0.5}
    for cell, given in zip(TOLD["buckling", name][2:4], asked, strict=True):
        if cell == "yes":
            assert LAWS["buckling"][name](**given) is not None
        else:
            with pytest.raises(TypeError):
                LAWS["buckling"][name](**given)


@pytest.mark.slow
@every
def test_second_derivatives_are_those_of_the_first(kind, name):
    """By pressure, pulling and pushing, away from kinks."""
    muscle = SIX.replace(**{kind: name})
    first, h = jax.jit(jax.grad(muscle.force)), 10.0
    second = jax.jit(jax.grad(jax.grad(muscle.force)))
    for P, eps in ((2e5, 0.05), (6e4, 0.2)):
        measured = (first(P + h, eps) - first(P - h, eps)) / (2 * h)
        # differences of slopes of some 1e-4 N/Pa over 20 Pa are known to 1e-17 or so
        assert_allclose(second(P, eps), measured, rtol=1e-4, atol=1e-14)
