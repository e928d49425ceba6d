"""Design of bundles for a task: designs, their objectives, and searches among them.

Names are loaded on first use, so that the command line's help loads no JAX.
"""

from typing import TYPE_CHECKING

from ..core.lazy import attach_lazy


if TYPE_CHECKING:
    from .catalog import Catalog, Product
    from .designs import Designs
    from .evaluation import evaluate
    from .exhaustive_search import (
        SearchResult,
        hypervolume,
        judge_safety,
        non_dominated,
        search,
    )
    from .genetic import evolve
    from .objectives import OBJECTIVES, Limit, objective
    from .outcome import Outcome
    from .remedies import Remedy
    from .scatter import DesignScatter, Spread, Uncertainty, spread
    from .space import Space, compositions, partitions
    from .summary import Cases, Summary, summarize
    from .sweep import Study
    from .task import Task, example_task

__all__ = [
    "OBJECTIVES", "Cases", "Catalog", "DesignScatter", "Designs", "Limit", "Outcome", "Product",
    "Remedy", "SearchResult", "Space", "Spread", "Study", "Summary", "Task",
    "Uncertainty", "compositions", "evaluate", "evolve", "example_task", "hypervolume",
    "judge_safety", "non_dominated", "objective", "partitions", "search", "spread", "summarize",
]  # fmt: skip

_HOMES = {
    **dict.fromkeys(("Catalog", "Product"), "catalog"),
    "Designs": "designs",
    "evaluate": "evaluation",
    **dict.fromkeys(("SearchResult", "hypervolume", "judge_safety", "non_dominated",
                     "search"), "exhaustive_search"),
    "evolve": "genetic",
    **dict.fromkeys(("OBJECTIVES", "Limit", "objective"), "objectives"),
    "Outcome": "outcome",
    "Remedy": "remedies",
    **dict.fromkeys(("DesignScatter", "Spread", "Uncertainty", "spread"), "scatter"),
    **dict.fromkeys(("Space", "compositions", "partitions"), "space"),
    **dict.fromkeys(("Cases", "Summary", "summarize"), "summary"),
    "Study": "sweep",
    **dict.fromkeys(("Task", "example_task"), "task"),
}  # fmt: skip
__getattr__, __dir__ = attach_lazy(__name__, _HOMES)
