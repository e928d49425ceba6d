from types import ModuleType

import pytest

import fascicle
from fascicle.core.lazy import attach_lazy


def test_a_name_in_a_module_of_its_name_is_refused():
    with pytest.raises(ValueError, match="can't be in a module of the same name"):
        attach_lazy("fascicle.some", {"law": "law"})


def test_packages_list_their_names():
    assert {"Task", "search", "evolve"} <= set(dir(fascicle.design))
    assert {"Muscle", "tables", "__version__"} <= set(dir(fascicle))


def test_public_modules_are_attributes():
    modules = {n for n in fascicle.__all__ if isinstance(getattr(fascicle, n), ModuleType)}
    assert {"buckling", "collapse", "recruitment", "schemes", "tension"} <= modules
