import re

import pytest

from fascicle.core.errors import InvalidInputError
from fascicle.core.validation import broadcast_shape


def test_shapes_that_fit_are_one():
    assert broadcast_shape(pressure=(3, 1), strain=(4,), force=()) == (3, 4)


@pytest.mark.parametrize("shapes", [((2,), (3,)), ((4, 2), (3,)), ((1, 2, 1), (2, 3, 1))])
def test_shapes_that_do_not_fit_are_named(shapes):
    first, second = shapes
    words = f"`strain` must broadcast against `pressure`, got the shapes {second} and {first}: "
    with pytest.raises(InvalidInputError, match=re.escape(words)):
        broadcast_shape(pressure=first, time=(), strain=second)
