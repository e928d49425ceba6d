"""How often does the calibration's 90 % interval hold the truth?

Virtual records of Table 1's two muscles, and of the second with a free strain that is the law's
times a polynomial of first and second order, with a load cell's noise of 0.5 % of full scale and
nothing else, are fitted from the untuned muscle, each with its own seed, by the same call that
users make. Printed and drawn: the share of intervals that hold the truth, quick ones and those of
the bootstrap, and the mean error over the mean width.

The bootstrap is judged at its warp speed: one simulated record for each record, the errors of all
of them pooled for the distribution that each record's own 199 would give it. `--full` simulates the
199 of some records as well, as users do.

**Source:** Giacomini, Politis and White (2013) for the warp-speed bootstrap.

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
from fascicle.calibrate import bootstrap
from fascicle.calibrate.after.bootstrap import fitted, simulated
from fascicle.calibrate.after.calibration import value_of
from fascicle.calibrate.data.readings import tables
from fascicle.calibrate.fits.fitting import fit
from fascicle.muscle.tuning import Tuning
from fascicle.plot.style import (
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


FACTORS = ("youngs_modulus_factor", "collapse_moment_factor", "hinge_stiffness_factor",
           "hinge_stiffness_slope")  # fmt: skip
TEN = "kim2021_slenderness_10"
# the example, and the free strain over the law's by powers of the pressure over the highest
MUSCLES: dict[str, tuple[str, tuple[float, ...]]] = {
    "slenderness 8": ("kim2021_slenderness_8", ()),
    "slenderness 10": (TEN, ()),
    "order 1": (TEN, (0.94, 0.1)),
    "order 2": (TEN, (0.9, 0.3, -0.18)),
}
LOOKS = ((BLUE, "o"), (VERMILION, "s"), (GREEN, "^"), (BLACK, "D"))
MEANT = (0.88, 0.92)
_ROWS = 200  # of a truth's table: between them it runs straight


def truth_of(name: str, quotient: tuple[float, ...], pressures: np.ndarray) -> Any:
    """An example, with the free strain and blocked force of smooth curves if they are given."""
    example: Any = fs.example(name)
    if not quotient:
        return example
    top = float(pressures.max())
    rows = np.unique(np.concatenate([np.linspace(0.02 * top, top, _ROWS), pressures[1:]]))
    blocked = np.asarray(example.blocked_force(rows))
    line = np.polynomial.polynomial.polyfit(rows / top, blocked, 1)
    curves = np.concatenate([quotient, np.zeros(4 - len(quotient)), line])
    c1, c2 = (np.asarray(x) for x in tables(example, curves, rows, top))
    old = example.tuning
    factors = {name: getattr(old, name) for name in (*FACTORS, "transition_rate")}
    return example.replace(tuning=Tuning(rows, c1, c2, **factors))


def recover(title: str, seeds: int, samples: int, full: int) -> dict:
    dynamometer = VirtualDynamometer(samples=samples)
    truth = truth_of(*MUSCLES[title], np.asarray(dynamometer.pressures))
    untuned = fs.Muscle.from_dimensions(
        truth.length, truth.outer_radius, truth.wall_thickness, truth.braid_angle, truth.material
    )
    first = dynamometer.record(truth, seed=0)
    forces = np.asarray(dynamometer.forces(truth, range(seeds))).reshape(seeds, -1)
    real = np.array([float(getattr(truth.tuning, name)) for name in (*FACTORS, "transition_rate")])
    rng = np.random.default_rng(1)
    found, away, spent, held, names = [], [], [], [], []
    for place, force in enumerate(forces):
        if place % 50 == 49:
            print(title, place + 1, flush=True)
        begun = time.perf_counter()
        made = fit(replace(first, force=force), untuned)
        spent.append(time.perf_counter() - begun)
        names = list(made.names)
        assert names == [*FACTORS, "transition_rate"]
        found.append([[one.value, one.low, one.high] for one in made.parameters])
        again = value_of(made.problem, fitted(made, simulated(made, rng)))
        away.append(on_scale(again) - on_scale(np.array([one.value for one in made.parameters])))
        if place < full:
            ends = bootstrap(made, seed=place).parameters
            held.append([one.low < x < one.high for one, x in zip(ends, real, strict=True)])
    value, low, high = np.moveaxis(np.array(found), -1, 0)
    least, most = np.quantile(np.array(away), [0.05, 0.95], axis=0)
    errors = on_scale(value) - on_scale(real)
    return {
        "names": names,
        "coverage": np.mean((low < real) & (real < high), axis=0).tolist(),
        "bootstrap": np.mean((least < errors) & (errors < most), axis=0).tolist(),
        "full": np.mean(held, axis=0).tolist() if held else None,
        "bias": (np.mean(value - real, axis=0) / np.mean(high - low, axis=0)).tolist(),
        "seconds": float(np.median(spent)),
    }


def on_scale(values: np.ndarray) -> np.ndarray:
    """Values as intervals take them: logarithms but for the hinge's slope, which is even."""
    even = np.arange(values.shape[-1]) == FACTORS.index("hinge_stiffness_slope")
    return np.where(even, values, np.log(np.where(even, 1.0, values)))


@styled
def draw(results: dict, seeds: int) -> Figure:
    names = next(iter(results.values()))["names"]
    figure, axes = new_figure(1, 2, DOUBLE, 0.34 * DOUBLE, sharey=True)
    for place, (title, one) in enumerate(results.items()):
        y = np.arange(len(names)) + 0.16 * (place - 1.5)
        color, mark = LOOKS[place]
        p = np.array(one["bootstrap"])
        error = 1.96 * np.sqrt(p * (1 - p) / seeds)
        axes[0, 0].errorbar(100 * p, y, xerr=100 * error, color=color, fmt=mark, label=title)
        axes[0, 0].plot(100 * np.array(one["coverage"]), y, mark, color=color, fillstyle="none")
        axes[0, 1].plot(100 * np.array(one["bias"]), y, mark, color=color, label=title)
    axes[0, 0].axvspan(100 * MEANT[0], 100 * MEANT[1], color=GRAY, alpha=0.2, linewidth=0)
    axes[0, 0].axvline(90, color=GRAY, linewidth=0.8, linestyle="--")
    axes[0, 1].axvspan(-10, 10, color=GRAY, alpha=0.2, linewidth=0)
    axes[0, 0].set_yticks(range(len(names)), [n.replace("_", " ") for n in names])
    axes[0, 0].set_xlabel("90 % intervals that hold the truth [%]")
    axes[0, 1].set_xlabel("Mean error over mean width [%]")
    axes[0, 0].set_xlim(77, 99)
    axes[0, 1].set_xlim(-15, 15)
    axes[0, 1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    letter(axes[0, 0], "a", f"{seeds} synthetic records; open: quick")
    letter(axes[0, 1], "b", "bias")
    axes[0, 0].invert_yaxis()
    return figure


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=1000)
    parser.add_argument("--samples", type=int, default=200, help="of a sweep, each way")
    parser.add_argument("--out", type=Path, default=None)
    parser.add_argument("--name", default="recovery", help="of the files there")
    parser.add_argument("--full", type=int, default=0, help="records with all 199 draws")
    parser.add_argument("--only", choices=list(MUSCLES), action="append", help="these truths")
    given = parser.parse_args()
    results = {
        title: recover(title, given.seeds, given.samples, given.full)
        for title in given.only or MUSCLES
    }
    error = 1.645 * np.sqrt(0.09 / given.seeds)
    print(f"{given.seeds} synthetic records each; meant: {MEANT[0]:.0%} to {MEANT[1]:.0%};")
    print(f"counting errs by {error:.1%} (90 %)")
    for title, one in results.items():
        print(f"{title}: {one['seconds']:.2f} s a fit")
        rows = zip(one["names"], one["coverage"], one["bootstrap"], one["bias"], strict=True)
        for name, share, boots, bias in rows:
            print(f"  {name:24s} quick {share:6.1%}  bootstrap {boots:6.1%}  bias {bias:+.3f}")
        if one["full"]:
            print(f"  all 199 draws, {given.full} records:", *(f"{x:.1%}" for x in one["full"]))
    if given.out is not None:
        (given.out / f"{given.name}.png").write_bytes(to_bytes(draw(results, given.seeds), "png"))
        text = json.dumps(
            {"seeds": given.seeds, "samples": given.samples, "muscles": results}, indent=1
        )
        (given.out / f"{given.name}.json").write_text(text + "\n")


if __name__ == "__main__":
    main()
