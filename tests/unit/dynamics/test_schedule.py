"""Commands by the clock: held from each time on, and what they refuse."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from fascicle.core.errors import InvalidInputError
from fascicle.dynamics import Schedule


def test_commands_are_held_until_the_next():
    schedule = Schedule([0, 0.1, 0.3], [[1, 0], [0.5, -1], [0, 0]])
    assert_array_equal(
        schedule.at([0.0, 0.0999, 0.1, 0.2999, 0.3, 9.0]),
        [[1, 0], [1, 0], [0.5, -1], [0.5, -1], [0, 0], [0, 0]],
    )


def test_rounding_of_times_is_tolerated():
    schedule = Schedule([0, 0.3], [0, 1])
    assert 3 * 0.1 != 0.3
    assert_array_equal(schedule.at(np.arange(5) * 0.1).ravel(), [0, 0, 0, 1, 1])
    assert_array_equal(schedule.at(np.nextafter(0.3, 0)), [1])


@pytest.mark.parametrize(
    ("times", "commands", "argument"),
    [
        ([0.1, 0.2], [0, 1], "times"),
        ([0, 0.2, 0.1], [0, 1, 0], "times"),
        ([0, np.nan], [0, 1], "times"),
        ([0, 1], [0, 1.01], "commands"),
        ([0, 1], [0, 1, 0], "commands"),
    ],
)
def test_invalid_input_is_refused(times, commands, argument):
    with pytest.raises(InvalidInputError) as error:
        Schedule(times, commands)
    assert error.value.argument == argument
