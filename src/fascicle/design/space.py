r"""The designs to choose among: numbers of muscles, their splits, their sizes, on grids.

Every design has an index, from which alone it is made: a search can be cut into blocks, and
a block made again on another machine. Splits run fastest, so that neighbors share a muscle.

**Radius.** By one of three rules: `each` gives a muscle's radius; `cross_section` a radius
$R$ of one muscle whose section all muscles of a design have together,
$r_i = f_i R / \sqrt{\sum_j n_j f_j^2}$; `packing` the diameter of the circle that they fill
side by side at rest. The factors $f_i$ make units unlike; they are 1 unless several are given.

**Splits.** $N$ equal muscles split into units in an order of recruitment are a composition of $N$:
each of the $N - 1$ gaps between muscles is cut or not, so there are $2^{N-1}$. Without the order
they are a partition; its units are then recruited from the smallest to the largest, as
Henneman's size principle has it.
"""

import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields
from functools import cache, cached_property
from itertools import product
from typing import Any

import jax
import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Float, Int
from ..core.validation import RANGES, check_choice, check_interval, check_plausible
from ..muscle import Muscle
from ..units import pretty
from .designs import Designs, packed_radius, pad_rows, scaled_designs


MOST_MUSCLES, MOST_SPLITS = 100, 2_000_000  # of a bundle whose splits are enumerated, and of these
SPLITS = ("all", "partitions")

Counts = Int[np.ndarray, "design unit"]


def compositions(muscles: int, most_units: int | None = None) -> Counts:
    """All compositions of a number of muscles.

    **Arguments:**

    - `muscles`: how many [-], 1 to 100.
    - `most_units`: largest number of motor units [-]; left out, any.

    **Returns:** muscles in each unit [-], a row each, zeros last; the undivided one first.

    **Raises:** `ValueError` for a number out of range, and for more than 2 000 000 compositions.
    """
    check_number((muscles,), "all", most_units)

    @cache
    def rows(rest: int, units: int) -> Counts:
        if rest == 0:
            return np.zeros((1, units), int)
        blocks = [np.zeros((0, units), int)]
        for first in range(rest, 0, -1) if units else ():
            others = rows(rest - first, units - 1)
            blocks.append(np.column_stack([np.full(len(others), first), others]))
        return np.concatenate(blocks)

    return rows(muscles, _width(muscles, most_units))


def partitions(muscles: int, most_units: int | None = None) -> Counts:
    """All partitions of a number of muscles, smallest unit first.

    **Arguments:**

    - `muscles`: how many [-], 1 to 100.
    - `most_units`: largest number of motor units [-]; left out, any.

    **Returns:** muscles in each unit [-], a row each, zeros last; the undivided one first.

    **Raises:** `ValueError` for a number out of range, and for more than 2 000 000 partitions.
    """
    check_number((muscles,), "partitions", most_units)

    def rows(rest: int, units: int, least: int) -> Iterator[tuple[int, ...]]:
        yield (rest,)
        for first in range(rest // 2, least - 1, -1) if units > 1 else ():
            for others in rows(rest - first, units - 1, first):
                yield first, *others

    width = _width(muscles, most_units)
    return pad_rows(list(rows(muscles, width, 1)), width)


def number_of_splits(muscles: int, splits: str, most_units: int | None = None) -> int:
    """How many splits there are.

    **Arguments:**

    - `muscles`: how many [-].
    - `splits`: "all" compositions, or "partitions".
    - `most_units`: largest number of motor units [-]; left out, any.

    **Returns:** their number [-].
    """
    width = _width(muscles, most_units)
    if splits == "all":
        return sum(math.comb(muscles - 1, cuts) for cuts in range(width))
    # partitions into at most so many parts are those into parts of at most that size
    ways = [1] + [0] * muscles
    for part in range(1, width + 1):
        for total in range(part, muscles + 1):
            ways[total] += ways[total - part]
    return ways[muscles]


def check_number(numbers: Iterable[int], splits: str, most_units: int | None = None) -> None:
    """Refuse numbers of muscles that have too many splits to be enumerated.

    **Arguments:**

    - `numbers`: of muscles [-].
    - `splits`: "all" compositions, or "partitions".
    - `most_units`: largest number of motor units [-]; `None` for any.

    **Raises:** `ValueError` with what would leave fewer.
    """
    numbers = tuple(numbers)
    for number in numbers:
        if not 1 <= number <= MOST_MUSCLES:
            raise InvalidInputError(
                "muscles",
                f"must lie in [1, {MOST_MUSCLES}]",
                number,
                "of more, list some splits, as '10+50+90'",
            )

    def count(kind: str, most: int | None) -> int:
        return sum(number_of_splits(number, kind, most) for number in numbers)

    total = count(splits, most_units)
    if total <= MOST_SPLITS:
        return
    ways = []
    largest = max(numbers) if most_units is None else most_units
    units = next((m for m in range(largest, 0, -1) if count(splits, m) <= MOST_SPLITS), 0)
    if units:
        left = count(splits, units)
        ways.append(f"{units} motor units at most leave {left} ([limits] valves)")
    if splits == "all" and (left := count("partitions", most_units)) <= MOST_SPLITS:
        ways.append(f"splits = 'partitions' leaves {left}")
    raise InvalidInputError(
        "muscles",
        f"lead to {total} splits, more than {MOST_SPLITS}",
        None,
        ", ".join([*ways, "or list some splits"]),
    )


def read(text: str) -> tuple[int, ...]:
    """A composition as it is written, `1+4`.

    **Arguments:** `text`: whole numbers with plus signs between [-].

    **Returns:** muscles in each unit [-].

    **Raises:** `ValueError` for anything else.
    """
    if not re.fullmatch(r"\s*[1-9]\d{0,3}(\s*\+\s*[1-9]\d{0,3})*\s*", text, re.ASCII):
        raise InvalidInputError(
            "splits", "must be written like '1+4', whole numbers and plus signs", text
        )
    return tuple(int(part) for part in text.split("+"))


def _width(muscles: int, most_units: int | None) -> int:
    """Length of a row of splits: the largest number of motor units."""
    return muscles if most_units is None else max(1, min(muscles, most_units))


RADIUS_RULES = ("each", "cross_section", "packing")

Floats = tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Space:
    """Designs with muscles of one of the `drawings`, by name.

    - `muscles`: numbers of them [-].
    - `splits`: "all" compositions, "partitions", or the compositions themselves.
    - `radius`: [m], by `radius_rule` [-]: "each", "cross_section" or "packing".
    - `length`: [m]; `braid_angle`: [rad]; left empty, the drawing's own.
    - `wall_ratio`: wall thickness over radius [-]; left empty, the drawing's own.
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
            raise InvalidInputError(
                "radius", f"must be given with the rule {self.radius_rule!r}, in m", None
            )
        for name, unit, low, high in (
            ("radius", "m", 0.0, RANGES["radius"].largest),
            ("length", "m", 0.0, RANGES["length"].largest),
            ("braid_angle", "rad", 0.0, math.acos(1 / math.sqrt(3))),
            ("wall_ratio", "-", 0.0, 1.0),
            ("unit_factors", "-", 0.0, 10.0),
        ):
            if getattr(self, name):
                value = _within(getattr(self, name), low, high, name, unit)
                if name in RANGES:
                    check_plausible(value, name)
        if isinstance(self.splits, str):
            check_choice(self.splits, SPLITS, "splits")
            if not self.muscles:
                raise InvalidInputError(
                    "muscles", "must hold at least one number of muscles", None, shown="none"
                )
            check_number(dict.fromkeys(self.muscles), self.splits, self.most_units)
        if not len(self._shapes[0]):
            raise ValueError(
                f"the space is empty: no split has {self.most_units} motor units or fewer."
            )

    def __getstate__(self) -> dict:
        # what is derived is derived again: it can be a thousand times larger. As NumPy's, since a
        # process that is sent JAX's arrays with each of its blocks grows with each of them
        state = {field.name: getattr(self, field.name) for field in fields(self)}
        return state | {"drawings": jax.tree.map(np.asarray, self.drawings)}

    def __len__(self) -> int:
        return math.prod(map(len, self._grid)) * len(self._shapes[0])

    def at(self, index: Int[np.ndarray, " design"]) -> Designs:
        """Designs by their index.

        **Arguments:** `index`: from 0 to the space's length.

        **Returns:** the designs.
        """
        counts, factor, scale = self._shapes
        grid, shape = np.divmod(index, len(counts))
        kind, *places = np.unravel_index(grid, tuple(map(len, self._grid)))
        own = np.array([self._own(drawing) for drawing in self.drawings.values()])[kind]
        # an axis that isn't given takes the drawing's own value
        length, radius, ratio, angle = (
            np.where(np.isnan(axis), own[:, i], axis)
            for i, axis in enumerate(
                np.asarray(values, float)[place]
                for values, place in zip(self._grid[1:], places, strict=True)
            )
        )
        sizes = (length, radius * scale[shape], ratio, angle)
        return scaled_designs(self.drawings, np.asarray(kind), counts[shape], factor[shape], *sizes)

    def kind(self, index: Int[np.ndarray, " design"]) -> Int[np.ndarray, " design"]:
        """Which of the drawings designs are of, by their `index`; -1 is of the first."""
        each = len(self) // len(self.drawings)
        return np.maximum(index, 0) // each

    def scale(
        self, counts: Int[np.ndarray, "design unit"], factor: Float[np.ndarray, "design unit"]
    ) -> Float[np.ndarray, " design"]:
        """A design's radius over what its rule counts [-].

        **Arguments:**

        - `counts`: muscles in each unit [-].
        - `factor`: of each unit's radius [-].

        **Returns:** the ratio [-].
        """
        if self.radius_rule == "cross_section":
            return 1 / np.sqrt(np.sum(counts * factor**2, axis=1))
        if self.radius_rule == "packing" and len(counts):
            return 0.5 / packed_radius(factor, counts)
        return np.ones(len(counts))

    @cached_property
    def _grid(self) -> tuple[tuple, ...]:
        nan = (math.nan,)
        return (
            tuple(range(len(self.drawings))), self.length or nan, self.radius or nan,
            self.wall_ratio or nan, self.braid_angle or nan,
        )  # fmt: skip

    @staticmethod
    def _own(drawing: Muscle) -> Floats:
        ratio = float(drawing.wall_thickness) / float(drawing.outer_radius)
        return float(drawing.length), float(drawing.outer_radius), ratio, float(drawing.braid_angle)

    @cached_property
    def _shapes(
        self,
    ) -> tuple[
        Int[np.ndarray, "shape unit"], Float[np.ndarray, "shape unit"], Float[np.ndarray, " shape"]
    ]:
        """Splits with their factors, and the radius over its rule's value."""
        counts = self._splits()
        if len(self.unit_factors) == 1:
            factor = np.full(counts.shape, self.unit_factors[0])
        else:
            counts, factor = _with_factors(counts, self.unit_factors)
        return counts, factor, self.scale(counts, factor)

    def _splits(self) -> Int[np.ndarray, "shape unit"]:
        if not isinstance(self.splits, str):
            counts = pad_rows(self.splits)
        else:
            make = compositions if self.splits == "all" else partitions
            parts = [make(n, self.most_units) for n in dict.fromkeys(self.muscles)]
            widest = max(part.shape[1] for part in parts)
            counts = np.concatenate([np.pad(p, ((0, 0), (0, widest - p.shape[1]))) for p in parts])
        units = np.sum(counts > 0, axis=1)
        if self.most_units is not None:
            counts = counts[units <= self.most_units]
            counts = counts[:, : max(1, self.most_units)]
        return counts


def _within(values: Floats, low: float, high: float, name: str, unit: str) -> Any:
    """`values` [SI] in the interval, an angle's error in degrees."""
    try:
        return check_interval(values, low, high, name, unit)
    except InvalidInputError as error:
        if unit != "rad" or not isinstance(error.value, float):
            raise
        rule = f"must lie in ({low:g}, {math.degrees(high):.6g}) deg"
        raise InvalidInputError(
            name, rule, error.value, shown=pretty(error.value, "angle")
        ) from None


def _with_factors(
    counts: Int[np.ndarray, "split unit"], factors: Floats
) -> tuple[Int[np.ndarray, "shape unit"], Float[np.ndarray, "shape unit"]]:
    """Each split with each choice of a factor for each of its units."""
    units = np.sum(counts > 0, axis=1)
    total = sum(len(factors) ** int(m) for m in units)
    if total > MOST_SPLITS:
        raise InvalidInputError(
            "unit_factors",
            f"lead to {total} kinds of bundle, more than {MOST_SPLITS}",
            None,
            "take fewer factors, muscles or motor units",
        )
    rows, chosen = [], []
    for row, m in zip(counts, units, strict=True):
        for choice in product(factors, repeat=int(m)):
            rows.append(row)
            chosen.append((*choice, *(choice[:1] * (counts.shape[1] - int(m)))))
    return np.array(rows), np.array(chosen)
