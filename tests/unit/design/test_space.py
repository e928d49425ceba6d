import pickle

import numpy as np
from numpy.testing import assert_allclose

from fascicle.design import Space
from fascicle.design.designs import packed_radius


def every(space):
    return space.at(np.arange(len(space)))


def test_every_design_has_an_index(muscle):
    space = Space(
        {"m": muscle}, (2, 3), length=(0.1, 0.12), braid_angle=(0.5, 0.6), wall_ratio=(0.2,)
    )
    designs = every(space)
    assert len(space) == len(designs) == (2 + 4) * 2 * 2
    designs_at = {
        (label, float(length), float(angle))
        for label, length, angle in zip(
            designs.labels, designs.length, designs.angle[:, 0], strict=True
        )
    }
    assert len(designs_at) == len(space)
    # from the index alone, in any order
    indices = np.array([5, 0, 17])
    assert space.at(indices).labels == [designs.labels[i] for i in indices]
    # what isn't listed is the drawing's own
    assert np.all(designs.radius == 6.35e-3) and np.all(designs.wall == 0.2 * designs.radius)


def test_one_cross_section(muscle):
    space = Space({"m": muscle}, (1, 4), radius=(0.012,), radius_rule="cross_section",
                  unit_factors=(1.0, 2.0))  # fmt: skip
    designs = every(space)
    area = np.sum(designs.counts * designs.radius**2, axis=1)
    assert_allclose(area, 0.012**2, rtol=1e-12)
    # 1 in two sizes; of four muscles the compositions with m units in 2**m sizes each
    assert len(space) == 2 + sum(2**m * c for m, c in ((1, 1), (2, 3), (3, 3), (4, 1)))
    assert not np.all(designs.uniform)


def test_packed_into_a_circle(muscle):
    designs = every(Space({"m": muscle}, (3,), radius=(0.04,), radius_rule="packing"))
    assert_allclose(packed_radius(designs.radius, designs.counts), 0.02, rtol=1e-12)
    # three equal circles in one: 1 + 2/sqrt(3)
    assert_allclose(designs.radius[:, 0] * (1 + 2 / np.sqrt(3)), 0.02, rtol=1e-12)


def test_two_different_circles_lie_side_by_side():
    assert_allclose(packed_radius(np.array([[3.0, 1.0]]), np.array([[1, 1]])), 4.0)
    assert_allclose(packed_radius(np.array([[3.0, 1.0]]), np.array([[1, 0]])), 3.0)


def test_no_more_units_than_valves(muscle):
    designs = every(Space({"m": muscle}, (5,), most_units=2))
    assert sorted(designs.labels) == ["1+4", "2+3", "3+2", "4+1", "5"]
    assert designs.counts.shape == (5, 2)


def test_cached_properties_are_not_pickled(muscle):
    space = Space({"m": muscle}, (12,))
    assert len(space) == 2048
    again = pickle.loads(pickle.dumps(space))  # noqa: S301 just made
    assert len(pickle.dumps(space)) < 20_000
    assert again.at(np.array([77])).labels == space.at(np.array([77])).labels


def test_designs_become_bundles(muscle, task):
    designs = every(Space({"m": muscle}, splits=((1, 4),), unit_factors=(1.0, 1.5)))
    bundle = designs.bundle(1, task)
    assert [int(unit.count) for unit in bundle.motor_units] == [1, 4]
    assert float(bundle.supply_pressure) == task.supply_pressure
    radii = [float(unit.muscle.outer_radius) for unit in bundle.motor_units]
    assert radii == designs.radius[1].tolist()
