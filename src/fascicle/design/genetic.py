r"""NSGA-II in spaces that are too large to be exhausted: by pymoo, a generation in one call.

A genome is a row of numbers in $[0, 1]$: one each for the number of muscles, length, radius,
wall and angle, one for each gap between muscles (cut or not), and one for each unit's factor.
With `continuous` sizes lie anywhere between the least and the largest that the space lists;
else they are the nearest listed, so that the front can be compared with an exhaustive one.

A design that doesn't reach the task is worse than any that does, the more so the larger a share
of its worst point it misses, so that a search leads there; the nearest is kept where none does.

The same seed gives the same front. A search that was stopped after any generation resumes from its
checkpoint to the same end. The file may come from anybody, so all of it is validated.
"""

import json
import os
from collections.abc import Callable, Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Float
from ..io.atomic import write_text
from ..io.input_file import read_bytes
from .catalog import Catalog, cheapest
from .designs import Designs, scaled_designs
from .evaluation import Values, evaluate
from .exhaustive_search import (
    LEAST_MARGIN,
    SearchResult,
    as_minimization,
    conclude,
    nearest,
    non_dominated,
)
from .objectives import (
    Limits,
    check_search,
    other_limits,
    reaches_task,
    recorded_objectives,
    with_reach_limits,
    within_limits,
)
from .space import Space
from .sweep import Study
from .tables import MIXED
from .task import Task


_AXES = ("length", "radius", "wall_ratio", "braid_angle")
_LARGEST = 1_000_000_000  # bytes of a checkpoint; a hundred generations take some two million

Genomes = Float[np.ndarray, "design gene"]


class Checkpoint:
    """Objectives of every generation of a search, in a file of JSON lines.

    A search resumes by running again with these objectives instead of the designs: the same seed
    makes the same generations, which a digest in each line confirms.
    """

    def __init__(self, path: Path, search: dict[str, Any]):
        """**Arguments:**

        - `path`: of the file, which may exist.
        - `search`: what distinguishes this search from any other, as JSON can hold it.

        **Raises:** `ValueError`, one line, for a file that isn't this search's checkpoint.
        """
        self.path, self.header = path, json.dumps({"format": 2, "search": search})
        self.lines: list[dict[str, Any]] = []
        if not path.exists():
            return
        first, lines, cut = "", [], ""
        try:
            # a last line without its end was cut off, and its generation is computed again
            first, *lines, cut = read_bytes(path, _LARGEST, "checkpoint").decode().split("\n")
            header, self.lines = json.loads(first), [json.loads(line) for line in lines]
            keys = {"genomes", "values"}
            valid = header["format"] == 2 and all(set(line) == keys for line in self.lines)
        except OSError as error:
            raise ValueError(f"{str(error).rstrip('.')}: name a new file.") from None
        except Exception:  # noqa: BLE001 there is no end to what a made-up file can provoke
            valid = False
        if not valid:
            raise ValueError(f"{path}: is no checkpoint of a search: name a new file.")
        if first != self.header:
            raise ValueError(f"{path}: is another search's: name a new file.")
        if cut:
            write_text(path, "\n".join([first, *lines, ""]))

    def values(self, generation: int, genomes: Genomes, names: tuple[str, ...]) -> Values | None:
        """Objectives [SI] of a `generation` by name, if the file has them.

        **Raises:** `ValueError` where they aren't those of the `genomes`.
        """
        if generation >= len(self.lines):
            return None
        line = self.lines[generation]
        try:
            values: np.ndarray = np.array(line["values"], float)
        except (TypeError, ValueError):
            values = np.zeros(0)
        shape = (len(names), len(genomes))
        if line["genomes"] != _digest(genomes) or values.shape != shape or np.isnan(values).any():
            raise ValueError(f"{self.path}: holds numbers that no search has: name a new file.")
        return {name: values[row] for row, name in enumerate(names)}

    def append(self, genomes: Genomes, values: Values) -> None:
        """Add a generation's `genomes` and `values` [SI]; on the disk on return."""
        rows = [row.tolist() for row in values.values()]
        line = json.dumps({"genomes": _digest(genomes), "values": rows}) + "\n"
        if not self.path.exists():
            write_text(self.path, f"{self.header}\n")
        with self.path.open("a", encoding="utf-8") as file:
            file.write(line)
            file.flush()
            os.fsync(file.fileno())


def _digest(genomes: Genomes) -> str:
    return sha256(np.ascontiguousarray(genomes, "<f8").tobytes()).hexdigest()


class SearchState(NamedTuple):
    """What a search keeps: how many `generation`s and designs `judged`, and of the front of all of
    them, with the cheapest, the `genomes` [-] and `values` [SI].
    """

    generation: int
    judged: int
    genomes: Genomes
    values: Values


class Coding:
    """From genomes to designs of a space."""

    def __init__(self, space: Space, continuous: bool):
        """**Arguments:**

        - `space`: of one drawing, with all compositions.
        - `continuous`: whether sizes may lie between those listed.

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
        return scaled_designs(self.space.drawings, kind, counts, factor, *sizes)

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
) -> SearchResult:
    """Search a space by NSGA-II.

    **Arguments:**

    - `space`: of one drawing, with all compositions.
    - `task`: what is demanded.
    - `senses`: "min" or "max" by objective.
    - `limits`: on objectives, by name [SI], as `search` takes them: all must be reached.
    - `population`: designs in a generation [-].
    - `generations`: how many [-].
    - `seed`: of chance.
    - `continuous`: whether sizes may lie between those listed.
    - `checkpoint`: a file that is kept after each generation, and gone on from [-].
    - `watch`: called with how many generations are done [-].
    - `extra`: objectives to record that don't make the front.
    - `catalog`: products and prices [-]; left out, none is known.
    - `least_margin`: relative margin [-] below which the recommended one is warned of.

    **Returns:** what was found: of all designs that were judged, those of the front and the
    cheapest, or where none keeps the limits the one that comes nearest to the task.

    **Raises:** `ValueError` for a space it can't search, or another search's checkpoint;
    `ModuleNotFoundError` without pymoo.
    """
    limits, catalog = with_reach_limits(limits), catalog or Catalog()
    senses = dict(senses)
    names, reported = (
        recorded_objectives(senses, limits),
        recorded_objectives(senses, limits, extra),
    )
    check_search(senses, limits)
    coding = Coding(space, continuous)
    # the digest is that of the numbers, `search` of how they are looked for
    digest = Study(space, task, names, senses, limits, block=1).digest
    search = {
        "study": digest, "senses": senses, "limits": str(limits), "catalog": str(catalog),
        "population": population, "seed": seed, "continuous": continuous,
    }  # fmt: skip
    store = None if checkpoint is None else Checkpoint(checkpoint, search)
    algorithm = _nsga2(coding.genes, len(senses), 1 + len(other_limits(limits)), population, seed)
    empty = {name: np.zeros(0) for name in names}
    state = SearchState(0, 0, np.zeros((0, coding.genes)), empty)
    while state.generation < generations or (store and state.generation < len(store.lines)):
        infills = algorithm.ask()
        genomes = np.asarray(infills.get("X"), float)
        values = store.values(state.generation, genomes, names) if store else None
        resumed = values is not None
        if values is None:
            values = evaluate(coding.designs(genomes), task, names, MIXED)
        infills.set("F", as_minimization(values, senses))
        infills.set("G", _broken(values, limits))
        algorithm.tell(infills=infills)
        state = _kept(state, genomes, values, senses, limits, coding, catalog)
        if store and not resumed:
            store.append(genomes, values)
        if watch is not None and not resumed:
            watch(state.generation)
    designs = coding.designs(state.genomes)
    # the end result has the resolution of an exhaustive search
    values = evaluate(designs, task, reported)
    return conclude(
        space, task, senses, limits, np.full(len(designs), -1), values, extra, catalog, designs,
        state.judged, least_margin,
    )  # fmt: skip


def _nsga2(genes: int, objectives: int, constraints: int, population: int, seed: int) -> Any:
    """Pymoo's algorithm before its first generation."""
    from pymoo.algorithms.moo.nsga2 import NSGA2
    from pymoo.core.problem import Problem
    from pymoo.termination import get_termination

    problem = Problem(
        n_var=genes, n_obj=objectives, n_ieq_constr=constraints, xl=np.zeros(genes),
        xu=np.ones(genes),
    )  # fmt: skip
    algorithm = NSGA2(pop_size=population)
    algorithm.setup(problem, termination=get_termination("n_gen", 10**9), seed=seed, verbose=False)
    return algorithm


def _broken(values: Values, limits: Limits) -> Float[np.ndarray, "design limit"]:
    """How far limits are broken [SI], positive where they are; first how far from the task."""
    # a share of points says nothing of how near they are
    far = np.maximum(values["relative_shortfall"], np.finfo(float).tiny)
    columns = [np.where(reaches_task(values, limits), -1.0, far)]
    for name, limit in other_limits(limits).items():
        excess = limit.excess(values[name])
        columns.append(np.where(np.isfinite(excess), excess, -1.0))
    return np.stack(columns, axis=1)


def _kept(
    state: SearchState,
    genomes: Genomes,
    values: Values,
    senses: Mapping[str, str],
    limits: Limits,
    coding: Coding,
    catalog: Catalog,
) -> SearchState:
    """A generation more, added to what is kept: the front and the cheapest, or the nearest."""
    more = state._replace(generation=state.generation + 1, judged=state.judged + len(genomes))
    rows = np.concatenate([state.genomes, genomes])
    both = {name: np.concatenate([state.values[name], values[name]]) for name in values}
    (good,) = np.nonzero(within_limits(both, limits))
    kept = np.zeros(len(rows), bool)
    if not good.size:
        kept[nearest(both, limits)] = True
    else:
        points = as_minimization(both, senses)[good]
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
