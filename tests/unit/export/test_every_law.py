"""The docs' table of laws: each law is written in C if the table says so."""

import importlib.util
from pathlib import Path

import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.export import c_code
from fascicle.export.point_function import compile_muscle_force
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


@every_law
def test_c_is_written_as_the_table_says(kind, name, abilities):
    muscle = SIX.replace(**{kind: name})
    if abilities[kind, name][0] == "yes":
        assert "muscle_force" in c_code(muscle)[1]
    else:
        with pytest.raises(fs.InvalidInputError) as error:
            c_code(muscle)
        assert "--table" in error.value.remedy


@pytest.mark.filterwarnings("ignore:`martens2017` was fitted to")
def test_a_muscle_that_never_stops_pulling_is_the_same_in_c():
    muscle = fs.Muscle(0.25, 0.01, 1.8e-3, np.radians(38), tension="martens2017")
    force = compile_muscle_force(muscle)
    for strain in (0.2, 0.31, 0.35):  # its mesh pushes beyond 0.32
        # both end at the same strain, to rounding
        assert force(2e5, strain) == pytest.approx(float(muscle.force(2e5, strain)), rel=1e-12)


@pytest.mark.parametrize("name", LAWS["buckling"])
def test_shear_and_braid_share_are_as_the_table_says(name, abilities):
    options = {"shear": "engesser"}, {"braid_share": 0.5}
    for cell, option in zip(abilities["buckling", name][2:4], options, strict=True):
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
