"""What muscles give at the task's points, against the whole law looked at at every level."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.design import Designs, Task, evaluate
from fascicle.design.designs import scaled_muscle
from fascicle.design.evaluation import Resolution, force_table
from fascicle.muscle.buckling import BUCKLING_LAWS
from fascicle.muscle.collapse import COLLAPSE_LAWS
from fascicle.muscle.post_collapse import POST_COLLAPSE_LAWS
from fascicle.muscle.tension import TENSION_LAWS, TonduLopez


SUPPLY = 300e3
COARSE = Resolution(17, 33)
TUNED = fs.Tuning(
    [50e3, 150e3, 280e3], [1.0, -3.0, 6.0], [0.8, 1.1, 0.9],
    hinge_stiffness_factor=0.7, hinge_stiffness_slope=1e-6, dead_band=15e3,
)  # fmt: skip
LAWS = (
    # a law with one muscle's numbers is none for designs
    [{"tension": name} for name, law in TENSION_LAWS.items() if not law.reference_muscle]
    + [{"buckling": name} for name in BUCKLING_LAWS]
    + [{"collapse": name} for name in COLLAPSE_LAWS if name != "stein_hedgepeth1961"]
    + [{"post_collapse": name} for name in POST_COLLAPSE_LAWS]
    # its free strain falls as pressure rises
    + [{"tension": TonduLopez(1.2, -0.4, 5e4)}, {"tuning": TUNED}]
    + [{"tuning": TUNED, "buckling": "elastica"}]
)


def drawing(laws):
    return fs.Muscle(0.12, 6e-3, 1.5e-3, np.radians(30), **laws)


def random_sizes(count, seed=3):
    generator = np.random.default_rng(seed)
    radius = generator.uniform(4e-3, 9e-3, count)
    wall, angle = generator.uniform(0.12, 0.3, count), generator.uniform(12.0, 45.0, count)
    length = generator.uniform(0.08, 0.3, count)
    return np.stack([length, radius, wall * radius, np.radians(angle)], axis=1)


# what takes ten times as long as any other law shows here with fewer designs
@pytest.mark.parametrize(("laws", "count"), [(laws, 12) for laws in LAWS], ids=str)
def test_largest_force_equals_that_of_the_whole_law(laws, count):
    """At strains from rest to far beyond what any level pulls with."""
    muscle, sizes = drawing(laws), random_sizes(count)
    strain = np.concatenate([np.linspace(0.0, 0.42, 60), [1e-9, 0.6]])
    task = Task.of(np.ones(strain.size), strain, SUPPLY)
    table = force_table(muscle, sizes, task, (), COARSE, largest_only=True)
    for i in range(count):
        one = scaled_muscle(muscle, sizes[i])
        with np.errstate(all="ignore"):  # of branches that aren't taken
            force = one.law.at(COARSE.level[:, None] * SUPPLY).pulling_force(strain)
        # rounding of the forces that are added up
        close = {"rtol": 1e-10, "atol": 1e-9}
        assert_allclose(table.vented[:, i], force[0], **close)
        assert_allclose(table.full[:, i], force[-1], **close)
        assert_allclose(table.levels[0, :, i], force.max(axis=0), **close)
        # so that the lowest state that gives enough covers what is demanded
        assert np.all(force[0] <= 1e-9)


def test_drawing_of_arrays_equals_drawing_of_numbers():
    plain = drawing({})
    task = Task.of([100.0, 300.0], [0.1, 0.02], SUPPLY)
    same = jax.tree.map(jnp.asarray, plain)
    values = [evaluate(Designs.of(m, [(1, 2)]), task, ["margin"])["margin"] for m in (plain, same)]
    assert_allclose(*values, rtol=1e-12)
