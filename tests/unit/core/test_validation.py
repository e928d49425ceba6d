import jax.numpy as jnp
import numpy as np
import pytest

from fascicle.core.errors import InvalidInputError
from fascicle.core.validation import broadcast_shape, check_finite, check_interval, check_positive
from refusing import refuses


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
    with pytest.raises(InvalidInputError) as error:
        check_finite(value, "ratio", "-")
    assert error.value.argument == "ratio" and "\n" not in str(error.value)


def test_a_refused_value_differs_from_its_limit_as_written():
    with refuses("pressure") as error:
        check_interval(np.nextafter(1e6, 2e6), 0.0, 1e6, "pressure", "Pa", closed=(True, True))
    assert "1000000.0000000001" in str(error.value)


@pytest.mark.parametrize("shapes", [((2,), (3,)), ((4, 2), (3,)), ((1, 2, 1), (2, 3, 1))])
def test_shapes_that_do_not_broadcast_are_named(shapes):
    assert broadcast_shape(pressure=(3, 1), strain=(4,), force=()) == (3, 4)
    first, second = shapes
    with pytest.raises(InvalidInputError) as error:
        broadcast_shape(pressure=first, time=(), strain=second)
    assert error.value.argument == "strain" and "`pressure`" in error.value.rule


def test_masked_elements_are_refused_and_an_empty_mask_is_not():
    masked = np.ma.masked_array([1.0, 2.0], [False, True])
    with pytest.raises(InvalidInputError) as error:
        check_finite(masked, "strain", "-")
    assert error.value.argument == "strain" and "1 masked" in str(error.value)
    unmasked = np.ma.masked_array([1.0, 2.0], [False, False])
    assert np.array_equal(check_finite(unmasked, "strain", "-"), [1.0, 2.0])
