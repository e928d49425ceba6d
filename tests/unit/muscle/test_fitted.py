"""What a muscle remembers of the length at which it was fitted."""

import copy
import pickle
import warnings
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import jax
import numpy as np
import pytest

import fascicle as fs
from fascicle.muscle.validation import FittedLength, fitted_length_mismatch
from refusing import warns


SIZES = (0.15, 6e-3, 1e-3, np.radians(25))


def fitted(ends=False):
    return fs.Muscle(*SIZES, fitted_length=FittedLength(0.15, ends))


def test_another_length_warns_with_both_lengths():
    with warns("150 mm", "300 mm"):
        longer = fitted().replace(length=0.3)
    # what else is changed of it says nothing again, and back at its length there is nothing to say
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        thinner = longer.replace(wall_thickness=8e-4)
        assert fitted_length_mismatch(thinner) and not fitted_length_mismatch(
            thinner.replace(length=0.15)
        )


@pytest.mark.parametrize("length", [0.15, 0.1525, 0.1475])
def test_the_same_length_within_a_rulers_error_says_nothing(length):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fitted().replace(length=length)


def test_it_is_copied_pickled_sent_and_compared():
    plain, other = fs.Muscle(*SIZES), fitted()
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        sent = pool.submit(copy.copy, other).result()
    pickled = pickle.loads(pickle.dumps(other))  # noqa: S301 what was just written
    for again in (copy.deepcopy(other), pickled, sent):
        assert again == other != plain
        with warns("150 mm", "300 mm"):
            again.replace(length=0.3)
    assert float(jax.jit(lambda muscle: muscle.force(1e5, 0.1))(other)) == pytest.approx(
        float(plain.force(1e5, 0.1)), rel=1e-12
    )
