"""Modules: values that are equal, hashed and copied by their numbers."""

import copy
import pickle

import jax
import numpy as np

import fascicle as fs


def test_a_used_muscle_is_equal_to_a_fresh_one_and_compiles_once():
    used, fresh = fs.example("kim2021_figure_6"), fs.example("kim2021_figure_6")
    used.force(np.array([1e5, 2e5]), 0.1)
    assert used == fresh
    assert jax.tree.structure(used) == jax.tree.structure(fresh)
    bundle = fs.example("kim2021_bundle_1_4")
    bundle.free_strain([1e5, 0.0])
    fs.recruitment.recruit(bundle, 50.0, 0.1)
    assert bundle == fs.example("kim2021_bundle_1_4")
    traces = []

    @jax.jit
    def length(muscle):
        traces.append(1)
        return muscle.length

    assert float(length(used)) == float(length(fresh)) and len(traces) == 1


def test_copies_have_an_empty_cache():
    muscle = fs.example("kim2021_figure_6")
    force = muscle.force(1e5, 0.1)
    for copied in (copy.copy(muscle), copy.deepcopy(muscle), pickle.loads(pickle.dumps(muscle))):  # noqa: S301
        assert copied == muscle and not copied.cache and copied.force(1e5, 0.1) == force


def test_equality_and_hash_are_of_all_numbers_and_laws():
    muscle = fs.example("kim2021_slenderness_8")  # tuned: it has tables
    as_jax = jax.tree.map(jax.numpy.asarray, muscle)
    assert muscle == muscle.replace() == as_jax
    assert len({muscle, muscle.replace(), as_jax, muscle.replace(length=0.1)}) == 2
    table = fs.Tuning([1e5, 2e5], [1.0, 2.0], [0.9, 0.95])
    variants = [
        muscle.replace(length=0.1),
        muscle.replace(buckling="elastica"),
        muscle.replace(tension=fs.tension.Kothera2009()),
        muscle.replace(tension=fs.tension.Kothera2009("ideal")),
        muscle.replace(collapse=fs.collapse.Kim2021Collapse(0.9)),
        muscle.replace(tuning=table),
        muscle.replace(tuning=fs.Tuning([1e5, 2e5], [1.0, 2.0], [0.9, 0.96])),
        muscle.replace(tuning=fs.Tuning([1e5], [1.0], [0.9])),
        jax.tree.map(lambda leaf: np.stack([leaf, leaf]), muscle),
        muscle.length,
        None,
    ]
    for i, variant in enumerate(variants):
        assert (muscle == variant) is False and (muscle != variant) is True
        assert [j for j, x in enumerate(variants) if variant is x or variant == x] == [i]


def test_traced_modules_are_equal_to_themselves_alone():
    results = []

    @jax.jit
    def compare(length):
        muscle = fs.example("kim2021_figure_6").replace(length=length)
        results.extend([muscle == muscle.replace(), muscle == muscle.replace(length=length + 0.0)])
        return length

    compare(0.127)
    assert results == [True, False]
