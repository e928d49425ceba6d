"""The command line, process by process: `fascicle force` the second time, and `fascicle --help`.

Wall time from start to end. The first run of `fascicle force` fills a cache of compiled
functions in a folder of its own; runs after it are measured. What imports take of it is the sum
over all modules that Python's own `-X importtime` prints.

    python benchmarks/command_line.py
"""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from timing import Measured, Row, interleaved, run


FORCE = ["force", "kim2021_slenderness_10"]
LINE = re.compile(r"^import time:\s+(\d+) \|", re.MULTILINE)


def rows(small: bool = False) -> list[Row]:
    repeats = 1 if small else 11
    with tempfile.TemporaryDirectory() as folder:
        kept = {k: v for k, v in os.environ.items() if not k.startswith(("JAX_", "FASCICLE_"))}
        surroundings = {**kept, "XDG_CACHE_HOME": folder, "LOCALAPPDATA": folder}

        def process(*arguments: str) -> str:
            ran = subprocess.run(  # noqa: S603 this package's own command
                arguments, env=surroundings, cwd=folder, capture_output=True, text=True, check=True
            )
            return ran.stderr

        python, command = sys.executable, str(Path(sys.executable).with_name("fascicle"))
        times = interleaved(
            {
                "python": lambda: process(python, "-c", "pass"),
                "jax": lambda: process(python, "-c", "import jax"),
                "help": lambda: process(command, "--help"),
                "force": lambda: process(command, *FORCE),
            },
            repeats,
            budget=60.0,
        )
        printed = [
            process(python, "-X", "importtime", "-m", "fascicle", *FORCE) for _ in range(repeats)
        ]
    imports = [sum(map(int, LINE.findall(text))) / 1e6 for text in printed]
    bare = f"`python -c pass` takes {times.median('python'):.3f} s"
    jax = f"`import jax` alone, as a process, takes {times.median('jax'):.2f} s"
    name = "`fascicle force`, second run"
    return [
        Row(name, times.each("force"), "s", bare, 1.2, "≤", jax),
        Row(f"{name}: of which imports", Measured.of(imports), "s", bare, 0.8, "≤", jax),
        Row("`fascicle --help`", times.each("help"), "s", bare, 0.2, "≤"),
    ]


if __name__ == "__main__":
    run(rows, __doc__)
