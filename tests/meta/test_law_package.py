"""Laws of other installed packages: the one of docs/laws.md, and broken ones."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest


ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/laws.md").read_text(encoding="utf-8")
LOAD = """
import sys
import fascicle as fs
from fascicle.files.muscle_files import loads
from fascicle.files import example_text
text = example_text("kim2021_figure_6").replace('"klute_hannaford"', '{ law = "NAME" }')
"""


@pytest.fixture(scope="module")
def template(tmp_path_factory):
    """Folder of the documentation's package, and the folder where it is installed."""
    source = tmp_path_factory.mktemp("source")
    blocks = re.findall(r"^`([\w.]+)`:\n\n```\w+\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
    for name, text in blocks:
        (source / name).write_text(text, encoding="utf-8")
    assert len(blocks) == 3
    target = tmp_path_factory.mktemp("installed")
    subprocess.run(
        [Path(sys.executable).parent / "uv", "pip", "install", "--offline", "--no-deps", "--quiet",
         "--no-build-isolation", "--python", sys.executable, "--target", target, source],
        check=True,
    )  # fmt: skip
    return source, target


def run(target, *arguments, cwd=None):
    path = os.pathsep.join([str(target), str(ROOT / "src")])
    return subprocess.run(
        [sys.executable, *map(str, arguments)], cwd=cwd, text=True, capture_output=True,
        env=os.environ | {"PYTHONPATH": path, "COLUMNS": "100"},
    )  # fmt: skip


def install(folder, name, point, module):
    """A distribution as an installer leaves it: a module, and its entry points."""
    info = folder / f"{name.replace('-', '_')}-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1\n")
    (info / "entry_points.txt").write_text(f"[fascicle.laws]\n{point}\n")
    (folder / f"{point.partition('=')[2].partition(':')[0].strip()}.py").write_text(module)


def test_its_own_test_passes(template):
    source, target = template
    done = run(target, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_linear_loss.py",
               cwd=source)  # fmt: skip
    assert done.returncode == 0, done.stdout


def test_files_and_commands_find_it(template, tmp_path):
    _, target = template
    made = run(target, "-c", LOAD.replace("NAME", "linear_loss") + """
muscle = loads(text.replace('{ law = "linear_loss" }', '{ law = "linear_loss", loss = "30 N" }'))
fs.save(muscle, "toy.toml")
from fascicle.calibrate.parameters import select_parameters
assert [x.dimension for x in select_parameters(["loss"], muscle)] == ["force"]
assert fs.load("toy.toml") == muscle and float(muscle.tension.loss) == 30.0
""", cwd=tmp_path)  # fmt: skip
    assert made.returncode == 0, made.stderr
    force = run(target, "-m", "fascicle", "force", "toy.toml", "--pressure", "100kPa",
                "--strain", "0.1", cwd=tmp_path)  # fmt: skip
    assert force.returncode == 0, force.stderr
    listed = run(target, "-m", "fascicle", "laws", "tension")
    assert "linear_loss" in listed.stdout and "[fascicle-linear-loss]" in listed.stdout
    wrong = (tmp_path / "toy.toml").read_text().replace('loss = "30 N"', "loss = 30")
    (tmp_path / "toy.toml").write_text(wrong)
    refused = run(target, "-m", "fascicle", "free-strain", "toy.toml", "--pressure", "100kPa",
                  cwd=tmp_path)  # fmt: skip
    assert refused.returncode == 2
    assert "tension.loss = 30: `loss` must be a force" in refused.stderr


def test_a_broken_package_is_named_in_one_line_and_breaks_nothing(tmp_path):
    install(tmp_path, "bad-laws", "bad = bad_laws:Bad", "1 / 0")
    install(tmp_path, "odd-laws", "odd = odd_laws:odd", "odd = 3")
    install(
        tmp_path,
        "twin-laws",
        "ideal = twin_laws:Ideal",
        """
from fascicle.muscle.tension.corrected import *
from fascicle.muscle.tension import AbstractTension
class Ideal(AbstractTension):
    name = "ideal"
""",
    )
    listed = run(tmp_path, "-m", "fascicle", "laws", "tension")
    assert listed.returncode == 0
    assert "kothera2009" in listed.stdout and "bad" not in listed.stdout
    warnings = listed.stderr.splitlines()
    assert len(warnings) == 3
    for package in ("bad-laws", "odd-laws", "twin-laws"):
        assert sum(package in line for line in warnings) == 1, warnings
    file = tmp_path / "muscle.toml"
    write = f"open({str(file)!r}, 'w').write(text)"
    made = run(tmp_path, "-c", LOAD.replace("NAME", "bad") + write)
    assert made.returncode == 0, made.stderr
    refused = run(tmp_path, "-m", "fascicle", "force", file, "--pressure", "100kPa")
    assert refused.returncode == 2
    assert refused.stderr.count("\n") == 1 and "bad-laws" in refused.stderr
    own = run(tmp_path, "-m", "fascicle", "force", "kim2021_figure_6", "--pressure", "100kPa",
              "--strain", "0.1")  # fmt: skip
    assert (own.returncode, own.stderr) == (0, "")
