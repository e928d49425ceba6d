"""Entries of public names, made from the packages: nobody lists them twice.

    ```{public} fascicle.fluid fascicle.dynamics
    ```

documents the classes and functions of packages, and

    ```{linked}
    ```

those that theory pages name beside an equation, and that have no entry yet.
"""

import importlib
import inspect
import itertools
import re
from pathlib import Path
from types import ModuleType
from typing import Any

from docstrings import equations
from docutils import nodes
from laws import modules, parse_markdown
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from fascicle.core.lazy import attach_lazy


PAGE = Path(__file__).parents[1] / "api.md"
AUTOMODULE = re.compile(r"automodule:: ([\w.]+)")


def public_names() -> dict[str, list[str]]:
    """Full names of the classes and functions of each package on the page, as a user writes them;
    each thing once.
    """
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    names, seen = {}, {attach_lazy}
    blocks = [line.split()[1:] for line in lines if line.startswith("```{public}")]
    for package in itertools.chain.from_iterable(blocks):
        module = _resolve(package)[0]
        things = {name: getattr(module, name) for name in dir(module) if not name.startswith("_")}
        ours = {name: thing for name, thing in things.items() if _is_ours(thing, module)}
        names[package] = [f"{package}.{name}" for name, thing in ours.items() if thing not in seen]
        seen |= set(ours.values())
    return names


def linked_names() -> list[str]:
    """Full names beside the equations of theory pages that neither this page nor that of the laws
    documents.
    """
    from fascicle.muscle import LAWS

    documented = {name for names in public_names().values() for name in names}
    documented |= {module for kind in LAWS for module in modules(kind)}
    documented |= set(AUTOMODULE.findall((PAGE.parent / "laws.md").read_text(encoding="utf-8")))
    names = sorted(equations(PAGE.parent / "theory"))
    return [name for name in names if not any(f"{name}.".startswith(f"{x}.") for x in documented)]


def entry(name: str) -> str:
    """The entry of a class or function, in reStructuredText."""
    thing, owner = _resolve(name)
    if inspect.isclass(thing):
        return f".. autoclass:: {name}"
    return f".. {'automethod' if inspect.isclass(owner) else 'autofunction'}:: {name}"


def _is_ours(thing: Any, module: ModuleType) -> bool:
    """True for a class or function of a package, or one that is written in a module."""
    if not (inspect.isclass(thing) or inspect.isfunction(thing)):
        return False
    if hasattr(module, "__path__"):
        return thing.__module__.startswith("fascicle.")
    return thing.__module__ == module.__name__


def _resolve(name: str) -> tuple[Any, Any]:
    """An object by its full `name`, and what it is an attribute of."""
    parts = name.split(".")
    for cut in range(len(parts), 0, -1):
        try:
            owner: Any = importlib.import_module(".".join(parts[:cut]))
        except ModuleNotFoundError:
            continue
        thing: Any = owner
        for part in parts[cut:]:
            owner, thing = thing, getattr(thing, part)
        return thing, owner
    raise ImportError(name)


class Public(SphinxDirective):
    """Entries of the names of packages."""

    required_arguments = 1
    final_argument_whitespace = True

    def run(self) -> list[nodes.Node]:
        """The entries."""
        names = public_names()
        return _parse_entries(self, [name for x in self.arguments[0].split() for name in names[x]])


class Linked(SphinxDirective):
    """Entries of names beside equations that have none yet."""

    def run(self) -> list[nodes.Node]:
        """The entries."""
        return _parse_entries(self, linked_names())


def _parse_entries(directive: SphinxDirective, names: list[str]) -> list[nodes.Node]:
    """Nodes of the entries of `names`."""
    return parse_markdown(directive, "```{eval-rst}\n" + "\n".join(map(entry, names)) + "\n```")


def setup(app: Sphinx) -> dict[str, Any]:
    """Register with Sphinx."""
    app.add_directive("public", Public)
    app.add_directive("linked", Linked)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
