r"""NSGA-II in spaces that are too large to be exhausted: by pymoo, a generation in one call.

A genome is a row of numbers in $[0, 1]$: one each for the number of muscles, length, radius,
wall and angle, one for each gap between muscles (cut or not), and one for each unit's factor.
With `continuous` sizes lie anywhere between the least and the largest that the space lists;
else they are the nearest listed, so that the front can be compared with an exhaustive one.

A design that doesn't reach the task is worse than any that does, the more so the larger a share
of its worst point it misses, so that a search leads there; the nearest is kept where none does.

The same seed gives the same front. A search that was stopped after any generation resumes from its
checkpoint to the same end. That file is NumPy's `.npz`: the population with its ranks, the front of
all designs evaluated, and a JSON text with the search's identity and the state of its random
numbers. It may come from anybody, so all of it is validated before any is used.
"""

import json
import os
from collections.abc import Callable, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Float
from ..io.atomic import replace_whole
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


_GENES = ("population", "genomes")
_LARGEST = 1_000_000_000  # bytes; a population of 10 000 takes some millions
_UNRANKED = -1  # what keeps no limit has no rank, and no crowding


class SearchState(NamedTuple):
    """What a search has so far: pymoo's `algorithm`, how many `generation`s and designs `judged`
    [-], and of the front of all of them the `genomes` [-] and `values` [SI].
    """

    algorithm: Any
    generation: int
    judged: int
    genomes: Float[np.ndarray, "front gene"]
    values: Values


def save(path: Path, search: dict[str, Any], kept: SearchState) -> None:
    """Write a checkpoint, whole or not at all.

    **Arguments:**

    - `path`: where it goes [-].
    - `search`: what tells this search from any other, as JSON can hold it [-].
    - `kept`: what it has so far [-].
    """
    pop, stream = kept.algorithm.pop, kept.algorithm.random_state.bit_generator.state
    rank, crowding = ([one.get(name) for one in pop] for name in ("rank", "crowding"))
    about = {
        "format": 1, "search": search, "generation": kept.generation, "judged": kept.judged,
        "names": list(kept.values), "random": stream,
    }  # fmt: skip
    with replace_whole(path) as draft, draft.open("wb") as file:
        np.savez(
            file,
            about=np.array(json.dumps(about)),
            population=pop.get("X"),
            objectives=pop.get("F"),
            limits=pop.get("G"),
            rank=np.array([_UNRANKED if one is None else one for one in rank], float),
            crowding=np.array([np.nan if one is None else one for one in crowding], float),
            genomes=kept.genomes,
            values=np.stack(list(kept.values.values())),
        )
        file.flush()
        os.fsync(file.fileno())


def load(path: Path, search: dict[str, Any], algorithm: Any, names: Sequence[str]) -> SearchState:
    """Go on from a checkpoint.

    **Arguments:**

    - `path`: where it is [-].
    - `search`: as of `save` [-].
    - `algorithm`: pymoo's, set up and not yet begun [-].
    - `names`: of the objectives that are kept [-].

    **Returns:** what the search had [-], the `algorithm` as it was.

    **Raises:** `ValueError`, one line, for a file that isn't this search's checkpoint.
    """
    try:
        arrays, about = _read(path)
    except OSError as error:
        raise ValueError(f"{str(error).rstrip('.')}: name a new file.") from None
    except Exception:  # noqa: BLE001 there is no end to what a made-up file can provoke
        raise ValueError(f"{path}: is no checkpoint of a search: name a new file.") from None
    if about["search"] != json.loads(json.dumps(search)):
        raise ValueError(f"{path}: is another search's: name a new file.")
    problem, size = algorithm.problem, len(arrays["population"])
    shapes = {
        "population": (size, problem.n_var), "objectives": (size, problem.n_obj),
        "limits": (size, problem.n_ieq_constr), "rank": (size,), "crowding": (size,),
        "genomes": (len(arrays["genomes"]), problem.n_var),
        "values": (len(names), len(arrays["genomes"])),
    }  # fmt: skip
    if (
        not size
        or sorted(about["names"]) != sorted(names)
        or any(arrays[name].shape != shape for name, shape in shapes.items())
        or not all(np.all((arrays[name] >= 0) & (arrays[name] <= 1)) for name in _GENES)
        or any(np.any(np.isnan(arrays[name])) for name in ("objectives", "limits", "rank"))
    ):
        raise ValueError(f"{path}: holds numbers that no search has: name a new file.")
    _restore(algorithm, arrays, about)
    values = dict(zip(about["names"], arrays["values"], strict=True))
    return SearchState(algorithm, about["generation"], about["judged"], arrays["genomes"], values)


def _read(path: Path) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Arrays and text, each of its kind; an exception of some kind where they aren't."""
    raw = BytesIO(read_bytes(path, _LARGEST, "checkpoint"))
    with np.load(raw, allow_pickle=False) as file:
        about = json.loads(str(file["about"]))
        names = ("population", "objectives", "limits", "rank", "crowding", "genomes", "values")
        arrays = {name: file[name] for name in names}
    if any(array.dtype != np.float64 or not array.ndim for array in arrays.values()):
        raise ValueError
    if any(arrays[name].ndim != 2 for name in _GENES):
        raise ValueError
    if not isinstance(about["search"], dict) or any(type(one) is not str for one in about["names"]):
        raise ValueError
    if about["format"] != 1 or min(about["generation"], about["judged"]) < 1:
        raise ValueError
    random = about["random"]
    whole = [about["generation"], about["judged"], *random["state"].values(),
             random["has_uint32"], random["uinteger"]]  # fmt: skip
    if any(type(one) is not int for one in whole):
        raise ValueError
    _stream(random)
    return arrays, about


def _stream(state: dict[str, Any]) -> np.random.Generator:
    """Random numbers from where they stood."""
    bits: Any = np.random.PCG64()
    bits.state = state
    return np.random.Generator(bits)


def _restore(algorithm: Any, arrays: dict[str, np.ndarray], about: dict[str, Any]) -> None:
    """Put pymoo's `algorithm` where it was after its last generation."""
    from pymoo.core.population import Population

    pop = Population.new("X", arrays["population"])
    pop.set("F", arrays["objectives"])
    pop.set("G", arrays["limits"])
    for one, rank, crowding in zip(pop, arrays["rank"], arrays["crowding"], strict=True):
        if rank != _UNRANKED:
            one.set("rank", int(rank))
            one.set("crowding", float(crowding))
    algorithm.pop = algorithm.off = pop
    algorithm.is_initialized = True
    algorithm.n_iter = about["generation"] + 1
    algorithm.random_state = _stream(about["random"])
    algorithm._set_optimum()


Genomes = Float[np.ndarray, "design gene"]
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
    limits, catalog = with_reach_limits(limits), catalog or Catalog()
    senses = dict(senses)
    names, told = recorded_objectives(senses, limits), recorded_objectives(senses, limits, extra)
    check_search(senses, limits)
    coding = Coding(space, continuous)
    # the digest is that of the numbers, `search` of how they are looked for
    digest = Study(space, task, names, senses, limits, block=1).digest
    search = {
        "study": digest, "senses": senses, "limits": str(limits), "catalog": str(catalog),
        "population": population, "seed": seed, "continuous": continuous,
    }  # fmt: skip
    state = _begun(coding, names, limits, len(senses), population, seed)
    if checkpoint is not None and checkpoint.exists():
        state = load(checkpoint, search, state.algorithm, tuple(state.values))
    while state.generation < generations:
        asked = state.algorithm.ask()
        genomes = np.asarray(asked.get("X"), float)
        values = evaluate(coding.designs(genomes), task, names, MIXED)
        asked.set("F", as_minimization(values, senses))
        asked.set("G", _broken(values, limits))
        state.algorithm.tell(infills=asked)
        state = _kept(state, genomes, values, senses, limits, coding, catalog)
        if checkpoint is not None:
            save(checkpoint, search, state)
        if watch is not None:
            watch(state.generation)
    designs = coding.designs(state.genomes)
    # what is told in the end is told by the same means as an exhaustive search tells it
    values = evaluate(designs, task, told)
    return conclude(
        space, task, senses, limits, np.full(len(designs), -1), values, extra, catalog, designs,
        state.judged, least_margin,
    )  # fmt: skip


def _begun(
    coding: Coding, names: tuple[str, ...], limits: Limits, objectives: int, population: int,
    seed: int,
) -> SearchState:  # fmt: skip
    """A search before its first generation."""
    from pymoo.algorithms.moo.nsga2 import NSGA2
    from pymoo.core.problem import Problem
    from pymoo.termination import get_termination

    problem = Problem(
        n_var=coding.genes, n_obj=objectives, n_ieq_constr=1 + len(other_limits(limits)),
        xl=np.zeros(coding.genes), xu=np.ones(coding.genes),
    )  # fmt: skip
    algorithm = NSGA2(pop_size=population)
    algorithm.setup(problem, termination=get_termination("n_gen", 10**9), seed=seed, verbose=False)
    return SearchState(
        algorithm, 0, 0, np.zeros((0, coding.genes)), {n: np.zeros(0) for n in names}
    )


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
