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


def test_a_time_that_steps_miss_by_rounding_is_meant():
    schedule = Schedule([0, 0.3], [0, 1])
    assert 3 * 0.1 != 0.3
    assert_array_equal(schedule.at(np.arange(5) * 0.1).ravel(), [0, 0, 0, 1, 1])
    assert_array_equal(schedule.at(np.nextafter(0.3, 0)), [1])


def test_one_command_needs_no_brackets():
    assert Schedule(0.0, 0.5).commands.shape == (1, 1)
    assert Schedule([0, 1], [0.5, 0]).commands.shape == (2, 1)


@pytest.mark.parametrize(
    ("times", "commands", "words"),
    [
        ([0.1, 0.2], [0, 1], "`times` must begin at 0 s, got 0.1."),
        ([0, 0.2, 0.2], [0, 1, 0], "`times` must rise, got 0.2 s after 0.2 s."),
        ([0, 0.2, 0.1], [0, 1, 0], "`times` must rise, got 0.1 s after 0.2 s."),
        ([0, np.nan], [0, 1], "`times` must lie in (-inf, inf) s, got nan s."),
        ([0, 1], [0, 1.01], "`commands` must lie in [-1, 1] from open exhaust to open supply, got"
         " 1.01."),
        ([0, 1], [[0, 0], [0, -2]], "`commands` must lie in [-1, 1] from open exhaust to open"
         " supply, got -2."),
        ([0, 1], [0, np.nan], "`commands` must lie in [-1, 1] from open exhaust to open supply, got"
         " nan."),
        ([0, 1], [0, 1, 0], "`commands` must have one row for each time, got 3."),
    ],
)  # fmt: skip
def test_what_can_t_be_is_refused(times, commands, words):
    with pytest.raises(InvalidInputError) as refused:
        Schedule(times, commands)
    assert str(refused.value) == words
