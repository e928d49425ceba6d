"""What a module works out about itself is no part of it."""

import copy
import pickle

import jax
import numpy as np

import fascicle as fs
from fascicle._methods import Module, kept


class Counted(Module):
    size: float

    @kept
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
        assert made == muscle and not made.store and made.force(1e5, 0.1) == force
