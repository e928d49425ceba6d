"""Laws spelled out for Python's numbers, and those that are asked for often."""

import ast
import math
import re
import warnings
from typing import NamedTuple

import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.core import often
from fascicle.core.arrays import (
    along_table,
    both,
    either,
    exp,
    isfinite,
    maximum,
    minimum,
    no,
    spread,
    sqrt,
    where,
)
from fascicle.core.evaluate import evaluate
from fascicle.core.often import Often
from fascicle.core.operations import FUNCTIONS
from fascicle.core.roots import root
from fascicle.core.spelled import SpellingError, _text, spelled
from fascicle.muscle.quantities import force_of
from fascicle.muscle.tension import TENSION_LAWS


class Both(NamedTuple):
    value: float
    large: bool


def elementwise(part, x, y):
    scale, rows = part
    bent = where(x > y, sqrt(x - where(x > y, y, 0.0)), -exp(y) / scale)
    table = along_table(rows[..., 1:] * where(rows[..., :-1] <= spread(x), spread(x), 0.0))
    held = minimum(maximum(bent, -scale), scale) + x**2 - y**3 + x**0.5
    open_ones = both(isfinite(x), either(x > scale, no(y > scale)))
    return Both(
        held + table + rows[..., 0] + x * 2.5 / 2.5 - (y - 0.0) * 1.0,
        where(open_ones, x > 1.0, False),
    )


PART = (np.float64(3.0), np.array([0.1, 0.7, 1.9, 2.5]))


def test_it_is_what_numpy_says():
    one = spelled(elementwise, PART, 2)
    for x, y in np.random.default_rng(1).uniform(0.0, 4.0, (200, 2)):
        found, wanted = one(float(x), float(y)), elementwise(PART, x, y)
        assert type(found) is Both
        assert type(found.value) is float and type(found.large) is bool
        assert_allclose(found.value, wanted.value, rtol=1e-15)
        assert found.large == wanted.large


def cubic(part, offset):
    def inner(a, x):
        return a - x - x**3, -1 - 3 * x**2

    def outer(theta, x):
        root_of_x = root(inner, x + part, -10.0, 10.0, 0.0)
        return theta - root_of_x - x, -1.0 - 1 / (1 + 3 * root_of_x**2)

    return root(outer, offset, -5.0, 5.0, 0.0)


def test_a_search_within_a_search_is_a_loop_of_its_own():
    one = spelled(cubic, np.float64(0.3), 1)
    for offset in (-2.0, -0.1, 0.0, 0.4, 3.0):
        found = one(offset)
        assert_allclose(found, cubic(np.float64(0.3), np.float64(offset)), rtol=1e-15)
        a = offset - found  # the inner root: a + a³ is found + 0.3
        assert_allclose(a + a**3, found + 0.3, rtol=1e-14, atol=1e-15)


def test_a_search_with_numbers_alone_for_its_bracket():
    def law(part, x):
        return root(lambda theta, y: (theta - y**3, -3 * y**2), part + x, 0.0, 3.0, 1.0)

    assert_allclose(spelled(law, 1.0, 1)(7.0), 2.0, rtol=1e-15)


def test_what_depends_on_the_part_alone_is_worked_out_once():
    def law(part, x):
        return sqrt(part) * x, sqrt(part) + x

    one = spelled(law, np.float64(2.0), 1)
    assert "sqrt" not in one.__code__.co_names
    assert one(3.0) == (math.sqrt(2.0) * 3.0, math.sqrt(2.0) + 3.0)


def test_nobody_asks_for_it_and_nothing_twice():
    calls = []

    def law(part, x):
        root_of_x = sqrt(x)
        calls.append(sqrt(x + part))  # of no use
        return root_of_x + sqrt(x) * root_of_x

    one = spelled(law, 1.0, 1)
    assert one(4.0) == 6.0
    assert sum(name == "sqrt" for name in one.__code__.co_names) == 1
    assert one(0.0) == 0.0


def test_a_root_of_what_is_negative_is_refused():
    with pytest.raises(ValueError, match="domain"):
        spelled(lambda part, x: (x - part) ** 0.5, 3.0, 1)(1.0)


HELD = (
    ast.Module, ast.FunctionDef, ast.arguments, ast.arg, ast.Return, ast.Assign, ast.Tuple,
    ast.Name, ast.Load, ast.Store, ast.Call, ast.IfExp, ast.BinOp, ast.UnaryOp, ast.Compare,
    ast.BoolOp, ast.operator, ast.unaryop, ast.cmpop, ast.boolop,
)  # fmt: skip


@pytest.mark.parametrize("tension", TENSION_LAWS)
def test_what_is_run_holds_operations_alone(tension):
    """No word of a file or a user gets into it: names that are made here, numbers, operators."""
    with warnings.catch_warnings(action="ignore"):  # of other sizes than the law's
        part = fs.example("kim2021_bundle_1_4").motor_units[0].muscle.replace(tension=tension)
    leaves, structure = jax.tree.flatten(part)
    text, _ = _text(force_of, structure, tuple(map(np.shape, leaves)), 2)
    known = {*FUNCTIONS, "inf", "nan", "searched", "kind", "spelled", "point"}
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Constant):
            assert type(node.value) in (float, bool, int)
        else:
            assert isinstance(node, HELD)
        if isinstance(node, ast.Name):
            assert node.id in known or re.fullmatch(r"(residual_v|[cvx])[0-9]+", node.id)


def branching(part, x):
    return part if x > 0 else -part


def own_function(part, x):
    return part + float(x)


def long(part, x):
    for n in range(3000):
        x = (x + part) * (1.0 + 1e-9 * n)
    return x


def several(part, x):
    return part * np.linspace(0.0, 1.0, 3) * x


@pytest.mark.parametrize("law", [branching, own_function, long, several])
def test_what_cant_be_spelled_is_numpys(law):
    for _ in range(2):  # and remembered
        with pytest.raises(SpellingError):
            spelled(law, np.float64(2.0), 1)
    one = Often(law, np.float64(2.0), 1)
    for _ in range(2 * often._PAYS):
        found = one(1.5)
    assert not one.spelled_out()
    assert np.array_equal(found, law(np.float64(2.0), np.float64(1.5)))


def test_rows_of_rows_are_numpys():
    with pytest.raises(SpellingError, match="rows"):
        spelled(elementwise, (1.0, np.ones((2, 3))), 2)


def quotient(part, x):
    return part / x


def test_what_pythons_numbers_refuse_numpy_answers():
    one = Often(quotient, np.float64(1.0), 1)
    for _ in range(2 * often._PAYS):
        assert one(2.0) == 0.5
    assert one.spelled_out()
    with pytest.raises(ZeroDivisionError):
        spelled(quotient, 1.0, 1)(0.0)
    assert one(0.0) == np.inf and one(4.0) == 0.25


def test_parts_that_are_made_alike_are_spelled_once():
    def law(part, x):
        return part * x

    first = Often(law, np.float64(2.0), 1)
    for _ in range(often._PAYS):
        first(1.0)
    assert first.spelled_out()
    second = Often(law, np.float64(3.0), 1)
    assert second.spelled_out() and second(2.0) == 6.0


METHODS = ("force", "stiffness", "free_strain", "collapse_strain", "blocked_force", "volume")


@pytest.mark.parametrize("method", [*METHODS, "response", "deflection", "moment"])
def test_a_muscle_that_is_asked_often_says_the_same(method):
    """To the bit where no exponential is: its `response` past collapse to rounding."""
    muscle = fs.example("kim2021_figure_6")
    point = {"volume": (0.2,)}.get(method, (60e3, 0.21))
    point = point[:1] if method in ("free_strain", "collapse_strain", "blocked_force") else point
    first = getattr(muscle, method)(*point)
    for _ in range(2 * often._PAYS):
        found = getattr(muscle, method)(*point)
    asked = [one for one in muscle.store["often"].values() if one.spelled_out()]
    assert len(asked) == 1
    assert type(found) is type(first)
    assert_allclose(found, first, rtol=1e-14)
    if method == "response":
        assert [type(x) for x in found] == [type(x) for x in first]


def test_arrays_of_one_number_stay_arrays():
    muscle = fs.example("kim2021_figure_6")
    for _ in range(2 * often._PAYS):
        found = muscle.force(np.array([60e3]), 0.2)
    assert found.shape == (1,) and "often" not in muscle.store


def test_single_points_of_what_is_no_number_are_numpys():
    muscle = fs.example("kim2021_figure_6")
    with np.errstate(all="ignore"):
        found = evaluate(lambda part, x: part.length * x, muscle, np.float64(2.0), points=1)
    assert type(found) is np.float64
