r"""A muscle as a solid that the pointer turns.

The centerline, the tube's extent above and below it, its radius and the fibers' angle are those of
`plot.shapes`, which draws the same in a plane. Here each point of the centerline becomes a ring:
upward it reaches as far as the outline, sideways the radius, so that a hinge folds flat. Along the
arc a fiber turns by $\mathrm{d}\varphi = \pm\tan\alpha\,\mathrm{d}s/r$.

Axes: z along the muscle, y the way it bows, x across; meters. The number of points is fixed. The
browser projects and shades the points (`plot/projection.js`), and turns them without asking the
server.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import panel as pn
from bokeh.events import DoubleTap, Pan, PanStart
from bokeh.models import CustomJS, Slider

from ..muscle import Muscle
from ..plot.shapes import PROJECTION, Outline, outline
from ..plot.theme import Colors, red_green_blue
from .chart import Chart
from .muscle_curves import MuscleCurves
from .widgets import WIDGET_CSS


RINGS, AROUND = 45, 20  # points of a tube: smooth on a screen, and few enough to turn at once
FIBERS, ALONG = 8, 72  # each way around, and points of each
AZIMUTH, ELEVATION = 30, 20  # degrees, of the camera at first
_FITTING = 1.3, 1.1  # radius and depth, over the bladder's radius
_LIFT = 9  # widths of a fiber by which it lies nearer than its middle does
_FIBER_WIDTH = 0.0028  # half of it, over the width of the view
_SCRIPT = Path(__file__).with_name("scene.js").read_text(encoding="utf-8")
_FRAME = """:host { border-radius: var(--round); background: var(--raised); cursor: grab;
  touch-action: pan-y; }"""


@dataclass(frozen=True)
class Solid:
    """A muscle in space: `points` [m] of its tube and fittings, a row each; `fibers` [m] of its
    braid, and their outward `normals`: fiber, point, axis. The braid's `angle` [rad] and the tube's
    `radius` [m] are those where it isn't folded.
    """

    points: np.ndarray
    fibers: np.ndarray
    normals: np.ndarray
    angle: float
    radius: float

    def transform(
        self, angle: float, x: float, y: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Points and fibers [m], and normals, turned about the axis [rad] and moved [m]."""
        cos, sin = np.cos(angle), np.sin(angle)
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        offset = np.array([x, y, 0.0])
        return self.points @ turn + offset, self.fibers @ turn + offset, self.normals @ turn


def muscle_solid(
    muscle: Muscle, curves: MuscleCurves, strain: float, fibers: int = FIBERS
) -> Solid:
    """Solid of a muscle at the `strain` [-] of its curves, with `fibers` each way around."""
    collapsed = strain > curves.collapse_strain
    flat = outline(muscle, curves.z, curves.y, curves.radius, curves.angle, collapsed)
    # rings crowd at the middle, where a hinge turns within less than a radius
    t = np.linspace(-1.0, 1.0, RINGS)
    s = flat.along[-1] * (1 + np.sign(t) * np.abs(t) ** 1.6) / 2
    rings = _tube_points(flat, s[:, None], 2 * np.pi * np.arange(AROUND) / AROUND)
    ends = [_fitting(flat, end) for end in (0, -1)]
    points = np.concatenate([rings.reshape(-1, 3), *ends])
    s = np.linspace(0.0, flat.along[-1], ALONG)
    turn = s * np.tan(curves.angle) / curves.radius
    starts = 2 * np.pi * np.arange(fibers)[:, None] / max(fibers, 1)
    lines = _tube_points(flat, s, np.concatenate([starts + turn, starts - turn]))
    center = (_tube_points(flat, s, np.zeros(1)) + _tube_points(flat, s, np.full(1, np.pi))) / 2
    return Solid(points, lines, lines - center, curves.angle, curves.radius)


def face_corners() -> np.ndarray:
    """Corners of a solid's faces, the tube's then the fittings': rows of four point indices."""
    # rings with a next one: the last of the tube, and of the first fitting, have none
    ring = np.delete(np.arange(RINGS + 7), [RINGS - 1, RINGS + 3])
    a, j = AROUND * ring[:, None], np.arange(AROUND)
    b, k = a + AROUND, (j + 1) % AROUND
    return np.stack([a + j, a + k, b + k, b + j], axis=-1).reshape(-1, 4)


def _tube_points(flat: Outline, s: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Points [m] of the tube at arc length `s` [m] and `angle` [rad] from the upper side."""
    along = flat.along
    # the repeated points of a hinge have one arc length: spread by a hair, so that it turns
    along = along + 1e-9 * np.linspace(0, 1, along.size) * along[-1]
    z, y, nz, ny, upper, lower = (
        np.interp(s, along, values)
        for values in (flat.z, flat.y, *flat.normal, flat.above, flat.below)
    )
    up = (upper - lower) / 2 + (upper + lower) / 2 * np.cos(angle)
    side = flat.radius * np.sin(angle)
    return np.stack(np.broadcast_arrays(side, y + up * ny, z + up * nz), axis=-1)


def _fitting(flat: Outline, index: int) -> np.ndarray:
    """Rings [m] of the cylinder at the first point of the muscle, or at the last."""
    radius, depth = (ratio * flat.rest_radius for ratio in _FITTING)
    end, out = flat.z[index], -depth if index == 0 else depth
    angle = 2 * np.pi * np.arange(AROUND) / AROUND
    closed = 1e-9 * radius  # not zero: a face needs a normal
    stations = [(end, closed), (end, radius), (end + out, radius), (end + out, closed)]
    # faces look outward if the rings run toward larger z
    stations = stations if index == -1 else stations[::-1]
    rings = [
        np.stack([r * np.sin(angle), r * np.cos(angle), np.full(AROUND, z)], axis=-1)
        for z, r in stations
    ]
    return np.concatenate(rings)


class Scene:
    """A figure of solids that the pointer turns, and a slider; a double click turns it back."""

    def __init__(
        self, colors: Colors, name: str, height: str, on_pull: Callable[[float], None] | None = None
    ):
        """`on_pull` takes the strain [-] to which a hand pulls an end of the muscle."""
        plain = {"tools": "", "toolbar_location": None, "min_border": 0}
        chart = self._chart = Chart(colors, "", "", height, **plain)
        figure = chart.figure
        figure.stylesheets = [*figure.stylesheets, _FRAME]
        camera = chart.new_source("azimuth elevation")
        camera.data = {"azimuth": [float(AZIMUTH)], "elevation": [float(ELEVATION)]}
        camera.tags = [AZIMUTH, ELEVATION]
        self.points = chart.new_source("x y z", name)
        self._faces = chart.new_source("a b c d red green blue")
        self._fibers = chart.new_source("x y z nx ny nz", f"{name}_fibers")
        self._hand = chart.new_source("strain")
        drawn = chart.add("patches_in_space", f"{name}_drawn")
        style = {"stylesheets": [WIDGET_CSS], "sizing_mode": "stretch_width", "margin": (0, 14)}
        turns = {"start": -180, "end": 180, "value": AZIMUTH, "step": 1}
        slider = self._slider = Slider(title="Turn the view [°]", **turns, **style)
        models = {"camera": camera, "slider": slider, "drawn": drawn, "frame": figure}
        models |= {"points": self.points, "faces": self._faces, "fibers": self._fibers}
        models |= {"hand": self._hand, "along": ALONG, "lift": _LIFT}
        code = CustomJS(args=models, code=PROJECTION + _SCRIPT)
        for source in (self.points, camera):  # all else changes before the points do
            source.js_on_change("data", code)
        for size in ("inner_width", "inner_height"):  # laid out when the tab is first opened
            figure.js_on_change(size, code)
        slider.js_on_change("value", code)
        for event in (PanStart, Pan, DoubleTap):
            figure.js_on_event(event, code)
        if on_pull is not None:
            self._hand.on_change("data", lambda _attr, _old, new: on_pull(new["strain"][0]))
        self._pulls = on_pull is not None
        self.describe = chart.describe
        self._kinds: tuple[object, ...] = ()

    def panes(self) -> tuple[pn.pane.Bokeh, pn.pane.Bokeh]:
        slider = pn.pane.Bokeh(self._slider, margin=0, sizing_mode="stretch_width")
        return self._chart.new_pane(), slider

    def show(
        self,
        solids: Sequence[Solid],
        colors: Sequence[tuple[str, str]],
        fitting: str,
        positions: Sequence[tuple[float, float, float]],
        reach: tuple[float, float],
        rest: tuple[float, float] = (0.0, 1.0),
    ) -> None:
        """Show solids with `colors` of tube and fibers at `positions` (angle [rad], x, y [m]), and
        `reach` [m] across and up; `rest`: strain [-] and rest length [m] of a muscle to pull.
        """
        pairs = zip(solids, positions, strict=True)
        parts = zip(*(solid.transform(*position) for solid, position in pairs), strict=True)
        points, lines, normals = (
            np.concatenate([a.reshape(-1, 3) for a in part]) for part in parts
        )
        middle = np.array([0.0, 0.0, (points[:, 2].min() + points[:, 2].max()) / 2])
        kinds = (tuple(colors), tuple(len(solid.fibers) for solid in solids))
        if kinds != self._kinds:  # faces are many, and stay while a slider moves
            tubes, fibers = zip(*colors, strict=True)
            self._faces.data = _face_columns(tubes, fitting)
            counts = zip(fibers, kinds[1], strict=True)
            self._fibers.tags = [color for color, count in counts for _ in range(count)]
            self._kinds = kinds
        normals = _columns(("nx", "ny", "nz"), normals)
        self._fibers.data = _columns("xyz", lines - middle) | normals
        self._hand.tags = [rest[0]] if self._pulls else []
        self.points.tags = [*reach, _FIBER_WIDTH * reach[0], rest[1]]
        self.points.data = _columns("xyz", points - middle)


def _columns(names: Sequence[str], points: np.ndarray) -> dict[str, np.ndarray]:
    """Columns of `points`, single precision, by their `names`."""
    return {name: points[:, i].astype(np.float32) for i, name in enumerate(names)}


def _face_columns(colors: Sequence[str], fitting: str) -> dict[str, np.ndarray]:
    """Columns of the faces of solids: indices of the corners, `a` to `d`, and colors."""
    corners = face_corners()
    number = corners.max() + 1
    all_corners = np.concatenate([corners + i * number for i in range(len(colors))])
    is_tube = np.arange(len(corners))[:, None] < (RINGS - 1) * AROUND
    ends = red_green_blue(fitting)
    rgb = np.concatenate([np.where(is_tube, red_green_blue(color), ends) for color in colors])
    columns = {key: all_corners[:, i].astype(np.int32) for i, key in enumerate("abcd")}
    return columns | {key: rgb[:, i] for i, key in enumerate(("red", "green", "blue"))}
