import importlib
import os
import subprocess
import sys
import warnings
from types import ModuleType

import pytest

import fascicle
from fascicle.core.lazy import attach_lazy, enable_whole_loops


# modules of version 0.1.0, and their present names
MOVED = {
    "calibrate.comparing.Row": "calibrate.comparison",
    "calibrate.profiling.profiles": "calibrate.intervals",
    "describe.calibrated.provenance_of": "files.calibration_files",
    "describe.provenance": "files",
    "describe.results.Variable": "results.labelled",
    "design.searching.SearchResult": "design.exhaustive_search",
    "design.store.Store": "design.sweep",
    "design.study.Study": "design.sweep",
    "reports.fitted.figures": "calibrate.plot_data",
}


@pytest.fixture
def forgotten():
    """Old names are imported for the first time, and forgotten afterwards."""
    names = {f"fascicle.{old.rpartition('.')[0]}" for old in MOVED}

    def forget():
        for old in names:
            sys.modules.pop(old, None)
            parent, _, name = old.rpartition(".")
            if parent in sys.modules:
                vars(sys.modules[parent]).pop(name, None)

    forget()
    yield
    forget()


@pytest.mark.parametrize(("old", "new"), MOVED.items())
def test_a_former_module_warns_with_its_present_name(old, new, forgotten):
    module, _, name = old.rpartition(".")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        former = getattr(importlib.import_module(f"fascicle.{module}"), name)
    assert former is getattr(importlib.import_module(f"fascicle.{new}"), name)
    messages = [str(w.message) for w in caught if w.category is DeprecationWarning]
    text = f"`fascicle.{module}` has moved to `fascicle.{new}`."
    assert any(message.startswith(text) for message in messages)


def test_former_modules_are_attributes_too(forgotten):
    with pytest.warns(DeprecationWarning, match="has moved to"):
        assert fascicle.design.study.Study is fascicle.design.Study
    with pytest.raises(AttributeError, match="no attribute 'genes'"):
        fascicle.design.genes  # noqa: B018
    with pytest.raises(ModuleNotFoundError):
        importlib.import_module("fascicle.design.genes")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("Refused", "InvalidInputError"),
        ("calibrate.find", "calibrate.select_model"),
        ("control.worth", "control.control_metrics"),
        ("design.refined", "design.refine_sizes"),
        ("dynamics.rest", "dynamics.equilibrium_state"),
        ("fluid.checked_commands", "fluid.validate_commands"),
        ("bundle.recruitment.Space", "bundle.recruitment.Workspace"),
        ("bundle.recruitment.space", "bundle.recruitment.workspace"),
    ],
)
def test_a_renamed_object_warns_at_the_users_line(old, new):
    package, _, name = f"fascicle.{old}".rpartition(".")
    module, message = importlib.import_module(package), f"`fascicle.{old}` is now `fascicle.{new}`"
    with pytest.warns(DeprecationWarning, match=message) as caught:
        former = getattr(module, name)
    assert former is getattr(module, new.rpartition(".")[2])
    assert caught[0].filename == __file__


@pytest.mark.parametrize(
    ("owner", "old", "new", "arguments"),
    [
        (fascicle.fluid.Direct(), "states", "state_count", (3,)),
        (fascicle.fluid.PressureBand(1e5, 2e5), "after", "update", (1.0, 1.5e5)),
        (fascicle.ends.Compliant(), "stretch", "strain_ratio", (0.1,)),
        (fascicle.tension.Bolen(), "largest_force", "blocked_force", (0.2,)),
    ],
)
def test_a_renamed_method_warns_at_the_users_line(owner, old, new, arguments):
    with pytest.warns(DeprecationWarning, match=rf"\.{old}` is now `{new}`") as caught:
        former = getattr(owner, old)(*arguments)
    assert former == getattr(owner, new)(*arguments)
    assert caught[0].filename == __file__


def test_a_name_in_a_module_of_its_name_is_refused():
    with pytest.raises(ValueError, match="can't be in a module of the same name"):
        attach_lazy("fascicle.some", {"law": "law"})


def test_packages_list_their_names():
    assert {"Task", "search", "evolve"} <= set(dir(fascicle.design))
    assert {"Muscle", "tables", "__version__"} <= set(dir(fascicle))


MODULES = ["buckling", "collapse", "ends", "materials", "post_collapse", "recruitment", "reversal",
           "schemes", "tables", "tension"]  # fmt: skip
IMPORT = """
import importlib, sys, warnings

warnings.simplefilter("error")
name = sys.argv[1]
module = importlib.import_module(f"fascicle.{name}")
import fascicle

assert module is getattr(fascicle, name) is sys.modules[module.__name__]
assert importlib.import_module(module.__name__) is module
assert module.__spec__.name == module.__name__
for inner in sys.argv[2:]:
    imported = importlib.import_module(f"fascicle.{name}.{inner}")
    assert imported is importlib.import_module(f"{module.__name__}.{inner}"), inner
"""


@pytest.mark.parametrize("name", MODULES)
def test_a_module_is_imported_by_the_name_in_the_docs(name):
    inner = ["kim2021", "elastica"] if name == "buckling" else []
    command = [sys.executable, "-c", IMPORT, name, *inner]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]


def test_public_modules_are_importable_and_other_names_are_not():
    modules = {n for n in fascicle.__all__ if isinstance(getattr(fascicle, n), ModuleType)}
    for name in modules:
        assert importlib.import_module(f"fascicle.{name}") is getattr(fascicle, name)
    assert set(MODULES) <= modules
    for name in ("Bundle", "example", "examples", "load", "nothing", "buckling.no"):
        with pytest.raises(ModuleNotFoundError, match=name):
            importlib.import_module(f"fascicle.{name}")


OPTION = "--xla_backend_extra_options=xla_cpu_small_while_loop_byte_threshold=100000000"


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("", OPTION),
        ("--xla_dump_to=there", f"--xla_dump_to=there {OPTION}"),
        (OPTION, OPTION),
        ("--xla_backend_extra_options=xla_other=1", "--xla_backend_extra_options=xla_other=1"),
    ],
)
def test_the_loops_option_replaces_no_other(before, after, monkeypatch):
    monkeypatch.setenv("XLA_FLAGS", before)
    enable_whole_loops()
    assert os.environ["XLA_FLAGS"] == after


@pytest.mark.parametrize("first", ["", "import fascicle as fs, jax; fs.Muscle"])
def test_dynamics_sets_the_loops_option_before_xla_compiles(first):
    code = f"""
{first}
import fascicle.dynamics, os
print(os.environ["XLA_FLAGS"])
import jax, jax.numpy as jnp
text = jax.jit(lambda x: jax.lax.fori_loop(0, 9, lambda _, x: jnp.sin(x) + x[::-1] @ x, x)).lower(
    jnp.ones(500)).compile().as_text()
print("xla_cpu_small_call" in text)
"""
    environ = {name: value for name, value in os.environ.items() if name != "XLA_FLAGS"}
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environ)
    assert done.stdout.split() == [OPTION, "True"]
