"""Synthetic benches with all errors of gauges at once: intervals hold the truth, faults are found.

`python tests/validation/test_gauge_bench.py 200` prints the figures for 200 records.
"""

import sys
from pathlib import Path

import numpy as np
import pytest


sys.path.insert(0, str(Path(__file__).parents[1]))

from fascicle.calibrate import fit
from fascicle.calibrate.data import select_fit_data
from fascicle.calibrate.gauges import GAUGE_NAMES, PERFECT
from gauge_bench import CONSTANTS, MUSCLE, TRUTH, bench_record


FLOOR = 5.0  # N: beyond the noise without pressure, above pushes past the free strain
FREE = (*CONSTANTS, "force_zero", "force_gain", "force_drift", "pressure_zero")
TRUE_VALUES = CONSTANTS | {name: getattr(TRUTH, name) for name in GAUGE_NAMES}


def run(records, first=0):
    """Fractions of faulty records whose interval holds the truth, by constant, and in which a fault
    is named, by fault; fraction of clean records without a fault.
    """
    inside, named, clean = {name: [] for name in FREE}, {}, []
    for seed in range(first, first + records):
        calibration = fit(bench_record(floor=FLOOR, seed=seed), MUSCLE, FREE, whole=False)
        for estimate in calibration.parameters:
            truth = TRUE_VALUES[estimate.name]
            inside[estimate.name].append(estimate.low < truth < estimate.high)
            if estimate.name in GAUGE_NAMES:
                perfect = getattr(PERFECT, estimate.name)
                outside = not estimate.low < perfect < estimate.high
                named.setdefault(estimate.name, []).append(outside)
        kinds = {fault.kind for fault in calibration.fit_data.faults}
        named.setdefault("floor", []).append("floor" in kinds)
        named.setdefault("no other fault", []).append(kinds <= {"floor"})
        friction = calibration.friction
        named.setdefault("loop", []).append(friction is not None and friction.law is not None)
        data = select_fit_data(bench_record(PERFECT, loop=0.0, seed=seed), MUSCLE)
        clean.append(not data.gauge.faults and not data.faults)
    fractions = {name: float(np.mean(values)) for name, values in inside.items()}
    return fractions, {k: float(np.mean(v)) for k, v in named.items()}, float(np.mean(clean))


def test_a_sample_of_benches():
    inside, named, clean = run(3)
    assert min(named.values()) == clean == 1.0
    assert np.mean(list(inside.values())) > 0.6


@pytest.mark.slow
def test_many_benches():
    inside, named, clean = run(60)
    # three standard errors of a binomial fraction about 90 %
    assert all(abs(fraction - 0.9) < 3 * np.sqrt(0.09 / 60) for fraction in inside.values()), inside
    assert min(named.values()) >= 0.95
    assert clean >= 0.98


if __name__ == "__main__":
    import warnings

    warnings.simplefilter("ignore")
    count, first = (int(text) for text in (*sys.argv[1:], "0")[:2])
    for figures in run(count, first):
        print(figures)  # noqa: T201 a script's output
