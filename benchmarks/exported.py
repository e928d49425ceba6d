"""A muscle as C: what a call of the table takes, compiled by gcc -O2, at points in random order.

Force and volume of one muscle from the table of doubles, 65 × 81 nodes, and of floats, 33 × 41;
nanoseconds of processor time a call, a million calls a round. Beside them a controller's step: the
force's cascade with "threshold", of a bundle of 1 + 4 muscles, at measurements that wander; and the
inverse of that bundle, at demands up to its largest force and beyond.

    python benchmarks/exported.py
"""

import shutil
import subprocess
import tempfile
from pathlib import Path

from timing import Measured, Row, run

import fascicle as fs
from fascicle import control, dynamics, fluid
from fascicle.export import write_table


POINTS = """
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
#define TIMED(call) t = clock(); for (i = 0; i < N; i++) { call; } \\
        if (k) printf("%.2f ", 1e9 * (double)(clock() - t) / CLOCKS_PER_SEC / N)
        TIMED(wide_force(P + i, eps[i], &F, 0, 0); sum += F);
        TIMED(wide_volume(P + i, eps[i], V); sum += V[0]);
        TIMED(slim_force(p + i, e[i], &f, 0, 0); sum += f);
        TIMED(at[0] = P[i]; at[1] = P[N - 1 - i];
              knee_step(&memory, 3e-4 * P[i], 1e-4 * P[i], at, 4e5, 0.1 + 0.1 * eps[i], 0.01, u);
              sum += u[0]);
        TIMED(knee_pressures(2e-3 * P[i] - 20, eps[i], 413.7e3, at, 0, 0); sum += at[0]);
    }
    return sum == 0;
}
"""


def controller() -> control.Cascade:
    bundle = fs.example("kim2021_bundle_1_4")
    plant = dynamics.Plant(
        bundle, dynamics.HangingMass(mass=5.0), fluid.ConstantSupply(413.7e3), fluid.Isothermal(),
        fluid.SonicValve(1e-9, 0.3),
    )  # fmt: skip
    return control.cascade(plant, "threshold")


def rows(small: bool = False) -> list[Row]:
    questions = (
        "one force, a table of doubles in C",
        "one volume, a table of doubles in C",
        "one force, a table of floats in C",
        "one controller's step in C, 1 + 4 muscles",
        "pressures for one force by a table in C, 1 + 4 muscles",
    )
    gcc = shutil.which("gcc")
    if gcc is None:
        return [Row(question, None, "ns", limit="there is no gcc here") for question in questions]
    muscle = fs.example("kim2021_figure_6")
    sizes = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, precision in (("wide", "double"), ("slim", "float")):
            _, source = write_table(muscle, folder, name, precision, highest_pressure=413.7e3)
            ran = [gcc, "-O2", "-c", str(source), "-o", str(Path(folder, f"{name}.o"))]
            subprocess.run(ran, check=True)  # noqa: S603 what was just written
            sizes[name] = Path(folder, f"{name}.o").stat().st_size
        _, source = write_table(controller(), folder, "knee")
        ran = [gcc, "-O2", "-c", str(source), "-o", str(Path(folder, "knee.o"))]
        subprocess.run(ran, check=True)  # noqa: S603 as above
        sizes["knee"] = Path(folder, "knee.o").stat().st_size
        main, program = Path(folder, "main.c"), str(Path(folder, "main"))
        main.write_text(POINTS, encoding="utf-8")
        counts = f"-DN={1000 if small else 1_000_000}", f"-DROUNDS={3 if small else 15}"
        objects = [str(Path(folder, f"{name}.o")) for name in ("wide", "slim", "knee")]
        build = [gcc, "-O2", *counts, "-o", program, str(main), *objects, "-lm"]
        subprocess.run(build, check=True)  # noqa: S603 as above
        told = subprocess.run([program], capture_output=True, text=True, check=True)  # noqa: S603 as above
    taken = [float(x) for x in told.stdout.split()]
    rooms = sizes["wide"], sizes["wide"], sizes["slim"], sizes["knee"], sizes["knee"]
    reaches = 48.0, 48.0, 48.0, None, 5000.0
    return [
        Row(
            question,
            Measured.of(taken[i :: len(questions)]),
            "ns",
            reach=reach,
            side="≤",
            limit=f"{room / 1e3:.0f} kB of machine code and numbers",
        )
        for i, (question, room, reach) in enumerate(zip(questions, rooms, reaches, strict=True))
    ]


if __name__ == "__main__":
    run(rows, __doc__)
