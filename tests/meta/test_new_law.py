"""The trial in CONTRIBUTING: a new tension law of two constants is its own file, nothing else."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest


ROOT = Path(__file__).parents[2]
LAW = '''"""A toy: the ideal law with a loss that grows with strain, and friction of either sign."""

from typing import ClassVar

from ...core.parameters import POSITIVE, Constant, symmetric_scale
from ...core.types import Batch, BatchLike
from ..bladder import Bladder
from . import AbstractTension, Offset, Pull, solved_free_strain


class Toy2026(AbstractTension):
    """The ideal law, less what two constants take."""

    name: ClassVar[str] = "toy2026"
    title: ClassVar[str] = "Toy"
    source: ClassVar[str] = "nobody (2026)"
    conservative: ClassVar[bool] = False

    loss: Batch = Constant(
        "loss", "k_l", "number", (1e-3, 0.01, 10.0, 100.0), POSITIVE, 0.5, "that grows with strain"
    ).field()
    friction: Batch = Constant(
        "friction", "p_f", "pressure", (-1e5, -1e4, 1e4, 1e5), symmetric_scale(1e3), 0.0,
        "of the threads"
    ).field()

    def pull(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Pull:
        """Mesh force [N] at `pressure` [Pa] and `strain` [-], less what is lost; none of a wall."""
        mesh, slope = bladder.braid.mesh(pressure, strain)
        unit = 1e-4 * (1e5 * self.loss + self.friction)
        return Pull(mesh - unit * strain, 0.0 * mesh, slope - unit, 0.0 * slope)

    def free_strain(self, bladder: Bladder, pressure: BatchLike, offset: Offset) -> Batch:
        """The root of what is left [-] at `pressure` [Pa]."""
        return solved_free_strain(self, bladder, pressure, offset)
'''


HEAD = """
import json, math, sys
from pathlib import Path
import numpy as np
import fascicle as fs
law = fs.tension.Toy2026(0.7, -300.0)
muscle = fs.Muscle(0.2, 10e-3, 2e-3, math.radians(27), tension=law)
assert fs.__file__.startswith(sys.argv[1]), fs.__file__
"""

READERS = {
    "files": """
fs.save(muscle, "toy.toml")
text = Path("toy.toml").read_text()
law_text = '[muscle.tension]\\nlaw = "toy2026"\\nloss = 0.7\\nfriction = "-0.3 kPa"\\n'
assert law_text in text, text
assert fs.load("toy.toml") == muscle
plain = muscle.replace(tension="toy2026")
fs.save(plain, "toy.toml")
assert 'tension = "toy2026"' in Path("toy.toml").read_text()
assert fs.load("toy.toml") == plain
from fascicle.files import loads
for wrong in ("friction = 3", "loss = -1", "los = 1"):
    try:
        loads(text.replace("loss = 0.7", wrong).replace('friction = "-0.3 kPa"\\n', ""))
    except ValueError as error:
        assert wrong in str(error), error
    else:
        raise AssertionError(wrong)
""",
    "explorer": """
from dataclasses import replace
from fascicle.explorer.muscle_curves import alternative_laws
from fascicle.explorer.muscle_tab import MuscleInputs
from fascicle.explorer.state import Session, view_of
assert "tension:toy2026" in alternative_laws(muscle.replace(tension="ideal"))
session = Session(view_of(muscle, "toy"))
inputs = MuscleInputs(session)
session.watch(lambda before, after: inputs.show(after))
inputs.show(session.view)
own = inputs.laws["tension"]
assert own.fields["friction"].input.value == "-0.3 kPa", own.fields["friction"].input.value
own.fields["friction"].input.value = "2 kPa"
assert float(session.view.muscle.tension.friction) == 2000.0
own.fields["loss"].input.value = "-2"
assert own.fields["loss"].message.text
""",
    "invariants": """
import fascicle.jax
import conftest, test_laws, test_work
named = [getattr(laws.get("tension"), "name", None) for laws in test_laws.COMBINATIONS]
assert named.count("toy2026") == 1, named
test_laws.test_what_a_law_declares_can_be(fs.tension.Toy2026)
test_laws.test_every_law_is_here()
test_work.test_mesh_works_as_much_as_the_pressure_does_if_a_law_says_so(law, conftest.stack)
""",
}


FIT = """
from fascicle.calibrate import compare_tension, fit
from fascicle.records.record import Record
P, strain = np.linspace(1.5e5, 5e5, 4)[:, None], np.linspace(0.0, 0.12, 8)
true = muscle.replace(tension=fs.tension.Toy2026(2.0, -4e3))
force = true.force(P, strain) + 0.2 * np.random.default_rng(0).normal(size=(4, 8))
record = Record.of(P, strain, np.asarray(force), rest_length=0.2)
made = fit(record, muscle, ["loss", "friction"], whole=False)
found = {one.name: one for one in made.parameters}
assert found["friction"].dimension == "pressure"
# the sum of both is what the force tells: its factor, 2e5 - 4e3
told = 1e5 * found["loss"].value + found["friction"].value
assert abs(told / 1.96e5 - 1) < 0.02, told
laws = compare_tension(record, muscle.replace(tension="ideal"), whole=False)
rows = [one.label for one in laws.rows]
assert "Toy: loss, friction, braid_angle, outer_radius" in rows, rows
"""


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """The package with one file more."""
    folder = tmp_path_factory.mktemp("toy")
    shutil.copytree(ROOT / "src/fascicle", folder / "fascicle")
    (folder / "fascicle/muscle/tension/toy2026.py").write_text(LAW, encoding="utf-8")
    return folder


def run(copy, folder, *blocks):
    """Run blocks of Python, each with names of its own, in an interpreter that has the copy."""
    path = f"{copy}{os.pathsep}{ROOT / 'tests/invariants'}"
    code = HEAD + f"\nfor block in {blocks!r}:\n    exec(block, dict(globals()))\n"
    done = subprocess.run(
        [sys.executable, "-c", code, str(copy)],
        cwd=folder, env=os.environ | {"PYTHONPATH": path}, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


def test_a_new_law_is_found_everywhere(copy, tmp_path):
    """In files, widgets, and the tests of laws."""
    run(copy, tmp_path, *READERS.values())


@pytest.mark.slow
def test_a_new_law_is_fitted_and_compared(copy, tmp_path):
    run(copy, tmp_path, FIT)
