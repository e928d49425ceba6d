"""A muscle and a bundle as C, compiled by `gcc -O2`: CPU time of a call at points in random order.

Force and volume of a muscle from a table of doubles, 65 × 81 nodes, and of floats, 33 × 41, a
million calls a round; a step of the controller "threshold" of 1 + 4 muscles; and the pressures for
a force of that bundle, at demands up to its largest force and beyond.

    python benchmarks/exported_c.py
"""

import shutil
import subprocess
import tempfile
from pathlib import Path

from timing import Quartiles, Row, run

import fascicle as fs
from fascicle import control, dynamics, fluid
from fascicle.export import write_table


PROGRAM = """
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include "wide.h"
#include "slim.h"
#include "knee.h"
static double P[N], eps[N];
static float p[N], e[N];
int main(void)
{
    double F, V[1], sum = 0;
    float f;
    int i, k;
    double at[2], u[2];
    knee_memory memory;
    clock_t t;
    knee_begin(&memory);
    for (i = 0; i < N; i++) {
        p[i] = (float)(P[i] = 4e5 * rand() / RAND_MAX);
        e[i] = (float)(eps[i] = -0.1 + 0.45 * rand() / RAND_MAX);
    }
    for (k = 0; k <= ROUNDS; k++) {
#define TIME(call) t = clock(); for (i = 0; i < N; i++) { call; } \\
        if (k) printf("%.2f ", 1e9 * (double)(clock() - t) / CLOCKS_PER_SEC / N)
        TIME(wide_force(P + i, eps[i], &F, 0, 0); sum += F);
        TIME(wide_volume(P + i, eps[i], V); sum += V[0]);
        TIME(slim_force(p + i, e[i], &f, 0, 0); sum += f);
        TIME(at[0] = P[i]; at[1] = P[N - 1 - i];
             knee_step(&memory, 3e-4 * P[i], 1e-4 * P[i], at, 4e5, 0.1 + 0.1 * eps[i], 0.01, u);
             sum += u[0]);
        TIME(knee_pressures(2e-3 * P[i] - 20, eps[i], 413.7e3, at, 0, 0); sum += at[0]);
    }
    return sum == 0;
}
"""
# what is called, its source, and the goal [ns]
CALLS = (
    ("C: one force, a table of doubles", "wide", 48),
    ("C: one volume, a table of doubles", "wide", 48),
    ("C: one force, a table of floats", "slim", 48),
    ("C: one step of a controller, 1 + 4 muscles", "knee", None),
    ("C: pressures for one force by a table, 1 + 4 muscles", "knee", 5000),
)


def make_controller() -> control.Cascade:
    """Controller of 1 + 4 muscles."""
    plant = dynamics.Plant(
        fs.example("kim2021_bundle_1_4"), dynamics.HangingMass(mass=5.0),
        fluid.ConstantSupply(413.7e3), fluid.Isothermal(), fluid.SonicValve(1e-9, 0.3),
    )  # fmt: skip
    return control.cascade(plant, "threshold")


def compile_and_run(gcc: str, small: bool) -> tuple[list[float], dict[str, int]]:
    """Nanoseconds of the calls, round by round, and the size of each compiled source [B]."""
    muscle = fs.example("kim2021_figure_6")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shape = (17, 21) if small else None
        sources = {
            "wide": write_table(muscle, folder, "wide", "double", 413.7e3, shape)[1],
            "slim": write_table(muscle, folder, "slim", "float", 413.7e3, shape)[1],
            "knee": write_table(make_controller(), folder, "knee")[1],
        }
        objects = {source: folder / f"{source}.o" for source in sources}
        for source, path in sources.items():
            command = [gcc, "-O2", "-c", str(path), "-o", str(objects[source])]
            subprocess.run(command, check=True)  # noqa: S603 what was just written
        main, program = folder / "main.c", folder / "main"
        main.write_text(PROGRAM, encoding="utf-8")
        counts = f"-DN={1000 if small else 1_000_000}", f"-DROUNDS={3 if small else 15}"
        command = [gcc, "-O2", *counts, "-o", program, main, *objects.values(), "-lm"]
        subprocess.run(command, check=True)  # noqa: S603 as above
        output = subprocess.run([program], capture_output=True, text=True, check=True).stdout  # noqa: S603 as above
        sizes = {source: path.stat().st_size for source, path in objects.items()}
    return [float(x) for x in output.split()], sizes


def rows(small: bool = False) -> list[Row]:
    """Nanoseconds of calls."""
    gcc = shutil.which("gcc")
    if gcc is None:
        return [Row(name, None, "ns", note="it needs gcc") for name, *_ in CALLS]
    times, sizes = compile_and_run(gcc, small)
    return [
        Row(name, Quartiles.of(times[i :: len(CALLS)]), "ns", at_most=goal,
            note=f"{sizes[source] / 1e3:.0f} kB of machine code and numbers")
        for i, (name, source, goal) in enumerate(CALLS)
    ]  # fmt: skip


if __name__ == "__main__":
    run(rows, __doc__)
