"""Every benchmark, one after another, each in a process of its own, into one table.

    python benchmarks/run_all.py            # writes benchmarks/RESULTS.md
    python benchmarks/run_all.py --small    # only whether all of them run, in a minute or two

Rows come in the order of the list below. A GPU's rows are measured where there is one, or
taken from `gpu.json` beside this file, which `gpu.py --json` has written on another machine.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from machine import describe
from timing import Row, load, options, table


HERE = Path(__file__).parent
RESULTS, FROM_GPU = HERE / "RESULTS.md", HERE / "gpu.json"
MODULES = (
    "force_field",
    "scattered_points",
    "point_derivatives",
    "muscle_gradient",
    "many_muscles",
    "against_scipy",
    "bundle_free_strain",
    "efficiency_maps",
    "one_point",
    "first_call",
    "command_line",
    "field_memory",
    "growing",
    "cores",
    "inverse",
    "designing",
    "in_time",
    "control_reach",
    "exported",
    "robots",
    "training",
    "fitting",
    "roofline",
    "gpu",
)


def rows_of(module: str, small: bool) -> list[Row]:
    """Rows of one benchmark, from a process of its own."""
    surroundings = dict(os.environ)
    if module != "gpu":
        surroundings["JAX_PLATFORMS"] = "cpu"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "rows.json")
        command = [sys.executable, str(HERE / f"{module}.py"), "--json", str(path)]
        ran = subprocess.run([*command, "--small"] if small else command, env=surroundings)  # noqa: S603, PLW1510 this folder's own files; the code is looked at
        if ran.returncode != 0:
            return [Row(module, None, "", limit=f"it ended with code {ran.returncode}")]
        rows = load(path)
    if module == "gpu" and FROM_GPU.exists() and all(row.figure is None for row in rows):
        return load(FROM_GPU)
    return rows


def farthest(rows: list[Row]) -> str:
    """The two rows that are slowest against what was hoped for."""
    known = [(row.shortfall, row) for row in rows if row.shortfall is not None]
    first = sorted(known, key=lambda one: -one[0])[:2]
    told = []
    for place, (short, row) in enumerate(first, start=1):
        how = f"misses its reach by a factor of {short:.2g}"
        if short <= 1:
            how = f"within its reach by a factor of {1 / short:.2g}"
        told.append(f"{place}. {row.question}, {row.cells()[2]}: {how}.")
    return "\n".join(["The two that are slowest against their reach:", "", *told])


def written(rows: list[Row], machine: dict[str, str], spent: float) -> str:
    """The text of RESULTS.md."""
    facts = "; ".join(f"{name} {value}" for name, value in machine.items())
    missed = sum(row.met is False for row in rows)
    held = sum(row.met is not None for row in rows)
    return f"""# Results of the benchmarks

Written by `make bench`, which measures everything again. The page "How fast, and why" in `docs`
says what is measured.

<!-- from here on the documentation shows it -->

Measured: {facts}. The whole run took {spent / 60:.1f} minutes.

{table(rows)}

{held - missed} of {held} are within reach. {farthest(rows)}
"""


def main() -> None:
    """Run all, print all, and write the table unless small."""
    given = options(__doc__)
    machine, begun = describe(), time.perf_counter()
    rows: list[Row] = []
    for module in MODULES:
        start = time.perf_counter()
        print(f"{module}:", flush=True)
        rows += rows_of(module, given.small)
        print(f"{time.perf_counter() - start:.0f} s\n", flush=True)
    text = written(rows, machine, time.perf_counter() - begun)
    print(text)
    if not given.small:
        RESULTS.write_text(text)
        print(RESULTS)
    if any(not row.unit for row in rows):
        raise SystemExit("a benchmark failed: see above")


if __name__ == "__main__":
    main()
