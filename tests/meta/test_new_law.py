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
        """Mesh force [N] at `pressure` [Pa] and `strain` [-], and what is lost of it."""
        mesh, slope = bladder.braid.mesh(pressure, strain)
        unit = 1e-4 * (1e5 * self.loss + self.friction)
        return Pull(mesh, -unit * strain, slope, -unit + 0.0 * strain)

    def free_strain(self, bladder: Bladder, pressure: BatchLike, offset: Offset) -> Batch:
        """The root of what is left [-] at `pressure` [Pa]."""
        return solved_free_strain(self, bladder, pressure, offset)
'''

# laws of other kinds take the same steps, and one of the same kind may use a name otherwise
OTHERS = {
    "tension/toy2027.py": LAW.replace("Toy2026", "Toy2027")
    .replace('"toy2026"', '"toy2027"')
    .replace('"k_l", "number"', '"k_l", "pressure"'),
    "buckling/toy_bow.py": '''"""A toy: the paper's law, with a number that it doesn't use."""

from typing import ClassVar

from ...core.parameters import POSITIVE, Constant
from ...core.types import Batch
from .kim2021 import Kim2021


class ToyBow(Kim2021):
    """The paper's law, with a number of its own."""

    name: ClassVar[str] = "toy_bow"
    source: ClassVar[str] = "nobody (2026)"

    gap: Batch = Constant(
        "gap", "g", "length", (1e-6, 1e-5, 1e-2, 0.1), POSITIVE, 1e-3, "that isn't used"
    ).field()
''',
    "collapse/toy_fold.py": '''"""A toy: a moment that is given."""

from typing import ClassVar

from ...core.parameters import POSITIVE, Constant
from ...core.types import Batch, BatchLike
from ..bladder import Bladder
from . import FACTOR, AbstractCollapse


class ToyFold(AbstractCollapse):
    """A moment that is given."""

    name: ClassVar[str] = "toy_fold"
    source: ClassVar[str] = "nobody (2026)"

    given: Batch = Constant(
        "given", "M", "moment", (1e-6, 1e-4, 10.0, 1e3), POSITIVE, 0.05, "given"
    ).field()
    factor: Batch = FACTOR.field()

    def moment(self, bladder: Bladder, youngs_modulus: BatchLike, pressure: BatchLike) -> Batch:
        """The moment [N·m], at any `pressure` [Pa]."""
        return self.factor * self.given + 0.0 * pressure
''',
}

HEAD = """
import json, math, sys
from pathlib import Path
import numpy as np
import fascicle as fs
law = fs.tension.Toy2026(0.7, -300.0)
muscle = fs.Muscle.from_dimensions(0.2, 10e-3, 2e-3, math.radians(27), tension=law)
assert fs.__file__.startswith(sys.argv[1]), fs.__file__
"""

READERS = {
    "files": """
fs.save(muscle, "toy.toml")
text = Path("toy.toml").read_text()
assert 'tension = { law = "toy2026", loss = 0.7, friction = "-0.3 kPa" }' in text, text
assert fs.load("toy.toml") == muscle
plain = muscle.replace(tension="toy2026")
fs.save(plain, "toy.toml")
assert 'tension = "toy2026"' in Path("toy.toml").read_text()
assert fs.load("toy.toml") == plain
from fascicle.files import loads
for wrong, said in (("friction = 3", "friction = 3: `friction` must be a pressure"),
                    ("loss = -1", "loss = -1: `loss` must be positive"),
                    ("los = 1", 'tension.los = 1: not a parameter of toy2026, did you mean')):
    try:
        loads(text.replace("loss = 0.7", wrong).replace(', friction = "-0.3 kPa"', ""))
    except ValueError as error:
        assert said in str(error), error
    else:
        raise AssertionError(wrong)
""",
    "files, other kinds": """
other = muscle.replace(
    tension=fs.tension.Toy2027(5.0, 10.0), buckling=fs.buckling.ToyBow(gap=2e-3),
    collapse=fs.collapse.ToyFold(0.07, 1.5),
)
fs.save(other, "toy.toml")
text = Path("toy.toml").read_text()
for line in ('tension = { law = "toy2027", loss = "0.005 kPa", friction = "0.01 kPa" }',
             'buckling = { law = "toy_bow", braid_share = 0, gap = "2 mm", shear = "none" }',
             'law = "toy_fold"', 'given = "0.07 N*m"', 'factor = 1.5'):
    assert line in text.splitlines(), text
assert fs.load("toy.toml") == other
assert other.collapse_moment(1e5) == 1.5 * 0.07
from fascicle.calibrate.parameters import select_parameters
assert [one.dimension for one in select_parameters(["gap", "given"], other)] == ["length", "moment"]
from fascicle.files import loads
for wrong, said in (("law = 'toy_bow', gap = 3", "buckling.gap = 3: `gap` must be a length"),
                    ("law = 'kim2021', gap = '1 mm'", "not a parameter of kim2021"),
                    ("law = 'toy_bow', gap = '-3 mm'", "`gap` must be positive")):
    try:
        loads(text.replace('law = "toy_bow", braid_share = 0, gap = "2 mm", shear = "none"', wrong))
    except ValueError as error:
        assert said in str(error), error
    else:
        raise AssertionError(wrong)
""",
    "explorer": """
from dataclasses import replace
from fascicle.explorer.muscle_curves import alternative_laws
from fascicle.explorer.muscle_inputs import MuscleInputs
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
assert "must be positive" in own.fields["loss"].message.text
""",
    "docs": """
import importlib.util
spec = importlib.util.spec_from_file_location("docs_laws", sys.argv[2])
pages = importlib.util.module_from_spec(spec)
spec.loader.exec_module(pages)
table = pages.table("tension")
row = "| `toy2026` | `friction` | $p_f$, of the threads | 0 kPa | -10 kPa to 10 kPa |"
assert row in table, table
assert "fascicle.muscle.tension.toy2026" in pages.modules("tension")
""",
    "invariants": """
spec = __import__("importlib.util").util.spec_from_file_location("laws", sys.argv[3])
tests = __import__("importlib.util").util.module_from_spec(spec)
spec.loader.exec_module(tests)
named = [getattr(laws.get("tension"), "name", None) for laws in tests.COMBINATIONS]
assert named.count("toy2026") == 1, named
tests.test_what_a_law_declares_can_be(fs.tension.Toy2026)
tests.test_every_law_is_here()
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
rows = [one.label for one in compare_tension(record, muscle.replace(tension="ideal"), whole=False)]
assert "Toy: loss, friction, braid_angle, outer_radius" in rows, rows
"""

COMMAND = """
from fascicle.cli import main
from fascicle.files import example_text
text = example_text("kim2021_figure_6")
text = text.replace('tension = "klute_hannaford"', 'tension = { law = "toy2026", loss = 0.6 }')
Path("toy.toml").write_text(text)
try:
    main("force toy.toml --pressure 100kPa --strain 0.1 --out toy.json".split())
except SystemExit as end:
    assert not end.code
assert len(json.loads(Path("toy.json").read_text())["force"][0]) == 1
"""


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """The package with some files more."""
    folder = tmp_path_factory.mktemp("toy")
    shutil.copytree(ROOT / "src/fascicle", folder / "fascicle")
    for name, text in {"tension/toy2026.py": LAW, **OTHERS}.items():
        (folder / "fascicle/muscle" / name).write_text(text, encoding="utf-8")
    return folder


def run(copy, folder, *blocks):
    """Run blocks of Python, each with names of its own, in an interpreter that has the copy."""
    arguments = [copy, ROOT / "docs/_ext/laws.py", ROOT / "tests/invariants/test_laws.py"]
    code = HEAD + f"\nfor block in {blocks!r}:\n    exec(block, dict(globals()))\n"
    done = subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)],
        cwd=folder, env=os.environ | {"PYTHONPATH": str(copy)}, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


def test_a_new_law_is_found_everywhere(copy, tmp_path):
    """In files, widgets, the docs, the tests of laws, and by the commands."""
    run(copy, tmp_path, *READERS.values(), COMMAND)


@pytest.mark.slow
def test_a_new_law_is_fitted_and_compared(copy, tmp_path):
    run(copy, tmp_path, FIT)
