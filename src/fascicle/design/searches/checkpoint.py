"""A search by NSGA-II, kept between two generations: arrays and JSON, nothing that is run.

The file is NumPy's `.npz`: the population with its ranks, the front of all that was judged, and
a text that says which search this is and where its random numbers stand. It is data from
whoever wrote it, so all of it is checked before any is used.
"""

import json
import os
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...core.types import Float
from ...io.atomic import replace_whole
from ...io.input_file import read_bytes
from ..judge.judging import Values


_GENES = ("population", "genomes")
_LARGEST = 1_000_000_000  # bytes; a population of 10 000 takes some millions
_UNRANKED = -1  # what keeps no limit has no rank, and no crowding


class Kept(NamedTuple):
    """What a search has so far: pymoo's `algorithm`, how many `generation`s and designs `judged`
    [-], and of the front of all of them the `genomes` [-] and `values` [SI].
    """

    algorithm: Any
    generation: int
    judged: int
    genomes: Float[np.ndarray, "front gene"]
    values: Values


def save(path: Path, search: dict[str, Any], kept: Kept) -> None:
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


def load(path: Path, search: dict[str, Any], algorithm: Any, names: Sequence[str]) -> Kept:
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
    return Kept(algorithm, about["generation"], about["judged"], arrays["genomes"], values)


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
