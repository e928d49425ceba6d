"""Many muscles of one drawing as one: what differs is their sizes."""

from typing import Any, NamedTuple

import equinox as eqx

from ...core.types import Numbers
from ...muscle import Muscle


class Rows(NamedTuple):
    """Muscles of a `drawing` [-], which has material, laws and tuning of all, each of its own
    `length` [m], `radius` [m], `wall` [m] and braid `angle` [rad], arrays of one shape.
    """

    drawing: Muscle
    length: Numbers
    radius: Numbers
    wall: Numbers
    angle: Numbers

    @property
    def muscle(self) -> Muscle:
        """All of them as one [-]."""
        return sized(*self)

    def take(self, places: Any) -> "Rows":
        """Those at `places` [-]."""
        return Rows(self.drawing, *(x[places] for x in self[1:]))


def sized(
    drawing: Muscle, length: Numbers, radius: Numbers, wall: Numbers, angle: Numbers
) -> Muscle:
    """A muscle of other sizes.

    **Arguments:**

    - `drawing`: whose material, laws and tuning it has [-].
    - `length`: between the end fittings [m].
    - `radius`: of the bladder at rest [m].
    - `wall`: its thickness at rest [m].
    - `angle`: of the braid at rest [rad].

    **Returns:** the muscle [-].
    """
    return eqx.tree_at(
        lambda m: (m.length, m.outer_radius, m.wall_thickness, m.braid_angle),
        drawing,
        (length, radius, wall, angle),
    )
