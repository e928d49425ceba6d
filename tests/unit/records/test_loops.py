import numpy as np
from numpy.testing import assert_allclose

from fascicle.records.hysteresis import loop_of
from fascicle.records.record import Record


STRAIN = np.linspace(0, 0.2, 101)


def looped(half):
    P = np.array([1e5, 3e5])[:, None]
    F = P * 1e-3 * (1 - STRAIN / 0.3)
    both = np.concatenate([F - half, F + half], axis=1)
    strain = np.concatenate([STRAIN, STRAIN])
    return Record.of(P, strain, both, branch=np.repeat([1, -1], STRAIN.size))


def test_widths_are_those_that_were_put_in():
    half = np.array([3.0, 9.0])[:, None]
    loop = loop_of(looped(half))
    assert_allclose(loop.pressure, [1e5, 3e5])
    assert_allclose(loop.width, [6, 18], rtol=1e-9)
    assert_allclose(loop.widest, [6, 18], rtol=1e-9)
    assert_allclose(loop.share, 0.06, rtol=1e-9)
    assert_allclose(loop.half, np.sqrt((9 + 81) / 2), rtol=1e-9)


def test_one_way_has_no_loop():
    assert loop_of(Record.of(1e5, STRAIN, 100 * (1 - STRAIN))) is None
    assert loop_of(Record.of(1e5, STRAIN, 100 * (1 - STRAIN), branch=1)) is None
