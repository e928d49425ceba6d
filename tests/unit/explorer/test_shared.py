"""What one session has computed is there for the others, and no more of it than fits."""

import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import fascicle as fs
from fascicle.explorer import background as module
from fascicle.explorer.background import MOST, shared


CALLS = []


def doubled(muscle, number):
    CALLS.append(number)
    if number < 0:
        raise ValueError("negative")
    return np.full(3, 2.0 * number)


@pytest.fixture(autouse=True)
def empty():
    module._KEPT.clear()
    CALLS.clear()
    yield
    module._KEPT.clear()


def test_equal_muscles_share_and_others_do_not():
    six, again = fs.example("kim2021_figure_6"), fs.example("kim2021_figure_6")
    assert shared(doubled, six, 1.0) is shared(doubled, again, 1.0)
    assert CALLS == [1.0]
    shared(doubled, six, np.nextafter(1.0, 2))  # in every digit
    shared(doubled, six.replace(length=np.nextafter(float(six.length), 1)), 1.0)
    shared(doubled, six.replace(buckling="elastica"), 1.0)
    shared(doubled, fs.example("kim2021_bundle_1_4"), 1.0)
    assert len(CALLS) == 5
    shared(doubled, fs.example("kim2021_bundle_1_4"), 1.0)
    assert len(CALLS) == 5


def test_a_failure_is_told_and_not_kept():
    for _ in range(2):
        with pytest.raises(ValueError, match="negative"):
            shared(doubled, None, -1)
    assert CALLS == [-1, -1]


def test_only_the_latest_are_kept():
    for number in range(3 * MOST):
        shared(doubled, None, number)
    assert len(module._KEPT) == MOST
    shared(doubled, None, 3 * MOST - 1)
    shared(doubled, None, 0)
    assert len(CALLS) == 3 * MOST + 1


STARTED, GO = threading.Event(), threading.Event()


def slow(_):
    CALLS.append(0)
    STARTED.set()
    assert GO.wait(10)
    return 1


def test_whoever_asks_meanwhile_waits_for_the_same():
    with ThreadPoolExecutor(4) as several:
        first = several.submit(shared, slow, None)
        assert STARTED.wait(10)
        others = [several.submit(shared, slow, None) for _ in range(3)]
        GO.set()
        assert [one.result(10) for one in (first, *others)] == [1] * 4
    assert CALLS == [0]
