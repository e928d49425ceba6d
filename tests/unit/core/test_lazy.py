import importlib
import subprocess
import sys
import warnings
from types import ModuleType

import pytest

import fascicle
from fascicle.core.lazy import attach_lazy


# documented in version 0.1.0, and where they are now
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
def anew():
    """Old names are imported as if for the first time, and forgotten afterwards."""
    olds = {f"fascicle.{old.rpartition('.')[0]}" for old in MOVED}

    def forget():
        for old in olds:
            sys.modules.pop(old, None)
            parent, _, name = old.rpartition(".")
            if parent in sys.modules:
                vars(sys.modules[parent]).pop(name, None)

    forget()
    yield
    forget()


@pytest.mark.parametrize(("old", "new"), MOVED.items())
def test_what_moved_is_found_and_says_where_it_is(old, new, anew):
    module, _, name = old.rpartition(".")
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        found = getattr(importlib.import_module(f"fascicle.{module}"), name)
    assert found is getattr(importlib.import_module(f"fascicle.{new}"), name)
    told = [str(one.message) for one in said if one.category is DeprecationWarning]
    assert f"`fascicle.{module}` has moved to `fascicle.{new}`." in told


def test_old_modules_are_attributes_too(anew):
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
    ],
)
def test_a_renamed_object_warns_at_the_users_line(old, new):
    package, _, name = f"fascicle.{old}".rpartition(".")
    module = importlib.import_module(package)
    with pytest.warns(
        DeprecationWarning, match=f"`fascicle.{old}` is now `fascicle.{new}`"
    ) as seen:
        former = getattr(module, name)
    assert former is getattr(module, new.rpartition(".")[2])
    assert seen[0].filename == __file__


def test_a_name_in_a_module_of_the_same_name_is_refused():
    with pytest.raises(ValueError, match="can't be in a module of the same name"):
        attach_lazy("fascicle.some", {"law": "law"})


def test_packages_list_their_names():
    assert {"Task", "search", "evolve"} <= set(dir(fascicle.design))
    assert {"Muscle", "tables", "__version__"} <= set(dir(fascicle))


LENT = ["buckling", "collapse", "ends", "materials", "post_collapse", "recruitment", "reversal",
        "schemes", "tables", "tension"]  # fmt: skip
IMPORTED = """
import importlib, sys, warnings

warnings.simplefilter("error")
name = sys.argv[1]
module = importlib.import_module(f"fascicle.{name}")
import fascicle

assert module is getattr(fascicle, name) is sys.modules[module.__name__]
assert importlib.import_module(module.__name__) is module
assert module.__spec__.name == module.__name__
for inside in sys.argv[2:]:
    one = importlib.import_module(f"fascicle.{name}.{inside}")
    assert one is importlib.import_module(f"{module.__name__}.{inside}"), inside
"""


@pytest.mark.parametrize("name", LENT)
def test_a_module_is_imported_by_the_name_that_the_docs_use(name):
    inside = ["kim2021", "elastica"] if name == "buckling" else []
    done = subprocess.run(
        [sys.executable, "-c", IMPORTED, name, *inside], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr[-2000:]


def test_every_module_that_fascicle_has_for_a_name_is_among_them():
    modules = {n for n in fascicle.__all__ if isinstance(getattr(fascicle, n), ModuleType)}
    for name in modules:
        assert importlib.import_module(f"fascicle.{name}") is getattr(fascicle, name)
    assert set(LENT) <= modules


@pytest.mark.parametrize(
    "name", ["Bundle", "example", "examples", "load", "nothing", "buckling.no"]
)
def test_what_is_no_module_is_not_imported(name):
    with pytest.raises(ModuleNotFoundError, match=name):
        importlib.import_module(f"fascicle.{name}")
