"""A scheme is one class, an objective one function: declared once, found everywhere.

A toy package declares one of each, from public names, in an interpreter of its own.
"""

import json
import re
import subprocess
import sys
from html import unescape
from pathlib import Path

import pytest

import fascicle
import fascicle.design


HERE = Path(__file__).parent
SOURCE = Path(fascicle.__file__).parent


CODE = """
import json, os, sys
sys.path.insert(0, sys.argv[1])
import toy_package, numpy as np, fascicle as fs
from typer.testing import CliRunner
from fascicle.cli import make_app
from fascicle.design import OBJECTIVES, Designs, Task, evaluate
from fascicle.explorer.link import from_query
from fascicle.explorer.state import view_of
b = toy_package.bundle()
fs.save(b, "pairs.toml")
again = fs.load("pairs.toml")
found = fs.recruitment.recruit(again, [60.0, 300.0], 0.08)
space = fs.recruitment.workspace(again, strain=[0.08])
task = Task.of([60.0, 300.0], [0.08, 0.08], 413.7e3, scheme="pairs")
designs = Designs.of(b.motor_units[0].muscle, [(1, 1, 1), (1, 1, 1, 1)])
values = evaluate(designs, task, ["mean_energy", "overlap_width", "reversal_depth"])
invoke = lambda *line: CliRunner().invoke(make_app(), list(line))
designed = invoke("design", "task.toml", "--out", "found")
assert designed.exit_code == 0, (designed.output, designed.exception)
print(json.dumps(dict(
    scheme=str(again.scheme), state=found.state.tolist(), pressures=found.pressures.tolist(),
    high=space.high[:, 0].tolist(), energy=values["mean_energy"].tolist(),
    overlap=values["overlap_width"].tolist(),
    taken=fs.energetics.unit_volume_change(b, 0.08).tolist(),
    eta=fs.energetics.average_efficiency(again),
    shown=invoke("space", "pairs.toml", "--scheme", "pairs").exit_code,
    query=from_query(dict(muscle="kim2021_slenderness_10", units="1,1", scheme="pairs"),
                     view_of(b, "x"))[0].scheme,
    objectives=[f"{n} {o.unit} {o.sense}" for n, o in OBJECTIVES.items()],
    designed=designed.output,
)))
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("toy")
    (folder / "task.toml").write_text(
        'format = 1\n[task]\nforce = ["60 N", "150 N"]\nstrain = [0.08, 0.1]\n'
        'supply_pressure = "413.7 kPa"\nscheme = "pairs"\n'
        '[design]\nmuscle = "kim2021_slenderness_10"\nmuscles = [2, 3]\n'
        '[objectives]\nwork_done = "max"\nvalves = "min"\n',
        encoding="utf-8",
    )
    return folder


@pytest.fixture(scope="module")
def answers(folder):
    """What a fresh interpreter answers that has the toy package."""
    done = subprocess.run(
        [sys.executable, "-c", CODE, str(HERE)], cwd=folder, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def test_a_new_scheme_is_one_class(answers):
    """Recruited, shown, judged, written and read, in the help and in the docs' list."""
    assert answers["scheme"] == answers["query"] == "pairs"
    assert answers["state"] == [1, 2]
    first, second = answers["pressures"]
    assert first[0] == first[1] > 0 == first[2] == first[3]
    assert second[:2] == [413.7e3] * 2 and 0 < second[2] == second[3] < 413.7e3
    # a pair takes the fluid of two, also the last that is alone in a bundle of three
    supply, (volume, *_) = 413.7e3, answers["taken"]
    energy = [supply * volume * 2.5, supply * volume * 3]
    assert answers["energy"] == pytest.approx(energy, rel=1e-9)
    assert len(answers["high"]) == 2 and answers["high"][1] > answers["high"][0]
    assert all(width >= 0 for width in answers["overlap"]) and 0 < answers["eta"] < 1
    assert answers["shown"] == 0


def test_a_new_objective_is_one_function(answers, folder):
    """In a task file, the search, the console's answer, the page and the docs' list."""
    assert "work_done J max" in answers["objectives"]
    page = unescape((folder / "found" / "report.html").read_text(encoding="utf-8"))
    assert "work_done" in page
    assert {"work", "done"} <= set(answers["designed"].split())  # a narrow head is broken


def test_no_other_module_compares_a_scheme_with_a_name():
    """Nowhere else is a scheme compared with a name."""
    by_name = re.compile(r"""scheme\s*[!=]=|[!=]=\s*["'](orderly|batch|free)["']""")
    found = [
        f"{path.relative_to(SOURCE)}:{number}"
        for path in sorted(SOURCE.rglob("*.py"))
        if path.name != "scheme.py"
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1)
        if by_name.search(line)
    ]
    assert not found
