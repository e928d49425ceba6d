import jax
import jax.numpy as jnp
import numpy as np
import pytest

from fascicle.core.errors import InvalidInputError
from fascicle.core.validation import (
    broadcast_shape,
    check_choice,
    check_finite,
    check_interval,
    check_positive,
    is_concrete,
)


@pytest.mark.parametrize(
    "value", [3, 3.5, np.float32(2), np.array([1, 2]), jnp.ones(2), [1.0, 2.0]]
)
def test_accepted_values_are_returned_as_float64(value):
    x = check_positive(value, "length", "m")
    assert x.dtype == jnp.float64 and x.shape == np.shape(value)
    assert np.array_equal(x, np.asarray(value, dtype=float))


@pytest.mark.parametrize("value", [0.0, -1, float("nan"), float("inf"), [1.0, -2.0, 3.0]])
def test_positive_names_the_first_bad_value(value):
    with pytest.raises(InvalidInputError) as error:
        check_positive(value, "length", "m")
    assert error.value.argument == "length"
    np.testing.assert_equal(error.value.value, -2.0 if np.ndim(value) else float(value))


@pytest.mark.parametrize("value", [b"3", None, True, 1 + 2j, [[1.0], [1.0, 2.0]], object()])
def test_other_types_are_refused(value):
    with pytest.raises(ValueError, match=r"^`length` takes numbers in m, got "):
        check_positive(value, "length", "m")
    with pytest.raises(ValueError, match=r"^`ratio` takes dimensionless numbers, got "):
        check_finite(value, "ratio", "-")


def test_a_long_refused_array_is_one_line():
    with pytest.raises(InvalidInputError) as error:
        check_finite(np.arange(1000) > 500, "command", "-")
    assert "\n" not in str(error.value) and len(str(error.value)) < 150


@pytest.mark.parametrize(
    ("closed", "good", "bad", "interval"),
    [
        ((False, False), [0.5], [0.0, 1.0], r"\(0, 1\)"),
        ((True, False), [0.0], [1.0], r"\[0, 1\)"),
        ((False, True), [1.0], [0.0], r"\(0, 1\]"),
        ((True, True), [0.0, 1.0], [-1e-9, 1 + 1e-9], r"\[0, 1\]"),
    ],
)
def test_interval_has_open_or_closed_ends(closed, good, bad, interval):
    for value in good:
        assert check_interval(value, 0.0, 1.0, "share", "Pa", "to pull", closed) == value
    for value in [*bad, float("nan")]:
        rule = rf"^`share` must lie in {interval} Pa to pull, got .* Pa\.$"
        with pytest.raises(ValueError, match=rule):
            check_interval(value, 0.0, 1.0, "share", "Pa", "to pull", closed)


def test_nearest_name_is_suggested():
    assert check_choice("latex", {"latex": 1, "rubber": 2}, "material") == "latex"
    with pytest.raises(ValueError, match=r"^`material` 'latx' is unknown: did you mean 'latex'\? "):
        check_choice("latx", {"latex": 1, "rubber": 2}, "material")
    with pytest.raises(ValueError, match=r"is unknown: choose one of latex, rubber\.$"):
        check_choice("qqqqqq", {"latex": 1, "rubber": 2}, "material")


def test_traced_values_are_not_checked():
    def function(x):
        assert not is_concrete(x) and not is_concrete(1.0, [x])
        return (
            check_positive(x, "x", "m")
            + check_interval(x, 0.0, 1.0, "x", "m")
            + check_finite(x, "x", "m")
        )

    assert is_concrete(1.0, np.ones(2), jnp.ones(2))
    assert jax.jit(function)(-2.0) == -6  # a traced value is its caller's own affair


@pytest.mark.parametrize("shapes", [((2,), (3,)), ((4, 2), (3,)), ((1, 2, 1), (2, 3, 1))])
def test_shapes_that_do_not_broadcast_are_named(shapes):
    assert broadcast_shape(pressure=(3, 1), strain=(4,), force=()) == (3, 4)
    first, second = shapes
    with pytest.raises(InvalidInputError) as error:
        broadcast_shape(pressure=first, time=(), strain=second)
    assert error.value.argument == "strain" and "`pressure`" in error.value.rule


@pytest.mark.parametrize(
    ("bad", "low", "high", "texts"),
    [
        (np.nextafter(1e6, 2e6), 0.0, 1e6, ["[0, 1e6]", "1000000.0000000001"]),
        (-0.1923634, -0.1923633, 0.6, ["[-0.1923633, 0.6]", "-0.1923634"]),
        (-1.0, 0.0, 1e6, ["[0, 1e6]", "-1 "]),
    ],
)
def test_a_refused_value_differs_from_its_limit_as_written(bad, low, high, texts):
    with pytest.raises(InvalidInputError) as error:
        check_interval(bad, low, high, "pressure", "Pa", closed=(True, True))
    for text in texts:
        assert text in str(error.value)


def test_masked_elements_are_refused_and_an_empty_mask_is_not():
    masked = np.ma.masked_array([1.0, 2.0], [False, True])
    with pytest.raises(InvalidInputError) as error:
        check_finite(masked, "strain", "-")
    assert error.value.argument == "strain" and "1 masked" in str(error.value)
    unmasked = np.ma.masked_array([1.0, 2.0], [False, False])
    assert np.array_equal(check_finite(unmasked, "strain", "-"), [1.0, 2.0])
