"""What a second core gives: two pinned processes against one.

Two cores of a virtual machine may be two threads of one real core, which then share its units for
arithmetic, or two cores that share memory. Each of two processes is pinned to a core of its own and
repeats a task for a while: divisions in registers' reach (1000 numbers in the nearest cache, where
only the unit that divides is at work), `x + 1` over memory that no cache holds, and scattered
points of the force law, compiled, on one thread. Told is the rate of both together through that of
one alone: 2 where the cores share nothing, 1 where they share what the task needs. Of the force law
also how many processors its process kept busy (processor seconds through seconds): 1 where it
really computes on one thread.

    python benchmarks/cores.py
"""

import json
import os
import subprocess
import sys

from timing import Measured, Row, run


CODE = """
import json, os, sys, time
core, task, seconds = int(sys.argv[1]), sys.argv[2], float(sys.argv[3])
os.sched_setaffinity(0, {core})
import numpy as np
if task == "divisions":
    x, y = np.linspace(1.0, 2.0, 1000), np.linspace(3.0, 4.0, 1000)
    def once():
        for _ in range(1000):
            np.divide(x, y, out=y)
elif task == "memory":
    x = np.zeros(30_000_000)
    def once():
        np.add(x, 1.0, out=x)
else:
    import jax
    import fascicle as fs
    rng = np.random.default_rng(0)
    P, e = jax.numpy.asarray(rng.uniform(0, [[4e5], [0.33]], (2, 300_000)))
    law = jax.jit(fs.example("kim2021_figure_6").force)
    def once():
        law(P, e).block_until_ready()
once()
print("ready", flush=True)
sys.stdin.readline()
begun, spent, rounds = time.perf_counter(), time.process_time(), 0
while time.perf_counter() - begun < seconds:
    once()
    rounds += 1
took = time.perf_counter() - begun
print(json.dumps([rounds / took, (time.process_time() - spent) / took]))
"""
ONE_THREAD = {
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1",
    "OPENBLAS_NUM_THREADS": "1",
    "JAX_PLATFORMS": "cpu",
}
TASKS = {
    "divisions": "1000 divisions in cache",
    "memory": "x + 1 over 240 MB",
    "law": "300,000 scattered forces, compiled",
}


def rates(task: str, cores: list[int], seconds: float) -> list[tuple[float, float]]:
    """Rounds a second of a `task` on each of `cores` at once, and processors each kept busy [-]."""
    workers = [
        subprocess.Popen(  # noqa: S603 this package's own code
            [sys.executable, "-c", CODE, str(core), task, str(seconds)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=os.environ | ONE_THREAD,
        )
        for core in cores
    ]  # fmt: skip
    for one in workers:
        assert one.stdout is not None
        assert one.stdout.readline() == "ready\n"
    for one in workers:
        assert one.stdin is not None
        one.stdin.write("\n")
        one.stdin.flush()
    return [tuple(json.loads(one.communicate()[0])) for one in workers]


def rows(small: bool = False) -> list[Row]:
    """Rate of two cores through that of one, and of the law the processors one kept busy."""
    cores = sorted(os.sched_getaffinity(0))[:2]
    if len(cores) < 2:
        return [Row("two cores", None, "×", limit="this process may use one core alone")]
    told, seconds = [], 0.2 if small else 3.0
    busy: dict[str, list[float]] = {}
    for task, name in TASKS.items():
        gains, busy[task] = [], []
        for _ in range(1 if small else 5):
            (alone, _), *_ = rates(task, cores[:1], seconds)
            both = rates(task, cores, seconds)
            gains.append(sum(rate for rate, _ in both) / alone)
            busy[task] += [processors for _, processors in both]
        told.append(
            Row(f"two pinned processes: {name}", Measured.of(gains), "×", "one process alone")
        )
    told.append(
        Row("processors one of the two keeps busy in the law", Measured.of(busy["law"]), "×")
    )
    return told


if __name__ == "__main__":
    run(rows, __doc__)
