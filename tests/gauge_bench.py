"""A plain bench in NumPy: a muscle's force, read by gauges with errors. Its records are synthetic.

The order of a test: vented, pressure by pressure, vented again. Nothing of the fit's code is used.
"""

import numpy as np

import fascicle as fs
from fascicle.calibrate.gauges import Gauge
from fascicle.muscle.materials import MooneyRivlin
from fascicle.records.record import Record


MUSCLE = fs.Muscle(0.2, 9.5e-3, 1.5e-3, np.radians(26), material="latex")
CONSTANTS = {"c10": 150e3, "c01": 70e3}
TRUE = MUSCLE.replace(material=MooneyRivlin(**CONSTANTS, youngs_modulus=6 * 220e3))
TRUTH = Gauge(force_zero=8.0, force_gain=1.03, force_drift=0.01, pressure_zero=1.5e3)
LEVELS = (0.0, 1e5, 2e5, 3e5, 4e5, 5e5, 0.0)  # Pa


PRESSURE_NOISE = 300.0  # Pa


def bench_record(
    gauge=TRUTH, loop=0.06, floor=None, noise=0.5, seed=0, samples=25, muscle=TRUE,
    pressure_noise=PRESSURE_NOISE,
):  # fmt: skip
    """Record of a `muscle` on a bench with the errors of a `gauge`.

    `loop`: width over the force [-]; `floor`: least reading [N]; `noise`: of forces [N]; `samples`:
    readings of one way; `pressure_noise`: [Pa].
    """
    rng = np.random.default_rng(seed)
    there = np.linspace(0.0, 1.0, samples)
    share, branch = np.append(there, there[::-1]), np.repeat([1, -1], samples)
    P = np.repeat(LEVELS, share.size)
    longest = np.repeat([0.02 if level == 0 else 0.30 for level in LEVELS], share.size)
    strain, branch = longest * np.tile(share, len(LEVELS)), np.tile(branch, len(LEVELS))
    time = 1.0 * np.arange(P.size)
    pull = np.asarray(muscle.force(P, strain))
    pull = pull - branch * loop / 2 * np.abs(pull)
    force = gauge.force_gain * pull + gauge.force_zero + gauge.force_drift * time
    force = force + rng.normal(0, noise, force.size)
    if floor is not None:
        force = np.maximum(force, floor)
    pressure = P + gauge.pressure_zero + rng.normal(0, pressure_noise, P.size)
    strain = strain + gauge.displacement_zero / 0.2
    return Record.of(
        pressure, strain, force, branch=branch, time=time, rest_length=0.2, synthetic=True,
        notes=("synthetic: a bench with errors of its gauges",),
    )  # fmt: skip
