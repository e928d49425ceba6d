"""A closed loop's width in closed form, against springs walked round it."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from oracle_slip import widths

from fascicle.dynamics import MaxwellSlip


@pytest.mark.oracle
@pytest.mark.parametrize("seed", range(8))
def test_a_loop_is_as_wide_as_springs_walk_it(seed):
    rng = np.random.default_rng(seed)
    many, stroke, P = rng.integers(1, 5), rng.uniform(1e-3, 5e-2), rng.uniform(0, 5e5)
    k, f, slope = (10 ** rng.uniform(a, b, many) for a, b in ((2, 5), (-1, 1), (-6, -4)))
    law = MaxwellSlip(k, f, slope)
    way = np.linspace(0, stroke, 41)
    found = law.loop_width(way, stroke - way, np.full(41, P))
    # springs that don't slip at all, on some seeds, make no loop
    assert_allclose(found, widths(k, f + slope * P, stroke, 40), rtol=1e-9, atol=1e-12)
