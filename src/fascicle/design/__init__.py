"""Which bundle for a task: designs, what they are judged by, and searches among them.

Names are looked up when they are asked for, so that the command line's help loads no JAX.
"""

from typing import TYPE_CHECKING

from ..core.lazy import attach_lazy


if TYPE_CHECKING:
    from .judge.allowed import Limit as Limit
    from .judge.cases import Cases as Cases
    from .judge.judging import evaluate as evaluate
    from .judge.objectives import OBJECTIVES as OBJECTIVES
    from .judge.objectives import objective as objective
    from .judge.outcome import Outcome as Outcome
    from .searches.catalog import Catalog as Catalog
    from .searches.catalog import Product as Product
    from .searches.exhaustive import Found as Found
    from .searches.exhaustive import search as search
    from .searches.genetic import evolve as evolve
    from .searches.pareto import hypervolume as hypervolume
    from .searches.pareto import non_dominated as non_dominated
    from .searches.refine import refined as refined
    from .searches.remedies import Remedy as Remedy
    from .searches.robust import Spread as Spread
    from .searches.robust import sensitivities as sensitivities
    from .searches.robust import spread as spread
    from .searches.study import Study as Study
    from .searches.summary import Summary as Summary
    from .searches.summary import summary_of as summary_of
    from .space.designs import Designs as Designs
    from .space.examples import example_task as example_task
    from .space.grids import Space as Space
    from .space.splits import compositions as compositions
    from .space.splits import partitions as partitions
    from .space.task import Task as Task
    from .sweeps.store import Store as Store

__all__ = [
    "Cases",
    "Catalog",
    "Designs",
    "Found",
    "Limit",
    "OBJECTIVES",
    "Outcome",
    "Product",
    "Remedy",
    "Space",
    "Spread",
    "Store",
    "Study",
    "Summary",
    "Task",
    "compositions",
    "evaluate",
    "evolve",
    "example_task",
    "hypervolume",
    "non_dominated",
    "objective",
    "partitions",
    "refined",
    "search",
    "sensitivities",
    "spread",
    "summary_of",
]

_HOMES = {
    "Cases": "judge.cases",
    "Catalog": "searches.catalog",
    "Designs": "space.designs",
    "Found": "searches.exhaustive",
    "Limit": "judge.allowed",
    "OBJECTIVES": "judge.objectives",
    "Outcome": "judge.outcome",
    "Product": "searches.catalog",
    "Remedy": "searches.remedies",
    "Space": "space.grids",
    "Spread": "searches.robust",
    "Store": "sweeps.store",
    "Study": "searches.study",
    "Summary": "searches.summary",
    "Task": "space.task",
    "compositions": "space.splits",
    "evaluate": "judge.judging",
    "evolve": "searches.genetic",
    "example_task": "space.examples",
    "hypervolume": "searches.pareto",
    "non_dominated": "searches.pareto",
    "objective": "judge.objectives",
    "partitions": "space.splits",
    "refined": "searches.refine",
    "search": "searches.exhaustive",
    "sensitivities": "searches.robust",
    "spread": "searches.robust",
    "summary_of": "searches.summary",
}
_WENT = {
    "cases": "design.judge.cases",
    "catalog": "design.searches.catalog",
    "checkpoint": "design.searches.checkpoint",
    "cluster": "design.sweeps.cluster",
    "curves": "design.judge.compositions",
    "designs": "design.space.designs",
    "examples": "design.space.examples",
    "first_zero": "design.judge.first_zero",
    "genetic": "design.searches.genetic",
    "judging": "design.judge.judging",
    "levels": "design.judge.every_level",
    "limits": "design.judge.allowed",
    "objectives": "design.judge.objectives",
    "outcome": "design.judge.outcome",
    "packing": "design.space.packing",
    "pareto": "design.searches.pareto",
    "reach": "design.judge.reach",
    "refine": "design.searches.refine",
    "remedies": "design.searches.remedies",
    "robust": "design.searches.robust",
    "rows": "design.space.rows",
    "searching": "design.searches.exhaustive",
    "shared": "design.judge.shared",
    "space": "design.space.grids",
    "splits": "design.space.splits",
    "store": "design.sweeps.store",
    "study": "design.searches.study",
    "summary": "design.searches.summary",
    "sweep": "design.sweeps.running",
    "table": "design.judge.forces",
    "task": "design.space.task",
    "unlike": "design.judge.unlike",
}

__getattr__, __dir__ = attach_lazy(__name__, _HOMES, _WENT)
