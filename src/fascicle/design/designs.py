r"""Designs as arrays: so many that a `Bundle` for each would be too slow to make.

`counts` are muscles in each unit, zeros last; sizes of units that don't exist repeat those of the
first, so that they are valid.

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
from typing import Any, NamedTuple

import numpy as np

from ..bundle import Bundle, MotorUnit
from ..bundle.efficiency import check_volume_by_strain
from ..core.array_namespace import array_namespace, maximum, sqrt, where
from ..core.errors import InvalidInputError
from ..core.module import to_numpy, with_fields
from ..core.types import Float, Int, Numbers, Values
from ..muscle import Muscle
from .task import Task


class Sizes(NamedTuple):
    """Sizes of muscles of one drawing: `length` [m], `radius` [m], `wall` [m] and braid `angle`
    [rad], arrays of one shape.
    """

    length: Numbers
    radius: Numbers
    wall: Numbers
    angle: Numbers

    def muscle(self, drawing: Muscle) -> Muscle:
        """A `drawing` of these sizes, all of them as one muscle."""
        return with_fields(
            drawing,
            length=self.length,
            outer_radius=self.radius,
            wall_thickness=self.wall,
            braid_angle=self.angle,
        )

    def take(self, index: Any) -> "Sizes":
        """Those with an `index`."""
        return Sizes(*(x[index] for x in self))


_RATIOS = (
    1.0, 2.0, 2.1547, 2.4142, 2.7013, 3.0, 3.0, 3.3048, 3.6131, 3.8130,
    3.9238, 4.0296, 4.2361, 4.3284, 4.5214, 4.6154, 4.7920, 4.8637, 4.8637, 5.1223,
    5.2523, 5.4397, 5.5452, 5.6517, 5.7528, 5.8282, 5.9063, 6.0149, 6.1386, 6.1977,
)  # fmt: skip
_EXACT = {2: 2.0, 3: 1 + 2 / np.sqrt(3), 4: 1 + np.sqrt(2)}


def ratio(count: Values) -> Numbers:
    r"""How much wider the circle around equal ones is.

    **Arguments:** `count`: $N$ of them [-], at least 1.

    **Returns:** $\rho_N$ [-].
    """
    table = np.array([_EXACT.get(n, rho) for n, rho in enumerate(_RATIOS, start=1)])
    xp, most = array_namespace(count), len(table)
    n = xp.asarray(count)
    known = xp.asarray(table)[xp.clip(n, 1, most) - 1]
    return where(n > most, table[-1] * sqrt(n / most), known)


def bowed_diameter(radii: Values, counts: Values, bulge: Values) -> Numbers:
    """Diameter of the circle around all muscles, where units that aren't fed bow out.

    **Arguments:**

    - `radii`: of a muscle of each unit [m].
    - `counts`: muscles in each unit [-]; 0 for none.
    - `bulge`: how far a muscle bows out [m]; a lone unit is fed, and doesn't.

    **Returns:** the diameter [m].
    """
    several = (array_namespace(counts).asarray(counts) > 0).sum(axis=-1) > 1
    return 2 * (packed_radius(radii, counts) + where(several, bulge, 0.0))


def packed_radius(radii: Values, counts: Values) -> Numbers:
    """Radius of the circle around all muscles, equation (G1).

    **Arguments:**

    - `radii`: of a muscle of each unit [m].
    - `counts`: muscles in each unit [-]; 0 for none.

    **Returns:** the radius [m].
    """
    xp = array_namespace(radii, counts)
    radii, counts = xp.asarray(radii), xp.asarray(counts)
    N = counts.sum(axis=-1)
    dense = ratio(N) * sqrt((counts * radii**2).sum(axis=-1) / maximum(N, 1))
    # the two largest: a unit of two or more brings both
    there, twice = where(counts > 0, radii, 0.0), where(counts > 1, radii, 0.0)
    both = xp.sort(xp.concatenate([there, twice], axis=-1), axis=-1)
    side_by_side = both[..., -1] + both[..., -2]
    return where(N == 2, side_by_side, maximum(dense, side_by_side))


@dataclass(frozen=True, eq=False)
class Designs:
    """Designs on the first axis. `kind`: which of the `drawings`, by name, their muscles are
    of; `counts` [-] of each unit, the muscles' `length` [m], and for each unit their `radius`
    [m], `wall` [m] and braid `angle` [rad].
    """

    drawings: dict[str, Muscle]
    kind: Int[np.ndarray, " design"]
    counts: Int[np.ndarray, "design unit"]
    length: Float[np.ndarray, " design"]
    radius: Float[np.ndarray, "design unit"]
    wall: Float[np.ndarray, "design unit"]
    angle: Float[np.ndarray, "design unit"]

    def __post_init__(self):
        """Refuse drawings whose fluid depends on more than strain, or whose law is of one size."""
        check_volume_by_strain(self.drawings.values())
        for muscle in self.drawings.values():
            if muscle.tension.reference_muscle:
                reference = muscle.tension.reference_muscle
                rule = f"has the numbers of {reference}, and a design has other sizes"
                remedy = "take a law of any muscle, such as klute_hannaford"
                raise InvalidInputError("tension", rule, muscle.tension.name, remedy)

    @classmethod
    def of(cls, muscle: Muscle, counts: Any, name: str = "muscle") -> "Designs":
        """Compositions of one muscle.

        **Arguments:**

        - `muscle`: the one.
        - `counts`: muscles in each unit [-], a row for each design.
        - `name`: what the muscle is called.

        **Returns:** the designs.
        """
        n = pad_rows([[int(x) for x in row if x] for row in counts])
        size = np.ones(n.shape)
        return cls(
            {name: muscle},
            np.zeros(len(n), int),
            n,
            float(muscle.length) * np.ones(len(n)),
            float(muscle.outer_radius) * size,
            float(muscle.wall_thickness) * size,
            float(muscle.braid_angle) * size,
        )

    def __len__(self) -> int:
        return len(self.counts)

    @property
    def units(self) -> Int[np.ndarray, " design"]:
        """Motor units of each."""
        return np.sum(self.counts > 0, axis=1)

    @property
    def labels(self) -> list[str]:
        """Each one's composition, such as `1+4`."""
        return [label(row) for row in self.counts]

    @property
    def uniform(self) -> np.ndarray:
        """Whether all units of a design have one muscle."""
        same = np.ones(len(self), bool)
        for sizes in (self.radius, self.wall, self.angle):
            same &= np.all((sizes == sizes[:, :1]) | (self.counts == 0), axis=1)
        return same

    def take(self, index: np.ndarray, units: int | None = None) -> "Designs":
        """Designs with an `index`, or a mask; their first `units` alone."""
        return Designs(
            self.drawings, self.kind[index], self.counts[index, :units], self.length[index],
            self.radius[index, :units], self.wall[index, :units], self.angle[index, :units],
        )  # fmt: skip

    def sizes(self, index: int) -> Sizes:
        """Sizes of the muscles of each unit of a design; `index`: which."""
        sizes = (x[index] for x in (self.radius, self.wall, self.angle))
        return Sizes(np.full(self.counts.shape[1], self.length[index]), *sizes)

    def drawing(self, index: int) -> Muscle:
        """The drawing of a design, NumPy's; `index`: which."""
        return to_numpy(list(self.drawings.values())[self.kind[index]])

    def muscle(self, index: int, unit: int = 0) -> Muscle:
        """A muscle of a design.

        **Arguments:**

        - `index`: which design.
        - `unit`: which motor unit, counted from 0.

        **Returns:** the muscle.
        """
        return self.sizes(index).take(unit).muscle(self.drawing(index))

    def bundle(self, place: int, task: Task | None = None) -> Bundle:
        """A design as a bundle.

        **Arguments:**

        - `place`: which design.
        - `task`: whose supply and scheme it has, if any.

        **Returns:** the bundle.
        """
        shared = self.muscle(place) if self.uniform[place] else None
        units = [
            MotorUnit(shared if shared is not None else self.muscle(place, unit), int(n))
            for unit, n in enumerate(self.counts[place])
            if n
        ]
        if task is None:
            return Bundle(units)
        return Bundle(units, task.supply_pressure, task.scheme)


def scaled_designs(
    drawings: dict[str, Muscle],
    kind: Int[np.ndarray, " design"],
    counts: Int[np.ndarray, "design unit"],
    factor: Float[np.ndarray, "design unit"],
    length: Float[np.ndarray, " design"],
    radius: Float[np.ndarray, " design"],
    wall_ratio: Float[np.ndarray, " design"],
    angle: Float[np.ndarray, " design"],
) -> Designs:
    """Designs whose units have radii in proportion, and walls in proportion to these.

    **Arguments:**

    - `drawings`: muscles by name; `kind`: which of them.
    - `counts`: muscles in each unit [-].
    - `factor`: of each unit's radius [-].
    - `length`: of all muscles [m].
    - `radius`: where the factor is 1 [m].
    - `wall_ratio`: wall thickness over radius [-].
    - `angle`: of the braid [rad].

    **Returns:** the designs.
    """
    radii = radius[:, None] * factor
    wall, tilt = wall_ratio[:, None] * radii, angle[:, None] * np.ones(radii.shape)
    return Designs(drawings, kind, counts, length, radii, wall, tilt)


def concatenate(parts: Sequence[Designs]) -> Designs:
    """Several sets of designs of the same drawings as one; `parts` aren't empty."""
    units = max(part.counts.shape[1] for part in parts)

    def rows(name: str) -> np.ndarray:
        mode = "constant" if name == "counts" else "edge"
        return np.concatenate(
            [
                np.pad(x, ((0, 0), (0, units - x.shape[1])), mode=mode)
                for x in (getattr(part, name) for part in parts)
            ]
        )

    return Designs(
        parts[0].drawings,
        np.concatenate([part.kind for part in parts]),
        rows("counts"),
        np.concatenate([part.length for part in parts]),
        rows("radius"),
        rows("wall"),
        rows("angle"),
    )


def pad_rows(
    rows: Sequence[Sequence[int]], units: int | None = None
) -> Int[np.ndarray, "design unit"]:
    """Rows of unlike length as one array.

    **Arguments:**

    - `rows`: muscles in each unit [-].
    - `units`: length of the rows; left out, the longest's.

    **Returns:** the same with zeros last.
    """
    width = max(map(len, rows)) if units is None else units
    counts = np.zeros((len(rows), width), int)
    for place, row in enumerate(rows):
        counts[place, : len(row)] = row
    return counts


def label(counts: Iterable[Any]) -> str:
    """A composition for a reader: `1+4`; `counts`: muscles in each unit [-], zeros aside."""
    return "+".join(str(int(n)) for n in counts if n)
