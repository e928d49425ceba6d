"""Every public argument and return has its unit: the docstrings are read, and held to it.

The long form has `**Arguments:**` with an entry for each parameter and `**Returns:**`; the short
form is one paragraph that gives the result's unit and its arguments'.
"""

import ast
import importlib
import inspect
import re
import sys
from collections.abc import Callable, Iterator
from functools import cached_property
from pathlib import Path

import pytest

import fascicle
import fascicle.results
from fascicle.muscle import LAWS
from fascicle.muscle.buckling import Centerline
from fascicle.muscle.muscle import Response


# SI only: a [kPa] is not found, and so fails; [SI]: of values by name, each in its own
UNITS = {
    "-", "1/Pa", "1/s", "J", "J/(kg·K)", "J/kg", "J/m³", "K", "N", "N/m", "N/s", "N·m", "N·m²",
    "N·s", "N²", "Pa", "Pa·s", "Pa·s/kg", "Pa·s²/kg²", "SI", "W", "W/K", "kg", "kg/(s·Pa)", "kg/m³",
    "kg/s", "m", "m²", "m³", "m³/(s·Pa)", "m³/Pa", "m³/s", "m⁴", "m/N", "m/s", "rad", "s",
}  # fmt: skip
UNIT = re.compile(r"\[(" + "|".join(re.escape(unit) for unit in sorted(UNITS)) + r")\]")
SECTION = re.compile(
    r"\*\*(Arguments|Returns|Raises|Source):\*\*(.*?)(?=\*\*\w+:\*\*|\Z)", re.DOTALL
)
SAME_AS = re.compile(r"those of `(\w+)`")


def faults(function: Callable, owner: type | None = None) -> list[str]:
    """What `function`'s docstring fails to say."""
    # a property inherits its docstring, the function in it does not
    doc = inspect.getdoc(getattr(owner, function.__name__, function)) or ""
    if not doc:
        return ["no docstring"]
    signature = inspect.signature(function)
    parameters = [name for name in signature.parameters if name not in ("self", "cls")]
    sections = {head: text.strip() for head, text in SECTION.findall(doc)}
    if not sections.keys() & {"Arguments", "Returns"}:
        # the short form
        annotations = inspect.get_annotations(inspect.unwrap(function))
        quantities = any(is_quantity(annotations.get(name)) for name in parameters)
        needed = gives_a_result(function) + quantities
        found = len(UNIT.findall(doc))
        return [f"{found} units, needs {needed}"] if found < needed else []
    wrong, annotations = [], inspect.get_annotations(inspect.unwrap(function))
    arguments = sections.get("Arguments", "")
    if (same := SAME_AS.search(arguments)) and owner is not None:
        arguments = dict(SECTION.findall(inspect.getdoc(getattr(owner, same.group(1))) or ""))[
            "Arguments"
        ]
    for name in parameters:
        # several names may share an entry
        entry = re.search(
            rf"(?:\A|- |; )(?:`\w+`(?:, | and ))*`{name}`(.*?)(?=\n- `|; `|\Z)",
            arguments,
            re.DOTALL,
        )
        if entry is None:
            wrong.append(f"`{name}` is not among its arguments")
        elif is_quantity(annotations.get(name)) and not UNIT.search(entry.group(1)):
            wrong.append(f"`{name}` has no unit")
    if gives_a_result(function) and not UNIT.search(sections.get("Returns", "")):
        wrong.append("its result has no unit")
    return wrong


QUANTITY = re.compile(r"float|Float|Values|Numbers|Batch|Points|Array|PerDesign|_empty")


def is_quantity(annotation: object) -> bool:
    """Whether an annotation is that of a number with a unit; objects and strings have none."""
    return annotation is None or bool(QUANTITY.search(str(annotation)))


def gives_a_result(function: Callable) -> bool:
    """Whether the function returns a quantity, which has a unit, if only [-]."""
    result = inspect.signature(function).return_annotation
    return function.__name__ != "__init__" and result is not None and is_quantity(result)


def public_objects() -> Iterator[tuple[str, object]]:
    """What is exported, and whatever else the API page shows."""
    sys.path.insert(0, str(Path(__file__).parents[2] / "docs/_ext"))
    public = importlib.import_module("public")
    names = [name for names in public.public_names().values() for name in names]
    for name in [*names, *public.linked_names()]:
        yield name.removeprefix("fascicle."), resolved(name.removeprefix("fascicle."))


def resolved(path: str) -> object:
    """What `fascicle.path` is; a function wins over the module of its name."""
    thing: object = fascicle
    for part in path.split("."):
        if not hasattr(thing, part):
            importlib.import_module(f"{thing.__name__}.{part}")  # type: ignore[attr-defined]
        thing = getattr(thing, part)
    return thing


def methods(owner: type) -> Iterator[tuple[str, Callable]]:
    """Public methods, classmethods and properties that the package itself defines."""
    for name in dir(owner):
        found = inspect.getattr_static(owner, name)
        function = (
            found.fget
            if isinstance(found, property)
            else found.func
            if isinstance(found, cached_property)
            else inspect.unwrap(getattr(owner, name, found))
        )
        if not inspect.isroutine(function) or (name.startswith("_") and name != "__init__"):
            continue
        written_here = (getattr(function, "__module__", None) or "").split(".")[0] == "fascicle"
        # equinox writes an `__init__` where a class has none
        if written_here and not (name == "__init__" and generated(function)):
            yield name, function


def generated(function: Callable) -> bool:
    """Whether an `__init__` was written by equinox, not by us."""
    return not (inspect.getdoc(function) or "").startswith("**")


def public_functions() -> Iterator[tuple[str, Callable, type | None]]:
    """Functions, and methods with their class, by name."""
    for name, thing in public_objects():
        if isinstance(thing, type):
            yield from (
                (f"{name}.{method}", function, thing) for method, function in methods(thing)
            )
        elif inspect.isroutine(thing) or hasattr(thing, "__wrapped__"):
            yield name, thing, None


def test_the_reader_opens_the_packages():
    names = {name for name, _ in public_objects()}
    for package in ("calibrate", "design", "energetics", "fluid", "records"):
        assert sum(name.startswith(f"{package}.") for name in names) >= 7
    assert {
        "calibrate.fit",
        "energetics.work",
        "design.objectives.margin",
        "export.table_code",
    } <= names


def test_arguments_and_returns_have_units():
    found = {name: faults(function, owner) for name, function, owner in public_functions()}
    assert len(found) > 500
    assert {name: wrong for name, wrong in found.items() if wrong} == {}


@pytest.mark.parametrize("record", [Centerline, Response])
def test_results_give_their_fields_units(record):
    assert UNIT.search(record.__doc__)


@pytest.mark.parametrize("law", [law for laws in LAWS.values() for law in laws.values()])
def test_registered_laws_give_units(law):
    assert law.__doc__
    for name, function in methods(law):
        if gives_a_result(function):
            assert UNIT.search(inspect.getdoc(function) or ""), name


def test_no_docstring_lost_a_backslash():
    # "\alpha" in a plain string is a bell and "lpha"
    control = re.compile(r"[\x00-\x08\x0b-\x1f]")
    documented = ast.Module | ast.ClassDef | ast.FunctionDef
    for path in Path(fascicle.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, documented):
                doc = ast.get_docstring(node, clean=False) or ""
                assert not control.search(doc), f"{path.name}: {doc[:60]!r}"
