from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.core import evaluate as _evaluate
from fascicle.core.arrays import sin, where
from fascicle.core.evaluate import evaluate
from fascicle.core.modules import Module


class Spring(Module):
    """A number and a row of them."""

    a: float
    row: np.ndarray


class Answer(NamedTuple):
    """Numbers, and what has no slopes."""

    value: np.ndarray
    falls: np.ndarray


def law(spring, x):
    value = spring.a**2 * sin(x) + sum(spring.row[..., i] * x**i for i in range(3))
    return Answer(value, value < 0)


SPRING = Spring(np.float64(0.7), np.array([0.2, -1.0, 0.4]))
X = np.linspace(-1.0, 2.0, 4)


def answer(spring, x, points=4):
    return evaluate(law, spring, x, points=points)


@pytest.fixture
def no_compiler(monkeypatch):
    """A law that is compiled fails."""

    def refused(*_, **__):
        raise AssertionError("compiled")

    monkeypatch.setattr(_evaluate, "compiled", lambda *_: refused)


@pytest.mark.parametrize(
    "slopes",
    [
        jax.jacfwd(lambda *of: answer(*of).value, (0, 1)),
        jax.jacrev(lambda *of: answer(*of).value, (0, 1)),
        jax.grad(lambda *of: jnp.sum(answer(*of).value ** 2), (0, 1)),
        lambda *of: jax.jvp(answer, of, (SPRING, X**2)),
        lambda *of: jax.linearize(answer, *of)[1](SPRING, X**2),
    ],
    ids=["jacfwd", "jacrev", "grad", "jvp", "linearize"],
)
def test_derivatives_are_the_compiled_ones(slopes):
    at_once, compiled = (
        jax.tree.leaves(slopes(SPRING, X)),
        jax.tree.leaves(jax.jit(slopes)(SPRING, X)),
    )
    assert len(at_once) == len(compiled)
    for one, other in zip(at_once, compiled, strict=True):
        if one.dtype == float:
            assert_allclose(one, other, rtol=1e-13, atol=1e-15)


def test_first_derivatives_need_no_compiler(no_compiler):
    value, slope = jax.value_and_grad(lambda x: jnp.sum(answer(SPRING, x).value))(X)
    assert_allclose(slope, 0.49 * np.cos(X) - 1 + 0.8 * X)
    assert_allclose(value, np.sum(law(SPRING, X).value))


def test_second_derivatives_are_right():
    curvature = jax.hessian(lambda x: answer(SPRING, x).value)(0.3)
    assert_allclose(curvature, -0.49 * np.sin(0.3) + 0.8)
    assert_allclose(jax.jacfwd(jax.grad(lambda x: answer(SPRING, x).value))(0.3), curvature)


def test_rows_under_vmap_and_many_numbers_are_compiled(no_compiler):
    with pytest.raises(AssertionError, match="compiled"):
        jax.vmap(jax.grad(lambda x: answer(SPRING, x).value))(X)
    with pytest.raises(AssertionError, match="compiled"):
        jax.jacfwd(lambda x: answer(SPRING, x, points=50_000).value)(X)


def test_what_a_muscle_and_a_bundle_do_is_differentiated_at_once(no_compiler):
    muscle = fs.example("kim2021_figure_6")
    by = jax.grad(lambda m: m.force(1e5, 0.2))(muscle)
    step = 1e-6 * muscle.length
    longer, shorter = (muscle.replace(length=muscle.length + side) for side in (step, -step))
    expected = (longer.force(1e5, 0.2) - shorter.force(1e5, 0.2)) / (2 * step)
    assert_allclose(by.length, expected, rtol=1e-6)
    stiffness = -jax.grad(muscle.force, 1)(1e5, 0.2) / muscle.length
    assert_allclose(stiffness, muscle.stiffness(1e5, 0.2), rtol=1e-12)
    bundle = fs.Bundle([fs.MotorUnit(muscle, 1), fs.MotorUnit(muscle, 4)])
    P, dP = np.array([1e5, 2e5]), np.array([0.0, 10.0])
    free = jax.grad(bundle.free_strain)(P)
    change = (bundle.free_strain(P + dP) - bundle.free_strain(P - dP)) / 20
    assert_allclose(free[1], change, rtol=1e-6)
    mesh = jax.grad(lambda m: m.response(1e5, 0.2).mesh)(muscle)
    assert mesh.tuning.pressures.shape == (1,) and mesh.length != 0


def test_a_kink_takes_the_side_that_the_law_takes():
    """Of `where`, the branch that isn't taken may be infinite."""

    def kinked(part, x):
        return where(x > 0, part.a * x, 0.0) + where(x > 0, 1 / where(x > 0, x, 1.0), 1.0)

    slope = jax.grad(lambda x: evaluate(kinked, SPRING, x, points=1))(0.0)
    assert slope == 0
