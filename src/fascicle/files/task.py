"""Task files: from TOML to a task, a space of designs, objectives and limits, and a catalog.

A catalog's product has a radius, and lengths: in stock, or a range of them, cut to order. Material,
laws and sizes that it doesn't give are those of a muscle. In one length it becomes one drawing.
"""

import math
import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import attrs

from ..bundle import Bundle
from ..bundle.schemes import scheme_of
from ..core.errors import InvalidInputError
from ..core.findings import Finding, Severity
from ..core.module import with_fields
from ..core.validation import check_choice, check_interval
from ..design import objectives
from ..design.cycle import Cycle
from ..design.exhaustive_search import LEAST_MARGIN, USUAL
from ..design.objectives import Limit, check_objectives
from ..design.scatter import USUAL_SCATTER, USUAL_SHARE, DesignScatter, Uncertainty
from ..design.space import SPLITS, Catalog, Product, Space, read_split
from ..design.task import FLUIDS, Task, example_task
from ..muscle import Muscle
from ..muscle.buckling import BUCKLING_LAWS
from ..table_model import validate
from ..units import dimension_of_unit, parse
from . import named_muscles, schema, shipped_names, shipped_text
from .measured_muscles import catalog as measured_muscles
from .muscle_files import load_named, parse_file, provenance, read_file
from .schema import DesignSection, FileLocation, Price, ProductSection


_BOUNDS = {"at_least": "least", "at_most": "most"}  # keys of a limit, and their names in `Limit`
_WARNING = "warn_below"  # key of a margin, in its table
_SAFETY = "safety"  # key of [limits] that isn't an objective's
_LISTS = ("force", "strain", "stroke", "weight")  # keys whose single value stands for all points
# keys of [design] that products have themselves
_PRODUCT_KEYS = ("radius", "radius_rule", "wall_ratio", "braid_angle", "unit_factors")
_RADII = ("outer_radius", "outer_diameter", "inner_diameter")  # of which a product has one
_BLOCK = 4096  # designs evaluated together: some 100 MB
_MAX_VALVES = 1e6  # a limit above is none
_MAX_DRAWINGS = 10_000  # more products are a slip in a list of lengths
# more than any product's, a slip in the unit
_MAX_VALUES = (
    ("largest_pressure", 1e9, "Pa"),
    ("largest_strain", 1.0, "-"),
    ("mass", 1e6, "kg"),
    ("mass_per_length", 1e6, "kg/m"),
)


class Offer(NamedTuple):
    """Muscles on sale by name, names of the muscles they are based on, the `products` they are, the
    `currency` of their prices ("" if none has one), and `findings` on them.
    """

    drawings: dict[str, Muscle]
    bases: dict[str, str]
    products: dict[str, Product]
    currency: str
    findings: list[Finding]


class TaskFile(NamedTuple):
    """Contents of a task file: `senses`, "min" or "max", and `limits` by objective; scatter and
    model error to judge designs by, or `None`; the relative margin of force below which a design is
    warned of [-]; the cycle for which valves are sized, or `None`.
    """

    task: Task
    space: Space
    senses: dict[str, str]
    limits: dict[str, Limit]
    catalog: Catalog
    uncertainty: Uncertainty | None
    block: int  # of a study's designs that are evaluated together
    findings: list[Finding]  # on products
    least_margin: float
    cycle: Cycle | None


def load_task(path: str | os.PathLike[str]) -> TaskFile:
    """Read a task file; muscles that it names by a path stand beside it. Raises as `load`."""
    path = Path(path)
    return _task_file(read_file(path), str(path), path.parent)


def loads_task(text: str, source: str = "<text>", folder: Path = Path()) -> TaskFile:
    """Read a task from the `text` of a file, `source` in errors, with muscles in a `folder`."""
    return _task_file(parse_file(text, source), source, folder)


def _task_file(data: dict[str, Any], source: str, folder: Path) -> TaskFile:
    schema.check_kind(data, "task", source)
    file = validate(schema.TaskFileSection, data, source)
    root = FileLocation(source, data)
    task = _task(file.task, root.child("task"))
    limits_location = root.child("limits", kind="limits")
    limit_entries = dict(file.limits or {})
    safety = limit_entries.pop(_SAFETY, USUAL_SHARE)
    remedy = 'write a share of the draws, such as "95 %"'
    probability = limits_location.call(_share, safety, _SAFETY, 1.0, remedy, closed=False)
    limits, least_margin = _limits(limit_entries, limits_location)
    senses = _senses(file.objectives, root.child("objectives", kind="objectives"))
    reached = objectives.with_reach_limits(limits)
    limits_location.call(objectives.recorded_objectives, senses, reached)
    design, location = file.design, root.child("design", kind="design")
    offer = _offer(design, location, folder)
    space = _design_space(design, location, limits, folder, offer)
    prices = file.prices or schema.PricesSection()
    catalog = _priced_catalog(prices, root.child("prices"), design.density, design.muscle, offer)
    block = (file.sweep and file.sweep.block) or _BLOCK
    if design.density is not None and not 1.0 <= design.density <= 3e4:
        raise location.error(("density",), "must lie in [1, 30000] kg/m^3.")
    scatter, uncertainty = file.scatter or schema.ScatterSection(), None
    if scatter.enabled is not False:
        uncertainty = _uncertainty(scatter, design, root.child("scatter"), folder, probability)
    findings = offer.findings if offer else []
    cycle = _cycle(file.cycle, task, root.child("cycle"))
    options = (catalog, uncertainty, block, findings, least_margin, cycle)
    return TaskFile(task, space, senses, limits, *options)


def _cycle(section: schema.CycleSection | None, task: Task, location: FileLocation) -> Cycle | None:
    if section is None:
        return None
    if task.fluid != "air":
        raise location.error((), 'sizes valves for air: drop it, or write fluid = "air".')
    values = section.model_dump(exclude_none=True)
    if ("time" in values) == ("lift" in values or "release" in values):
        raise location.error((), "needs time, or lift and release.")
    if "time" in values:
        values["lift"] = values["release"] = 0.5 * values.pop("time")
    return location.call(Cycle, **values)


def _fit_error(name: str, folder: Path) -> float | None:
    """Error of a fitted muscle's force over the largest one [-], if it is known."""
    if entry := measured_muscles.get(name):
        return entry.error.relative_rmse
    is_file = name not in named_muscles() and (folder / name).exists()
    error = provenance(folder / name).get("relative_rmse") if is_file else None
    return error if isinstance(error, float) and 0 <= error < 1 else None


def _task(section: schema.TaskSection, location: FileLocation) -> Task:
    values: dict[str, Any] = section.model_dump(exclude_none=True)
    supply = values.pop("supply_pressure")
    if section.example is not None:
        if keys := values.keys() - {"example", "scheme", "fluid"}:
            raise location.error((min(keys),), "an example has its own: drop this key.")
        with location.error_context():
            task = example_task(section.example, supply)
            scheme = scheme_of(section.scheme or task.scheme)
            fluid = check_choice(section.fluid or "air", FLUIDS, "fluid")
            return replace(task, scheme=scheme, fluid=fluid)
    if "force" not in values:
        raise location.error(("force",), 'missing, write force = […], or example = "…".')
    if "time" in values and "weight" in values:
        rule = "points in time count for as long as they last: drop it."
        raise location.error(("weight",), rule)
    for key in _LISTS:
        # one value, not a list of one, stands for all points
        if key in values and isinstance(location.data["task"][key], str | int | float):
            values[key] = values[key][0] if len(values[key]) == 1 else values[key]
    with location.error_context():
        build = Task.in_time if "time" in values else Task.of
        return build(**({"strain": None, "supply_pressure": supply} | values))


def _senses(section: Mapping[str, str] | None, location: FileLocation) -> dict[str, str]:
    senses = dict(USUAL if section is None else section)
    location.call(check_objectives, senses)
    for name, sense in senses.items():
        if sense not in ("min", "max"):
            raise location.error((name,), 'must be "min" or "max".')
    return senses


def _limits(section: Mapping[str, Any], location: FileLocation) -> tuple[dict[str, Limit], float]:
    """Limits by objective, and the relative margin below which a design has a warning."""
    limits, least_margin = {}, LEAST_MARGIN
    remedy = 'write a share, such as "20 %"; a limit is margin = { at_least = "50 N" }'
    for name, entry in section.items():
        location.call(check_objectives, [name])
        if not isinstance(entry, dict):
            if name != "margin":
                raise location.error((name,), "must be a table: write { at_most = … }.")
            least_margin = location.call(_share, entry, name, 10.0, remedy)
            continue
        if not entry:
            raise location.error((name,), "empty: write { at_most = … } or { at_least = … }.")
        ends = {}
        for key, text in entry.items():
            if name == "margin" and key == _WARNING:
                least_margin = location.child(name).call(_share, text, key, 10.0, remedy)
                continue
            if key not in _BOUNDS:
                raise location.error((name, key), "unknown key: write at_least or at_most.")
            dimension = dimension_of_unit(objectives.OBJECTIVES[name].unit) or "number"
            value = location.child(name).call(parse, text, dimension, key)
            if name in objectives.SHARES and not 0 <= value < 1:
                rule = 'a share of the task: must lie in [0, 1), as "10 %" does.'
                raise location.error((name,), rule)
            ends[_BOUNDS[key]] = value
        if ends:
            limits[name] = Limit(**ends)
    return limits, least_margin


def _design_space(
    section: DesignSection,
    location: FileLocation,
    limits: Mapping[str, Limit],
    folder: Path,
    offer: Offer | None,
) -> Space:
    used = {"muscle", "splits", "buckling", "density", "catalog"}
    if offer is None:
        drawings = {name: _drawing(name, section, location, folder) for name in section.muscle}
    else:
        drawings, used = offer.drawings, {*used, "length"}
    options: dict[str, Any] = section.model_dump(exclude_none=True, exclude=used)
    splits = section.splits or ("all",)
    valves = limits["valves"].most if "valves" in limits else float("inf")
    if valves < 1:
        raise location.error((), "the space is empty: every bundle needs a valve.")
    if valves < _MAX_VALVES:
        options["most_units"] = int(valves)
    with location.error_context():
        if len(splits) == 1 and splits[0] in SPLITS:
            return Space(drawings, splits=splits[0], **options)
        rows = tuple(read_split(text) for text in splits)
        numbers = tuple(dict.fromkeys(sum(row) for row in rows))
        if "muscles" in options and set(options["muscles"]) != set(numbers):
            rule = "must be left out where the splits are written out"
            raise InvalidInputError("muscles", rule, None)
        options["muscles"] = numbers
        return Space(drawings, splits=rows, **options)


def _drawing(name: str, section: DesignSection, location: FileLocation, folder: Path) -> Muscle:
    muscle = location.child("muscle").call(load_named, name, folder)
    with location.error_context():
        if isinstance(muscle, Bundle):
            raise InvalidInputError("muscle", f"{name!r} is a bundle", None, "name a muscle")
        if section.buckling is not None:
            law: Any = BUCKLING_LAWS[check_choice(section.buckling, BUCKLING_LAWS, "buckling")]
            muscle = with_fields(muscle, buckling=law())
        return muscle


def _share(entry: Any, name: str, most: float, remedy: str, closed: bool = True) -> float:
    """A share [-] between 0 and `most`, both of which it can be if `closed`."""
    value, ends = parse(entry, "number", name), (closed, closed)
    return float(check_interval(value, 0.0, most, name, "-", closed=ends, remedy=remedy))


def _uncertainty(
    section: schema.ScatterSection,
    design: DesignSection,
    location: FileLocation,
    folder: Path,
    probability: float,
) -> Uncertainty:
    """Uncertainty of designs from `[scatter]`, and from the fits of calibrated muscles."""
    others = {"enabled", "draws", "calibrated"}
    deviations = section.model_dump(exclude_none=True, exclude=others)
    usual, basis = attrs.asdict(USUAL_SCATTER), Uncertainty.basis
    errors = [e for name in design.muscle if (e := _fit_error(name, folder)) is not None]
    if design.catalog is not None:
        basis = "product"
    elif len(errors) == len(design.muscle):
        usual["model_error"], basis = max(errors), "fit"
    if "model_error" in deviations:
        basis = "given"
    name, calibrated, muscles = design.muscle[0], section.calibrated, None
    path = folder / name
    obstacles = {
        "needs one muscle and no catalog": len(design.muscle) > 1 or design.catalog,
        f"needs a muscle file, {name!r} is none": not path.exists(),
        "constants hold for their own law: drop [design] buckling": design.buckling is not None,
    }
    obstacle = next((rule for rule, applies in obstacles.items() if applies), "")
    with location.error_context():
        scatter = DesignScatter(**usual | deviations)
        if calibrated is None:
            calibrated = not obstacle and "covariance" in provenance(path)
        if calibrated:
            if obstacle:
                raise InvalidInputError("calibrated", obstacle, None)
            from .calibration_files import sample_muscles

            muscles = sample_muscles(path)
    draws = section.draws or Uncertainty.draws
    return Uncertainty(scatter, draws, muscles, probability, basis)


def _priced_catalog(
    prices_section: schema.PricesSection,
    location: FileLocation,
    density: float | None,
    muscles: Sequence[str],
    offer: Offer | None,
) -> Catalog:
    """Catalog of an offer's products, or of `muscles`, with the prices of `[prices]`."""
    prices: dict[str, Price] = {key: price for key, price in prices_section if price is not None}
    products, currency = (offer.products, offer.currency) if offer else ({}, "")
    for key, price in prices.items():
        currency = _common_currency(currency, price, location.child(key))
    amounts = {key: price.amount for key, price in prices.items()}
    bases = offer.bases if offer else dict(zip(muscles, muscles, strict=True))
    extrapolations = {
        name: measured_muscles[base].extrapolations
        for name, base in bases.items()
        if base in measured_muscles
    }
    return Catalog(products, currency, density=density, extrapolations=extrapolations, **amounts)


def _common_currency(currency: str, price: Price | None, location: FileLocation) -> str:
    """The `currency` of prices so far, "" of none, or the first price's; refuses another one."""
    if price is None or currency in ("", price.currency):
        return price.currency if price else currency
    raise location.error((), f"another price is in {currency}: give all in one currency.")


def _offer(section: DesignSection, location: FileLocation, folder: Path) -> Offer | None:
    """Muscles on sale, if there is a catalog."""
    if section.catalog is None:
        return None
    for key in _PRODUCT_KEYS:
        if getattr(section, key) is not None:
            rule = "products have their own: drop this key, or the catalog."
            raise location.error((key,), rule)
    if len(section.muscle) != 1:
        rule = "must be one for a catalog; a product may name its own, muscle = …."
        raise location.error(("muscle",), rule)
    catalog, products = location.child("catalog", kind="catalog"), section.catalog
    if isinstance(products, str):
        source, path, shipped = products, folder / products, shipped_names("catalogs")
        if source in shipped:
            data = parse_file(shipped_text("catalogs", source), source)
        else:
            if not path.exists():
                catalog.call(check_choice, source, shipped, "catalog")
            source, data = str(path), read_file(path)
        products = validate(schema.CatalogFile, data, source).product
        catalog = FileLocation(source, data, ("product",), "catalog")
    if not products:
        raise catalog.error((), "holds no product.")
    return _build_offer(products, catalog, section, folder)


def _build_offer(
    products_on_sale: Sequence[ProductSection],
    catalog: FileLocation,
    design: DesignSection,
    folder: Path,
) -> Offer:
    drawings: dict[str, Muscle] = {}
    bases: dict[str, str] = {}
    products: dict[str, Product] = {}
    findings, currency = list[Finding](), ""
    borrowed: dict[tuple[str, ...], list[str]] = {}  # products by their base and its parts
    for i, section in enumerate(products_on_sale):
        location, base_name = catalog.child(i, kind="catalog"), section.muscle or design.muscle[0]
        base = _drawing(base_name, design, location, folder)
        candidates = section.length or design.length or (float(base.length),)
        low, high = section.least_length or 0.0, section.most_length or float("inf")
        if low > high:
            raise location.error(("least_length",), "must not be more than most_length.")
        available = [length for length in candidates if low <= length <= high]
        if len(available) < len(candidates):
            missing = [x for x in candidates if x not in available]
            data = {"product": section.name, "lengths": missing}
            data |= {"shortest": low, "longest": None if math.isinf(high) else high}
            findings.append(Finding("product.length_unavailable", Severity.NOTE, data))
        for price in (section.price, section.price_per_length):
            currency = _common_currency(currency, price, location)
        for length in available:
            name = f"{section.name}, {1e3 * length:.6g} mm"
            if name in drawings:
                raise location.error(("name",), "repeats a product of this length.")
            with location.error_context(), warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # of other lengths: a note says it
                bases[name] = base_name
                drawings[name] = _product_muscle(section, base, base_name, length)
                products[name] = _product(section, length)
        borrowed.setdefault((base_name, *_borrowed_parts(section)), []).append(section.name)
        if len(drawings) > _MAX_DRAWINGS:
            raise catalog.error((), f"holds more than {_MAX_DRAWINGS} products and lengths.")
    if not drawings:
        names = ", ".join(section.name for section in products_on_sale)
        raise catalog.error((), f"none of its products is made in a length of the design: {names}.")
    for (base_name, *parts), names in borrowed.items():
        data = {"products": names, "muscle": base_name, "parts": parts}
        findings.append(Finding("product.parts_borrowed", Severity.NOTE, data))
    return Offer(drawings, bases, products, currency, findings)


def _borrowed_parts(section: ProductSection) -> list[str]:
    """Keys of sizes, or "calibration", that a product has from the muscle it is based on."""
    if _is_calibrated(section):
        return ["calibration"]
    keys = ("wall_thickness", "braid_angle")
    return [*(key for key in keys if getattr(section, key) is None), "material", "laws"]


def _is_calibrated(section: ProductSection) -> bool:
    """True for a product without sizes that names its muscle: it is that muscle, in any length."""
    return section.muscle is not None and all(getattr(section, key) is None for key in _RADII)


def _product_muscle(section: ProductSection, base: Muscle, base_name: str, length: float) -> Muscle:
    """The base in a product's sizes, checked as any muscle is."""
    if _is_calibrated(section):
        # what the calibration took for the active part of the nominal length scales with it
        entry = measured_muscles.get(base_name)
        nominal = float(base.length) if entry is None else entry.rest_length
        return base.replace(length=length * float(base.length) / nominal)
    ratio, wall = float(base.wall_thickness) / float(base.outer_radius), section.wall_thickness
    sizes = [key for key in _RADII if getattr(section, key) is not None]
    if len(sizes) != 1:
        rule = ", outer_diameter or inner_diameter is needed"
        remedy = f"give one of them, got {' and '.join(sizes) or 'none'}"
        raise InvalidInputError("outer_radius", rule, None, remedy)
    size = getattr(section, sizes[0])
    radius = size if sizes[0] == "outer_radius" else size / 2
    if sizes[0] == "inner_diameter":
        radius = radius / (1 - ratio) if wall is None else radius + wall
    wall = ratio * radius if wall is None else wall
    angle = float(base.braid_angle) if section.braid_angle is None else section.braid_angle
    return base.replace(length=length, outer_radius=radius, wall_thickness=wall, braid_angle=angle)


def _product(section: ProductSection, length: float) -> Product:
    """Price, mass and limits of a product at a `length` [m]."""
    for key, limit, unit in _MAX_VALUES:
        if (value := getattr(section, key)) is not None:
            check_interval(value, 0.0, limit, key, unit, closed=(False, True))
    price = _total(section.price, section.price_per_length, length)
    mass = _total(section.mass, section.mass_per_length, length)
    limits = section.largest_pressure, section.largest_strain
    return Product(section.name, price, mass, *limits, section.source or "")


def _total(fixed: Price | float | None, rate: Price | float | None, length: float) -> float | None:
    """A price or mass: a fixed part and a rate per length, if one of them is known."""
    if fixed is None and rate is None:
        return None
    amounts = [x.amount if isinstance(x, Price) else x or 0.0 for x in (fixed, rate)]
    return amounts[0] + amounts[1] * length
