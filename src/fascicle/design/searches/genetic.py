r"""NSGA-II in spaces that are too large to be exhausted: by pymoo, a generation in one call.

A genome is a row of numbers in $[0, 1]$: one each for the number of muscles, length, radius,
wall and angle, one for each gap between muscles (cut or not), and one for each unit's factor.
With `continuous` sizes lie anywhere between the least and the largest that the space lists;
else they are the nearest listed, so that the front can be compared with an exhaustive one.

A design that doesn't reach the task is worse than any that does, the more so the larger a share
of its worst point it misses, so that a search leads there; the nearest is kept where none does.

Seeded: the same seed gives the same front. Stopped after any generation, it goes on from its
checkpoint to the same end.
"""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from ...core.errors import InvalidInputError
from ...core.types import Float
from ..judge.allowed import Limits, checked, within_limits
from ..judge.judging import Values, evaluate, of_one_number, sizes_of
from ..judge.objectives import needs
from ..judge.outcome import Demand
from ..judge.reach import demanding, others, reaching, recorded
from ..judge.unlike import unlike_objectives
from ..space.designs import Designs, of_sizes
from ..space.grids import Space
from ..space.task import Task
from . import checkpoint as checkpoints
from .catalog import Catalog, cheapest
from .checkpoint import Kept
from .exhaustive import LEAST_MARGIN, Found, concluded, nearest
from .pareto import directed, non_dominated
from .study import Study


Genomes = Float[np.ndarray, "design gene"]
_GENERATIONS = 100  # of most searches: whether it pays to compile mustn't hang on when one stops
_AXES = ("length", "radius", "wall_ratio", "braid_angle")


class Coding:
    """From genomes to designs of a space."""

    def __init__(self, space: Space, continuous: bool):
        """**Arguments:**

        - `space`: of one drawing, with all compositions [-].
        - `continuous`: whether sizes may lie between those listed [-].

        **Raises:** `ValueError` for a space that isn't so.
        """
        if len(space.drawings) != 1:
            raise InvalidInputError(
                "drawings", "must hold one muscle for NSGA-II", None, "search each alone"
            )
        if space.splits != "all":
            raise InvalidInputError(
                "splits", "must be 'all' for NSGA-II, which cuts where it likes", None
            )
        self.space, self.continuous = space, continuous
        self.drawing = next(iter(space.drawings.values()))
        self.muscles = np.array(sorted(set(space.muscles)))
        self.most = int(self.muscles[-1])
        self.units = min(self.most, space.most_units or self.most)

    @property
    def genes(self) -> int:
        """How many numbers a genome has [-]."""
        return 1 + len(_AXES) + (self.most - 1) + self.units

    def designs(self, genomes: Genomes) -> Designs:
        """Designs of `genomes` [-], a row each."""
        total = self.muscles[_place(genomes[:, 0], len(self.muscles))]
        sizes = genomes[:, 1 : 1 + len(_AXES)]
        cuts = genomes[:, 1 + len(_AXES) : len(_AXES) + self.most] > 0.5
        shares = genomes[:, len(_AXES) + self.most :]
        counts = self._counts(total, cuts)
        factor = np.stack([self._value(self.space.unit_factors, row) for row in shares.T], axis=1)
        factor = np.where(counts > 0, factor, factor[:, :1])
        own = Space._own(self.drawing)
        length, radius, ratio, angle = (
            self._value(getattr(self.space, name) or (default,), sizes[:, i])
            for i, (name, default) in enumerate(zip(_AXES, own, strict=True))
        )
        sizes = (length, radius * self.space.scale(counts, factor), ratio, angle)
        kind = np.zeros(len(genomes), int)
        return of_sizes(self.space.drawings, kind, counts, factor, *sizes)

    def _counts(self, total: np.ndarray, cuts: np.ndarray) -> np.ndarray:
        gap = np.arange(1, self.most)
        cut = cuts & (gap < total[:, None])
        # units beyond the largest number join the last
        unit = np.minimum(np.cumsum(cut, axis=1), self.units - 1)
        unit = np.concatenate([np.zeros((len(total), 1), int), unit], axis=1)
        there = np.arange(self.most) < total[:, None]
        counts = np.zeros((len(total), self.units), int)
        np.add.at(counts, (np.nonzero(there)[0], unit[there]), 1)
        return counts

    def _value(self, listed: tuple[float, ...], share: np.ndarray) -> np.ndarray:
        if self.continuous:
            return min(listed) + share * (max(listed) - min(listed))
        return np.array(listed)[_place(share, len(listed))]


def evolve(
    space: Space,
    task: Task,
    senses: Mapping[str, str],
    limits: Limits | None = None,
    population: int = 100,
    generations: int = 100,
    seed: int = 0,
    continuous: bool = True,
    checkpoint: Path | None = None,
    watch: Callable[[int], None] | None = None,
    extra: tuple[str, ...] = (),
    catalog: Catalog | None = None,
    least_margin: float = LEAST_MARGIN,
) -> Found:
    """Search a space by NSGA-II.

    **Arguments:**

    - `space`: of one drawing, with all compositions [-].
    - `task`: what is demanded [-].
    - `senses`: "min" or "max" by objective [-].
    - `limits`: on objectives, by name [SI], as `search` takes them: all must be reached.
    - `population`: designs in a generation [-].
    - `generations`: how many [-].
    - `seed`: of chance [-].
    - `continuous`: whether sizes may lie between those listed [-].
    - `checkpoint`: a file that is kept after each generation, and gone on from [-].
    - `watch`: told how many generations are done [-].
    - `extra`: objectives to record that don't make the front [-].
    - `catalog`: products and prices [-]; left out, none is known.
    - `least_margin`: relative margin below which the recommended one is warned of [-].

    **Returns:** what was found [-]: of all designs that were judged, those of the front and the
    cheapest, or where none keeps the limits the one that comes nearest to the task.

    **Raises:** `ValueError` for a space it can't search, or another search's checkpoint;
    `ModuleNotFoundError` without pymoo.
    """
    limits, catalog = demanding(limits), catalog or Catalog()
    senses = dict(senses)
    names, told = recorded(senses, limits), recorded(senses, limits, extra)
    checked(senses, limits)
    coding, demand = Coding(space, continuous), Demand.of(task)
    # the digest is that of the numbers, `search` of how they are looked for
    digest = Study(space, task, names, senses, limits, block=1).digest
    search = {
        "study": digest, "senses": senses, "limits": str(limits), "catalog": str(catalog),
        "population": population, "seed": seed, "continuous": continuous,
    }  # fmt: skip
    state = _begun(coding, names, limits, len(senses), population, seed)
    if checkpoint is not None and checkpoint.exists():
        state = checkpoints.load(checkpoint, search, state.algorithm, tuple(state.values))
    while state.generation < generations:
        asked = state.algorithm.ask()
        genomes = np.asarray(asked.get("X"), float)
        values = _judged(coding, genomes, demand, names, population)
        asked.set("F", directed(values, senses))
        asked.set("G", _broken(values, limits))
        state.algorithm.tell(infills=asked)
        state = _kept(state, genomes, values, senses, limits, coding, catalog)
        if checkpoint is not None:
            checkpoints.save(checkpoint, search, state)
        if watch is not None:
            watch(state.generation)
    designs = coding.designs(state.genomes)
    # what is told in the end is told by the same means as an exhaustive search tells it
    values = evaluate(designs, task, told)
    return concluded(
        space, task, senses, limits, np.full(len(designs), -1), values, extra, catalog, designs,
        state.judged, least_margin,
    )  # fmt: skip


def _begun(
    coding: Coding, names: tuple[str, ...], limits: Limits, objectives: int, population: int,
    seed: int,
) -> Kept:  # fmt: skip
    """A search before its first generation."""
    from pymoo.algorithms.moo.nsga2 import NSGA2
    from pymoo.core.problem import Problem
    from pymoo.termination import get_termination

    problem = Problem(
        n_var=coding.genes, n_obj=objectives, n_ieq_constr=1 + len(others(limits)),
        xl=np.zeros(coding.genes), xu=np.ones(coding.genes),
    )  # fmt: skip
    algorithm = NSGA2(pop_size=population)
    algorithm.setup(problem, termination=get_termination("n_gen", 10**9), seed=seed, verbose=False)
    return Kept(algorithm, 0, 0, np.zeros((0, coding.genes)), {n: np.zeros(0) for n in names})


def _judged(
    coding: Coding,
    genomes: Genomes,
    demand: Demand,
    names: tuple[str, ...],
    population: int,
) -> Values:
    """Objectives of a generation in one call; a short one is filled up."""
    values = np.empty((len(names), len(genomes)))
    for places, designs in of_one_number(coding.designs(genomes), demand.scheme):
        rows = np.minimum(np.arange(max(population, len(designs))), len(designs) - 1)
        found = unlike_objectives(
            coding.drawing, sizes_of(designs, rows), demand, names=names, needs=needs(names),
            among=_GENERATIONS * population,
        )  # fmt: skip
        values[:, places] = np.asarray(found)[:, : len(designs)]
    return dict(zip(names, values, strict=True))


def _broken(values: Values, limits: Limits) -> Float[np.ndarray, "design limit"]:
    """How far limits are broken [SI], positive where they are; first how far from the task."""
    # a share of points says nothing of how near they are
    far = np.maximum(values["relative_shortfall"], np.finfo(float).tiny)
    columns = [np.where(reaching(values, limits), -1.0, far)]
    for name, limit in others(limits).items():
        excess = limit.excess(values[name])
        columns.append(np.where(np.isfinite(excess), excess, -1.0))
    return np.stack(columns, axis=1)


def _kept(
    state: Kept,
    genomes: Genomes,
    values: Values,
    senses: Mapping[str, str],
    limits: Limits,
    coding: Coding,
    catalog: Catalog,
) -> Kept:
    """A generation more, added to what is kept: the front and the cheapest, or the nearest."""
    more = state._replace(generation=state.generation + 1, judged=state.judged + len(genomes))
    rows = np.concatenate([state.genomes, genomes])
    both = {name: np.concatenate([state.values[name], values[name]]) for name in values}
    (good,) = np.nonzero(within_limits(both, limits))
    kept = np.zeros(len(rows), bool)
    if not good.size:
        kept[nearest(both, limits)] = True
    else:
        points = directed(both, senses)[good]
        # of equal points the first is enough
        first = np.zeros(len(good), bool)
        first[np.unique(points, axis=0, return_index=True)[1]] = True
        kept[good[first & non_dominated(points)]] = True
        kept[_cheapest(coding, rows, both, good, catalog)] = True
    return more._replace(genomes=rows[kept], values={name: one[kept] for name, one in both.items()})


def _cheapest(
    coding: Coding, rows: Genomes, values: Values, good: np.ndarray, catalog: Catalog
) -> int | None:
    def designs(places: np.ndarray) -> Designs:
        return coding.designs(rows[places])

    return cheapest(good, values, designs, catalog, coding.space.drawings)


def _place(share: np.ndarray, count: int) -> np.ndarray:
    return np.minimum((share * count).astype(int), count - 1)
