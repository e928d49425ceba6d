r"""A muscle as a solid that the pointer turns.

The centerline, the tube's extent above and below it, its radius and the fibers' angle are those of
`plot.shapes`, which draws the same in a plane. Here each point of the centerline becomes a ring:
upward it reaches as far as the outline, sideways the radius, so that a hinge folds flat. Along the
arc a fiber turns by $\mathrm{d}\varphi = \pm\tan\alpha\,\mathrm{d}s/r$.

Axes: z along the muscle, y the way it bows, x across; meters. The number of points is fixed. The
browser projects and shades the points (`solid.js`), and turns them without asking the server.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import panel as pn
from bokeh.events import DoubleTap, Pan, PanStart
from bokeh.models import CustomJS, Slider
from bokeh.models.glyphs import Patches

from ..muscle import Muscle
from ..plot.shapes import Outline, outline
from ..plot.theme import Colors, red_green_blue
from .muscle_curves import MuscleCurves
from .theme import WIDGET_CSS, Chart, height_css


RINGS, AROUND = 45, 20
FIBERS, ALONG = 8, 72  # each way around, and points of each
AZIMUTH, ELEVATION = 30, 20  # degrees, of the camera at first
_FITTING = 1.3, 1.1  # radius and depth, over the bladder's radius
_LIFT = 9  # widths of a fiber by which it lies nearer than its middle does
_THREAD = 0.0028  # half a fiber's width, of the width shown
_PROJECT = Path(__file__).with_name("solid.js").read_text(encoding="utf-8")
# the slider follows the pointer, and the camera the slider
_GRIP = "camera.grip = camera.data;"
_TURN = """
const turned = camera.grip.azimuth[0] - 0.5 * cb_obj.delta_x;  // since the pointer went down
const azimuth = ((turned + 180) % 360 + 360) % 360 - 180;
const elevation = Math.max(-89, Math.min(89, camera.grip.elevation[0] + 0.5 * cb_obj.delta_y));
camera.data = {azimuth: [azimuth], elevation: [elevation]};
slider.value = Math.round(azimuth);
"""
_SLIDE = """
const data = camera.data;
if (Math.round(data.azimuth[0]) !== slider.value)
  camera.data = {azimuth: [slider.value], elevation: data.elevation};
"""
_RESET = """
camera.data = {azimuth: [azimuth], elevation: [elevation]};
slider.value = azimuth;
"""
_FRAME = ":host { border-radius: var(--round); overflow: hidden; cursor: grab; }"


@dataclass(frozen=True)
class Solid:
    """Points and fibers of a muscle.

    `points` [m] of the tube and its fittings, a row each; `fibers` [m] and their outward `normals`:
    fiber, point, axis; the braid's `angle` [rad] and the tube's `radius` [m] where it isn't folded.
    """

    points: np.ndarray
    fibers: np.ndarray
    normals: np.ndarray
    angle: float
    radius: float


def muscle_solid(
    muscle: Muscle, curves: MuscleCurves, strain: float, fibers: int = FIBERS
) -> Solid:
    """Solid of a muscle at the point of its curves.

    **Arguments:**

    - `muscle`: the muscle.
    - `curves`: its curves.
    - `strain`: contraction of their point [-].
    - `fibers`: number of fibers each way around.
    """
    collapsed = bool(strain > curves.collapse_strain[-1])
    flat = outline(muscle, curves.z, curves.y, curves.radius, curves.angle, collapsed)
    s = np.linspace(0.0, flat.along[-1], RINGS)
    # rings crowd at the middle, where a hinge turns within less than a radius
    s = s[-1] * (0.5 + np.sign(s / s[-1] - 0.5) * np.abs(2 * s / s[-1] - 1) ** 1.6 / 2)
    rings = _on_tube(flat, s[:, None], 2 * np.pi * np.arange(AROUND) / AROUND)
    ends = [_fitting(flat, end) for end in (0, -1)]
    points = np.concatenate([rings.reshape(-1, 3), *ends])
    lines, normals = _fibers(flat, fibers)
    return Solid(points, lines, normals, flat.angle, flat.radius)


@lru_cache(maxsize=1)
def face_corners() -> np.ndarray:
    """Corners of a solid's faces, the tube's then the fittings': rows of four point numbers."""
    faces, first = [], 0
    for count in (RINGS, 4, 4):
        for i in range(count - 1):
            for j in range(AROUND):
                k = (j + 1) % AROUND
                a, b = first + i * AROUND, first + (i + 1) * AROUND
                faces.append((a + j, a + k, b + k, b + j))
        first += count * AROUND
    return np.array(faces)


def _on_tube(flat: Outline, s: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Points [m] of the tube at arc length `s` [m] and `angle` [rad] from the upper side."""
    along = flat.along
    # the repeated points of a hinge have one arc length: spread by a hair, so that it turns
    along = along + 1e-9 * np.linspace(0, 1, along.size) * along[-1]
    z, y, nz, ny, above, below = (
        np.interp(s, along, values)
        for values in (flat.z, flat.y, flat.normal[0], flat.normal[1], flat.above, flat.below)
    )
    up = (above - below) / 2 + (above + below) / 2 * np.cos(angle)
    side = flat.radius * np.sin(angle)
    return np.stack(np.broadcast_arrays(side, y + up * ny, z + up * nz), axis=-1)


def _fitting(flat: Outline, index: int) -> np.ndarray:
    """Rings [m] of the cylinder at the first point of the muscle, or at the last."""
    radius, depth = (share * flat.rest_radius for share in _FITTING)
    end, out = flat.z[index], -depth if index == 0 else depth
    angle = 2 * np.pi * np.arange(AROUND) / AROUND
    outer, closed = radius, 1e-9 * radius
    stations = [(end, closed), (end, outer), (end + out, outer), (end + out, closed)]
    # faces look outward if the rings run toward larger z
    stations = stations if index == -1 else stations[::-1]
    return np.concatenate([
        np.stack([r * np.sin(angle), r * np.cos(angle), np.full(AROUND, z)], axis=-1)
        for z, r in stations
    ])  # fmt: skip


def _fibers(flat: Outline, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Fibers [m] on the tube and their outward directions: fiber, point, axis."""
    s = np.linspace(0.0, flat.along[-1], ALONG)
    turn = s * np.tan(flat.angle) / flat.radius
    starts = 2 * np.pi * np.arange(count) / count
    phase = np.concatenate([starts[:, None] + turn, starts[:, None] - turn])
    points = _on_tube(flat, s, phase)
    center = _on_tube(flat, s, np.zeros(1))
    opposite = _on_tube(flat, s, np.full(1, np.pi))
    return points, points - (center + opposite) / 2


class Scene:
    """A figure of solids that the pointer turns, and a slider; a double click turns it back."""

    def __init__(self, colors: Colors, name: str, height: str):
        """**Arguments:**

        - `colors`: the page's.
        - `name`: of the source of its points.
        - `height`: of the figure, in CSS; it is as wide as there is room.
        """
        self._colors = colors
        chart = Chart(
            colors, "", "", 0, tools="", toolbar_location=None, min_border=0,
            stylesheets=[height_css(height), _FRAME],
        )  # fmt: skip
        self.figure = chart.figure
        self.figure.background_fill_color = self.figure.border_fill_color = colors.raised
        self.camera = chart.source("azimuth", "elevation")
        self.camera.data = {"azimuth": [float(AZIMUTH)], "elevation": [float(ELEVATION)]}
        self.points = chart.source(*"xyz", name=name)
        self._faces = chart.source(*"abcd", "red", "green", "blue")
        self._fibers = chart.source("x", "y", "z", "nx", "ny", "nz", name=f"{name}_fibers")
        drawn = chart.source("xs", "ys", "color", name=f"{name}_drawn")
        chart.draw(drawn, Patches(fill_color="color", line_color="color", line_width=0.6))
        project = CustomJS(
            args={"camera": self.camera, "points": self.points, "faces": self._faces,
                  "fibers": self._fibers, "drawn": drawn, "along": ALONG, "lift": _LIFT,
                  "frame": self.figure, "sign": -1},
            code=_PROJECT,
        )  # fmt: skip
        # all else changes before the points do
        for source in (self.points, self.camera):
            source.js_on_change("data", project)
        # laid out for the first time, which is when the tab is first looked at
        self.figure.js_on_change("inner_width", project)
        self.figure.js_on_change("inner_height", project)
        slider = Slider(
            title="Turn or drag it [°]", start=-180, end=180, value=AZIMUTH, step=1,
            stylesheets=[WIDGET_CSS], sizing_mode="stretch_width", margin=(0, 14),
        )  # fmt: skip
        self.slider = pn.pane.Bokeh(slider, margin=0, sizing_mode="stretch_width")
        models = {"camera": self.camera, "slider": slider}
        first = {"azimuth": AZIMUTH, "elevation": ELEVATION}
        slider.js_on_change("value", CustomJS(args=models, code=_SLIDE))
        self.figure.js_on_event(PanStart, CustomJS(args=models, code=_GRIP))
        self.figure.js_on_event(Pan, CustomJS(args=models, code=_TURN))
        self.figure.js_on_event(DoubleTap, CustomJS(args=models | first, code=_RESET))
        self._kinds: tuple[Any, ...] = ()

    def show(
        self,
        solids: Sequence[Solid],
        colors: Sequence[tuple[str, str]],
        places: Sequence[tuple[float, float, float]],
        reach: tuple[float, float],
    ) -> None:
        """Show solids, each turned and moved to its place.

        **Arguments:**

        - `solids`: the solids.
        - `colors`: of each tube and its fibers.
        - `places`: angle about the axis [rad], x and y [m] of each.
        - `reach`: half of what must be seen across and up [m].
        """
        moved = [_move(solid, *place) for solid, place in zip(solids, places, strict=True)]
        points = np.concatenate([points for points, _, _ in moved])
        lines = np.concatenate([line.reshape(-1, 3) for _, line, _ in moved])
        normals = np.concatenate([normal.reshape(-1, 3) for _, _, normal in moved])
        middle = np.array([0.0, 0.0, (points[:, 2].min() + points[:, 2].max()) / 2])
        points, lines = points - middle, lines - middle
        kinds = (tuple(colors), tuple(len(solid.fibers) for solid in solids))
        if kinds != self._kinds:
            tubes = [tube for tube, _ in colors]
            self._faces.data = _face_columns(len(solids), tubes, self._colors.fitting)
            self._fibers.tags = [
                color for (_, color), solid in zip(colors, solids, strict=True)
                for _ in solid.fibers
            ]  # fmt: skip
            self._kinds = kinds
        self._fibers.data = _columns("xyz", lines) | _columns(("nx", "ny", "nz"), normals)
        self.points.tags = [*reach, _THREAD * reach[0]]
        self.points.data = _columns("xyz", points)


def _columns(names: Sequence[str], points: np.ndarray) -> dict[str, np.ndarray]:
    return {name: points[:, i].astype(np.float32) for i, name in enumerate(names)}


def _move(
    solid: Solid, angle: float, x: float, y: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points, fibers [m] and normals turned about the axis by an `angle` [rad] and moved [m]."""
    turn = np.array([
        [np.cos(angle), np.sin(angle), 0.0], [-np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]
    ])  # fmt: skip
    offset = np.array([x, y, 0.0])
    return solid.points @ turn.T + offset, solid.fibers @ turn.T + offset, solid.normals @ turn.T


def _face_columns(count: int, colors: Sequence[str], fitting: str) -> dict[str, np.ndarray]:
    corners = face_corners()
    number = corners.max() + 1
    every = np.concatenate([corners + i * number for i in range(count)])
    is_tube = np.arange(len(corners))[:, None] < (RINGS - 1) * AROUND
    ends = red_green_blue(fitting)
    rgb = np.concatenate([np.where(is_tube, red_green_blue(color), ends) for color in colors])
    columns = {key: every[:, i].astype(np.int32) for i, key in enumerate("abcd")}
    return columns | {key: rgb[:, i] for i, key in enumerate(("red", "green", "blue"))}
