"""Design of bundles for a task: designs, their objectives, and searches among them."""

from .answer import Answer, Remedy, answer_search
from .designs import Designs
from .evaluation import evaluate
from .exhaustive_search import SearchResult, judge_safety, non_dominated, search
from .genetic import evolve
from .objectives import OBJECTIVES, Limit, objective
from .outcome import Outcome
from .scatter import DesignScatter, Spread, Uncertainty, spread
from .space import Catalog, Product, Space, compositions, partitions
from .summary import Cases, Summary, best_splits, summarize
from .sweep import Study
from .task import Task, example_task


__all__ = [
    "OBJECTIVES",
    "Answer",
    "Cases",
    "Catalog",
    "DesignScatter",
    "Designs",
    "Limit",
    "Outcome",
    "Product",
    "Remedy",
    "SearchResult",
    "Space",
    "Spread",
    "Study",
    "Summary",
    "Task",
    "Uncertainty",
    "answer_search",
    "best_splits",
    "compositions",
    "evaluate",
    "evolve",
    "example_task",
    "judge_safety",
    "non_dominated",
    "objective",
    "partitions",
    "search",
    "spread",
    "summarize",
]
