"""Many columns that ovalize: as right as each alone, and no more work for each."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.muscle.buckling import oval_column


SLENDER = fs.Muscle.from_dimensions(0.127, 6.35e-3, 1.6e-3, math.radians(33), buckling="ovalising")
# walls touch in many places, and the braid changes the stiffness with pressure
STUBBY = fs.Muscle.from_dimensions(
    0.08, 1e-2, 2e-3, math.radians(33), buckling=fs.muscle.buckling.Ovalising(braid_share=0.5)
)
PRESSURES = np.linspace(0.0, 4e5, 200)


@pytest.mark.parametrize("muscle", [SLENDER, STUBBY], ids=["slender", "stubby"])
def test_many_pressures_have_the_forces_of_each_alone(muscle):
    some = np.array([0, 1, 7, 60, 150, 199])
    together = muscle.force(PRESSURES[:, None], [0.1, 0.3, 0.55])[some]
    alone = muscle.force(PRESSURES[some, None], [0.1, 0.3, 0.55])
    assert_allclose(together, alone, rtol=1e-7)  # states are known to 1e-9, forces to some more


def test_unlike_columns_are_right_too():
    # numbers of no line: nothing between them is a good guess
    rng = np.random.default_rng(1)
    numbers = np.exp(rng.uniform(np.log([2, 1e-3, 3e-5, 0.8]), np.log([300, 1e-2, 4e-4, 0.95]),
                                 (40, 4)))  # fmt: skip
    together = oval_column.states(oval_column.Oval(*numbers.T))
    for k in (3, 21):
        alone = oval_column.states(oval_column.Oval(*numbers[k]))
        assert_allclose(together.load[:, k], alone.load, rtol=1e-7)
