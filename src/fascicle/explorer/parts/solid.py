"""Solids in the browser: points come from Python, and turn there without asking it again.

Bokeh draws flat patches; a few lines of JavaScript project the points, drop the faces that
look away, shade the others and draw the far ones first. There is no physics in it.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import panel as pn
from bokeh.events import Pan
from bokeh.models import CustomJS, Range1d
from bokeh.plotting import figure

from ..curves.tube import ALONG, Solid, quads, tube_faces
from .look import Look, source_of


Color = tuple[int, int, int]

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
  const [a, b, c, d] = [Q.a[k], Q.b[k], Q.c[k], Q.d[k]];
  const [e1, e2, e3] = [u[c] - u[a], v[c] - v[a], w[c] - w[a]];
  const [f1, f2, f3] = [u[d] - u[b], v[d] - v[b], w[d] - w[b]];
  const nz = e1 * f2 - e2 * f1;
  const area = Math.hypot(e2 * f3 - e3 * f2, e3 * f1 - e1 * f3, nz);
  if (area === 0 || sign * nz <= 0) continue;
  const ny = sign * (e3 * f1 - e1 * f3) / area;
  seen.push([w[a] + w[b] + w[c] + w[d], k, 0.55 + 0.35 * sign * nz / area + 0.18 * ny]);
}
seen.sort((p, q) => p[0] - q[0]);
const xs = [], ys = [], color = [];
for (const [_, k, light] of seen) {
  const at = [Q.a[k], Q.b[k], Q.c[k], Q.d[k]];
  xs.push(at.map(i => u[i])); ys.push(at.map(i => v[i]));
  const c = [Q.red[k], Q.green[k], Q.blue[k]].map(x => Math.round(Math.min(255, x * light)));
  color.push(`rgb(${c[0]},${c[1]},${c[2]})`);
}
drawn.data = {xs, ys, color};
const F = fibers.data, fx = [], fy = [];
for (let first = 0; first < F.x.length; first += along) {
  let px = [], py = [];
  for (let i = first; i < first + along; i++) {
    const a = F.x[i] * ca - F.z[i] * sa, b = F.x[i] * sa + F.z[i] * ca;
    const na = F.nx[i] * ca - F.nz[i] * sa;
    if (F.ny[i] * se + na * ce >= 0) { px.push(b); py.push(F.y[i] * ce - a * se); }
    else if (px.length) { fx.push(px); fy.push(py); px = []; py = []; }
  }
  if (px.length) { fx.push(px); fy.push(py); }
}
lines.data = {xs: fx, ys: fy};
"""
_TURN = """
const data = camera.data;
const azimuth = data.azimuth[0] - 0.5 * cb_obj.delta_x;
const elevation = Math.max(-89, Math.min(89, data.elevation[0] + 0.5 * cb_obj.delta_y));
camera.data = {azimuth: [azimuth], elevation: [elevation]};
"""


class Scene:
    """A figure of solids that the pointer turns; `show` replaces what is in it."""

    def __init__(self, look: Look, width: int, height: int, name: str):
        """**Arguments:**

        - `look`: the page's [-].
        - `width`: of the figure, in pixels [-].
        - `height`: of the figure, in pixels [-].
        - `name`: of the source of its points [-].
        """
        self._look, self._aspect = look, width / height
        self.camera = source_of({"azimuth": [35.0], "elevation": [22.0]})
        self.points = source_of({axis: [] for axis in "xyz"}, name=name)
        self._faces = source_of({key: [] for key in (*"abcd", "red", "green", "blue")})
        self._fibers = source_of({key: [] for key in ("x", "y", "z", "nx", "ny", "nz")})
        drawn = source_of({"xs": [], "ys": [], "color": []})
        lines = source_of({"xs": [], "ys": []})
        self.figure = figure(
            width=width, height=height, tools="", toolbar_location=None,
            x_range=Range1d(start=-1, end=1), y_range=Range1d(start=-1, end=1), min_border=0,
        )  # fmt: skip
        self.figure.axis.visible = False
        self.figure.grid.visible = False
        self.figure.outline_line_color = None
        self.figure.background_fill_color = self.figure.border_fill_color = look.paper
        self.figure.patches("xs", "ys", source=drawn, color="color", line_width=0.6)
        self.figure.multi_line(
            "xs", "ys", source=lines, color=look.accent if look.dark else "#0b3d5c",
            line_width=1.1, line_alpha=0.75,
        )  # fmt: skip
        project = CustomJS(
            args={"camera": self.camera, "points": self.points, "faces": self._faces,
                  "fibers": self._fibers, "drawn": drawn, "lines": lines, "along": ALONG,
                  "sign": -1},
            code=_PROJECT,
        )  # fmt: skip
        # the faces only change before the points do, which then draw them
        for source in (self.points, self.camera):
            source.js_on_change("data", project)
        # laid out for the first time, which is when the tab is first looked at
        self.figure.js_on_change("inner_width", project)
        self.figure.js_on_event(Pan, CustomJS(args={"camera": self.camera}, code=_TURN))
        self._kinds: tuple[Any, ...] = ()

    def turn(self, azimuth: float, elevation: float) -> None:
        """Look from `azimuth` and `elevation` in degrees [-]."""
        with pn.io.unlocked():
            self.camera.data = {"azimuth": [azimuth], "elevation": [elevation]}

    def show(
        self,
        solids: Sequence[Solid],
        colors: Sequence[Color],
        places: Sequence[tuple[float, float, float]],
        reach: float,
    ) -> None:
        """Show `solids` [m] in their `colors` [-], each turned and moved to its place.

        `places`: angle about the axis [rad], then x and y [m]; `reach`: half of what the
        figure is wide [m].
        """
        moved = [_moved(one, place) for one, place in zip(solids, places, strict=True)]
        points = np.concatenate([points for points, _, _ in moved])
        lines = np.concatenate([line.reshape(-1, 3) for _, line, _ in moved])
        normals = np.concatenate([normal.reshape(-1, 3) for _, _, normal in moved])
        middle = np.array([0.0, 0.0, (points[:, 2].min() + points[:, 2].max()) / 2])
        points, lines = points - middle, lines - middle
        kinds = tuple(colors)
        if kinds != self._kinds:
            self._faces.data = _faces(len(solids), kinds)
            self._kinds = kinds
        set_symmetric(self.figure, reach, reach / self._aspect)
        self._fibers.data = {
            **{axis: lines[:, i].astype(np.float32) for i, axis in enumerate("xyz")},
            **{f"n{axis}": normals[:, i].astype(np.float32) for i, axis in enumerate("xyz")},
        }
        self.points.data = {axis: points[:, i].astype(np.float32) for i, axis in enumerate("xyz")}


def set_symmetric(fig: Any, x: float, y: float) -> None:
    """Show -x to x and -y to y [m]."""
    fig.x_range.update(start=-x, end=x)
    fig.y_range.update(start=-y, end=y)


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


def _faces(count: int, colors: Sequence[Color]) -> dict[str, np.ndarray]:
    one, tube = quads(), tube_faces()
    number = one.max() + 1
    corners = np.concatenate([one + i * number for i in range(count)])
    fitting = (96, 102, 110)
    rgb = np.concatenate([
        np.where(np.arange(len(one))[:, None] < tube, color, fitting) for color in colors
    ])  # fmt: skip
    shown = {key: corners[:, i].astype(np.int32) for i, key in enumerate("abcd")}
    return shown | {key: rgb[:, i] for i, key in enumerate(("red", "green", "blue"))}
