r"""Designs as arrays: a `Bundle` for each of so many would be too slow.

Sizes of units that don't exist, whose counts are 0, repeat those of the first, to be valid.

**Packing.** $N$ equal circles of radius $r$ fit into one of radius $\rho_N r$. The $\rho_N$ up to
30 are those of the best packings known (proved for $N \le 13$ and $19$; Graham, Lubachevsky,
Nurmela and Östergård 1998); beyond, the density is taken to stay that of 30. Two lie side by side.
More, unlike ones are taken to fill the circle around them as densely as equal ones do,

$$R = \max\Bigl(\rho_N \sqrt{\textstyle\sum_i r_i^2 / N},\; r_1 + r_2\Bigr), \tag{G1}$$

with $r_1$ and $r_2$ the two largest, which must lie side by side. **Exact** for equal circles
and for two; else an estimate: a large circle among small ones wastes more, small ones that
fit into the gaps less.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..bundle import Bundle, MotorUnit
from ..bundle.pressurized import check_volume_by_strain
from ..core.errors import InvalidInputError
from ..core.module import to_numpy, with_fields
from ..core.types import Float, Int
from ..muscle import Muscle
from .task import Task


SIZES = ("outer_radius", "wall_thickness", "braid_angle")


def scaled_muscle(drawing: Muscle, sizes: Float[np.ndarray, "*any 4"]) -> Muscle:
    """A `drawing` with `sizes`: length, outer radius and thickness of the wall [m], and braid angle
    [rad]; many muscles as one.
    """
    names = ("length", *SIZES)
    return with_fields(drawing, **dict(zip(names, np.moveaxis(sizes, -1, 0), strict=True)))


_RATIOS = (  # ρ_N of 1 to 30 circles, Graham and others (1998)
    1.0, 2.0, 2.1547, 2.4142, 2.7013, 3.0, 3.0, 3.3048, 3.6131, 3.8130,
    3.9238, 4.0296, 4.2361, 4.3284, 4.5214, 4.6154, 4.7920, 4.8637, 4.8637, 5.1223,
    5.2523, 5.4397, 5.5452, 5.6517, 5.7528, 5.8282, 5.9063, 6.0149, 6.1386, 6.1977,
)  # fmt: skip
_EXACT = {2: 2.0, 3: 1 + 2 / np.sqrt(3), 4: 1 + np.sqrt(2)}  # closed forms of some of them


def packing_ratio(count: Int[np.ndarray, "..."]) -> Float[np.ndarray, "..."]:
    r"""Radius $\rho_N$ of the circle around $N$ equal circles, over the radius of one [-]; `count`:
    $N$, at least 1.
    """
    table = np.array([_EXACT.get(n, rho) for n, rho in enumerate(_RATIOS, start=1)])
    dense = table[-1] * np.sqrt(np.asarray(count) / len(table))
    return np.where(count > len(table), dense, table[np.clip(count, 1, len(table)) - 1])


def packed_radius(
    radii: Float[np.ndarray, "*any unit"], counts: Int[np.ndarray, "*any unit"]
) -> Float[np.ndarray, "*any"]:
    """Radius of the circle around all muscles [m], equation (G1); `radii`: of a muscle of each unit
    [m]; `counts`: muscles in each unit.
    """
    N = counts.sum(axis=-1)
    dense = packing_ratio(N) * np.sqrt((counts * radii**2).sum(axis=-1) / np.maximum(N, 1))
    # the two largest: a unit of two or more has both
    largest = np.concatenate([radii * (counts > 0), radii * (counts > 1)], axis=-1)
    side_by_side = np.sort(largest, axis=-1)[..., -2:].sum(axis=-1)
    return np.where(N == 2, side_by_side, np.maximum(dense, side_by_side))


@dataclass(frozen=True, eq=False)
class Designs:
    """Many designs of bundles as arrays, designs on the first axis: `kind`, the index of their
    muscles' drawing in `drawings`; `counts` of muscles in each unit; the muscles' `length` [m], and
    for each unit outer `radius` [m], thickness of the `wall` [m] and braid `angle` [rad].
    """

    drawings: dict[str, Muscle]
    kind: Int[np.ndarray, " design"]
    counts: Int[np.ndarray, "design unit"]
    length: Float[np.ndarray, " design"]
    radius: Float[np.ndarray, "design unit"]
    wall: Float[np.ndarray, "design unit"]
    angle: Float[np.ndarray, "design unit"]

    def __post_init__(self):
        """Refuse drawings whose fluid depends on more than strain, or whose law has one size."""
        check_volume_by_strain(self.drawings.values())
        for muscle in self.drawings.values():
            if reference := muscle.tension.reference_muscle:
                rule = f"has the numbers of {reference}, and a design has other sizes"
                remedy = "take a law of any muscle, such as klute_hannaford"
                raise InvalidInputError("tension", rule, muscle.tension.name, remedy)

    @classmethod
    def of(cls, muscle: Muscle, counts: Any, name: str = "muscle") -> "Designs":
        """Designs of one `muscle` with a `name`; `counts`: muscles in each unit [-], a row each."""
        n = pad_rows([[int(x) for x in row if x] for row in counts])
        sizes = [np.full(n.shape, float(getattr(muscle, size))) for size in SIZES]
        length = np.full(len(n), float(muscle.length))
        return cls({name: muscle}, np.zeros(len(n), int), n, length, *sizes)

    def __len__(self) -> int:
        return len(self.counts)

    @property
    def units(self) -> Int[np.ndarray, " design"]:
        """Number of motor units of each design [-]."""
        return np.sum(self.counts > 0, axis=1)

    @property
    def labels(self) -> list[str]:
        """Composition of each design, such as `1+4`."""
        return [label(row) for row in self.counts]

    @property
    def uniform(self) -> np.ndarray:
        """Mask of designs all units of which have one muscle."""
        uniform = np.ones(len(self), bool)
        for sizes in (self.radius, self.wall, self.angle):
            uniform &= np.all((sizes == sizes[:, :1]) | (self.counts == 0), axis=1)
        return uniform

    def take(self, index: np.ndarray | slice, units: int | None = None) -> "Designs":
        """Designs with an `index`, a mask or a slice; their first `units` alone."""
        per_unit = (x[index, :units] for x in (self.radius, self.wall, self.angle))
        kind, counts = self.kind[index], self.counts[index, :units]
        return Designs(self.drawings, kind, counts, self.length[index], *per_unit)

    def drawing(self, index: int) -> Muscle:
        """The drawing of the design with an `index`, NumPy's."""
        return to_numpy(list(self.drawings.values())[self.kind[index]])

    def muscle(self, index: int, unit: int = 0) -> Muscle:
        """A muscle of the design with an `index`, in a motor `unit` counted from 0."""
        per_unit = [x[index, unit] for x in (self.radius, self.wall, self.angle)]
        return scaled_muscle(self.drawing(index), np.array([self.length[index], *per_unit]))

    def bundle(self, index: int, task: Task | None = None) -> Bundle:
        """Bundle of the design with an `index`, with supply pressure and scheme of a `task`."""
        shared = self.muscle(index) if self.uniform[index] else None
        units = [
            MotorUnit(self.muscle(index, unit) if shared is None else shared, int(n))
            for unit, n in enumerate(self.counts[index])
            if n
        ]
        return Bundle(units, task.supply_pressure, task.scheme) if task else Bundle(units)


def scaled_designs(
    drawings: dict[str, Muscle],
    kind: Int[np.ndarray, " design"],
    counts: Int[np.ndarray, "design unit"],
    factor: Float[np.ndarray, "design unit"],
    sizes: Float[np.ndarray, "design 4"],
) -> Designs:
    """Designs of `sizes`: length and radius [m], ratio of the wall to it [-] and braid angle [rad];
    `factor`: of each unit's radius and wall [-].
    """
    length, radius, ratio, angle = sizes.T[..., None]
    radii = radius * factor
    return Designs(drawings, kind, counts, length[:, 0], radii, ratio * radii, angle + 0.0 * radii)


def pad_rows(rows: Sequence[Sequence[int]]) -> Int[np.ndarray, "design unit"]:
    """Rows of muscles in each unit [-], filled with zeros to the longest."""
    counts = np.zeros((len(rows), max(map(len, rows))), int)
    for index, row in enumerate(rows):
        counts[index, : len(row)] = row
    return counts


def label(counts: Iterable[Any]) -> str:
    """Text of a composition, such as `1+4`; `counts`: muscles in each unit [-], without zeros."""
    return "+".join(str(int(n)) for n in counts if n)
