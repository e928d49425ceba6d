"""How often does the calibration's 90 % interval hold the truth?

Virtual records of Table 1's two muscles, with a load cell's noise of 0.5 % of full scale and
nothing else, are fitted from the untuned muscle, each with its own seed, by the same call
that users make. Printed and drawn: the share of intervals that hold the truth, and the mean
error over the mean width.

    python benchmarks/recovery.py --seeds 1000 --out docs/_static
    python benchmarks/recovery.py --seeds 200 --samples 30 --out docs/_static --name sparse
"""

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

import fascicle as fs
from fascicle.calibrate.fits.fitting import fit
from fascicle.plot.style import BLUE, DOUBLE, GRAY, VERMILION, letter, new_figure, styled, to_bytes
from fascicle.records import VirtualDynamometer


MUSCLES = {"slenderness 8": "kim2021_slenderness_8", "slenderness 10": "kim2021_slenderness_10"}
MEANT = (0.87, 0.93)


def recover(name: str, seeds: int, samples: int) -> dict:
    truth: Any = fs.example(name)
    untuned = fs.Muscle.from_dimensions(
        truth.length, truth.outer_radius, truth.wall_thickness, truth.braid_angle, truth.material
    )
    dynamometer = VirtualDynamometer(samples=samples)
    first = dynamometer.record(truth, seed=0)
    forces = np.asarray(dynamometer.forces(truth, range(seeds))).reshape(seeds, -1)
    tuning = truth.tuning
    real = np.array([
        tuning.youngs_modulus_factor, tuning.collapse_moment_factor,
        tuning.hinge_stiffness_factor, tuning.hinge_stiffness_slope, tuning.transition_rate,
    ])  # fmt: skip
    found, spent, names = [], [], []
    for place, force in enumerate(forces):
        if place % 100 == 99:
            print(place + 1, flush=True)
        begun = time.perf_counter()
        made = fit(replace(first, force=force), untuned)
        spent.append(time.perf_counter() - begun)
        names = list(made.names)
        found.append([[one.value, one.low, one.high] for one in made.parameters])
    value, low, high = np.moveaxis(np.array(found), -1, 0)
    return {
        "names": names,
        "coverage": np.mean((low < real) & (real < high), axis=0).tolist(),
        "bias": (np.mean(value - real, axis=0) / np.mean(high - low, axis=0)).tolist(),
        "seconds": float(np.median(spent)),
    }


@styled
def draw(results: dict, seeds: int) -> Figure:
    names = next(iter(results.values()))["names"]
    figure, axes = new_figure(1, 2, DOUBLE, 0.34 * DOUBLE, sharey=True)
    for place, (title, one) in enumerate(results.items()):
        y = np.arange(len(names)) + 0.12 * (2 * place - 1)
        color, mark = ((BLUE, "o"), (VERMILION, "s"))[place]
        p = np.array(one["coverage"])
        error = 1.96 * np.sqrt(p * (1 - p) / seeds)
        axes[0, 0].errorbar(100 * p, y, xerr=100 * error, color=color, fmt=mark, label=title)
        axes[0, 1].plot(100 * np.array(one["bias"]), y, mark, color=color, label=title)
    axes[0, 0].axvspan(100 * MEANT[0], 100 * MEANT[1], color=GRAY, alpha=0.2, linewidth=0)
    axes[0, 0].axvline(90, color=GRAY, linewidth=0.8, linestyle="--")
    axes[0, 1].axvspan(-10, 10, color=GRAY, alpha=0.2, linewidth=0)
    axes[0, 0].set_yticks(range(len(names)), [n.replace("_", " ") for n in names])
    axes[0, 0].set_xlabel("90 % intervals that hold the truth [%]")
    axes[0, 1].set_xlabel("Mean error over mean width [%]")
    axes[0, 0].set_xlim(82, 98)
    axes[0, 1].set_xlim(-15, 15)
    axes[0, 1].legend(loc="upper right")
    letter(axes[0, 0], "a", f"coverage, {seeds} synthetic records")
    letter(axes[0, 1], "b", "bias")
    axes[0, 0].invert_yaxis()
    return figure


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=1000)
    parser.add_argument("--samples", type=int, default=200, help="of a sweep, each way")
    parser.add_argument("--out", type=Path, default=None)
    parser.add_argument("--name", default="recovery", help="of the files there")
    given = parser.parse_args()
    results = {title: recover(name, given.seeds, given.samples) for title, name in MUSCLES.items()}
    print(f"{given.seeds} synthetic records each; meant: {MEANT[0]:.0%} to {MEANT[1]:.0%}")
    for title, one in results.items():
        print(f"{title}: {one['seconds']:.2f} s a fit")
        for name, share, bias in zip(one["names"], one["coverage"], one["bias"], strict=True):
            print(f"  {name:24s} {share:6.1%}  bias {bias:+.3f} of the width")
    if given.out is not None:
        (given.out / f"{given.name}.png").write_bytes(to_bytes(draw(results, given.seeds), "png"))
        text = json.dumps(
            {"seeds": given.seeds, "samples": given.samples, "muscles": results}, indent=1
        )
        (given.out / f"{given.name}.json").write_text(text + "\n")


if __name__ == "__main__":
    main()
