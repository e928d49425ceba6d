"""Design of bundles for a task: designs, their objectives, and searches among them.

Names are loaded on first use, so that the command line's help loads no JAX.
"""

from typing import TYPE_CHECKING

from ..core.lazy import attach_lazy


if TYPE_CHECKING:
    from .catalog import Catalog as Catalog
    from .catalog import Product as Product
    from .designs import Designs as Designs
    from .evaluation import evaluate as evaluate
    from .exhaustive_search import SearchResult as SearchResult
    from .exhaustive_search import hypervolume as hypervolume
    from .exhaustive_search import non_dominated as non_dominated
    from .exhaustive_search import search as search
    from .genetic import evolve as evolve
    from .objectives import OBJECTIVES as OBJECTIVES
    from .objectives import Limit as Limit
    from .objectives import objective as objective
    from .outcome import Outcome as Outcome
    from .refine import refine_sizes as refine_sizes
    from .remedies import Remedy as Remedy
    from .robust import Spread as Spread
    from .robust import sensitivities as sensitivities
    from .robust import spread as spread
    from .space import Space as Space
    from .space import compositions as compositions
    from .space import partitions as partitions
    from .summary import Cases as Cases
    from .summary import Summary as Summary
    from .summary import summarize as summarize
    from .sweep import Store as Store
    from .sweep import Study as Study
    from .task import Task as Task
    from .task import example_task as example_task

_HOMES = {
    "Cases": "summary",
    "Catalog": "catalog",
    "Designs": "designs",
    "Limit": "objectives",
    "OBJECTIVES": "objectives",
    "Outcome": "outcome",
    "Product": "catalog",
    "Remedy": "remedies",
    "SearchResult": "exhaustive_search",
    "Space": "space",
    "Spread": "robust",
    "Store": "sweep",
    "Study": "sweep",
    "Summary": "summary",
    "Task": "task",
    "compositions": "space",
    "evaluate": "evaluation",
    "evolve": "genetic",
    "example_task": "task",
    "hypervolume": "exhaustive_search",
    "non_dominated": "exhaustive_search",
    "objective": "objectives",
    "partitions": "space",
    "refine_sizes": "refine",
    "search": "exhaustive_search",
    "sensitivities": "robust",
    "spread": "robust",
    "summarize": "summary",
}
_WENT = {  # modules of the last release
    "checkpoint": "design.genetic",
    "examples": "design.task",
    "judging": "design.evaluation",
    "packing": "design.designs",
    "pareto": "design.exhaustive_search",
    "reach": "design.objectives",
    "searching": "design.exhaustive_search",
    "store": "design.sweep",
    "study": "design.sweep",
}

_RENAMED = {"Found": "SearchResult", "refined": "refine_sizes", "summary_of": "summarize"}

__all__ = [*_HOMES]  # noqa: PLE0604 names alone
__getattr__, __dir__ = attach_lazy(__name__, _HOMES, _WENT, _RENAMED)
