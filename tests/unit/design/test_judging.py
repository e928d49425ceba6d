"""Objectives of whole batches: both kernels agree, and what is simple about them holds."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import fascicle as fs
from fascicle.design import OBJECTIVES, Designs, evaluate
from fascicle.design.evaluation import sizes_of
from fascicle.design.objectives import judged
from fascicle.design.outcome import Demand
from fascicle.design.shared import prepared, shared_objectives
from fascicle.design.splits import compositions, partitions
from fascicle.design.tables import Resolution
from fascicle.design.unlike import unlike_objectives, unlike_outcome


NAMES = tuple(OBJECTIVES)
NEEDS = ("curves", "size")
COARSE = Resolution(17, 65)


@pytest.fixture(scope="module")
def five(muscle):
    return Designs.of(muscle, compositions(5))


@pytest.fixture(scope="module")
def values(five, task):
    return evaluate(five, task, NAMES)


def test_like_and_unlike_units_are_judged_the_same(muscle, five, task):
    demand = Demand.of(task)
    rows = np.array([0, 1, 7, 15])
    known = prepared(muscle, 5, demand, most=5, needs=NEEDS, resolution=COARSE)
    shared = shared_objectives(known, jnp.asarray(five.counts[rows]), demand, names=NAMES)
    unlike = unlike_objectives(
        muscle, sizes_of(five, rows), demand, names=NAMES, needs=NEEDS, resolution=COARSE
    )
    # the same sums in another order
    assert_allclose(shared, unlike, rtol=1e-9, atol=1e-9)


def test_what_is_simple(muscle, five, task, values):
    blocked = float(muscle.blocked_force(task.supply_pressure))
    assert_allclose(values["largest_force"], 5 * blocked, rtol=1e-12)
    assert_allclose(values["force_resolution"], five.counts.max(axis=1) * blocked, rtol=1e-12)
    assert_array_equal(values["valves"], five.units)
    # a fifth of the weight is beyond any of them
    assert_allclose(values["not_reached"], 0.2)
    single = values["valves"] == 1
    assert values["reversal_depth"][single] == 0 and values["overlap_width"][single] == 0
    assert np.all(values["reversal_depth"] >= 0)
    # only one that isn't alone is ever bowed by others
    assert values["envelope"][single] == values["envelope"].min()
    assert np.ptp(values["envelope"][~single]) == 0
    # with a valve for each muscle no more are fed than must be; others may feed as few
    assert values["mean_efficiency"][single] == values["mean_efficiency"].min()
    assert values["mean_efficiency"][15] >= values["mean_efficiency"].max() - 1e-12
    assert np.all(values["worst_shortfall"] >= values["shortfall"])


def test_a_design_alone_and_among_others(five, task, values):
    alone = evaluate(five.take(np.array([9])), task, NAMES)
    for name in NAMES:
        assert_allclose(alone[name][0], values[name][9], rtol=1e-12, atol=1e-12)


def test_unlike_units(muscle, task):
    """One unit of two sizes is what two muscles of these sizes are."""
    names = ("largest_force", "envelope", "valves", "mean_efficiency", "not_reached")
    same = Designs.of(muscle, [(1, 1)])
    radius = same.radius * np.array([[1.0, 1.2]])
    other = Designs(
        same.drawings, same.kind, same.counts, same.length, radius, 0.25 * radius, same.angle
    )
    assert not other.alike[0]
    values = evaluate(other, task, names)
    bundle = other.bundle(0, task)
    supply = np.full(2, task.supply_pressure)
    assert_allclose(values["largest_force"], bundle.force(supply, 0.0), rtol=1e-9)
    assert values["valves"] == [2]
    found = fs.recruitment.recruit(bundle, task.force, task.strain)
    reached = found.status == 0
    assert reached.tolist() == [True, True, True, False]
    assert_allclose(values["not_reached"], (task.weight * ~reached).sum() / task.weight.sum())
    fed = np.arange(2) < found.state[:, None]
    taken = (fed * fs.energetics.unit_volume_change(bundle, task.strain)).sum(axis=1)
    work = task.force * task.strain * float(bundle.length)
    share = np.where(reached, work / (task.supply_pressure * taken), 0.0)
    assert_allclose(values["mean_efficiency"], np.average(share, weights=task.weight), rtol=1e-9)
    # two side by side, at the task's largest strain, and the deeper bow of either up to there
    muscles, steps = [unit.muscle for unit in bundle.motor_units], np.linspace(0, 0.2, 401)
    width = sum(float(one.braid.radius_at(0.2)) for one in muscles)
    bow = max(float(one.deflection(0.0, steps).max()) for one in muscles)
    assert_allclose(values["envelope"], 2 * (width + bow), rtol=1e-3)


def test_unknown_objectives_and_designs_that_can_not_be(five, task):
    with pytest.raises(ValueError, match="did you mean 'mean_efficiency'"):
        evaluate(five, task, ["mean_eficiency"])
    thick = Designs(
        five.drawings, five.kind, five.counts, five.length, five.radius, five.radius, five.angle
    )
    with pytest.raises(ValueError, match="`wall_thickness` must be less"):
        evaluate(thick, task, ["valves"])


def test_gradients_against_differences(muscle, task):
    """By length, radius, wall and angle of a unit, of every objective that is smooth."""
    demand = Demand.of(task)
    smooth = tuple(name for name in NAMES if name not in ("valves", "not_reached"))
    first = sizes_of(Designs.of(muscle, [(1, 2)]), np.array([0]))
    sizes = jax.tree.map(lambda x: jnp.asarray(x[0]), first)
    scale = jnp.array([0.127, 6.35e-3, 1.6e-3, 0.576])

    def objectives(z):
        length, radius, wall, angle = z * scale
        moved = sizes._replace(
            length=length,
            radius=sizes.radius.at[1].set(radius),
            wall=sizes.wall.at[1].set(wall),
            angle=sizes.angle.at[1].set(angle),
        )
        return judged(unlike_outcome(muscle, moved, demand, NEEDS, COARSE), smooth)

    @jax.jit
    def along(z, way):  # values and slopes of one program
        return jax.jvp(objectives, (z,), (way,))

    # off the corner where both units are alike
    z = jnp.array([1.0, 1.05, 1.02, 0.98])
    ways, h = jnp.eye(4), 1e-5
    exact = np.stack([along(z, way)[1] for way in ways], axis=1)
    assert np.all(np.isfinite(exact))
    plain = [(along(z + h * way, way)[0] - along(z - h * way, way)[0]) / (2 * h) for way in ways]
    plain = np.stack(plain, axis=1)
    size = np.abs(np.asarray(along(z, ways[0])[0]))[:, None]
    # central differences err by h² of the third derivative, and by rounding over h
    assert_allclose(exact, plain, rtol=1e-4, atol=1e-5 * (1e-3 + size.max(axis=1)).max())


def test_all_partitions_of_thirty(muscle, task):
    names = ("mean_efficiency", "reversal_depth", "overlap_width")
    counts = partitions(30)
    every = evaluate(Designs.of(muscle, counts), task, names)
    few = [4, 2500, 5603]
    alone = evaluate(Designs.of(muscle, counts[few]), task, names)
    for name in names:
        assert np.all(np.isfinite(every[name]))
        assert_allclose(every[name][few], alone[name], rtol=1e-12, atol=1e-15)
    # undivided, nothing can reverse; with a valve for each, little does
    assert every["reversal_depth"][0] == 0
    assert every["reversal_depth"][-1] < 0.1 * every["reversal_depth"].max()


def test_few_designs_are_judged_without_a_compiler(muscle, task, caplog):
    """Of one muscle, their reversal too, and of unlike ones; nor is what one of them does."""
    from fascicle.design.cases import cases

    like = Designs.of(muscle, [(1, 2), (3,)])
    radius = like.radius * np.array([1.0, 1.2])
    unlike = Designs(
        like.drawings, like.kind, like.counts, like.length, radius, 0.25 * radius, like.angle
    )
    with jax.log_compiles(), caplog.at_level("WARNING"):
        evaluate(like, task, [*NAMES])
        evaluate(unlike, task, ["margin", "mean_efficiency", "envelope"])
        cases(unlike, 0, task)
    assert not [record for record in caplog.records if "ompil" in record.getMessage()]
