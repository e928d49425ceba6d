"""The project's own files agree with one another."""

import re
import tomllib
from pathlib import Path

import yaml


ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def test_the_core_install_is_small():
    names = {re.split(r"[><=\[]", d)[0] for d in PROJECT["dependencies"]}
    assert names == {
        "jax", "equinox", "jaxtyping", "optimistix", "diffrax", "numpy", "pydantic", "pint",
        "typer", "rich", "xarray", "netcdf4", "matplotlib",
    }  # fmt: skip


def test_the_version_is_one_number():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["version"] == PROJECT["version"]
    assert citation["preferred-citation"]["doi"] == "10.3390/act10030042"
    assert f"## {PROJECT['version']}" in (ROOT / "CHANGELOG.md").read_text()


def test_the_lock_covers_what_is_declared():
    lock = (ROOT / "requirements.lock").read_text().lower()
    extras = PROJECT["optional-dependencies"]
    for declared in PROJECT["dependencies"] + extras["dev"] + extras["docs"]:
        name = re.split(r"[><=\[]", declared)[0].lower()
        assert re.search(rf"^{re.escape(name)}==", lock, re.MULTILINE), name
