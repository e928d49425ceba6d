"""Coverage: how often do the calibration's 90 % intervals contain the true value?

Virtual records of Table 1's two muscles, and of the second with a free strain that is the law's
times a polynomial of first and second order, with a load cell's noise of 0.5 % of full scale and
no other error, are fitted from the untuned muscle, each with its own seed, by the call that users
make. Printed and drawn: the share of intervals that contain the true value, with the error of
counting, and the mean error over the mean width.

With 1000 records a share of 90 % is counted to 1.9 % (two deviations). Much of this error is known:
on the same noise, exactly 90 % of the intervals of the linear theory contain the true value. The
deviation of their count is subtracted in proportion to the correlation of both (a control variate).
The remaining error is printed.

Records take their time: `--resume FILE` notes each, and a later run continues from there.

**Source:** control variates are textbook, Asmussen and Glynn (2007), V.2.

    python benchmarks/recovery.py --seeds 1000 --resume records.jsonl --out docs/_static
    python benchmarks/recovery.py --seeds 200 --samples 30 --out docs/_static --name sparse
"""

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from matplotlib.figure import Figure

import fascicle as fs
from fascicle.calibrate.calibration import slope_of
from fascicle.calibrate.fitting import fit
from fascicle.calibrate.least_squares import NORMAL, linearize
from fascicle.calibrate.readings import SmoothCurves
from fascicle.muscle.tuning import Tuning
from fascicle.plot.theme import (
    BLACK,
    BLUE,
    DOUBLE,
    GRAY,
    GREEN,
    VERMILION,
    letter,
    new_figure,
    styled,
    to_bytes,
)
from fascicle.records import VirtualDynamometer


NAMES = ["youngs_modulus_factor", "collapse_moment_factor", "hinge_stiffness_factor",
         "hinge_stiffness_slope", "transition_rate"]  # fmt: skip
IS_LINEAR = np.array([name == "hinge_stiffness_slope" for name in NAMES])  # others: logarithms
SLENDERNESS_10 = "kim2021_slenderness_10"
# the example, and coefficients of its free strain over the law's in pressure over the highest
MUSCLES: dict[str, tuple[str, tuple[float, ...]]] = {
    "slenderness 8": ("kim2021_slenderness_8", ()),
    "slenderness 10": (SLENDERNESS_10, ()),
    "order 1": (SLENDERNESS_10, (0.94, 0.1)),
    "order 2": (SLENDERNESS_10, (0.9, 0.3, -0.18)),
}
LOOKS = ((BLUE, "o"), (VERMILION, "s"), (GREEN, "^"), (BLACK, "D"))
LEVEL, GOAL = 0.9, (0.88, 0.92)
FEWEST = 100  # records for a control variate
TABLE_ROWS = 200  # of a truth's table, linear between them


def make_truth(title: str, pressures: np.ndarray) -> Any:
    """An example, with free strain and blocked force of smooth curves if it has coefficients."""
    name, quotient = MUSCLES[title]
    example: Any = fs.example(name)
    if not quotient:
        return example
    top = float(pressures.max())
    rows = np.unique(np.concatenate([np.linspace(0.02 * top, top, TABLE_ROWS), pressures[1:]]))
    blocked_force = np.asarray(example.blocked_force(rows))
    line = np.polynomial.polynomial.polyfit(rows / top, blocked_force, 1)
    curves = np.concatenate([quotient, np.zeros(4 - len(quotient)), line])
    c1, c2 = SmoothCurves(example, rows, top).corrections(curves)
    factors = {name: getattr(example.tuning, name) for name in NAMES}
    return example.replace(tuning=Tuning(rows, c1, c2, **factors))


def recover(title: str, options: argparse.Namespace) -> list[dict]:
    """Values, intervals, and linear errors of each record."""
    key = [title, options.samples]
    rows = {row["seed"]: row for row in load_rows(options.resume) if row["key"] == key}
    machine = VirtualDynamometer(samples=options.samples)
    truth = make_truth(title, np.asarray(machine.pressures))
    untuned = fs.Muscle(
        truth.length, truth.outer_radius, truth.wall_thickness, truth.braid_angle, truth.material
    )
    first = machine.record(truth, seed=0)
    exact = attrs.evolve(machine, noise=0.0).record(truth, seed=0).force
    influence, sigma = None, machine.noise * float(np.abs(exact).max())
    for seed in (seed for seed in range(options.seeds) if seed not in rows):
        force = machine.record(truth, seed).force
        begin = time.process_time()
        result = fit(replace(first, force=force), untuned)
        seconds = time.process_time() - begin
        assert list(result.names) == NAMES
        if influence is None:
            influence = linear_influence(result)
        noise = mean_noise(result, force - exact)
        rows[seed] = {
            "key": key, "seed": seed, "seconds": seconds,
            "fit": [[p.value, p.low, p.high] for p in result.parameters],
            "linear": linear_errors(influence, noise, sigma),
        }  # fmt: skip
        if options.resume is not None:
            with options.resume.open("a") as file:
                file.write(json.dumps(rows[seed]) + "\n")
        if seed % 50 == 49:
            print(title, seed + 1, flush=True)
    return [rows[seed] for seed in range(options.seeds)]


def load_rows(path: Path | None) -> list[dict]:
    """Rows of an earlier run."""
    if path is None or not path.exists():
        return []
    return [json.loads(line) for line in path.read_text().splitlines()]


def linear_influence(result: Any) -> tuple[np.ndarray, np.ndarray]:
    """Errors of the parameters by a newton in each cell of the tables, linear in curves and
    coordinates, and the number of readings of each cell. It is that of one record's fit: that the
    linear theory is a little off there makes it a worse control variate, not a wrong one.
    """
    at = linearize(result.problem, result.coordinates, by_curves=True)
    count = np.where(result.grid.measured, result.grid.count, 0.0).reshape(-1)
    root = np.sqrt(count)
    slopes = at.force_slopes.reshape(root.size, -1) * root[:, None]
    K = np.linalg.pinv(slopes)[: len(NAMES)] * root
    scale = np.eye(len(NAMES))
    scale[IS_LINEAR] = slope_of(result.problem, result.coordinates)[IS_LINEAR]
    return scale @ K, np.maximum(count, 1.0)


def linear_errors(
    influence: tuple[np.ndarray, np.ndarray], noise: np.ndarray, sigma: float
) -> list[float]:
    """Linear error of each parameter over its deviation, standard normal."""
    K, count = influence
    return (K @ noise.reshape(-1) / (sigma * np.sqrt(np.sum(K**2 / count, axis=1)))).tolist()


def mean_noise(result: Any, noise: np.ndarray) -> np.ndarray:
    """Mean noise of the readings of each cell of the tables."""
    data, (levels, columns) = result.fit_data, result.grid.count.shape
    cell, size = data.level * columns + data.column, levels * columns
    return np.bincount(cell, noise, size) / np.maximum(np.bincount(cell, minlength=size), 1)


def evaluate(title: str, rows: list[dict]) -> dict:
    """Shares that contain the true value, with the deviation of counting, and the mean error."""
    truth = make_truth(title, np.asarray(VirtualDynamometer().pressures))
    exact = np.array([float(getattr(truth.tuning, name)) for name in NAMES])
    value, low, high = np.moveaxis(np.array([row["fit"] for row in rows]), -1, 0)
    linear = np.array([row["linear"] for row in rows])
    share, error = coverage((low < exact) & (exact < high), linear)
    return {
        "names": NAMES,
        "coverage": share.tolist(),
        "coverage_error": error.tolist(),
        "bias": (np.mean(value - exact, axis=0) / np.mean(high - low, axis=0)).tolist(),
        "seconds": float(np.median([row["seconds"] for row in rows])),
    }


def coverage(contains: np.ndarray, linear: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The share that contains the true value, and its deviation, corrected by what the linear
    theory counts on the same noise.
    """
    if len(contains) < FEWEST:  # too few for a correlation
        deviation = np.sqrt(LEVEL * (1 - LEVEL) / len(contains))
        return contains.mean(axis=0), np.full(len(NAMES), deviation)
    count, control = contains.astype(float), (np.abs(linear) < NORMAL) - LEVEL
    centered, control_centered = count - count.mean(axis=0), control - control.mean(axis=0)
    variance = np.maximum(np.sum(control_centered**2, axis=0), 1e-12)  # without any: factor 0
    factor = np.sum(centered * control_centered, axis=0) / variance
    share = np.mean(count - factor * control, axis=0)
    return share, np.std(centered - factor * control_centered, axis=0) / np.sqrt(len(count))


@styled
def draw(results: dict, seeds: int) -> Figure:
    """Figure of coverage and bias."""
    figure, axes = new_figure(1, 2, DOUBLE, 0.34 * DOUBLE, sharey=True)
    left, right = axes[0]
    for i, (title, result) in enumerate(results.items()):
        y = np.arange(len(NAMES)) + 0.16 * (i - 1.5)
        color, mark = LOOKS[i]
        error = 1.96 * 100 * np.array(result["coverage_error"])
        share = 100 * np.array(result["coverage"])
        left.errorbar(share, y, xerr=error, color=color, fmt=mark, label=title)
        right.plot(100 * np.array(result["bias"]), y, mark, color=color, label=title)
    left.axvspan(100 * GOAL[0], 100 * GOAL[1], color=GRAY, alpha=0.2, linewidth=0)
    left.axvline(90, color=GRAY, linewidth=0.8, linestyle="--")
    left.set_yticks(range(len(NAMES)), [name.replace("_", " ") for name in NAMES])
    left.set_xlabel("90 % intervals that contain the true value [%]")
    left.set_xlim(77, 99)
    left.invert_yaxis()
    right.axvspan(-10, 10, color=GRAY, alpha=0.2, linewidth=0)
    right.set_xlabel("Mean error over mean width [%]")
    right.set_xlim(-15, 15)
    right.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    letter(left, "a", f"{seeds} synthetic records")
    letter(right, "b", "bias")
    return figure


def main() -> None:
    """Fit the records, print the shares, and write them with a figure."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=1000, help="records of each muscle")
    parser.add_argument("--samples", type=int, default=200, help="readings of a sweep, each way")
    parser.add_argument("--only", choices=list(MUSCLES), action="append", help="these muscles")
    parser.add_argument("--resume", type=Path, default=None, help="file in which records are noted")
    parser.add_argument("--out", type=Path, default=None, help="folder for the results")
    parser.add_argument("--name", default="recovery", help="name of the files there")
    options = parser.parse_args()
    results = {title: evaluate(title, recover(title, options))
               for title in options.only or MUSCLES}  # fmt: skip
    print(f"{options.seeds} synthetic records each; goal: {GOAL[0]:.0%} to {GOAL[1]:.0%};")
    print("after each share two deviations of its count")
    for title, result in results.items():
        print(f"{title}: {result['seconds']:.2f} s of CPU for a fit")
        for i, name in enumerate(NAMES):
            share = f"{result['coverage'][i]:6.1%} ± {2 * result['coverage_error'][i]:.1%}"
            print(f"  {name:24s} {share}  bias {result['bias'][i]:+.3f}")
    if options.out is not None:
        text = json.dumps(
            {
                "seeds": options.seeds,
                "samples": options.samples,
                "muscles": results,
            },
            indent=1,
        )
        (options.out / f"{options.name}.json").write_text(text + "\n")
        figure = draw(results, options.seeds)
        (options.out / f"{options.name}.png").write_bytes(to_bytes(figure, "png"))


if __name__ == "__main__":
    main()
