"""Benches with a law of their own, calibrated by the plain command's choices: intervals hold the
truth, and the band the readings of a second bench.

`python tests/validation/test_lab_bench.py 60` prints the figures for 60 benches.
"""

import sys

import numpy as np

import fascicle as fs
from fascicle.calibrate import select_model
from fascicle.records.record import Record
from fascicle.report.calibration_figures import fit_plot


TUBE = {"c10": 110e3, "c01": 95e3, "braid_angle": np.radians(26.0), "outer_radius": 6e-3}
LENGTH, WALL = 0.18, 1.2e-3  # m
SWEEPS = np.arange(100e3, 401e3, 50e3)  # Pa
FRICTION = 1.5, 0.04  # N, and of the force
REVERSAL = 8e-3  # of strain, in which friction turns around
GAUGES = {"force_zero": 5.0, "pressure_zero": 2e3, "force_drift": 0.02}  # deviations [SI]
NOISE, PRESSURE_NOISE = 0.5, 600.0  # N, Pa


def pull(pressure, strain):
    """Force [N]: minus the slope with length of the rubber's energy less the gas's work."""
    a, r0 = TUBE["braid_angle"], TUBE["outer_radius"]
    fiber, turn = LENGTH / np.cos(a), LENGTH * np.tan(a) / r0
    wall = np.pi * (r0**2 - (r0 - WALL) ** 2) * LENGTH

    def energy(length):
        radius = np.sqrt(fiber**2 - length**2) / turn
        stretches = np.stack([length / LENGTH, radius / r0, LENGTH * r0 / (length * radius)])
        rubber = TUBE["c10"] * (np.sum(stretches**2, 0) - 3)
        rubber += TUBE["c01"] * (np.sum(stretches**-2, 0) - 3)
        return wall * rubber - pressure * np.pi * radius**2 * length

    length, step = LENGTH * (1 - strain), 1e-6
    return (energy(length + step) - energy(length - step)) / (2 * step)


def bench(gauge, seed, samples=40):
    """Sweeps both ways while the muscle pulls, read with noise and the errors of a `gauge`."""
    rng, there = np.random.default_rng(seed), np.linspace(0, 1, samples)
    P = np.repeat(SWEEPS, 2 * samples)
    ends = 0.24 * np.minimum(SWEEPS / 300e3, 1.0) ** 0.5
    strain = (ends[:, None] * np.append(there, there[::-1])).ravel()
    slip = np.full(strain.size, -1.0)
    for i in range(1, strain.size):
        slip[i] = np.clip(slip[i - 1] + 2 * (strain[i] - strain[i - 1]) / REVERSAL, -1, 1)
    force, time = pull(P, strain), 0.1 * np.arange(strain.size)
    force = force - slip * (FRICTION[0] + FRICTION[1] * force)
    force += gauge["force_zero"] + gauge["force_drift"] * time + rng.normal(0, NOISE, time.size)
    pressure = P + gauge["pressure_zero"] + rng.normal(0, PRESSURE_NOISE, time.size)
    return Record.of(pressure, strain, force, time=time, rest_length=LENGTH, synthetic=True)


def share_in_band(fitted, record):
    """Share of the readings of a new `record` in the band of a fit."""
    band, inside = fit_plot(fitted), []
    new = fitted.gauge.correct(record)
    levels = np.argmin(np.abs(new.pressure - band.pressure[:, None]), axis=0)
    for i, strain, force in zip(levels, new.strain, new.force, strict=True):
        curves = band.curve_force[i], band.half_width[i]
        middle, half = (np.interp(strain, band.curve_strain[i], values) for values in curves)
        if np.isfinite(middle):
            inside.append(abs(force - middle) < half)
    return np.mean(inside)


def run(count, first=0):
    """Whether intervals hold the truth, by constant, and shares of new readings in the band."""
    start = fs.Muscle(LENGTH, 6e-3, WALL, np.radians(25.0))
    inside, shares = {}, []
    for seed in range(first, first + count):
        rng = np.random.default_rng(seed)
        gauge = {name: deviation * rng.normal() for name, deviation in GAUGES.items()}
        truth = TUBE | gauge
        fitted = select_model(bench(gauge, seed), start).calibration
        for e in fitted.parameters:
            inside.setdefault(e.name, []).append(e.low < truth.get(e.name, np.nan) < e.high)
        shares.append(share_in_band(fitted, bench(gauge, seed + 10**6)))
    return inside, shares


def test_a_sample_of_benches():
    inside, shares = run(3)
    assert {*TUBE, "force_zero", "pressure_zero"} <= {*inside}
    assert np.mean([hit for hits in inside.values() for hit in hits]) > 0.6
    assert 0.85 < np.mean(shares) < 0.95


if __name__ == "__main__":
    inside, shares = run(int(sys.argv[1]))
    lines = [f"new readings in the band: {np.mean(shares):.1%}"]
    for name, hits in inside.items():
        error = 2 * np.sqrt(0.9 * 0.1 / len(hits))
        lines.append(f"{name:16s} {np.mean(hits):6.1%} ± {error:.1%} of {len(hits)} that fit it")
    print(*lines, sep="\n")  # noqa: T201 a script's output
