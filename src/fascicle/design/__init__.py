"""Which bundle for a task: designs, what they are judged by, and searches among them.

Names are looked up when they are asked for, so that the command line's help loads no JAX.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any


if TYPE_CHECKING:
    from .catalog import Catalog as Catalog
    from .catalog import Product as Product
    from .designs import Designs as Designs
    from .examples import example_task as example_task
    from .judging import evaluate as evaluate
    from .limits import Limit as Limit
    from .objectives import OBJECTIVES as OBJECTIVES
    from .objectives import objective as objective
    from .outcome import Outcome as Outcome
    from .pareto import hypervolume as hypervolume
    from .pareto import non_dominated as non_dominated
    from .searching import search as search
    from .space import Space as Space
    from .splits import compositions as compositions
    from .splits import partitions as partitions
    from .task import Task as Task

_HOMES = {
    "Catalog": "catalog",
    "Designs": "designs",
    "Limit": "limits",
    "OBJECTIVES": "objectives",
    "Outcome": "outcome",
    "Product": "catalog",
    "Space": "space",
    "Task": "task",
    "compositions": "splits",
    "evaluate": "judging",
    "example_task": "examples",
    "hypervolume": "pareto",
    "non_dominated": "pareto",
    "objective": "objectives",
    "partitions": "splits",
    "search": "searching",
}

__all__ = [
    "Catalog",
    "Designs",
    "Limit",
    "OBJECTIVES",
    "Outcome",
    "Product",
    "Space",
    "Task",
    "compositions",
    "evaluate",
    "example_task",
    "hypervolume",
    "non_dominated",
    "objective",
    "partitions",
    "search",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOMES[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted(__all__)
