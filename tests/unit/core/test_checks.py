import jax
import jax.numpy as jnp
import numpy as np
import pytest

from fascicle.core.validation import (
    check_choice,
    check_finite,
    check_interval,
    check_positive,
    is_concrete,
)


@pytest.mark.parametrize(
    "value", [3, 3.5, np.float32(2), np.array([1, 2]), jnp.ones(2), [1.0, 2.0]]
)
def test_accepted_values_come_back_as_float64(value):
    kept = check_positive(value, "length", "m")
    assert kept.dtype == jnp.float64 and kept.shape == np.shape(value)
    assert np.array_equal(kept, np.asarray(value, dtype=float))


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (0.0, "got 0 m."),
        (-1, "got -1 m."),
        (float("nan"), "got nan m."),
        (float("inf"), "got inf m."),
        ([1.0, -2.0, 3.0], "got -2 m."),
    ],
)
def test_positive_names_the_first_bad_value(value, words):
    with pytest.raises(ValueError, match=r"^`length` must be positive and finite, ") as caught:
        check_positive(value, "length", "m")
    assert str(caught.value).endswith(words)


@pytest.mark.parametrize("value", [b"3", None, True, 1 + 2j, [[1.0], [1.0, 2.0]], object()])
def test_what_is_no_number_is_refused(value):
    with pytest.raises(ValueError, match=r"^`length` takes numbers in m, got "):
        check_positive(value, "length", "m")
    with pytest.raises(ValueError, match=r"^`ratio` takes dimensionless numbers, got "):
        check_finite(value, "ratio", "-")


@pytest.mark.parametrize(
    ("closed", "good", "bad", "interval"),
    [
        ((False, False), [0.5], [0.0, 1.0], r"\(0, 1\)"),
        ((True, False), [0.0], [1.0], r"\[0, 1\)"),
        ((False, True), [1.0], [0.0], r"\(0, 1\]"),
        ((True, True), [0.0, 1.0], [-1e-9, 1 + 1e-9], r"\[0, 1\]"),
    ],
)
def test_within_holds_its_ends(closed, good, bad, interval):
    for value in good:
        assert check_interval(value, 0.0, 1.0, "share", "Pa", closed=closed) == value
    for value in [*bad, float("nan")]:
        with pytest.raises(ValueError, match=rf"^`share` must lie in {interval} Pa, got .* Pa\.$"):
            check_interval(value, 0.0, 1.0, "share", "Pa", closed=closed)


def test_within_says_why():
    with pytest.raises(ValueError, match=r"must lie in \(0, 1\) rad to contract, got 2 rad\.$"):
        check_interval(2.0, 0.0, 1.0, "angle", "rad", "to contract")


def test_finite_takes_any_sign():
    assert check_finite(-3.0, "slope", "1/Pa") == -3
    with pytest.raises(ValueError, match="`slope` must lie in"):
        check_finite(float("inf"), "slope", "1/Pa")


def test_nearest_name_is_suggested():
    assert check_choice("latex", {"latex": 1, "rubber": 2}, "material") == "latex"
    with pytest.raises(ValueError, match=r"^`material` 'latx' is unknown: did you mean 'latex'\? "):
        check_choice("latx", {"latex": 1, "rubber": 2}, "material")
    with pytest.raises(ValueError, match=r"is unknown: choose one of latex, rubber\.$"):
        check_choice("qqqqqq", {"latex": 1, "rubber": 2}, "material")


def test_traced_values_pass_unseen():
    def inside(x):
        assert not is_concrete(x) and not is_concrete(1.0, [x])
        return (
            check_positive(x, "x", "m")
            + check_interval(x, 0.0, 1.0, "x", "m")
            + check_finite(x, "x", "m")
        )

    assert is_concrete(1.0, np.ones(2), jnp.ones(2))
    assert jax.jit(inside)(-2.0) == -6  # a traced value is its caller's own affair
