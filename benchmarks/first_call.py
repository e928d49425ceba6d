"""The first answer of a fresh process, with nothing compiled before: what people wait for.

Each call is made once, in a process of its own, with an empty cache of compiled functions: CPU
seconds of that call alone, imports before it left out; of commands and of the README's first
snippet those of the whole process, whose bytecode is there, as an installer leaves it. Beside them
the CPU seconds of a process that only imports JAX.

    python benchmarks/first_call.py
"""

import compileall
import os
import re
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from real_record import DATA, find
from timing import Measured, Row, run

import fascicle


README = Path(__file__).parents[1] / "README.md"
SNIPPET = re.compile(r"```python\n(.*?)```", re.DOTALL)
MUSCLE = 'import fascicle as fs; m = fs.example("kim2021_figure_6"); P, e = 1e5, 0.1'
BUNDLE = 'import fascicle as fs; b = fs.example("kim2021_bundle_five"); P = [4e5, 3e5, 1e5, 0, 0]'
ELASTICA = """
import math, fascicle as fs
m = fs.Muscle.from_dimensions(0.127, 6.35e-3, 1.6e-3, math.radians(24), buckling="elastica")
b = fs.Bundle([fs.MotorUnit(m), fs.MotorUnit(m, 4)], supply_pressure=4e5)
"""
# what is called, what goes before it, the call, and the seconds that were hoped for
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
    "`average_efficiency`, 5 units": (f"{BUNDLE}; from fascicle.energetics import "
                                      "average_efficiency", "average_efficiency(b, 4e5)", 1.0),
    "`recruit`, one demand": (BUNDLE, "fs.recruitment.recruit(b, 50.0, 0.1, 4e5)", 0.3),
    "`recruit`, 1000 demands": (
        f"{BUNDLE}; import numpy as np; F = np.linspace(-20, 300, 1000)",
        "fs.recruitment.recruit(b, F, 0.1, 4e5)", 2.0),
    "gradient of a force by the muscle": (
        f"{MUSCLE}; import jax", "jax.grad(lambda m: m.force(P, e))(m).length.block_until_ready()",
        1.5),
}  # fmt: skip
COMMANDS = {
    "`fascicle force`": (("force", "kim2021_slenderness_10"), 0.9),
    "`fascicle recruit`": (
        ("recruit", "kim2021_bundle_1_4", "--force", "50N", "--strain", "0.1"), 1.5
    ),
    "`fascicle efficiency`": (("efficiency", "kim2021_bundle_1_4"), 2.5),
    "`fascicle space`": (("space", "kim2021_bundle_1_4"), 1.5),
    "`fascicle bundle`": (("bundle", "kim2021_bundle_1_4"), 1.5),
    "`fascicle design`, the template's task": (("design", "task.toml"), 6.0),
}  # fmt: skip
CALIBRATE = "`fascicle calibrate`, the DMSP-20's record"


def rows(small: bool = False) -> list[Row]:
    """CPU seconds of every first call; the memory of a calibration."""
    repeats, made = (1 if small else 3), []
    with tempfile.TemporaryDirectory() as folder:
        kept = {k: v for k, v in os.environ.items() if not k.startswith(("JAX_", "FASCICLE_"))}
        environment = {**kept, "FASCICLE_NO_CACHE": "1", "JAX_PLATFORMS": "cpu"}
        # a checkout that changed, under PYTHONDONTWRITEBYTECODE, is else read as source each time
        compileall.compile_dir(Path(fascicle.__file__).parent, quiet=1)
        python, command = sys.executable, str(Path(sys.executable).with_name("fascicle"))

        def process(*arguments: str) -> tuple[float, str]:
            """CPU seconds of a process, and what it printed."""
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            ran = subprocess.run(  # noqa: S603 this package's own command
                arguments, env=environment, cwd=folder, capture_output=True, text=True, check=True
            )
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            return spent, ran.stdout

        jax = Measured.of(process(python, "-c", "import jax")[0] for _ in range(repeats))
        floor = f"`import jax`, {jax.value:.2f} s"
        for name, (setting, call, reach) in list(CALLS.items())[: 2 if small else None]:
            code = (
                f"{setting}\nimport time\nbegun = time.process_time()\n{call}\n"
                "print(time.process_time() - begun)"
            )
            times = [float(process(python, "-c", code)[1]) for _ in range(repeats)]
            made.append(row(name, times, floor, reach))
        snippet = SNIPPET.findall(README.read_text(encoding="utf-8"))[0]
        times = [process(python, "-c", snippet)[0] for _ in range(repeats)]
        made.append(row("README's first snippet, whole process", times, floor, 1.5))
        process(command, "init", "--task")
        for name, (arguments, reach) in list(COMMANDS.items())[: 1 if small else None]:
            more = ("--json",) if arguments[0] == "design" else ()
            times = [process(command, *arguments, *more)[0] for _ in range(repeats)]
            made.append(row(f"{name}, whole process", times, floor, reach))
        return made if small else [*made, *calibration(process, command, floor)]


def row(name: str, seconds: list[float], floor: str, reach: float) -> Row:
    return Row(f"first call: {name}", Measured.of(seconds), "s", floor, reach, "≤")


def calibration(process: Callable[..., tuple[float, str]], command: str, floor: str) -> list[Row]:
    """Of the measured record, where it is; the memory is the largest of all these processes."""
    try:
        record = find()
    except SystemExit:
        return [Row(f"first call: {CALIBRATE}", None, "s", floor, limit=f"{DATA} isn't here")]
    sizes = ("--length", "300mm", "--outer-radius", "10mm", "--wall-thickness", "2mm",
             "--braid-angle", "28.6deg")  # fmt: skip
    told = ("calibrate", str(record), *sizes, "--rest-length", "300mm", "--json")
    spent, _ = process(command, *told)
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024 / 1e9
    return [
        row(CALIBRATE, [spent], floor, 12.0),
        Row("memory of the largest of these processes", Measured.of([peak]), "GB", "", 0.7, "≤"),
    ]


if __name__ == "__main__":
    run(rows, __doc__)
