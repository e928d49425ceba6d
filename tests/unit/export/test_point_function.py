"""Single points by CasADi: the library's force and its slopes."""

import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.core.module import tree_leaves, tree_replace
from fascicle.muscle.muscle import eval_force


pytest.importorskip("casadi")
random = np.random.default_rng(0)


@pytest.mark.parametrize("buckling", ["kim2021", "elastica"])
def test_a_muscle_function_equals_the_muscle(buckling):
    muscle = fs.example("kim2021_figure_6").replace(buckling=buckling)
    force = muscle.compile(backend="casadi")
    pressure, strain = random.uniform(1e3, 4e5, 40), random.uniform(-0.02, 0.35, 40)
    result = [force(P, eps) for P, eps in zip(pressure, strain, strict=True)]
    assert_allclose(result, muscle.force(pressure, strain), rtol=1e-10, atol=1e-10)
    F, by_pressure, by_strain = force.with_slopes(2e5, 0.1)
    h = 1.0  # Pa: a millionth of the domain, where differences are good to 1e-9
    assert force(2e5, 0.1) == F
    ahead, behind = muscle.force(2e5 + h, 0.1), muscle.force(2e5 - h, 0.1)
    assert_allclose(by_pressure, [(ahead - behind) / (2 * h)], rtol=1e-7)
    assert_allclose(by_strain, -muscle.stiffness(2e5, 0.1) * muscle.length, rtol=1e-10)


TUNING = fs.Tuning([1e5, 3e5], [0.5, 1.0], [0.9, 1.1], dead_band=2e4, transition_rate=30.0)
# scales of parameters whose values may be zero
SCALES = {"hinge_stiffness_slope": 1e-6, "dead_band": 1e4}


def leaf_scales(muscle):
    """Index, name and scale of each parameter of a muscle but its tuning's pressures."""
    paths, _ = jax.tree_util.tree_flatten_with_path(muscle)
    for i, (path, leaf) in enumerate(paths):
        name = jax.tree_util.keystr(path).removeprefix(".")
        for k in np.ndindex(np.shape(leaf)):
            key = name + "".join(f"[{n}]" for n in k)
            if name != "tuning.pressures":
                yield i, k, key, SCALES.get(name.split(".")[-1], abs(leaf[k]) or 1.0)


@pytest.mark.parametrize(
    "laws",
    [
        {"tuning": TUNING},
        {"ends": fs.ends.Compliant(0.01, 1e-6)},
        {"buckling": fs.buckling.Kim2021(shear="engesser")},
        *({"tension": name} for name in fs.tension.TENSION_LAWS),
        *({"collapse": name} for name in fs.collapse.COLLAPSE_LAWS),
        *({"post_collapse": name} for name in fs.post_collapse.POST_COLLAPSE_LAWS),
        *({"buckling": name} for name, law in fs.buckling.BUCKLING_LAWS.items() if law.symbolic),
    ],
    ids=str,
)
@pytest.mark.filterwarnings("ignore")  # of laws that were published for another muscle
def test_a_gradient_equals_differences_by_each_parameter(laws):
    muscle = fs.example("kim2021_figure_6").replace(**laws)
    force = muscle.compile(backend="casadi")
    pressure = np.repeat([5e4, 2e5, 3.7e5], 5)
    strain = np.tile([-0.02, 0.08, 0.17, 0.26, 0.4], 3)  # pulling, bowed and collapsed
    results = [force.with_gradient(P, eps) for P, eps in zip(pressure, strain, strict=True)]
    law_force = muscle.force(pressure, strain)
    assert_allclose([F for F, _ in results], law_force, rtol=1e-10, atol=1e-9)
    # of a step of 1e-5: its square and rounding over it are far below
    tolerance = 1e-6 * np.max(np.abs(law_force))
    leaves, names = tree_leaves(muscle), {"pressure", "strain"}
    for i, k, name, scale in leaf_scales(muscle):
        moved = []
        for sign in (1, -1):
            leaf = np.array(leaves[i])
            leaf[k] += sign * 1e-5 * scale
            changed = tree_replace(muscle, [*leaves[:i], leaf[()], *leaves[i + 1 :]])
            moved.append(eval_force(changed, pressure, strain))
        difference = (moved[0] - moved[1]) / 2e-5
        computed = [scale * gradient[name] for _, gradient in results]
        assert_allclose(computed, difference, rtol=1e-5, atol=tolerance, err_msg=name)
        names.add(name)
    assert set(results[0][1]) == names
    F, by_pressure, by_strain = force.with_slopes(2e5, 0.17)
    again, gradient = force.with_gradient(2e5, 0.17)
    slopes = [gradient["pressure"], gradient["strain"]]
    assert_allclose([again, *slopes], [F, by_pressure[0], by_strain], rtol=1e-10)


def test_a_gradient_equals_that_of_jax():
    muscle = fs.example("kim2021_figure_6").replace(tuning=TUNING)
    force, jax_gradient = muscle.compile(backend="casadi"), jax.jit(jax.grad(eval_force))
    strains = np.array([-0.02, 0.08, 0.17, 0.26, 0.4])
    assert set(muscle.response(2e5, strains).region) == {0, 1, 2}
    for strain in strains:
        _, gradient = force.with_gradient(2e5, strain)
        leaves = tree_leaves(jax_gradient(muscle, 2e5, strain))
        for i, k, name, scale in leaf_scales(muscle):
            assert_allclose(
                scale * gradient[name], scale * leaves[i][k], rtol=1e-9, atol=1e-9, err_msg=name
            )


@pytest.mark.parametrize("length", [None, 0.13])
def test_a_bundle_function_equals_the_bundle(length):
    bundle = fs.example("kim2021_bundle_1_4")
    if length is not None:
        bundle = fs.Bundle(bundle.motor_units, length=length)
    force = bundle.compile(backend="casadi")
    pressures, strain = random.uniform(1e3, 4e5, (20, 2)), random.uniform(0.03, 0.3, 20)
    result = [force(P, eps) for P, eps in zip(pressures, strain, strict=True)]
    assert_allclose(result, bundle.force(pressures, strain), rtol=1e-10, atol=1e-9)
    _, by_pressures, by_strain = force.with_slopes([2e5, 1e5], 0.1)
    for i, step in enumerate(np.eye(2)):
        ahead, behind = (bundle.force([2e5, 1e5] + s * step, 0.1) for s in (1.0, -1.0))
        assert_allclose(by_pressures[i], (ahead - behind) / 2, rtol=1e-7)
    h = 1e-6  # far above rounding of a strain, and far below where a force bends
    slope = (bundle.force([2e5, 1e5], 0.1 + h) - bundle.force([2e5, 1e5], 0.1 - h)) / (2 * h)
    assert_allclose(by_strain, slope, rtol=1e-6)


def test_an_unknown_backend_is_refused():
    with pytest.raises(fs.InvalidInputError) as caught:
        fs.example("kim2021_figure_6").compile(backend="numba")
    assert caught.value.argument == "backend"
