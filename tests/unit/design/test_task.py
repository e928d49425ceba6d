import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle.design import Task, example_task
from fascicle.design.task import TASKS


def test_points_in_time_have_their_duration_as_weight():
    task = Task.in_time([0.0, 1.0, 3.0], [10.0, 20.0, 5.0], [0.0, 0.1, 0.2], 4e5)
    assert_allclose(task.weight, [0.5, 1.5, 1.0])
    assert task.strain.max() == 0.2 and len(task) == 3


@pytest.mark.parametrize("name", TASKS)
def test_examples_have_made_up_as_source(name):
    task = example_task(name, 3e5)
    assert task.supply_pressure == 3e5 and task.name == name
    assert "made up" in task.source
    assert np.all(task.force > 0) and np.all(task.strain >= 0) and task.strain.max() < 0.2


def test_reference_of_zero_force_is_the_largest_force():
    task = Task.of([0.0, 20.0, 5.0], [0.1, 0.1, 0.0], 4e5)
    assert_allclose(task.reference, [20.0, 20.0, 5.0])
