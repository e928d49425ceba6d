"""The project's own files agree with one another."""

import ast
import re
import sys
import tomllib
from importlib import metadata
from pathlib import Path

import yaml

import fascicle


ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def imported() -> set[str]:
    """Names of others' packages that a module of ours imports, at its top or in a function."""
    found = set()
    for path in Path(fascicle.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found |= {name.name.split(".")[0] for name in node.names}
            elif isinstance(node, ast.ImportFrom) and not node.level:
                found.add(str(node.module).split(".")[0])
    return found - set(sys.stdlib_module_names) - {"fascicle"}


def test_what_is_imported_is_declared_and_the_core_imported():
    whose = {
        name: owner.lower()
        for name, owners in metadata.packages_distributions().items()
        for owner in owners
    }
    found = {whose[name] for name in imported()}
    core = {re.split(r"[><=\[]", one)[0].lower() for one in PROJECT["dependencies"]}
    extras = {
        re.split(r"[><=\[]", one)[0].lower()
        for name, wanted in PROJECT["optional-dependencies"].items()
        for one in wanted
        if name not in ("dev", "docs")
    }
    assert found - core - extras - {"distributed"} == set()  # dask's extra brings its own
    assert core <= found


def test_the_version_is_one_number():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["version"] == fascicle.__version__
    assert PROJECT["dynamic"] == ["version"] and "version" not in PROJECT
    assert citation["preferred-citation"]["doi"] == "10.3390/act10030042"


def test_the_lock_covers_what_is_declared():
    lock = (ROOT / "requirements.lock").read_text().lower()
    extras = PROJECT["optional-dependencies"]
    for declared in PROJECT["dependencies"] + extras["dev"] + extras["docs"]:
        name = re.split(r"[><=\[]", declared)[0].lower()
        assert re.search(rf"^{re.escape(name)}==", lock, re.MULTILINE), name


def test_workflows_call_targets_that_exist_on_supported_pythons():
    makefile = (ROOT / "Makefile").read_text()
    targets = set(re.findall(r"^([a-z]+):", makefile, re.MULTILINE))
    texts = [path.read_text() for path in (ROOT / ".github/workflows").glob("*.yml")]
    assert len(texts) == 3
    for text in texts:
        assert {"name", "jobs"} <= yaml.safe_load(text).keys()
        for command in re.findall(r"run: make ([a-z ]+)", text):
            assert set(command.split()) <= targets
    nightly = yaml.safe_load((ROOT / ".github/workflows/nightly.yml").read_text())
    assert set(nightly["jobs"]["suite"]["strategy"]["matrix"]["target"]) <= targets
    test = yaml.safe_load((ROOT / ".github/workflows/test.yml").read_text())
    pythons = test["jobs"]["core"]["strategy"]["matrix"]["python"]
    tested = {f"Programming Language :: Python :: {version}" for version in pythons}
    assert {c for c in PROJECT["classifiers"] if ":: Python ::" in c} <= tested


def test_each_extra_is_tried_in_a_fresh_environment():
    script = (ROOT / ".ci/package").read_text()
    extras = set(PROJECT["optional-dependencies"]) - {"all", "dev", "docs"}
    assert set(re.findall(r"^ +(\w+)\) try ", script, re.MULTILINE)) == extras
    loop = re.search(r"^for extra in (.+); do$", script, re.MULTILINE)
    assert loop is not None
    assert set(loop[1].split()) == extras
