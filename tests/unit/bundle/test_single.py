"""A muscle at single points, and at kept levels: its law, with what was solved for before."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle.bundle.recruit.single import CELLS, LEVELS, Single
from unlike import LAWS, SUPPLY, random_bundle


@pytest.mark.parametrize("laws", LAWS)
def test_it_is_the_law(laws):
    random = np.random.default_rng(3)
    muscle = random_bundle(random, 1, **LAWS[laws]).motor_units[0].muscle
    one, count = Single(muscle, SUPPLY), 40 if laws == "elastica" else 400
    pressure = SUPPLY * random.choice([1.0, 0.1, 1e-4, 0.0], count) * random.random(count)
    strain = random.uniform(-0.05, 0.35, count)
    with np.errstate(all="ignore"):
        at = muscle.law.at(pressure)
        # at the free strain, where one law goes over to the other, and beside it
        strain[:9] = at.column.free_strain[:9] + np.repeat([-1e-9, 0.0, 1e-9], 3)
        strain[strain > 0.34] = 0.34
        found = [one.force(P, eps) for P, eps in zip(pressure, strain, strict=True)]
        force, slope = at.force(strain)
        again = [one.force(P, eps) for P, eps in zip(pressure, strain, strict=True)]
    assert found == again
    assert_allclose(np.transpose(found)[0], force, rtol=1e-12, atol=1e-10)
    apart = np.abs(np.transpose(found)[1] - slope) > 1e-9 * (1 + np.abs(slope))
    assert not apart[9:].any()  # at the kink itself there are two slopes
    regions = muscle.response(pressure, strain).region
    assert set(regions) >= {0, 1 if laws != "elastica" else 3}


@pytest.mark.parametrize("few", [True, False])
@pytest.mark.parametrize("laws", LAWS)
def test_levels_that_are_kept_are_the_laws(laws, few):
    random = np.random.default_rng(4)
    muscle = random_bundle(random, 1, **LAWS[laws]).motor_units[0].muscle
    single, shape = Single(muscle, SUPPLY), (3, 20) if few else (5, 20)
    for _ in range(3):  # one by one once it's asked often, from the second time on
        node, strain = (
            random.integers(0, CELLS + 1, shape),
            random.uniform(-0.05, 0.33, (shape[0], 1)),
        )
        with np.errstate(all="ignore"):
            found = single.along(node, strain)
            wanted, _ = muscle.law.at(LEVELS[node] * SUPPLY).force(strain)
        assert_allclose(found, wanted, rtol=1e-12, atol=1e-10)
