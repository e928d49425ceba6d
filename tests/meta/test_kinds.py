"""Annotations are checks here, once for each kind of call."""

from typing import Literal

import beartype
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import TypeCheckError

import fascicle as fs
import kinds
from fascicle.core.types import Batch, BatchLike
from kinds import checked_once, kind


def checked(function):
    return checked_once(function, typechecker=beartype.beartype)


@pytest.fixture
def total():
    @checked
    def total(x: BatchLike, y: BatchLike, how: Literal["plain", "odd"] = "plain") -> Batch:
        return np.zeros(3, int) if how == "odd" else x + y

    return total


ROW, SQUARE = np.ones(3), np.ones((2, 2))


@pytest.mark.parametrize("passed", [0, 2])
@pytest.mark.parametrize(
    "wrong", [(ROW, SQUARE), (ROW, "1"), (ROW, ROW > 0), (ROW, ROW, "even"), (ROW, ROW, "odd")]
)
def test_another_kind_of_call_is_checked_after_others_have_passed(total, wrong, passed):
    for _ in range(passed):
        total(ROW, ROW)
        total(ROW, 1.0)
    with pytest.raises(TypeCheckError):
        total(*wrong)
    with pytest.raises(TypeCheckError):
        total(*wrong)


def test_what_is_named_is_checked_too(total):
    assert np.all(total(ROW, y=ROW) == 2)
    with pytest.raises(TypeCheckError):
        total(ROW, y=SQUARE)


def test_another_kind_of_result_is_checked():
    answers = iter([1.0, 2.0, jnp.ones(2), "three"])

    @checked
    def answer(x: float) -> float:
        return next(answers)

    assert (answer(0.0), answer(0.0)) == (1.0, 2.0)
    for _ in range(2):
        with pytest.raises(TypeCheckError):
            answer(0.0)


def test_a_tests_first_calls_are_looked_at_then_some(total, monkeypatch):
    monkeypatch.setattr(kinds, "_THEN", 16)
    for _ in range(63):
        total(ROW, ROW)
    with pytest.raises(TypeCheckError):
        total(ROW, SQUARE)
    refused = 0
    for _ in range(160):
        try:
            total(ROW, ROW > 0)
        except TypeCheckError:
            refused += 1
    assert refused == 10
    kinds.begin()
    with pytest.raises(TypeCheckError):
        total(ROW, ROW > 0)
    kinds.look_at_each()
    for _ in range(100):
        with pytest.raises(TypeCheckError):
            total(ROW, ROW > 0)


def test_a_kind_is_all_that_an_annotation_tells_apart():
    assert kind((ROW, {"a": [1.0]})) == kind((2 * ROW, {"a": [2.0]}))
    apart = [ROW, ROW > 0, SQUARE, jnp.ones(3), [1.0], (1.0,), [1], {1.0}, {1}, {"a": 1}, {"b": 1},
             {"a": "b"}, 1, 1.0, np.float64(1), True, None, "a", "b", float, int]  # fmt: skip
    assert len({kind(one) for one in apart}) == len(apart)


def test_the_package_is_checked():
    muscle = fs.example("kim2021_figure_6")
    for _ in range(2):
        assert muscle.braid.volume(0.1) > 0
        with pytest.raises(TypeCheckError):
            muscle.braid.volume("0.1")
