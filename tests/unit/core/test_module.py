"""What a module works out about itself is no part of it."""

import copy
import pickle
from functools import cached_property

import jax
import numpy as np

import fascicle as fs
from fascicle.core.module import Module


class Counted(Module):
    size: float

    @cached_property
    def square(self):
        """Its square."""
        seen.append(self.size)
        return self.size**2


seen: list[float] = []


def test_a_kept_property_is_worked_out_once_for_each_module():
    seen.clear()
    one, other = Counted(2.0), Counted(3.0)
    assert [one.square, one.square, other.square, one.square] == [4.0, 4.0, 9.0, 4.0]
    assert seen == [2.0, 3.0]
    assert Counted.square.__doc__ == "Its square."


def test_a_muscle_that_was_used_is_still_equal_and_compiles_nothing_again():
    used, fresh = fs.example("kim2021_figure_6"), fs.example("kim2021_figure_6")
    used.force(np.array([1e5, 2e5]), 0.1)
    assert used == fresh
    assert jax.tree.structure(used) == jax.tree.structure(fresh)
    bundle, other = fs.example("kim2021_bundle_1_4"), fs.example("kim2021_bundle_1_4")
    bundle.free_strain([1e5, 0.0])
    fs.recruitment.recruit(bundle, 50.0, 0.1)
    assert bundle == other
    traced = []

    @jax.jit
    def length(muscle):
        traced.append(1)
        return muscle.length

    assert float(length(used)) == float(length(fresh)) and len(traced) == 1


def test_copies_start_anew():
    muscle = fs.example("kim2021_figure_6")
    force = muscle.force(1e5, 0.1)
    for made in (copy.copy(muscle), copy.deepcopy(muscle), pickle.loads(pickle.dumps(muscle))):  # noqa: S301 its own
        assert made == muscle and not made.cache and made.force(1e5, 0.1) == force


def test_equality_is_of_all_numbers_and_laws():
    muscle = fs.example("kim2021_slenderness_8")  # tuned: it has tables
    same = muscle.replace()
    assert (muscle == same) is True and (muscle != same) is False
    as_jax = jax.tree.map(jax.numpy.asarray, muscle)
    assert (muscle == as_jax) is True and (as_jax == same) is True
    table = fs.Tuning([1e5, 2e5], [1.0, 2.0], [0.9, 0.95])
    others = [
        muscle.replace(length=0.1),
        muscle.replace(buckling="elastica"),
        muscle.replace(tension=fs.tension.Kothera2009()),
        muscle.replace(collapse=fs.collapse.Kim2021Collapse(0.9)),
        muscle.replace(tuning=table),
        muscle.replace(tuning=fs.Tuning([1e5, 2e5], [1.0, 2.0], [0.9, 0.96])),
        muscle.replace(tuning=fs.Tuning([1e5], [1.0], [0.9])),
        muscle.length,
        None,
    ]
    for i, one in enumerate(others):
        assert (muscle == one) is False and (muscle != one) is True
        assert [one == other for other in others].count(True) == 1, i
    by_choice = fs.tension.Kothera2009("ideal"), fs.tension.Kothera2009("inner_radius")
    assert by_choice[0] != by_choice[1]
    rows = jax.tree.map(lambda leaf: np.stack([leaf, leaf]), muscle)
    assert (rows == muscle) is False and (rows == copy.deepcopy(rows)) is True


def test_what_has_single_numbers_alone_has_a_hash():
    law = fs.tension.Meller2014(1.1, 0.9)
    assert hash(law) == hash(fs.tension.Meller2014(1.1, 0.9))
    assert {law: 1}[fs.tension.Meller2014(1.1, 0.9)] == 1


def test_what_is_equal_has_one_hash_tables_and_all():
    muscle = fs.example("kim2021_slenderness_8")  # tuned: it has tables
    as_jax = jax.tree.map(jax.numpy.asarray, muscle)
    found = {muscle: "this one", muscle.replace(length=0.1): "another"}
    assert found[muscle.replace()] == found[as_jax] == "this one" and len(found) == 2


def test_traced_numbers_are_equal_to_themselves_alone():
    seen = []

    @jax.jit
    def look(length):
        muscle = fs.example("kim2021_figure_6")
        one = muscle.replace(length=length)
        seen.extend([one == one.replace(), one == one.replace(length=length + 0.0)])
        return length

    look(0.127)
    assert seen == [True, False]
