"""Every benchmark in a process of its own, into one table.

    python benchmarks/run_all.py                             # writes benchmarks/RESULTS.md
    python benchmarks/run_all.py --only first_call bundles   # the same, of some of them
    python benchmarks/run_all.py --small                     # only whether they run

A small run takes about two minutes of CPU.
"""

import datetime as dt
import os
import platform
import subprocess
import sys
import tempfile
import time
from importlib.metadata import version
from pathlib import Path

from timing import Row, load_rows, parse_options, table


FOLDER = Path(__file__).parent
RESULTS = FOLDER / "RESULTS.md"
MODULES = (
    "first_call", "against_scipy", "bundles", "fitting", "design_evaluation", "simulation",
    "explorer", "exported_c",
)  # fmt: skip


def measure(module: str, small: bool) -> list[Row] | None:
    """Rows of one benchmark; `None` if it failed."""
    environment = {**os.environ, "JAX_PLATFORMS": "cpu"}
    if small:
        environment["XLA_FLAGS"] = "--xla_backend_optimization_level=0"  # compiles sooner
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "rows.json")
        command = [sys.executable, str(FOLDER / f"{module}.py"), "--json", str(path)]
        process = subprocess.run([*command, "--small"] if small else command, env=environment)  # noqa: S603, PLW1510 this folder's own files; the code is looked at
        return load_rows(path) if process.returncode == 0 else None


def describe_machine() -> str:
    """The machine, its load and the versions that a table of times belongs to."""
    cores = len(os.sched_getaffinity(0)) if sys.platform == "linux" else os.cpu_count()
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    packages = ("fascicle", "numpy", "scipy", "jax")
    versions = ", ".join(f"{package} {version(package)}" for package in packages)
    return (
        f"{dt.datetime.now(tz=dt.UTC):%Y-%m-%d %H:%M} UTC; {processor()}, {cores} cores, "
        f"{memory:.0f} GiB; {platform.system()} {platform.machine()}; "
        f"Python {platform.python_version()}, {versions}; load {load()} before the run"
    )


def load() -> str:
    """Mean number of processes that ran or waited in the last minute."""
    return f"{os.getloadavg()[0]:.1f}"


def processor() -> str:
    """Name of the processor."""
    path = Path("/proc/cpuinfo")
    lines = path.read_text().splitlines() if path.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def results_page(rows: list[Row], machine: str, seconds: float, left_out: list[str]) -> str:
    """Text of RESULTS.md."""
    omission = f" Left out of this run: {', '.join(left_out)}." if left_out else ""
    missed = sorted(
        (row for row in rows if row.met is False), key=lambda row: -(row.shortfall or 0)
    )
    judged = sum(row.met is not None for row in rows)
    lines = [f"- {row.name}: by a factor of {row.shortfall:.2g}" for row in missed]
    return "\n".join(
        [
            "# Results of the benchmarks",
            "",
            "Written by `make bench`. The page *Speed* of the documentation explains the table.",
            "",
            "<!-- the documentation shows what follows -->",
            "",
            f"Measured {machine}, {load()} after it. The run took {seconds / 60:.1f} minutes."
            + omission,
            "",
            table(rows),
            "",
            f"{judged - len(missed)} of {judged} goals are met."
            + (" These are missed:" if missed else ""),
            "",
            *lines,
        ]
    ).rstrip() + "\n"  # fmt: skip


def main() -> None:
    """Run every benchmark, print the table, and write it unless small."""
    options = parse_options(__doc__, MODULES)
    machine, start = describe_machine(), time.perf_counter()
    rows, failed = [], []
    modules = options.only or MODULES
    for module in modules:
        begin = time.perf_counter()
        print(f"{module}:", flush=True)
        measured = measure(module, options.small)
        rows += measured or []
        failed += [module] if measured is None else []
        print(f"{time.perf_counter() - begin:.0f} s\n", flush=True)
    left_out = [module for module in MODULES if module not in modules]
    text = results_page(rows, machine, time.perf_counter() - start, left_out)
    print(text)
    if failed:
        raise SystemExit(f"These benchmarks failed, see above: {', '.join(failed)}.")
    if not options.small:
        RESULTS.write_text(text)


if __name__ == "__main__":
    main()
