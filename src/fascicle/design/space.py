r"""The designs to choose among: numbers of muscles, their splits, their sizes, on grids; products
on sale, and prices. A missing price is never guessed.

A design is determined by its index alone: a search can be cut into blocks, and a block repeated on
another machine. Splits run fastest, so that neighbors share a muscle.

**Radius.** By one of three rules: `each` gives a muscle's radius; `cross_section` a radius $R$ of
one muscle whose section all muscles of a design have together,
$r_i = f_i R / \sqrt{\sum_j n_j f_j^2}$; `packing` the diameter of the circle that they fill side by
side. Factors $f_i$ give units different radii.

**Splits.** $N$ equal muscles split into units in an order of recruitment are one of $2^{N-1}$
compositions of $N$; without the order they are a partition, recruited from the smallest to the
largest unit, as Henneman's size principle has it.
"""

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from functools import cache, cached_property
from itertools import product
from typing import NamedTuple

import numpy as np

from ..core import validation
from ..core.errors import InvalidInputError
from ..core.findings import Finding, Severity
from ..core.module import to_numpy
from ..core.types import Float, Int
from ..core.validation import RANGES, check_choice, check_interval
from ..muscle import Muscle
from .designs import Designs, packed_radius, pad_rows, scaled_designs
from .task import Task


MAX_MUSCLES = 100  # of a bundle whose splits are enumerated: columns of their table
MAX_SPLITS = 2_000_000  # rows of that table: some hundred megabytes
_ROUNDING = 1e-9  # relative, of a product's limits: 150 mm of 600 mm are a quarter
_LARGEST_FACTOR = 10.0  # of a unit's radius; more is a slip
SPLITS = ("all", "partitions")
RADIUS_RULES = ("each", "cross_section", "packing")

Counts = Int[np.ndarray, "design unit"]
PerUnit = Float[np.ndarray, "design unit"]
PerDesign = Float[np.ndarray, " design"]
Floats = tuple[float, ...]


def compositions(muscles: int, most_units: int | None = None) -> Counts:
    """All splits of a number of muscles into motor units in an order of recruitment.

    **Arguments:**

    - `muscles`: their number [-], 1 to 100.
    - `most_units`: largest number of motor units [-]; default: any.

    **Returns:** muscles in each unit [-], a row each, zeros last; the undivided one first.

    **Raises:** `ValueError` for a number out of range, and for more than 2 000 000 splits.
    """
    check_splits((muscles,), "all", most_units)

    @cache
    def rows(total: int, units: int) -> Counts:
        if total == 0:
            return np.zeros((1, units), int)
        blocks = [np.zeros((0, units), int)]
        for first in range(total, 0, -1) if units else ():
            later = rows(total - first, units - 1)
            blocks.append(np.column_stack([np.full(len(later), first), later]))
        return np.concatenate(blocks)

    return rows(muscles, _width(muscles, most_units))


def partitions(muscles: int, most_units: int | None = None) -> Counts:
    """All splits of a number of muscles without an order, smallest unit first; else as
    `compositions`.
    """
    check_splits((muscles,), "partitions", most_units)

    def rows(total: int, units: int, smallest: int) -> Iterator[tuple[int, ...]]:
        yield (total,)
        for first in range(total // 2, smallest - 1, -1) if units > 1 else ():
            for later in rows(total - first, units - 1, first):
                yield first, *later

    return pad_rows(list(rows(muscles, _width(muscles, most_units), 1)))


def number_of_splits(muscles: int, splits: str, most_units: int | None = None) -> int:
    """Number of `splits` [-], "all" or "partitions", of `muscles` into `most_units` or fewer."""
    width = _width(muscles, most_units)
    if splits == "all":
        return sum(math.comb(muscles - 1, cuts) for cuts in range(width))
    # partitions into `width` parts or fewer are as many as those into parts of at most `width`
    counts = [1] + [0] * muscles
    for size in range(1, width + 1):
        for total in range(size, muscles + 1):
            counts[total] += counts[total - size]
    return counts[muscles]


def check_splits(numbers: Iterable[int], splits: str, most_units: int | None = None) -> None:
    """Refuse `numbers` of muscles with too many `splits`, "all" or "partitions", into at most
    `most_units` motor units; the error names ways to fewer splits.
    """
    numbers = tuple(numbers)
    for number in numbers:
        if not 1 <= number <= MAX_MUSCLES:
            rule, remedy = f"must lie in [1, {MAX_MUSCLES}]", "of more, list splits, as '10+50+90'"
            raise InvalidInputError("muscles", rule, number, remedy)

    def total(kind: str, units: int | None) -> int:
        return sum(number_of_splits(number, kind, units) for number in numbers)

    if total(splits, most_units) <= MAX_SPLITS:
        return
    fewer = range(most_units or max(numbers), 0, -1)
    units = next((units for units in fewer if total(splits, units) <= MAX_SPLITS), None)
    remedies = ["or list some splits"]
    if splits == "all" and (left := total("partitions", most_units)) <= MAX_SPLITS:
        remedies.insert(0, f"splits = 'partitions' leaves {left}")
    if units is not None:
        left = total(splits, units)
        remedies.insert(0, f"{units} motor units at most leave {left} ([limits] valves)")
    rule = f"lead to {total(splits, most_units)} splits, more than {MAX_SPLITS}"
    raise InvalidInputError("muscles", rule, None, ", ".join(remedies))


def read_split(text: str) -> tuple[int, ...]:
    """Muscles in each unit [-] of a composition as it is written, `1+4`; else `ValueError`."""
    if not re.fullmatch(r"\s*[1-9]\d{0,3}(\s*\+\s*[1-9]\d{0,3})*\s*", text, re.ASCII):
        rule = "must be written like '1+4', whole numbers and plus signs"
        raise InvalidInputError("splits", rule, text)
    return tuple(map(int, text.split("+")))


def _width(muscles: int, most_units: int | None) -> int:
    return muscles if most_units is None else max(1, min(muscles, most_units))


@dataclass(frozen=True, eq=False)
class Space:
    """Designs to search, on grids, with muscles of one of the `drawings`, by name.

    - `muscles`: numbers of them [-].
    - `splits`: "all" compositions, "partitions", or the compositions themselves.
    - `radius`: [m], by `radius_rule`: "each", "cross_section" or "packing".
    - `length` [m], `braid_angle` [rad], `wall_ratio`, wall thickness over radius [-]; left empty,
      the drawing's own.
    - `unit_factors`: of a unit's radius [-]; with several, each unit takes any.
    - `most_units`: largest number of motor units [-]; `None` for any.
    """

    drawings: dict[str, Muscle]
    muscles: tuple[int, ...] = ()
    splits: str | tuple[tuple[int, ...], ...] = "all"
    radius: Floats = ()
    radius_rule: str = "each"
    length: Floats = ()
    braid_angle: Floats = ()
    wall_ratio: Floats = ()
    unit_factors: Floats = (1.0,)
    most_units: int | None = None

    def __post_init__(self):
        """**Raises:** `ValueError` for values off the domain, and a space without a design."""
        if not self.drawings:
            raise InvalidInputError("drawings", "must hold at least one muscle", None, shown="none")
        check_choice(self.radius_rule, RADIUS_RULES, "radius_rule")
        if self.radius_rule != "each" and not self.radius:
            rule = f"must be given with the rule {self.radius_rule!r}, in m"
            raise InvalidInputError("radius", rule, None)
        for name, unit, largest in (
            ("radius", "m", RANGES["radius"].largest),
            ("length", "m", RANGES["length"].largest),
            ("wall_ratio", "-", 1.0),
            ("unit_factors", "-", _LARGEST_FACTOR),
        ):
            values = check_interval(getattr(self, name), 0.0, largest, name, unit)
            if name in RANGES:
                validation.check_plausible(values, name)
        angles, largest = np.degrees(self.braid_angle), math.degrees(validation.NEUTRAL_ANGLE)
        check_interval(angles, 0.0, largest, "braid_angle", "deg")
        if isinstance(self.splits, str):
            check_choice(self.splits, SPLITS, "splits")
            if not self.muscles:
                rule = "must hold at least one number of muscles"
                raise InvalidInputError("muscles", rule, None, shown="none")
            check_splits(dict.fromkeys(self.muscles), self.splits, self.most_units)
        if not len(self._units_and_scales[0]):
            most = f"{self.most_units} motor units or fewer"
            raise ValueError(f"the space is empty: no split has {most}.")

    def __getstate__(self) -> dict:
        # without cached properties, which can be a thousand times larger. Drawings as NumPy's:
        # a process that is sent JAX's arrays with each block keeps them all
        state = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        return state | {"drawings": to_numpy(self.drawings)}

    def __len__(self) -> int:
        return math.prod(map(len, self._grid)) * len(self._units_and_scales[0])

    def at(self, index: Int[np.ndarray, " design"]) -> Designs:
        """Designs of the space with an `index` from 0 to its length."""
        counts, factor, scale = self._units_and_scales
        grid, shape = np.divmod(index, len(counts))
        kind, *columns = np.unravel_index(grid, tuple(map(len, self._grid)))
        defaults = np.array([drawing_sizes(drawing) for drawing in self.drawings.values()])[kind]
        columns = zip(self._grid[1:], columns, strict=True)
        sizes = np.stack([np.asarray(values, float)[i] for values, i in columns], axis=1)
        sizes = np.where(np.isnan(sizes), defaults, sizes)
        sizes[:, 1] *= scale[shape]
        return scaled_designs(self.drawings, kind, counts[shape], factor[shape], sizes)

    def scale(self, counts: Counts, factor: PerUnit) -> PerDesign:
        """Factor from the listed `radius` to that of a muscle with a unit factor of 1 [-] for each
        design; `counts`: muscles in each unit; `factor`: of each unit's radius [-].
        """
        if self.radius_rule == "cross_section":
            return 1 / np.sqrt(np.sum(counts * factor**2, axis=1))
        if self.radius_rule == "packing" and len(counts):
            return 0.5 / packed_radius(factor, counts)
        return np.ones(len(counts))

    @cached_property
    def _grid(self) -> tuple[tuple, ...]:
        """Values along each axis of the grid, NaN for the drawing's own."""
        axes = (self.length, self.radius, self.wall_ratio, self.braid_angle)
        return (tuple(range(len(self.drawings))), *(axis or (math.nan,) for axis in axes))

    @cached_property
    def _units_and_scales(self) -> tuple[Counts, PerUnit, PerDesign]:
        """Muscles in each unit, radius factor of each unit [-] and `scale` [-], a row for each
        split with each combination of unit factors.
        """
        rows, most = self.splits, self.most_units
        if isinstance(rows, str):
            enumerate_splits = compositions if rows == "all" else partitions
            tables = [enumerate_splits(n, most) for n in dict.fromkeys(self.muscles)]
            width = max(table.shape[1] for table in tables)
            padding = [((0, 0), (0, width - table.shape[1])) for table in tables]
            counts = np.concatenate(list(map(np.pad, tables, padding)))
        else:
            counts = pad_rows(rows)
        if most is not None:
            counts = counts[np.sum(counts > 0, axis=1) <= most, : max(1, most)]
        counts, factor = _combine_factors(counts, self.unit_factors)
        return counts, factor, self.scale(counts, factor)


def drawing_sizes(drawing: Muscle) -> Floats:
    """Length and radius [m], ratio of the wall to the radius [-] and braid angle [rad]."""
    length, radius, angle = map(float, (drawing.length, drawing.outer_radius, drawing.braid_angle))
    return length, radius, float(drawing.wall_thickness) / radius, angle


def _combine_factors(counts: Counts, factors: Floats) -> tuple[Counts, PerUnit]:
    """Splits with every choice of a radius factor [-] for each unit, equal units repeated."""
    if len(factors) == 1:
        return counts, np.full(counts.shape, factors[0])
    units, width = np.sum(counts > 0, axis=1), counts.shape[1]
    total = sum(len(factors) ** int(m) for m in units)
    if total > MAX_SPLITS:
        rule = f"lead to {total} kinds of bundle, more than {MAX_SPLITS}"
        remedy = "take fewer factors, muscles or motor units"
        raise InvalidInputError("unit_factors", rule, None, remedy)
    choices = [
        (row, (*choice, *choice[:1] * (width - int(m))))  # missing units repeat the first
        for row, m in zip(counts, units, strict=True)
        for choice in product(factors, repeat=int(m))
    ]
    rows, factor = zip(*choices, strict=True) if choices else (counts, counts)
    return np.array(rows), np.array(factor, float)


class Product(NamedTuple):
    """A muscle on sale, of one length: `name`, `price` for one in the catalog's currency, `mass` of
    one [kg], the largest pressure [Pa] and contraction [-] that its maker allows, and the `source`
    of the figures; `None` if unknown.
    """

    name: str
    price: float | None = None
    mass: float | None = None
    largest_pressure: float | None = None
    largest_strain: float | None = None
    source: str = ""

    def exclusion(self, name: str, task: Task, length: float) -> Finding | None:
        """Finding on a `task` beyond what the maker allows; `length`: of the drawing `name` [m]."""
        for quantity, value, largest in (
            ("pressure", task.supply_pressure, self.largest_pressure),
            ("strain", float(task.strain_of(length).max()), self.largest_strain),
        ):
            if largest is not None and value > largest * (1 + _ROUNDING):
                data = {"product": name, "quantity": quantity, "value": value, "largest": largest}
                return Finding("design.product_excluded", Severity.NOTE, data)
        return None


@dataclass(frozen=True)
class Catalog:
    """Prices and makers' limits of `products`, by the name of their muscle in a `Space`. Prices in
    a `currency`: of a `valve` and of a `muscle` of products without a price [-], of `air` for each
    normal m³ and of `energy` for each J; `density` of the bladder [kg/m³]. `extrapolations`: by
    that name, findings on a largest pressure [Pa] and strain [-] beyond those measured.
    """

    products: Mapping[str, Product] = field(default_factory=dict)
    currency: str = ""
    valve: float | None = None
    muscle: float | None = None
    air: float | None = None
    energy: float | None = None
    density: float | None = None
    extrapolations: Mapping[str, Callable[[float, float], list[Finding]]] = field(
        default_factory=dict
    )

    def price(self, designs: Designs) -> PerDesign:
        """Price of muscles and valves of each of the `designs` [-]; NaN if unknown."""
        valve = np.nan if self.valve is None else self.valve
        return designs.counts.sum(axis=1) * self.muscle_price(designs) + valve * designs.units

    def muscle_price(self, designs: Designs) -> PerDesign:
        """Price of one muscle of each of the `designs` [-]; NaN if unknown."""
        return np.array([self._price_of_one(name) for name in designs.drawings])[designs.kind]

    def excluded(self, drawings: Mapping[str, Muscle], task: Task) -> dict[str, Finding]:
        """Findings on products that must not be used for a `task`, by names of their `drawings`."""
        findings = (
            (name, product.exclusion(name, task, float(drawings[name].length)))
            for name, product in self.products.items()
        )
        return {name: finding for name, finding in findings if finding is not None}

    def is_priced(self, drawings: Mapping[str, Muscle]) -> bool:
        """True if the prices of a valve and of the muscles of all `drawings` are known."""
        prices = [self._price_of_one(name) for name in drawings]
        return self.valve is not None and not np.any(np.isnan(prices))

    def _price_of_one(self, name: str) -> float:
        """Price of one muscle of the drawing with a `name` [-]; NaN if unknown."""
        product = self.products.get(name)
        price = self.muscle if product is None or product.price is None else product.price
        return np.nan if price is None else price
