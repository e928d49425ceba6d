r"""A muscle as a solid: points on its tube, its fittings and its fibers, from the laws' shape.

The centerline, the tube's reach above and below it, its radius and the fibers' angle are
those of `plot.shapes`, which draws the same in a plane. Here each point of the centerline
becomes a ring: upward it reaches as far as the outline, sideways the radius, so that a hinge
folds flat. Along the arc a fiber turns by $\mathrm{d}\varphi = \pm\tan\alpha\,\mathrm{d}s/r$.

Axes: z along the muscle, y the way it bows, x across; meters. The number of points is fixed.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ...muscle import Muscle
from ...plot.shapes import Outline, outline
from .muscle_curves import Picture


RINGS, AROUND = 45, 20
FIBERS, ALONG = 8, 72  # each way around, and points of each
_FITTING = 1.3, 1.1  # radius and depth, over the bladder's radius


@dataclass(frozen=True)
class Solid:
    """`points` [m] of the tube and its fittings, a row each; `fibers` [m]: fiber, point, axis;
    the braid's `angle` [rad] and the tube's `radius` [m] where it isn't folded.
    """

    points: np.ndarray
    fibers: np.ndarray
    normals: np.ndarray
    angle: float
    radius: float


def solid(muscle: Muscle, found: Picture, strain: float, fibers: int = FIBERS) -> Solid:
    """The muscle as it is in a picture.

    **Arguments:**

    - `muscle`: the muscle [-].
    - `found`: its picture [-].
    - `strain`: the contraction there [-].
    - `fibers`: how many each way around [-].

    **Returns:** the solid [m].
    """
    collapsed = bool(strain > found.collapse_strain[-1])
    drawn = outline(muscle, found.z, found.y, found.radius, found.angle, collapsed)
    s = np.linspace(0.0, drawn.along[-1], RINGS)
    # rings crowd at the middle, where a hinge turns within less than a radius
    s = s[-1] * (0.5 + np.sign(s / s[-1] - 0.5) * np.abs(2 * s / s[-1] - 1) ** 1.6 / 2)
    rings = _rings(drawn, s, AROUND)
    ends = [_fitting(drawn, at) for at in (0, -1)]
    points = np.concatenate([rings.reshape(-1, 3), *ends])
    lines, normals = _fibers(drawn, fibers)
    return Solid(points, lines, normals, drawn.angle, drawn.radius)


@lru_cache(maxsize=4)
def quads(rings: int = RINGS, around: int = AROUND) -> np.ndarray:
    """Corners of the faces: rows of four point numbers [-], the tube's then the fittings'."""
    faces, first = [], 0
    for count in (rings, 4, 4):
        for i in range(count - 1):
            for j in range(around):
                k = (j + 1) % around
                a, b = first + i * around, first + (i + 1) * around
                faces.append((a + j, a + k, b + k, b + j))
        first += count * around
    return np.array(faces)


def tube_faces(rings: int = RINGS, around: int = AROUND) -> int:
    """How many of `quads` [-] are the tube's; the others are the fittings'."""
    return (rings - 1) * around


def _rings(drawn: Outline, s: np.ndarray, around: int) -> np.ndarray:
    """Points [m] around the centerline at arc lengths `s` [m]: ring, place, axis."""
    angle = 2 * np.pi * np.arange(around) / around
    return _on_tube(drawn, s[:, None], angle)


def _on_tube(drawn: Outline, s: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Points [m] of the tube at arc length `s` [m] and `angle` [rad] from the upper side."""
    along = drawn.along
    # the repeated points of a hinge have one arc length: spread by a hair, so that it turns
    along = along + 1e-9 * np.linspace(0, 1, along.size) * along[-1]
    at = [
        np.interp(s, along, one)
        for one in (drawn.z, drawn.y, drawn.normal[0], drawn.normal[1], drawn.above, drawn.below)
    ]
    z, y, nz, ny, above, below = at
    up = (above - below) / 2 + (above + below) / 2 * np.cos(angle)
    side = drawn.radius * np.sin(angle)
    return np.stack(np.broadcast_arrays(side, y + up * ny, z + up * nz), axis=-1)


def _fitting(drawn: Outline, at: int) -> np.ndarray:
    """Rings [m] of the cylinder that ends the muscle: at the first point or the last."""
    radius, depth = (share * drawn.rest_radius for share in _FITTING)
    end, out = drawn.z[at], -depth if at == 0 else depth
    angle = 2 * np.pi * np.arange(AROUND) / AROUND
    outer, closed = radius, 1e-9 * radius
    stations = [(end, closed), (end, outer), (end + out, outer), (end + out, closed)]
    # faces look outward if the rings run toward larger z
    stations = stations if at == -1 else stations[::-1]
    return np.concatenate([
        np.stack([r * np.sin(angle), r * np.cos(angle), np.full(AROUND, z)], axis=-1)
        for z, r in stations
    ])  # fmt: skip


def _fibers(drawn: Outline, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Fibers [m] on the tube and the directions [-] they are seen from: fiber, point, axis."""
    s = np.linspace(0.0, drawn.along[-1], ALONG)
    turn = s * np.tan(drawn.angle) / drawn.radius
    starts = 2 * np.pi * np.arange(count) / count
    phase = np.concatenate([starts[:, None] + turn, starts[:, None] - turn])
    points = _on_tube(drawn, s, phase)
    center = _on_tube(drawn, s, np.zeros(1))
    opposite = _on_tube(drawn, s, np.full(1, np.pi))
    return points, points - (center + opposite) / 2
