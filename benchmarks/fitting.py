"""A fit of the paper's factors against SciPy's, from the same start to the same minimum.

13 pressures × 200 strains, synthetic, past the free strain four factors free (the hinge's
is two numbers). Three ways, interleaved: the library's search from one start; SciPy's
`least_squares` with finite differences on the very same residuals; and on residuals
as a good student would write them, in NumPy, the roots by `brentq` at each pressure.

    python benchmarks/fitting.py
"""

import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import brentq, least_squares
from timing import Measured, Row, run

import fascicle as fs
from fascicle.calibrate.data import fit_table
from fascicle.calibrate.least_squares import Problem, solve
from fascicle.calibrate.parameters import FACTORS, coordinates, put, values
from fascicle.records import VirtualDynamometer


REPEATS = 5
OWN = "fascicle"


def problem(truth: fs.Muscle, untuned: fs.Muscle, samples: int = 200) -> Problem:
    """The factors' problem on a synthetic record, blocked force and free strain as they are."""
    record = VirtualDynamometer(samples=samples, both_ways=False).record(truth, seed=1)
    data = fit_table(record).grid
    past = data.strain > truth.free_strain(data.pressure)
    return Problem(
        untuned, data, past.astype(float), 1.0, np.asarray(coordinates(FACTORS, untuned)),
        np.array([one.deviation for one in FACTORS]), FACTORS,
    )  # fmt: skip


def zero(function: Callable[[float], float], low: float, high: float) -> float:
    root: Any = brentq(function, low, high, xtol=1e-14)
    return root


class Student:
    """The same residuals in NumPy, a loop over pressures and roots by `brentq`."""

    def __init__(self, problem: Problem):
        muscle, data = problem.muscle, problem.grid
        self.L0, self.r0, self.t0, self.a0 = (
            float(x)
            for x in (muscle.length, muscle.outer_radius, muscle.wall_thickness, muscle.braid_angle)
        )
        rubber: Any = muscle.material
        self.c10, self.c01, self.E, self.nu = (
            float(x) for x in (rubber.c10, rubber.c01, rubber.youngs_modulus, rubber.poisson_ratio)
        )
        self.P, self.eps, self.F = (np.asarray(x) for x in (data.pressure, data.strain, data.force))
        self.weight = np.asarray(problem.weight)
        self.center, self.deviation = np.asarray(problem.center), np.asarray(problem.deviation)

    def parts(self, P: float, eps: Any) -> tuple[Any, Any]:
        lam = 1 - eps
        ideal = 3 * lam**2 / np.tan(self.a0) ** 2 - 1 / np.sin(self.a0) ** 2
        mesh = np.pi * self.r0**2 * P * ideal
        p, q = lam**2, (1 - np.cos(self.a0) ** 2 * lam**2) / np.sin(self.a0) ** 2
        dp, dq = 2 * lam, -2 * lam / np.tan(self.a0) ** 2
        cross = dp * q + p * dq
        slope = self.c10 * (dp + dq - cross / (p * q) ** 2)
        slope = slope + self.c01 * (-dp / p**2 - dq / q**2 + cross)
        return mesh, np.pi * (self.r0**2 - (self.r0 - self.t0) ** 2) * slope

    def row(
        self, P: float, eps: np.ndarray, E: float, moment: float, hinge: float, rate: float
    ) -> np.ndarray:
        """Force at one pressure, over strain."""
        ri = self.r0 - self.t0
        EI, EA = E * np.pi / 4 * (self.r0**4 - ri**4), E * np.pi * (self.r0**2 - ri**2)
        free = 0.0 if P < 1e-9 else zero(lambda e: sum(self.parts(P, e)), -0.05, 0.5)
        Lf = self.L0 * (1 - free)

        def share(xi: float) -> float:
            a = 4 * np.pi**2 * EI * (1 + xi) / (Lf**2 * EA * xi * (1 - xi) ** 4)

            def residual(w: float) -> float:
                h = np.sqrt(1 - w * xi / (2 - xi)) / (1 - w * xi)
                return a * h / (1 + a * h) - w

            return zero(residual, 0.0, 1.0)

        def bent(xi: float) -> float:
            return 2 / np.pi * Lf * np.sqrt(max(xi * (1 - share(xi)) * (1 - xi), 0.0))

        def largest(xi: float) -> float:
            return 2 * np.pi**2 * EI * bent(xi) / (Lf * (1 - xi)) ** 2

        grid = np.linspace(0.01, 0.95, 60)
        heights = np.array([largest(xi) for xi in grid])
        top = grid[np.argmax(heights)]
        collapse = np.inf
        if heights.max() > moment:
            reached = zero(lambda x: largest(x) - moment, 1e-9, top)
            collapse = free + reached * (1 - free)

        def buckled(e: float) -> float:
            xi = (e - free) / (1 - free)
            w = share(xi)
            mesh, _ = self.parts(P, free + xi * w * (1 - free))
            return mesh + self.parts(P, free)[1] - EA * xi * w * (1 - xi) / (1 - xi * w)

        force = np.empty(eps.size)
        for i, e in enumerate(eps):
            if e <= free:
                force[i] = sum(self.parts(P, e))
            elif e <= collapse:
                force[i] = buckled(e)
            else:
                x = (e - free) * self.L0
                halves = EI * np.pi**2 * (Lf + x) / (4 * (Lf - x) ** 3)
                Fc = halves + hinge / np.sqrt(x * (Lf - x))
                force[i] = -Fc + (buckled(collapse) + Fc) * np.exp(-rate * (e - collapse))
        return force

    def residuals(self, z: np.ndarray) -> np.ndarray:
        factor, on_moment, at_rest, rate = np.exp(z[[0, 1, 2, 4]])
        slope = (np.logaddexp(z[3], 0.0) - at_rest) / 1e6
        E, out = factor * self.E, []
        for P, eps in zip(self.P[:, 0], self.eps, strict=True):
            stiff = 1 / (1 - self.nu**2) + 4 * P / E * self.r0 / self.t0
            brazier = 2 * np.sqrt(2) / 9 * np.pi * E * self.r0 * self.t0**2 * np.sqrt(stiff)
            hinge = (at_rest + slope * P) * np.pi * E * self.r0 * self.t0**2 / 4
            out.append(self.row(P, eps, E, on_moment * brazier, hinge, rate))
        r = self.weight * (self.F - np.array(out))
        return np.concatenate([r.ravel(), (z - self.center) / self.deviation])


def rows(small: bool = False) -> list[Row]:
    """Times against the library's, and where each way ends."""
    truth: Any = fs.example("kim2021_slenderness_10")
    untuned = fs.Muscle.from_dimensions(
        truth.length, truth.outer_radius, truth.wall_thickness, truth.braid_angle, truth.material
    )
    task = problem(truth, untuned, 20 if small else 200)
    start = np.asarray(task.center)
    student = Student(task)

    def own(z: np.ndarray) -> np.ndarray:
        r = student.weight * (student.F - task.force(z))
        return np.concatenate([r.ravel(), (z - student.center) / student.deviation])

    first = own(start)
    apart = np.max(np.abs(first - student.residuals(start)))
    ways = {
        OWN: lambda: solve(task, start[None]).points[0],
        "SciPy on the same residuals": lambda: least_squares(own, start, xtol=1e-8, ftol=1e-8).x,
        "SciPy on residuals of a loop": lambda: (
            least_squares(student.residuals, start, xtol=1e-8, ftol=1e-8).x
        ),
    }
    if small:
        del ways["SciPy on residuals of a loop"]
    print(f"residuals differ by at most {apart:.1e} N between both")
    times: dict[str, list[float]] = {name: [] for name in ways}
    for turn in range(1 + (1 if small else REPEATS)):
        for name, way in ways.items():
            plain = name.endswith("loop")
            if plain and turn:
                continue  # it takes a minute: once is enough
            begun = time.perf_counter()
            end = way()
            if turn or plain:
                times[name].append(time.perf_counter() - begun)
            if not turn:
                cost = 0.5 * float(np.sum(own(end) ** 2))
                fitted = np.asarray(values(FACTORS, put(FACTORS, untuned, end)))
                numbers = ", ".join(f"{x:.5g}" for x in fitted)
                print(f"{name:38s} cost {cost:.6f}  {numbers}")
    fastest = statistics.median(times[OWN])
    return [
        Row(
            "a fit of four factors, 13 pressures × 200 strains",
            Measured.of(np.array(times[name]) / fastest),
            "×",
            f"{name}, {statistics.median(times[name]):.2g} s",
        )
        for name in ways
        if name != OWN
    ]


if __name__ == "__main__":
    run(rows, __doc__)
