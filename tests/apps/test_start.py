"""How commands start: JAX is loaded once it is made ready, and its imports are never collected."""

import os
import subprocess
import sys

import pytest


BUNDLE, MUSCLE = "kim2021_bundle_1_1", "kim2021_figure_6"
# a file of data that isn't there ends a calibration after its muscle was read
COMMANDS = (
    ("force", MUSCLE),
    ("bundle", BUNDLE),
    ("calibrate", "none.csv", "--muscle", MUSCLE),
)
ENDED = """
import gc, sys
from fascicle.cli import main, startup
ready, made = startup._load, []
def loaded():
    made.append("jax" in sys.modules)
    ready()
startup._load = loaded
try:
    main({arguments!r})
except SystemExit:
    pass
print("jax before it was made ready:", made[0])
print("kept for good:", gc.get_freeze_count() > 100_000, "collecting again:", gc.isenabled())
"""


@pytest.mark.parametrize(
    "arguments",
    [COMMANDS[0], *(pytest.param(one, marks=pytest.mark.slow) for one in COMMANDS[1:])],
    ids=lambda arguments: arguments[0],
)
def test_imports_are_made_ready_and_kept_for_good(tmp_path, arguments):
    done = subprocess.run(
        [sys.executable, "-c", ENDED.format(arguments=list(arguments))],
        cwd=tmp_path,
        env=os.environ | {"FASCICLE_NO_CACHE": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.splitlines()[-2:] == [
        "jax before it was made ready: False",
        "kept for good: True collecting again: True",
    ]


def test_a_process_of_somebody_elses_collects_as_before():
    kept = "import gc, jax\nfrom fascicle.cli import main\ntry: main(['force', 'x'])\n"
    done = subprocess.run(
        [sys.executable, "-c", kept + "except SystemExit: print(gc.get_freeze_count())"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == "0\n"
