"""From a task file to a task, a space of designs, and what is good: checked once, on the way in."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationError

from ..bundle import Bundle
from ..bundle.schemes import scheme_of
from ..core.errors import InvalidInputError
from ..core.module import with_fields
from ..core.validation import check_choice
from ..design.catalog import Catalog
from ..design.exhaustive_search import LEAST_MARGIN, USUAL
from ..design.objectives import OBJECTIVES, SHARES, Limit, checked, demanding, known
from ..design.space import SPLITS, Space
from ..design.space import read as read_split
from ..design.task import FLUIDS, Task, example_task
from ..muscle import Muscle
from ..muscle.buckling import BUCKLING_LAWS
from ..records.dynamometer import Scatter
from ..units import parse
from .catalog import Offer, offer, sections_of
from .drawn import drawn
from .faults import from_validation
from .kinds import check_kind
from .named import example, examples
from .places import Place
from .prices import Price
from .reading import load, parsed, provenance, text_of
from .task_schema import (
    DesignSection,
    PricesSection,
    ScatterSection,
    TaskFileSection,
    TaskSection,
)


DIMENSIONS = {"-": "number", "J": "energy", "N": "force", "m": "length"}
_BOUNDS = {"at_least": "least", "at_most": "most"}
_WARNING = "warn_below"  # of a margin, in its table
_BY_LIST = ("force", "strain", "stroke", "weight")
_OF_PRODUCTS = ("radius", "radius_rule", "wall_ratio", "braid_angle", "unit_factors")
BLOCK = 4096  # designs of a study worked on at once, unless it says otherwise


class Chance(NamedTuple):
    """How unlike muscles come out: `scatter`, how many `draws`, and `muscles` drawn from a
    calibration, or `None`.
    """

    scatter: Scatter
    draws: int
    muscles: Muscle | None


@dataclass(frozen=True, eq=False)
class TaskFile:
    """What a task file says: the `task`, the `space` of designs, the objectives' `senses` and
    `limits` by name, the `catalog` of what can be bought, the `chance` that no muscle comes out as
    drawn, how many designs make a `block` of a study, the file's own `data`, `notes` on what
    was left out, and the `least_margin` below which a design is warned of.
    """

    task: Task
    space: Space
    senses: dict[str, str]
    limits: dict[str, Limit]
    catalog: Catalog
    chance: Chance | None
    block: int
    data: Mapping[str, Any]
    notes: tuple[str, ...] = ()
    least_margin: float = LEAST_MARGIN


def load_task(path: str | os.PathLike[str]) -> TaskFile:
    """Read a task file.

    **Arguments:** `path`: the TOML file [-]; muscles that it names by a path stand beside it.

    **Returns:** what it says [-].

    **Raises:** `OSError` where it can't be read; `ValueError`, in one line with the path and
    the key, where what it says can't be.
    """
    path = Path(path)
    return loads_task(text_of(path), str(path), path.parent)


def loads_task(text: str, source: str = "<text>", folder: Path = Path()) -> TaskFile:
    """Read what a task file holds.

    **Arguments:**

    - `text`: the TOML [-].
    - `source`: what to call it in an error [-].
    - `folder`: where muscle files stand that it names [-].

    **Returns:** as `load_task` [-].

    **Raises:** as `load_task`.
    """
    data = parsed(text, source)
    check_kind(data, "task", source)
    try:
        file = TaskFileSection.model_validate(data)
    except ValidationError as error:
        raise ValueError(from_validation(error, source, data, TaskFileSection)) from None
    task = _task(file.task, Place(source, data, ("task",), "task"))
    at_limits = Place(source, data, ("limits",), "limits")
    limits, least_margin = _limits(file.limits or {}, at_limits)
    senses = _senses(file.objectives, Place(source, data, ("objectives",), "objectives"))
    place = Place(source, data, ("design",), "design")
    with at_limits.naming():
        checked(senses, demanding(limits))
    bought = _offer(file.design, place, folder)
    space = _space(file.design, place, limits, folder, bought)
    at = Place(source, data, ("prices",), "prices")
    catalog = _catalog(file.prices or PricesSection(), at, file.design.density, bought)
    block = BLOCK if file.sweep is None or file.sweep.block is None else file.sweep.block
    if not 1 <= block <= 2**20:
        at = Place(source, data, ("sweep",), "task")
        raise at.refuse(("block",), "must lie in [1, 1048576] designs.")
    density = file.design.density
    if density is not None and not 1.0 <= density <= 3e4:
        raise place.refuse(("density",), "must lie in [1, 30000] kg/m^3.")
    chance = None
    if file.scatter is not None:
        at = Place(source, data, ("scatter",), "task")
        if len(space.drawings) > 1:
            raise at.refuse((), "needs a space of one muscle, search each alone.")
        chance = _chance(file.scatter, file.design, at, folder)
    notes = (*_errors(file.design, folder), *(() if bought is None else bought.notes))
    return TaskFile(task, space, senses, limits, catalog, chance, block, data, notes, least_margin)


def _task(section: TaskSection, place: Place) -> Task:
    given: dict[str, Any] = section.model_dump(exclude_none=True)
    supply = given.pop("supply_pressure")
    if section.example is not None:
        others = [key for key in given if key not in ("example", "scheme", "fluid")]
        if others:
            raise place.refuse((others[0],), "an example has its own, drop this key or `example`.")
        with place.naming():
            made = example_task(section.example, supply)
            scheme = scheme_of(section.scheme or made.scheme)
            return replace(
                made, scheme=scheme, fluid=check_choice(section.fluid or "air", FLUIDS, "fluid")
            )
    if "strain" in given and "stroke" in given:
        raise place.refuse(
            ("stroke",),
            "`strain` is there too, and says the same of a bundle of one length: keep one of them.",
        )
    for key in ("force", "strain"):
        if key not in given and not (key == "strain" and "stroke" in given):
            other = ' (or stroke = ["25 mm", …])' if key == "strain" else ""
            raise place.refuse((key,), f'missing, write {key} = […]{other}, or example = "…".')
    if "time" in given and "weight" in given:
        raise place.refuse(("weight",), "points in time count for as long as they last: drop it.")
    for key in _BY_LIST:
        # one value, not a list of one, stands for all points
        if key in given and isinstance(place.data["task"][key], str | int | float):
            given[key] = given[key][0] if len(given[key]) == 1 else given[key]
    with place.naming():
        make = Task.in_time if "time" in given else Task.of
        return make(**({"strain": None, "supply_pressure": supply} | given))


def _offer(section: DesignSection, place: Place, folder: Path) -> Offer | None:
    """What the catalog offers, where there is one."""
    if section.catalog is None:
        return None
    for key in _OF_PRODUCTS:
        if getattr(section, key) is not None:
            raise place.refuse((key,), "products have their own: drop this key, or the catalog.")
    if len(section.muscle) != 1:
        raise place.refuse(
            ("muscle",), "must be one for a catalog; a product may name its own, muscle = …."
        )
    at = place.inner("catalog", kind="catalog")
    sections, at = sections_of(section.catalog, at, folder)
    drawing: dict[str | None, tuple[str, Muscle]] = {}
    for i, product in enumerate(sections):
        name = product.muscle or section.muscle[0]
        own = place if product.muscle is None else at.inner(i, kind="catalog")
        drawing[product.muscle] = name, _drawing(name, section, own, folder)
    return offer(sections, at, section.length or (), drawing)


def _catalog(
    section: PricesSection, place: Place, density: float | None, bought: Offer | None
) -> Catalog:
    given: dict[str, Price] = {key: one for key, one in section if one is not None}
    currency = "" if bought is None else bought.currency
    for key, one in given.items():
        currency = currency or one.currency
        if one.currency != currency:
            raise place.refuse((key,), f"another price is in {currency}: give all in one currency.")
    amounts = {key: one.amount for key, one in given.items()}
    products = {} if bought is None else bought.products
    return Catalog(products, currency, density=density, **amounts)


def _space(
    section: DesignSection,
    place: Place,
    limits: Mapping[str, Limit],
    folder: Path,
    bought: Offer | None,
) -> Space:
    kept = ("muscle", "splits", "buckling", "density", "catalog")
    if bought is None:
        drawings = {name: _drawing(name, section, place, folder) for name in section.muscle}
    else:
        drawings, kept = bought.drawings, (*kept, "length")
    given: dict[str, Any] = section.model_dump(exclude_none=True, exclude=set(kept))
    splits = section.splits or ("all",)
    if "valves" in limits and limits["valves"].most < 1:
        raise place.refuse((), "the space is empty: every bundle needs a valve.")
    if "valves" in limits and limits["valves"].most < 1e6:
        given["most_units"] = int(limits["valves"].most)
    with place.naming():
        if len(splits) == 1 and splits[0] in SPLITS:
            return Space(drawings, splits=splits[0], **given)
        chosen = tuple(read_split(text) for text in splits)
        numbers = tuple(dict.fromkeys(sum(row) for row in chosen))
        if "muscles" in given and set(given["muscles"]) != set(numbers):
            raise InvalidInputError(
                "muscles", "must be left out where the splits are written out", None
            )
        given["muscles"] = numbers
        return Space(drawings, splits=chosen, **given)


def _chance(section: ScatterSection, design: DesignSection, place: Place, folder: Path) -> Chance:
    name, *others = design.muscle
    if others:
        raise place.refuse((), "needs a space of one muscle, search each alone.")
    draws = 200 if section.draws is None else section.draws
    if not 2 <= draws <= 100_000:
        raise place.refuse(("draws",), "must lie in [2, 100000].")
    with place.naming():
        given = section.model_dump(exclude_none=True, include={"length", "braid_angle"})
        scatter, muscles = Scatter(**given), None
        if section.calibrated:
            path = folder / name
            if not path.exists():
                raise InvalidInputError(
                    "calibrated", f"needs a muscle file, {name!r} is none", None
                )
            muscles = drawn(path)
            if design.buckling is not None:
                raise InvalidInputError(
                    "calibrated", "constants hold for the law they were fitted with", None
                )
        return Chance(scatter, draws, muscles)


def _drawing(name: str, section: DesignSection, place: Place, folder: Path) -> Muscle:
    with place.naming():
        if name in examples():
            found = example(name)
        else:
            path = folder / name
            if not path.exists():
                check_choice(name, examples(), "muscle")
            found = load(path)
        if isinstance(found, Bundle):
            raise InvalidInputError("muscle", f"{name!r} is a bundle", None, "name a muscle")
        if section.buckling is not None:
            law: Any = BUCKLING_LAWS[check_choice(section.buckling, BUCKLING_LAWS, "buckling")]
            found = with_fields(found, buckling=law())
        return found


def _errors(section: DesignSection, folder: Path) -> list[str]:
    """What calibrated muscles are off by, which no margin counts."""
    notes = []
    for name in section.muscle:
        told = provenance(folder / name).get("rmse") if name not in examples() else None
        if isinstance(told, str):
            notes.append(
                f"{name} was fitted with an error of {told} (rmse): a margin doesn't count it."
            )
    return notes


def _senses(given: Mapping[str, str] | None, place: Place) -> dict[str, str]:
    senses = dict(USUAL if given is None else given)
    for name, sense in senses.items():
        with place.naming():
            known([name])
        if sense not in ("min", "max"):
            raise place.refuse((name,), 'must be "min" or "max".')
    return senses


def _limits(given: Mapping[str, Any], place: Place) -> tuple[dict[str, Limit], float]:
    """Limits by objective, and the relative margin below which a design is warned of."""
    limits, least_margin = {}, LEAST_MARGIN
    for name, bounds in given.items():
        with place.naming():
            known([name])
        if name == "margin" and not isinstance(bounds, dict):
            least_margin = _share(bounds, place, (name,))
            continue
        if not isinstance(bounds, dict):
            raise place.refuse((name,), "must be a table: write { at_most = … }.")
        if name == "margin" and _WARNING in bounds:
            least_margin = _share(bounds[_WARNING], place, (name, _WARNING))
            if len(bounds) == 1:
                continue
        ends = {key: end for key, end in bounds.items() if (name, key) != ("margin", _WARNING)}
        limits[name] = _limit(name, ends, place)
    return limits, least_margin


def _share(text: Any, place: Place, keys: tuple[str, ...]) -> float:
    """The share of a demanded force that `[limits] margin` gives."""
    rule = 'must be a share in [0, 10], as "20 %" is; a limit is margin = { at_least = "50 N" }.'
    try:
        share = parse(text, "number", keys[-1])
    except ValueError:
        raise place.refuse(keys, rule) from None
    if not 0 <= share <= 10:
        raise place.refuse(keys, rule)
    return share


def _limit(name: str, bounds: Mapping[str, Any], place: Place) -> Limit:
    dimension = DIMENSIONS[OBJECTIVES[name].unit]
    ends = {}
    for key, text in bounds.items():
        if key not in _BOUNDS:
            raise place.refuse((name, key), "unknown key: write at_least or at_most.")
        try:
            ends[_BOUNDS[key]] = parse(text, dimension, key)
        except ValueError as error:
            raise place.refuse((name, key), str(error)) from None
    if not ends:
        raise place.refuse((name,), "empty: write { at_most = … } or { at_least = … }.")
    if name in SHARES and not all(0 <= end < 1 for end in ends.values()):
        rule = 'a share of the task: must lie in [0, 1), as "10 %" does.'
        raise place.refuse((name,), f"{rule} Something must be reached.")
    return Limit(**ends)
