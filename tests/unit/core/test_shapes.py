import re

import pytest

from fascicle.core.refused import Refused
from fascicle.core.shapes import common


def test_shapes_that_fit_are_one():
    assert common(pressure=(3, 1), strain=(4,), force=()) == (3, 4)


@pytest.mark.parametrize("shapes", [((2,), (3,)), ((4, 2), (3,)), ((1, 2, 1), (2, 3, 1))])
def test_shapes_that_do_not_fit_are_named(shapes):
    first, second = shapes
    words = f"`strain` must broadcast against `pressure`, got the shapes {second} and {first}: "
    with pytest.raises(Refused, match=re.escape(words)):
        common(pressure=first, time=(), strain=second)
