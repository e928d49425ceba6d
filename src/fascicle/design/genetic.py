r"""NSGA-II, by pymoo, in spaces that are too large for an exhaustive search.

A genome is a row of numbers in $[0, 1]$: one each for the number of muscles, length, radius,
wall and angle, one for each gap between muscles (cut or not), and one for each unit's factor.

A design that doesn't reach the task is worse than any that does, the more so the larger a share
of its worst point it misses, so that a search leads there. The same seed gives the same front.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Float
from . import objectives
from .designs import Designs, scaled_designs
from .evaluation import MIXED, Values, evaluate
from .exhaustive_search import LEAST_MARGIN, SearchResult, conclude
from .objectives import Limits, other_limits, with_reach_limits
from .space import Catalog, Space, drawing_sizes
from .task import Task


_AXES = ("length", "radius", "wall_ratio", "braid_angle")

Genomes = Float[np.ndarray, "design gene"]


class GenomeDecoder:
    """Translation of genomes to designs of a space of one drawing and all compositions, else
    `ValueError`; `continuous`: true if sizes may lie between those listed.
    """

    def __init__(self, space: Space, continuous: bool):
        if len(space.drawings) != 1:
            rule, remedy = "must hold one muscle for NSGA-II", "search each in a file of its own"
            raise InvalidInputError("drawings", rule, None, remedy)
        if space.splits != "all":
            rule = "must be 'all' for NSGA-II, which cuts anywhere"
            raise InvalidInputError("splits", rule, None)
        self.space, self.continuous = space, continuous
        self.muscles = np.array(sorted(set(space.muscles)))
        self.largest = int(self.muscles[-1])
        self.units = min(self.largest, space.most_units or self.largest)
        self.genes = 1 + len(_AXES) + (self.largest - 1) + self.units

    def designs(self, genomes: Genomes) -> Designs:
        """Designs of `genomes` [-], a row each."""
        number, sizes, cuts, factors = np.split(
            genomes, np.cumsum([1, len(_AXES), self.largest - 1]), axis=1
        )
        total = self.muscles[_choice_index(number[:, 0], len(self.muscles))]
        # units beyond the largest number join the last
        unit = np.minimum(np.cumsum(cuts > 0.5, axis=1), self.units - 1)
        unit = np.pad(unit, ((0, 0), (1, 0)))
        exists = np.arange(self.largest) < total[:, None]
        members = unit[:, :, None] == np.arange(self.units)
        counts = np.sum(members & exists[:, :, None], axis=1)
        factor = self._decode_gene(self.space.unit_factors, factors)
        factor = np.where(counts > 0, factor, factor[:, :1])
        (drawing,) = self.space.drawings.values()
        genes = zip(_AXES, drawing_sizes(drawing), sizes.T, strict=True)
        columns = [
            self._decode_gene(getattr(self.space, axis) or (default,), gene)
            for axis, default, gene in genes
        ]
        sizes = np.stack(columns, axis=1)
        sizes[:, 1] *= self.space.scale(counts, factor)
        kind = np.zeros(len(genomes), int)
        return scaled_designs(self.space.drawings, kind, counts, factor, sizes)

    def _decode_gene(self, values: tuple[float, ...], gene: np.ndarray) -> np.ndarray:
        """Value for each `gene`: linear from the least to the largest, or if not `continuous` the
        listed one in the gene's equal share of [0, 1].
        """
        if self.continuous:
            return min(values) + gene * (max(values) - min(values))
        return np.array(values)[_choice_index(gene, len(values))]


def _choice_index(gene: np.ndarray, count: int) -> np.ndarray:
    """Index, counted from 0, of one of `count` choices, for each `gene` in [0, 1]."""
    return np.minimum((gene * count).astype(int), count - 1)


def evolve(
    space: Space,
    task: Task,
    senses: Mapping[str, str],
    limits: Limits | None = None,
    population: int = 100,
    generations: int = 100,
    seed: int = 0,
    continuous: bool = True,
    watch: Callable[[int], None] = lambda _: None,
    extra: tuple[str, ...] = (),
    catalog: Catalog | None = None,
    least_margin: float = LEAST_MARGIN,
) -> SearchResult:
    """Search a space by NSGA-II, an evolutionary algorithm.

    **Arguments:**

    - `space`: of one drawing, with all compositions.
    - `task`, `senses`, `limits`, `extra`, `catalog`, `least_margin`: as of `search` [SI].
    - `population`: designs in a generation [-].
    - `generations`: their number [-].
    - `seed`: random seed.
    - `continuous`: true if sizes may lie between those listed.
    - `watch`: called with the number of finished generations [-].

    **Returns:** the result, with the designs of the last generation.

    **Raises:** `ValueError` for a space it can't search; `ModuleNotFoundError` without pymoo.
    """
    from pymoo.algorithms.moo.nsga2 import NSGA2
    from pymoo.core.problem import Problem
    from pymoo.optimize import minimize

    limits, senses = with_reach_limits(limits), dict(senses)
    names = objectives.recorded_objectives(senses, limits)
    decoder = GenomeDecoder(space, continuous)

    class Search(Problem):
        """Objectives and broken limits of a generation."""

        def _evaluate(self, x: np.ndarray, out: dict[str, Any], *_: Any, **__: Any) -> None:
            values = evaluate(decoder.designs(x), task, names, MIXED)
            out["F"] = objectives.as_minimization(values, senses)
            out["G"] = _violations(values, limits)

    n_limits = 1 + len(other_limits(limits))
    problem = Search(decoder.genes, n_obj=len(senses), n_ieq_constr=n_limits, xl=0.0, xu=1.0)
    algorithm = NSGA2(pop_size=population)
    run: Any = minimize
    until = "n_gen", generations
    end = run(problem, algorithm, until, callback=lambda search: watch(search.n_iter), seed=seed)
    designs = decoder.designs(np.asarray(end.pop.get("X"), float))
    # the end result has the resolution of an exhaustive search
    values = evaluate(designs, task, objectives.recorded_objectives(senses, limits, extra))
    return conclude(
        *(space, task, senses, limits, values, extra, catalog, least_margin, designs),
        judged=population * generations,
    )


def _violations(values: Values, limits: Limits) -> Float[np.ndarray, "design limit"]:
    """Excess over each limit [SI], positive where it is broken; first a column for the task."""
    # a share of points says nothing of how near they are
    miss = np.maximum(values["relative_shortfall"], np.finfo(float).tiny)
    columns = [np.where(objectives.reaches_task(values, limits), -1.0, miss)]
    for name, limit in other_limits(limits).items():
        excess = limit.excess(values[name])
        columns.append(np.where(np.isfinite(excess), excess, -1.0))
    return np.stack(columns, axis=1)
