"""First answers: new processes, with no cache of compiled functions.

Of imports, commands and the README's first snippet the whole process counts, with its bytecode, as
an installer leaves it; times beyond that of `python -c "import numpy"` have it as their floor. A
call is made once in a process, and its CPU seconds count without the imports before it.

    python benchmarks/first_call.py
"""

import compileall
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from timing import Quartiles, Row, Times, run

import fascicle


FOLDER = Path(__file__).parent
README = FOLDER.parent / "README.md"
SNIPPET = re.compile(r"```python\n(.*?)```", re.DOTALL)
NUMPY = (sys.executable, "-c", "import numpy")
FASCICLE = str(Path(sys.executable).with_name("fascicle"))
MUSCLE = 'import fascicle as fs; m = fs.example("kim2021_figure_6"); P, e = 1e5, 0.1'
BUNDLE = 'import fascicle as fs; b = fs.example("kim2021_bundle_five"); P = [4e5, 3e5, 1e5, 0, 0]'
ELASTICA = """
import math, fascicle as fs
m = fs.Muscle(0.127, 6.35e-3, 1.6e-3, math.radians(24), buckling="elastica")
b = fs.Bundle([fs.MotorUnit(m), fs.MotorUnit(m, 4)], supply_pressure=4e5)
"""
FIRST_FORCE = """
import fascicle as fs
fs.Muscle(0.127, 6.35e-3, 1.6e-3, 0.576).force(1e5, 0.1)
"""
# the call, what runs before it, and the goal [CPU s]
CALLS = {
    "`muscle.force`, one point": (MUSCLE, "m.force(P, e)", 0.02),
    "`muscle.force`, 100 points": (f"{MUSCLE}; import numpy as np; e = np.linspace(0, 0.3, 100)",
                                   "m.force(P, e)", 0.02),
    "`muscle.free_strain`": (MUSCLE, "m.free_strain(P)", 0.02),
    "`muscle.collapse_strain`": (MUSCLE, "m.collapse_strain(P)", 0.02),
    "`muscle.shape`": (MUSCLE, "m.shape(P, 0.3)", 0.02),
    "`bundle.force`, 5 units": (BUNDLE, "b.force(P, 0.1)", 0.05),
    "`bundle.free_strain`, 5 units": (BUNDLE, "b.free_strain(P)", 0.05),
    "`bundle.equilibria`, 5 units": (BUNDLE, "b.equilibria(P)", 0.05),
    "`bundle.free_strain`, elastica": (ELASTICA, "b.free_strain([4e5, 1e5])", 0.3),
    "`average_efficiency`, 5 units": (f"{BUNDLE}; from fascicle.bundle.energetics import "
                                      "average_efficiency", "average_efficiency(b, 4e5)", 1.0),
    "`recruit`, one demand": (BUNDLE, "fs.recruitment.recruit(b, 50.0, 0.1, 4e5)", 0.3),
    "`recruit`, 1000 demands": (f"{BUNDLE}; import numpy as np; F = np.linspace(-20, 300, 1000)",
                                "fs.recruitment.recruit(b, F, 0.1, 4e5)", 2.0),
    "`jax.grad` of a force by the muscle": (
        f"{MUSCLE}; import jax", "jax.grad(lambda m: m.force(P, e))(m).length.block_until_ready()",
        6.0),
    "10 s of 1 + 4 muscles on gas": ("from simulation import simulate_gas", "simulate_gas(10.0)",
                                     4.0),
}  # fmt: skip
# wall seconds beyond `import numpy`
QUICK_COMMANDS = {
    "force": ("kim2021_slenderness_10",),
    "recruit": ("kim2021_bundle_1_4", "--force", "50N", "--strain", "0.1"),
    "space": ("kim2021_bundle_1_4",),
}
QUICK = 0.35  # s
# goals in CPU s
COMMANDS = {
    "--help": ((), 0.2),
    "efficiency": (("kim2021_bundle_1_4",), 2.5),
    "bundle": (("kim2021_bundle_1_4",), 1.5),
    "design": (("task.toml", "--json"), 6.0),
}


class Processes:
    """New processes in a folder, without a cache."""

    def __init__(self, folder: str):
        kept = {k: v for k, v in os.environ.items() if not k.startswith(("JAX_", "FASCICLE_"))}
        path = os.pathsep.join(filter(None, [str(FOLDER), kept.get("PYTHONPATH")]))
        self.folder = folder
        self.environment = {**kept, "FASCICLE_NO_CACHE": "1", "JAX_PLATFORMS": "cpu",
                            "PYTHONPATH": path}  # fmt: skip

    def run(self, *command: str) -> tuple[float, float, str]:
        """Wall seconds and CPU seconds of a command, and its output."""
        before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        process = subprocess.run(  # noqa: S603 this package's own commands
            command, env=self.environment, cwd=self.folder, capture_output=True, text=True,
            check=True,
        )  # fmt: skip
        wall, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        return wall, cpu, process.stdout

    def take_turns(self, commands: Mapping[str, Sequence[str]], rounds: int) -> tuple[Times, Times]:
        """Wall times and CPU times of commands in turn, after a first run that writes bytecode."""
        names = [name for _ in range(1 + rounds) for name in commands]
        seconds = [self.run(*commands[name])[:2] for name in names]
        later = np.array(seconds).reshape(1 + rounds, len(commands), 2)[1:]
        wall, cpu = ({name: later[:, i, clock] for i, name in enumerate(commands)}
                     for clock in (0, 1))  # fmt: skip
        return Times(wall), Times(cpu)


def process_rows(processes: Processes, small: bool) -> list[Row]:
    """Whole processes."""
    snippet = SNIPPET.findall(README.read_text(encoding="utf-8"))[0]
    processes.run(FASCICLE, "init", "--task")
    commands = {name: (FASCICLE, name, *arguments) for name, arguments in QUICK_COMMANDS.items()}
    others = {name: (FASCICLE, name, *arguments) for name, (arguments, _) in COMMANDS.items()}
    scripts = {"first force": FIRST_FORCE, "snippet": snippet}
    python = {name: (sys.executable, "-c", code) for name, code in scripts.items()}
    everything = {"numpy": NUMPY, **python, **commands, **({} if small else others)}
    wall, cpu = processes.take_turns(everything, 1 if small else 7)
    floor = f"`import numpy`: {cpu.median('numpy'):.2f} s of CPU, {wall.median('numpy'):.2f} s"
    rows = [Row("`import fascicle` and a first force, CPU beyond `import numpy`",
                cpu.difference("first force", "numpy"), "s", floor, at_most=0.15)]  # fmt: skip
    for name in commands:
        note = f"{cpu.difference(name, 'numpy').median:.2f} s of CPU"
        rows.append(Row(f"`fascicle {name}`, wall beyond `import numpy`",
                        wall.difference(name, "numpy"), "s", floor, at_most=QUICK, note=note)
                    )  # fmt: skip
    rows.append(Row("README's first snippet, CPU", cpu.of("snippet"), "s", floor, at_most=1.5))
    return rows + [
        Row(f"`fascicle {name}`, CPU", cpu.of(name), "s", floor, at_most=goal)
        for name, (_, goal) in COMMANDS.items()
        if name in everything
    ]


def call_rows(processes: Processes, small: bool) -> list[Row]:
    """CPU seconds of first calls."""
    rows = []
    for name, (setup, call, goal) in list(CALLS.items())[: 1 if small else None]:
        code = (f"{setup}\nimport time\nbegin = time.process_time()\n{call}\n"
                "print(time.process_time() - begin)")  # fmt: skip
        seconds = [float(processes.run(sys.executable, "-c", code)[2])
                   for _ in range(1 if small else 3)]  # fmt: skip
        rows.append(Row(f"first call: {name}, CPU", Quartiles.of(seconds), "s", at_most=goal))
    return rows


def calibration_rows(processes: Processes, small: bool) -> list[Row]:
    """A calibration of a synthetic record; the largest memory of all processes."""
    rows = []
    if not small:
        processes.run(FASCICLE, "record", "kim2021_slenderness_10", "-o", "record.csv", "--samples",
                      "25", "--pressure", "0kPa:360kPa:40kPa")  # fmt: skip
        _, cpu, _ = processes.run(FASCICLE, "calibrate", "record.csv", "-m",
                                  "kim2021_slenderness_10", "--json")  # fmt: skip
        rows.append(Row("`fascicle calibrate`, 500 readings, CPU", Quartiles.of([cpu]), "s",
                        at_most=10))  # fmt: skip
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024 / 1e9
    name = "memory of the largest of these processes"
    return [*rows, Row(name, Quartiles.of([peak]), "GB", at_most=0.7)]


def rows(small: bool = False) -> list[Row]:
    """Processes, calls and calibrations."""
    # a changed checkout is read as source each time under PYTHONDONTWRITEBYTECODE
    compileall.compile_dir(Path(fascicle.__file__).parent, quiet=1)
    with tempfile.TemporaryDirectory() as folder:
        processes = Processes(folder)
        return [
            *process_rows(processes, small),
            *call_rows(processes, small),
            *calibration_rows(processes, small),
        ]


if __name__ == "__main__":
    run(rows, __doc__)
