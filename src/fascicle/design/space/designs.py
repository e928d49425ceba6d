"""Designs as arrays: so many that a `Bundle` for each would be too slow to make.

`counts` are muscles in each unit, zeros last; sizes of units that aren't there repeat those
of the first, so that they exist.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...bundle import Bundle, MotorUnit
from ...bundle.volumes import told_by_strain
from ...core.errors import InvalidInputError
from ...core.module import to_numpy
from ...core.types import Float, Int
from ...muscle import Muscle
from .rows import sized
from .splits import label
from .task import Task


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
        """Refuse drawings whose fluid isn't told by strain alone, or whose law is of one size."""
        told_by_strain(self.drawings.values())
        for muscle in self.drawings.values():
            if muscle.tension.made_for:
                rule = f"has the numbers of {muscle.tension.made_for}, and a design has other sizes"
                remedy = "take a law of any muscle, such as klute_hannaford"
                raise InvalidInputError("tension", rule, muscle.tension.name, remedy)

    @classmethod
    def of(cls, muscle: Muscle, counts: Any, name: str = "muscle") -> "Designs":
        """Compositions of one muscle.

        **Arguments:**

        - `muscle`: the one [-].
        - `counts`: muscles in each unit [-], a row for each design.
        - `name`: what the muscle is called [-].

        **Returns:** the designs [-].
        """
        from .splits import padded

        n = padded([[int(x) for x in row if x] for row in counts])
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
        """Motor units of each [-]."""
        return np.sum(self.counts > 0, axis=1)

    @property
    def labels(self) -> list[str]:
        """Each one's composition [-], such as `1+4`."""
        return [label(row) for row in self.counts]

    @property
    def alike(self) -> np.ndarray:
        """Whether all units of a design have one muscle [-]."""
        same = np.ones(len(self), bool)
        for sizes in (self.radius, self.wall, self.angle):
            same &= np.all((sizes == sizes[:, :1]) | (self.counts == 0), axis=1)
        return same

    def take(self, places: np.ndarray) -> "Designs":
        """Some of them [-]; `places`: their indices, or a mask [-]."""
        return Designs(
            self.drawings, self.kind[places], self.counts[places], self.length[places],
            self.radius[places], self.wall[places], self.angle[places],
        )  # fmt: skip

    def muscle(self, place: int, unit: int = 0) -> Muscle:
        """A muscle of a design.

        **Arguments:**

        - `place`: which design [-].
        - `unit`: which motor unit, counted from 0 [-].

        **Returns:** the muscle [-].
        """
        drawing = to_numpy(list(self.drawings.values())[self.kind[place]])
        own = (x[place, unit] for x in (self.radius, self.wall, self.angle))
        return sized(drawing, self.length[place], *own)

    def bundle(self, place: int, task: Task | None = None) -> Bundle:
        """A design as a bundle.

        **Arguments:**

        - `place`: which design [-].
        - `task`: whose supply and scheme it has [-], if any.

        **Returns:** the bundle [-].
        """
        shared = self.muscle(place) if self.alike[place] else None
        units = [
            MotorUnit(shared if shared is not None else self.muscle(place, unit), int(n))
            for unit, n in enumerate(self.counts[place])
            if n
        ]
        if task is None:
            return Bundle(units)
        return Bundle(units, task.supply_pressure, task.scheme)


def of_sizes(
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

    - `drawings`: muscles by name [-]; `kind`: which of them [-].
    - `counts`: muscles in each unit [-].
    - `factor`: of each unit's radius [-].
    - `length`: of all muscles [m].
    - `radius`: where the factor is 1 [m].
    - `wall_ratio`: wall thickness over radius [-].
    - `angle`: of the braid [rad].

    **Returns:** the designs [-].
    """
    radii = radius[:, None] * factor
    wall, tilt = wall_ratio[:, None] * radii, angle[:, None] * np.ones(radii.shape)
    return Designs(drawings, kind, counts, length, radii, wall, tilt)


def joined(parts: Sequence[Designs]) -> Designs:
    """Several sets of designs of the same drawings as one; `parts` [-] aren't empty."""
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
