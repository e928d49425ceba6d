import jax
import jax.numpy as jnp
import numpy as np
import pytest

from fascicle.core.checks import concrete, finite, one_of, positive, within


@pytest.mark.parametrize(
    "value", [3, 3.5, np.float32(2), np.array([1, 2]), jnp.ones(2), [1.0, 2.0]]
)
def test_accepted_values_come_back_as_float64(value):
    kept = positive(value, "length", "m")
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
        positive(value, "length", "m")
    assert str(caught.value).endswith(words)


@pytest.mark.parametrize("value", [b"3", None, True, 1 + 2j, [[1.0], [1.0, 2.0]], object()])
def test_what_is_no_number_is_refused(value):
    with pytest.raises(ValueError, match=r"^`length` takes numbers in m, got "):
        positive(value, "length", "m")
    with pytest.raises(ValueError, match=r"^`ratio` takes dimensionless numbers, got "):
        finite(value, "ratio", "-")


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
        assert within(value, 0.0, 1.0, "share", "Pa", closed=closed) == value
    for value in [*bad, float("nan")]:
        with pytest.raises(ValueError, match=rf"^`share` must lie in {interval} Pa, got .* Pa\.$"):
            within(value, 0.0, 1.0, "share", "Pa", closed=closed)


def test_within_says_why():
    with pytest.raises(ValueError, match=r"must lie in \(0, 1\) rad to contract, got 2 rad\.$"):
        within(2.0, 0.0, 1.0, "angle", "rad", "to contract")


def test_finite_takes_any_sign():
    assert finite(-3.0, "slope", "1/Pa") == -3
    with pytest.raises(ValueError, match="`slope` must lie in"):
        finite(float("inf"), "slope", "1/Pa")


def test_nearest_name_is_suggested():
    assert one_of("latex", {"latex": 1, "rubber": 2}, "material") == "latex"
    with pytest.raises(ValueError, match=r"^`material` 'latx' is unknown: did you mean 'latex'\? "):
        one_of("latx", {"latex": 1, "rubber": 2}, "material")
    with pytest.raises(ValueError, match=r"is unknown: choose one of latex, rubber\.$"):
        one_of("qqqqqq", {"latex": 1, "rubber": 2}, "material")


def test_traced_values_pass_unseen():
    def inside(x):
        assert not concrete(x) and not concrete(1.0, [x])
        return positive(x, "x", "m") + within(x, 0.0, 1.0, "x", "m") + finite(x, "x", "m")

    assert concrete(1.0, np.ones(2), jnp.ones(2))
    assert jax.jit(inside)(-2.0) == -6  # a traced value is its caller's own affair
