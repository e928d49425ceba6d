"""A fit of the paper's factors, compared with SciPy's from the same start.

13 pressures × 200 strains, synthetic; four factors are free, of which the hinge's is two numbers.
Three ways: the library's search from one start, `least_squares` of SciPy with finite differences
on the same residuals, and on residuals of `scipy_script.py`.

    python benchmarks/fitting.py
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares
from scipy_script import Tube, force_field
from timing import Row, Times, run, take_turns

import fascicle as fs
from fascicle.calibrate.data import fit_table
from fascicle.calibrate.least_squares import Problem, solve
from fascicle.calibrate.parameters import FACTORS, coordinates
from fascicle.records import VirtualDynamometer


TOLERANCE = 1e-8  # N: between residuals of both; the hinge's force is steep at the free strain


def make_problem(samples: int) -> Problem:
    """The factors' problem on a synthetic record, with its blocked force and free strain."""
    truth = fs.example("kim2021_slenderness_10")
    untuned = fs.Muscle(
        truth.length, truth.outer_radius, truth.wall_thickness, truth.braid_angle, truth.material
    )
    record = VirtualDynamometer(samples=samples, both_ways=False).record(truth, seed=1)
    grid = fit_table(record).grid
    weight = (grid.strain > truth.free_strain(grid.pressure)).astype(float)
    start = np.asarray(coordinates(FACTORS, untuned))
    deviations = np.array([factor.deviation for factor in FACTORS])
    return Problem(untuned, grid, weight, 1.0, start, deviations, FACTORS)


def rows(small: bool = False) -> list[Row]:
    """Times over the library's."""
    problem = make_problem(20 if small else 200)
    grid, start, tube = problem.grid, np.asarray(problem.center), Tube.of(problem.muscle)
    pressure, strain, weight = np.asarray(grid.pressure)[:, 0], grid.strain, problem.weight

    def script_force(z: np.ndarray) -> np.ndarray:
        modulus, collapse, hinge, rate = np.exp(z[[0, 1, 2, 4]])
        slope = (np.logaddexp(z[3], 0.0) - hinge) / 1e6
        tuned = replace(tube, E=modulus * tube.E, collapse_factor=collapse, hinge_factor=hinge,
                        hinge_slope=slope, beta=rate)  # fmt: skip
        return force_field(tuned, pressure, strain)

    def residuals(force: np.ndarray, z: np.ndarray) -> np.ndarray:
        misfit = weight * (grid.force - force)
        return np.concatenate([misfit.ravel(), (z - start) / problem.deviation])

    def minimize(force_of: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        return least_squares(lambda z: residuals(force_of(z), z), start, xtol=1e-8, ftol=1e-8).x

    difference = np.max(np.abs(weight * (script_force(start) - problem.force(start))))
    assert difference < TOLERANCE, f"the script's residuals differ by {difference:.1e} N"
    ways = {
        "fascicle": lambda: solve(problem, start[None]).points[0],
        "SciPy on the same residuals": lambda: minimize(problem.force),
        "SciPy on residuals of the script": lambda: minimize(script_force),
    }
    costs = [np.sum(residuals(problem.force(z), z) ** 2) for z in (way() for way in ways.values())]
    assert costs[0] <= 1.001 * min(costs), f"SciPy finds a lower minimum: {costs}"
    times: Times = take_turns(ways, rounds=1 if small else 5, budget=60.0)
    size = f"{len(pressure)} pressures × {strain.shape[-1]} strains"
    return [
        Row(f"a fit of four factors, {size}", times.ratio(name, "fascicle"), "×",
            f"{name}, {times.median(name):.2g} s", note=f"sum of squares {cost / costs[0]:.4f} ×")
        for name, cost in zip(ways, costs, strict=True) if name != "fascicle"
    ]  # fmt: skip


if __name__ == "__main__":
    run(rows, __doc__)
