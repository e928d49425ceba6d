"""How often does the calibration's 90 % interval hold the truth?

Virtual records of Table 1's two muscles, and of the second with a free strain that is the law's
times a polynomial of first and second order, with a load cell's noise of 0.5 % of full scale and
nothing else, are fitted from the untuned muscle, each with its own seed, by the same call that
users make. Printed and drawn: the share of intervals that hold the truth, quick ones and those of
the bootstrap, each with its counting error, and the mean error over the mean width.

The bootstrap is judged at its warp speed: a few simulated records for each record, the errors of
all of them pooled for the distribution that each record's own 199 would give it. `--full` simulates
the 199 of some records as well, as users do.

Of 1000 records a share of 90 % is counted to 1.9 % (two deviations), the pooled distribution errs
beside it. Much of that is known: of the linear theory, on the same noise, exactly 90 % hold, and
what the count makes of it is taken off in the proportion in which both go together (a control
variate). What is left of the counting error is printed.

Records take their time: `--kept FILE` notes each, and a later run goes on from there.

**Source:** Giacomini, Politis and White (2013) for the warp-speed bootstrap; control variates are
textbook, Asmussen and Glynn (2007), V.2.

    python benchmarks/recovery.py --seeds 1000 --kept kept.jsonl --out docs/_static
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
from fascicle.calibrate.calibration import slope_of, value_of
from fascicle.calibrate.fitting import fit
from fascicle.calibrate.intervals import refit, simulate_grid
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


FACTORS = ("youngs_modulus_factor", "collapse_moment_factor", "hinge_stiffness_factor",
           "hinge_stiffness_slope")  # fmt: skip
NAMES = [*FACTORS, "transition_rate"]
EVEN = np.array([name == "hinge_stiffness_slope" for name in NAMES])
TEN = "kim2021_slenderness_10"
# the example, and the free strain over the law's by powers of the pressure over the highest
MUSCLES: dict[str, tuple[str, tuple[float, ...]]] = {
    "slenderness 8": ("kim2021_slenderness_8", ()),
    "slenderness 10": (TEN, ()),
    "order 1": (TEN, (0.94, 0.1)),
    "order 2": (TEN, (0.9, 0.3, -0.18)),
}
LOOKS = ((BLUE, "o"), (VERMILION, "s"), (GREEN, "^"), (BLACK, "D"))
LEVEL, MEANT = 0.9, (0.88, 0.92)
_FEW = 100  # records
_DRAWN = 10_000  # seeds of simulated records from here on
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
    c1, c2 = SmoothCurves(example, rows, top).corrections(curves)
    old = example.tuning
    factors = {name: getattr(old, name) for name in NAMES}
    return example.replace(tuning=Tuning(rows, c1, c2, **factors))


def recover(title: str, seeds: int, samples: int, draws: int, kept: Path | None) -> list[dict]:
    """What was found of each record: values, intervals, simulated records, and linear errors."""
    rows = {row["seed"]: row for row in noted(kept) if row["of"] == [title, samples, draws]}
    machine = VirtualDynamometer(samples=samples)
    truth = truth_of(*MUSCLES[title], np.asarray(machine.pressures))
    untuned = fs.Muscle.from_dimensions(
        truth.length, truth.outer_radius, truth.wall_thickness, truth.braid_angle, truth.material
    )
    first = machine.record(truth, seed=0)
    clean = np.asarray(replace(machine, noise=0.0).forces(truth, [0])).reshape(-1)
    influence, sigma = None, machine.noise * float(np.abs(clean).max())
    for seed in (seed for seed in range(seeds) if seed not in rows):
        force = np.asarray(machine.forces(truth, [seed])).reshape(-1)
        begun = time.process_time()
        made = fit(replace(first, force=force), untuned)
        spent = time.process_time() - begun
        assert list(made.names) == NAMES
        if influence is None:
            influence = linear_errors(made)
        again = []
        rng = np.random.default_rng(_DRAWN + seed)
        for _ in range(draws):
            data = simulate_grid(made, rng)
            scatter = (
                made.diagnosis.noise if made.diagnosis.significant else float(made.problem.noise)
            )
            away = np.asarray(data.force) - made.force
            z = refit(made, data)
            again.append([value_of(made.problem, z).tolist(), of_grid(influence, away, scatter)])
        noise = in_places(made, force - clean)
        row = {
            "of": [title, samples, draws], "seed": seed,
            "found": [[one.value, one.low, one.high] for one in made.parameters],
            "linear": of_grid(influence, noise, sigma), "again": again, "seconds": spent,
        }  # fmt: skip
        rows[seed] = row
        if kept is not None:
            with kept.open("a") as file:
                file.write(json.dumps(row) + "\n")
        if seed % 50 == 49:
            print(title, seed + 1, flush=True)
    return [rows[seed] for seed in range(seeds)]


def noted(kept: Path | None) -> list[dict]:
    """Rows of an earlier run."""
    if kept is None or not kept.exists():
        return []
    return [json.loads(line) for line in kept.read_text().splitlines()]


def linear_errors(made: Any) -> tuple[np.ndarray, np.ndarray]:
    """By how much each parameter errs for a newton in each place of the tables, linear in the
    curves and coordinates; and how many readings each place averages. Taken at one record's fit:
    that the linear theory is a little off there makes it a worse control, not a wrong one.
    """
    at = linearize(made.problem, made.coordinates, by_curves=True)
    count = np.where(made.grid.measured, made.grid.count, 0.0)
    root = np.sqrt(count.reshape(-1))
    slopes = at.force_slopes.reshape(root.size, -1) * root[:, None]
    K = np.linalg.pinv(slopes)[: len(NAMES)] * root
    by = np.eye(len(NAMES))
    by[EVEN] = slope_of(made.problem, made.coordinates)[EVEN]
    return by @ K, np.maximum(count.reshape(-1), 1.0)


def of_grid(influence: tuple[np.ndarray, np.ndarray], noise: np.ndarray, sigma: float) -> list:
    """The linear error of each parameter over its deviation, a standard normal deviate."""
    K, count = influence
    deviation = sigma * np.sqrt(np.sum(K**2 / count, axis=1))
    return (K @ noise.reshape(-1) / deviation).tolist()


def in_places(made: Any, noise: np.ndarray) -> np.ndarray:
    """The readings' noise as the tables average it."""
    of, shape = made.fit_data, made.grid.count.shape
    flat = of.level * shape[1] + of.column
    size = shape[0] * shape[1]
    return np.bincount(flat, noise, size) / np.maximum(np.bincount(flat, minlength=size), 1)


def judged(title: str, rows: list[dict], samples: int, full: int) -> dict:
    """The shares that hold the truth, with the deviation of counting, and the mean error."""
    truth = truth_of(*MUSCLES[title], np.asarray(VirtualDynamometer().pressures))
    real = np.array([float(getattr(truth.tuning, name)) for name in NAMES])
    value, low, high = np.moveaxis(np.array([row["found"] for row in rows]), -1, 0)
    theirs = np.array([row["linear"] for row in rows])
    again = np.array([[one[0] for one in row["again"]] for row in rows])
    of_again = np.array([[one[1] for one in row["again"]] for row in rows])
    away = (on_scale(again) - on_scale(value)[:, None]).reshape(-1, real.size)
    errors = on_scale(value) - on_scale(real)
    least, most = np.quantile(away, [0.05, 0.95], axis=0)
    quick, quick_error = counted((low < real) & (real < high), theirs)
    hold, hold_error = counted((least < errors) & (errors < most), theirs)
    # between the pooled ends lie 90 % of what was drawn, and not quite of what might have been
    ends, ends_error = counted((least < away) & (away < most), of_again.reshape(away.shape))
    return {
        "names": NAMES,
        "coverage": quick.tolist(),
        "coverage_error": quick_error.tolist(),
        "bootstrap": np.clip(hold - ends + LEVEL, 0, 1).tolist(),
        "bootstrap_error": np.hypot(hold_error, ends_error).tolist(),
        "full": held(title, samples, full),
        "bias": (np.mean(value - real, axis=0) / np.mean(high - low, axis=0)).tolist(),
        "seconds": float(np.median([row["seconds"] for row in rows])),
    }


def counted(hold: np.ndarray, theirs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The share that holds, and its deviation, with what the linear theory's known share says of
    the same noise taken off.
    """
    if len(hold) < _FEW:  # too few to tell how both go together
        return hold.mean(axis=0), np.full(len(NAMES), np.sqrt(LEVEL * (1 - LEVEL) / len(hold)))
    I, known = hold.astype(float), (np.abs(theirs) < NORMAL) - LEVEL
    apart, own = I - I.mean(axis=0), known - known.mean(axis=0)
    factor = np.sum(apart * own, axis=0) / np.maximum(np.sum(own**2, axis=0), 1e-12)
    share = np.mean(I - factor * known, axis=0)
    return share, np.std(apart - factor * own, axis=0) / np.sqrt(len(I))


def held(title: str, samples: int, full: int) -> list[float] | None:
    """The share of intervals with all 199 draws that hold the truth, of so many records."""
    if not full:
        return None
    machine, good = VirtualDynamometer(samples=samples), []
    truth = truth_of(*MUSCLES[title], np.asarray(machine.pressures))
    untuned = truth.replace(tuning=Tuning())
    for seed in range(full):
        made = bootstrap(fit(machine.record(truth, seed=seed), untuned), seed=seed)
        real = [float(getattr(truth.tuning, name)) for name in NAMES]
        good.append([one.low < x < one.high for one, x in zip(made.parameters, real, strict=True)])
    return np.mean(good, axis=0).tolist()


def on_scale(values: np.ndarray) -> np.ndarray:
    """Values as intervals take them: logarithms but for the hinge's slope, which is even."""
    return np.where(EVEN, values, np.log(np.where(EVEN, 1.0, values)))


@styled
def draw(results: dict, seeds: int) -> Figure:
    names = next(iter(results.values()))["names"]
    figure, axes = new_figure(1, 2, DOUBLE, 0.34 * DOUBLE, sharey=True)
    for place, (title, one) in enumerate(results.items()):
        y = np.arange(len(names)) + 0.16 * (place - 1.5)
        color, mark = LOOKS[place]
        p = np.array(one["bootstrap"])
        error = 1.96 * np.array(one["bootstrap_error"])
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
    parser.add_argument("--draws", type=int, default=3, help="simulated records of each record")
    parser.add_argument("--kept", type=Path, default=None, help="where records are noted")
    parser.add_argument("--full", type=int, default=0, help="records with all 199 draws")
    parser.add_argument("--only", choices=list(MUSCLES), action="append", help="these truths")
    given = parser.parse_args()
    results = {}
    for title in given.only or MUSCLES:
        rows = recover(title, given.seeds, given.samples, given.draws, given.kept)
        results[title] = judged(title, rows, given.samples, given.full)
    print(f"{given.seeds} synthetic records each; meant: {MEANT[0]:.0%} to {MEANT[1]:.0%};")
    print("behind each share two deviations of counting it")
    for title, one in results.items():
        print(f"{title}: {one['seconds']:.2f} s of computing a fit")
        for i, name in enumerate(one["names"]):
            quick, boots = (
                f"{one[key][i]:6.1%} ± {2 * one[key + '_error'][i]:.1%}"
                for key in ("coverage", "bootstrap")
            )
            print(f"  {name:24s} quick {quick}  bootstrap {boots}  bias {one['bias'][i]:+.3f}")
        if one["full"]:
            print(f"  all 199 draws, {given.full} records:", *(f"{x:.1%}" for x in one["full"]))
    if given.out is not None:
        (given.out / f"{given.name}.png").write_bytes(to_bytes(draw(results, given.seeds), "png"))
        text = json.dumps(
            {
                "seeds": given.seeds,
                "samples": given.samples,
                "draws": given.draws,
                "muscles": results,
            },
            indent=1,
        )
        (given.out / f"{given.name}.json").write_text(text + "\n")


if __name__ == "__main__":
    main()
