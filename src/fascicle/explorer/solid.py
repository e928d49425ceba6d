r"""A muscle as a solid: points on its tube, its fittings and its fibers, from the laws' shape.

The centerline, the tube's reach above and below it, its radius and the fibers' angle are
those of `plot.shapes`, which draws the same in a plane. Here each point of the centerline
becomes a ring: upward it reaches as far as the outline, sideways the radius, so that a hinge
folds flat. Along the arc a fiber turns by $\mathrm{d}\varphi = \pm\tan\alpha\,\mathrm{d}s/r$.

Axes: z along the muscle, y the way it bows, x across; meters. The number of points is fixed.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import panel as pn
from bokeh.events import DoubleTap, Pan, PanStart
from bokeh.models import CustomJS, Range1d, Slider
from bokeh.plotting import figure

from ..muscle import Muscle
from ..plot.shapes import Outline, outline
from ..plot.theme import red_green_blue
from .muscle_curves import Picture
from .theme import Look, high_css, source_of, widget_css


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


_PROJECT = """
const [az, el] = [camera.data.azimuth[0], camera.data.elevation[0]].map(d => d * Math.PI / 180);
const [ca, sa, ce, se] = [Math.cos(az), Math.sin(az), Math.cos(el), Math.sin(el)];
const P = points.data, n = P.x.length, u = new Float64Array(n), v = new Float64Array(n),
      w = new Float64Array(n);
for (let i = 0; i < n; i++) {
  const a = P.x[i] * ca - P.z[i] * sa, b = P.x[i] * sa + P.z[i] * ca;
  u[i] = b; v[i] = P.y[i] * ce - a * se; w[i] = P.y[i] * se + a * ce;
}
const Q = faces.data, seen = [];
for (let k = 0; k < Q.a.length; k++) {
  const at = [Q.a[k], Q.b[k], Q.c[k], Q.d[k]], [a, b, c, d] = at;
  const [e1, e2, e3] = [u[c] - u[a], v[c] - v[a], w[c] - w[a]];
  const [f1, f2, f3] = [u[d] - u[b], v[d] - v[b], w[d] - w[b]];
  const nz = e1 * f2 - e2 * f1;
  const area = Math.hypot(e2 * f3 - e3 * f2, e3 * f1 - e1 * f3, nz);
  if (area === 0 || sign * nz <= 0) continue;
  const ny = sign * (e3 * f1 - e1 * f3) / area;
  const light = 0.55 + 0.35 * sign * nz / area + 0.18 * ny;
  const rgb = [Q.red[k], Q.green[k], Q.blue[k]].map(x => Math.round(Math.min(255, x * light)));
  seen.push([(w[a] + w[b] + w[c] + w[d]) / 4, at.map(i => u[i]), at.map(i => v[i]),
             `rgb(${rgb})`]);
}
const reach = extent.data.wide[0], tall = extent.data.high[0], thin = extent.data.thread[0];
const F = fibers.data;
for (let first = 0, thread = 0; first < F.x.length; first += along, thread++) {
  let last = null;
  for (let i = first; i < first + along; i++) {
    const a = F.x[i] * ca - F.z[i] * sa, na = F.nx[i] * ca - F.nz[i] * sa;
    const at = [F.x[i] * sa + F.z[i] * ca, F.y[i] * ce - a * se, F.y[i] * se + a * ce];
    const facing = F.ny[i] * se + na * ce >= 0;
    if (facing && last) {
      const [du, dv] = [at[0] - last[0], at[1] - last[1]], long = Math.hypot(du, dv) || 1;
      const [pu, pv] = [-thin * dv / long, thin * du / long];
      // nearer by a few of its widths: it lies on the face that it would vanish in
      seen.push([(last[2] + at[2]) / 2 + lift * thin,
                 [last[0] + pu, at[0] + pu, at[0] - pu, last[0] - pu],
                 [last[1] + pv, at[1] + pv, at[1] - pv, last[1] - pv], threads.data.color[thread]]);
    }
    last = facing ? at : null;
  }
}
seen.sort((p, q) => p[0] - q[0]);
drawn.data = {xs: seen.map(s => s[1]), ys: seen.map(s => s[2]), color: seen.map(s => s[3])};
// undistorted in whatever room there is, and all of it to be seen
const size = name => frame.properties[name].is_unset ? 1 : frame[name] || 1;
const shape = size("inner_height") / size("inner_width");
const x = Math.max(reach, tall / shape), y = x * shape;
if (frame.x_range.end !== x || frame.y_range.end !== y) {
  frame.x_range.setv({start: -x, end: x}); frame.y_range.setv({start: -y, end: y});
}
"""
# the slider goes where the pointer turns it, and turns it where it is moved
_GRIP = "held.data = camera.data;"
_TURN = """
// by how far the pointer is from where it went down
const turned = held.data.azimuth[0] - 0.5 * cb_obj.delta_x;
const azimuth = ((turned + 180) % 360 + 360) % 360 - 180;
const elevation = Math.max(-89, Math.min(89, held.data.elevation[0] + 0.5 * cb_obj.delta_y));
camera.data = {azimuth: [azimuth], elevation: [elevation]};
slider.value = Math.round(azimuth);
"""
_SLID = """
const data = camera.data;
if (Math.round(data.azimuth[0]) !== slider.value)
  camera.data = {azimuth: [slider.value], elevation: data.elevation};
"""
_BACK = """
camera.data = {azimuth: [azimuth], elevation: [elevation]};
slider.value = azimuth;
"""
_FRAMED = ":host { border-radius: var(--round); overflow: hidden; cursor: grab; }"
_LIFT = 9  # widths of a fiber by which it lies nearer than its middle does
_THREAD = 0.0028  # of the width shown: half a fiber's
AZIMUTH, ELEVATION = 30, 20  # degrees that the picture is seen from first


class Scene:
    """A figure of solids that the pointer turns, and a slider; a double click turns it back.

    `show` replaces what is in it.
    """

    def __init__(self, look: Look, name: str, height: str):
        """**Arguments:**

        - `look`: the page's [-].
        - `name`: of the source of its points [-].
        - `height`: of the figure, in CSS [-]; it is as wide as there is room.
        """
        self._look = look
        self.camera = source_of({"azimuth": [float(AZIMUTH)], "elevation": [float(ELEVATION)]})
        self.points = source_of({axis: [] for axis in "xyz"}, name=name)
        self._faces = source_of({key: [] for key in (*"abcd", "red", "green", "blue")})
        self._fibers = source_of(
            {key: [] for key in ("x", "y", "z", "nx", "ny", "nz")}, name=f"{name}_fibers"
        )
        self._threads = source_of({"color": []})
        self._extent = source_of({"wide": [1.0], "high": [1.0], "thread": [0.0]})
        drawn = source_of({"xs": [], "ys": [], "color": []}, name=f"{name}_drawn")
        self.figure = figure(
            height=300, sizing_mode="stretch_width", tools="", toolbar_location=None,
            x_range=Range1d(start=-1, end=1), y_range=Range1d(start=-1, end=1), min_border=0,
            stylesheets=[high_css(height), _FRAMED],
        )  # fmt: skip
        self.figure.axis.visible = False
        self.figure.grid.visible = False
        self.figure.outline_line_color = None
        self.figure.background_fill_color = self.figure.border_fill_color = look.raised
        self.figure.patches("xs", "ys", source=drawn, color="color", line_width=0.6)
        project = CustomJS(
            args={"camera": self.camera, "points": self.points, "faces": self._faces,
                  "fibers": self._fibers, "threads": self._threads, "extent": self._extent,
                  "drawn": drawn, "along": ALONG, "lift": _LIFT, "frame": self.figure, "sign": -1},
            code=_PROJECT,
        )  # fmt: skip
        # all else only changes before the points do, which then draw it
        for source in (self.points, self.camera):
            source.js_on_change("data", project)
        # laid out for the first time, which is when the tab is first looked at
        self.figure.js_on_change("inner_width", project)
        self.figure.js_on_change("inner_height", project)
        slider = Slider(
            title="Turn or drag it [°]", start=-180, end=180, value=AZIMUTH, step=1,
            stylesheets=[widget_css(look)], sizing_mode="stretch_width", margin=(0, 14),
        )  # fmt: skip
        self.turn = pn.pane.Bokeh(slider, margin=0, sizing_mode="stretch_width")
        held = source_of(self.camera.data)
        seen = {"camera": self.camera, "slider": slider, "held": held}
        first = {"azimuth": AZIMUTH, "elevation": ELEVATION}
        slider.js_on_change("value", CustomJS(args=seen, code=_SLID))
        self.figure.js_on_event(PanStart, CustomJS(args=seen, code=_GRIP))
        self.figure.js_on_event(Pan, CustomJS(args=seen, code=_TURN))
        self.figure.js_on_event(DoubleTap, CustomJS(args=seen | first, code=_BACK))
        self._kinds: tuple[Any, ...] = ()

    def show(
        self,
        solids: Sequence[Solid],
        colors: Sequence[tuple[str, str]],
        places: Sequence[tuple[float, float, float]],
        reach: tuple[float, float],
    ) -> None:
        """Show `solids` [m], each turned and moved to its place.

        `colors`: of each tube and its fibers; `places`: angle about the axis [rad], then x and
        y [m]; `reach`: half of what must be seen across and up [m].
        """
        moved = [_moved(one, place) for one, place in zip(solids, places, strict=True)]
        points = np.concatenate([points for points, _, _ in moved])
        lines = np.concatenate([line.reshape(-1, 3) for _, line, _ in moved])
        normals = np.concatenate([normal.reshape(-1, 3) for _, _, normal in moved])
        middle = np.array([0.0, 0.0, (points[:, 2].min() + points[:, 2].max()) / 2])
        points, lines = points - middle, lines - middle
        kinds = (tuple(colors), tuple(len(one.fibers) for one in solids))
        if kinds != self._kinds:
            self._faces.data = _faces(len(solids), [tube for tube, _ in colors], self._look.fitting)
            self._threads.data = {
                "color": [c for (_, c), one in zip(colors, solids, strict=True) for _ in one.fibers]
            }
            self._kinds = kinds
        wide, high = reach
        self._extent.data = {"wide": [wide], "high": [high], "thread": [_THREAD * wide]}
        self._fibers.data = {
            **{axis: lines[:, i].astype(np.float32) for i, axis in enumerate("xyz")},
            **{f"n{axis}": normals[:, i].astype(np.float32) for i, axis in enumerate("xyz")},
        }
        self.points.data = {axis: points[:, i].astype(np.float32) for i, axis in enumerate("xyz")}


def _moved(
    one: Solid, place: tuple[float, float, float]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points, fibers [m] and normals [-] turned about the axis and moved aside."""
    angle, x, y = place
    turn = np.array([
        [np.cos(angle), np.sin(angle), 0.0], [-np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]
    ])  # fmt: skip
    aside = np.array([x, y, 0.0])
    return one.points @ turn.T + aside, one.fibers @ turn.T + aside, one.normals @ turn.T


def _faces(count: int, colors: Sequence[str], fitting: str) -> dict[str, np.ndarray]:
    one, tube = quads(), tube_faces()
    number = one.max() + 1
    corners = np.concatenate([one + i * number for i in range(count)])
    ends = red_green_blue(fitting)
    rgb = np.concatenate([
        np.where(np.arange(len(one))[:, None] < tube, red_green_blue(color), ends)
        for color in colors
    ])  # fmt: skip
    shown = {key: corners[:, i].astype(np.int32) for i, key in enumerate("abcd")}
    return shown | {key: rgb[:, i] for i, key in enumerate(("red", "green", "blue"))}
