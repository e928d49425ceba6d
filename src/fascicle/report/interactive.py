"""Pictures with a text at each mark when the mouse is over it: SVG from a template, and a script.

Without the script a browser still shows each mark's title. A page is to be sent around and read
for years: Bokeh adds 1.27 MB of script to each, and shows nothing if scripts are off or cut out.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from markupsafe import Markup
from matplotlib.ticker import MaxNLocator

from ..units import format_digits
from .page import fill


# of the picture, and of its axes' ends [px]
_WIDTH, _HEIGHT = 760.0, 420.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 78.0, 740.0, 18.0, 366.0
_TICKS = MaxNLocator(6, steps=[1, 2, 5, 10])  # so few that labels don't touch


class Axis(NamedTuple):
    """A quantity along an axis: its `label`, and its `values` for every mark."""

    label: str
    values: np.ndarray


def objective_axis(values: np.ndarray, name: str, unit: str) -> Axis:
    """Axis of an objective's `values` [SI], by its `name` and SI `unit`, in a handy unit."""
    label = name.replace("_", " ")
    if unit == "-":
        return Axis(label, values)
    return Axis(f"{label} [mm]", 1e3 * values) if unit == "m" else Axis(f"{label} [{unit}]", values)


def scatter(
    across: Axis,
    up: Axis,
    texts: Sequence[str],
    chosen: int | None,
    background: tuple[np.ndarray, np.ndarray] | None = None,
    second: int | None = None,
) -> Markup:
    """Marks over two quantities, as SVG.

    **Arguments:**

    - `across`, `up`: the horizontal and the vertical quantity.
    - `texts`: of each mark.
    - `chosen`: the mark that is emphasized, or none.
    - `background`: points without a text, behind the marks, or none.
    - `second`: a mark that is emphasized less, by a rim, or none.
    """
    x_points, y_points = background or (np.empty(0), np.empty(0))
    x = _Scale(np.concatenate([across.values, x_points]), _LEFT, _RIGHT)
    y = _Scale(np.concatenate([up.values, y_points]), _BOTTOM, _TOP)
    return _svg(
        f"{up.label} over {across.label}", texts, chosen, second, "circle",
        [
            f'cx="{x(a):.1f}" cy="{y(b):.1f}" r="{6 if i in (chosen, second) else 4.5}"'
            for i, (a, b) in enumerate(zip(across.values, up.values, strict=True))
        ],
        rules=[
            *((x(tick), _TOP, x(tick), _BOTTOM, "grid") for tick in x.ticks()),
            *((_LEFT, y(tick), _RIGHT, y(tick), "grid") for tick in y.ticks()),
        ],
        labels=[
            *((x(tick), _BOTTOM + 18, f"{tick:.6g}", "middle") for tick in x.ticks()),
            *((_LEFT - 8, y(tick) + 4, f"{tick:.6g}", "end") for tick in y.ticks()),
            ((_LEFT + _RIGHT) / 2, _HEIGHT - 12, across.label, "middle"),
        ],
        upright=(16, (_TOP + _BOTTOM) / 2, up.label),
        points=list(zip(map(x, x_points), map(y, y_points), strict=True)),
    )  # fmt: skip


def parallel_coordinates(
    axes: Sequence[Axis], texts: Sequence[str], chosen: int | None, second: int | None = None
) -> Markup:
    """Parallel coordinates as SVG: an axis for each quantity, a line across them for each mark.

    **Arguments:**

    - `axes`: the quantities.
    - `texts`: of each line.
    - `chosen`: the line that is emphasized, or none.
    - `second`: a line that is emphasized less, or none.
    """
    top = _TOP + 14
    abscissas = np.linspace(_LEFT, _WIDTH - _LEFT, max(2, len(axes)))[: len(axes)]
    scales = [_Scale(axis.values, _BOTTOM, top) for axis in axes]
    labels = []
    for i, (x, axis, y) in enumerate(zip(abscissas, axes, scales, strict=True)):
        labels += [
            (x, y(end) + (-6 if y(end) < _HEIGHT / 2 else 16), format_digits(end), "middle")
            for end in dict.fromkeys((y.least, y.most))
        ]
        labels.append((x, _BOTTOM + (34 if i % 2 == 0 else 48), axis.label, "middle"))
    columns = [
        [f"{x:.1f} {y(value):.1f}" for value in axis.values]
        for x, axis, y in zip(abscissas, axes, scales, strict=True)
    ]
    return _svg(
        "Objectives of every design of the front", texts, chosen, second, "path",
        [f'd="M{" L".join(points)}"' for points in zip(*columns, strict=True)],
        rules=[(x, top, x, _BOTTOM, "axis") for x in abscissas], labels=labels, upright=(),
        points=(),
    )  # fmt: skip


class _Scale:
    """Map from values to pixels between `start` and `end`, with a margin."""

    def __init__(self, values: np.ndarray, start: float, end: float):
        finite = values[np.isfinite(values)]
        low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
        self.least, self.most = low, high
        if low == high:
            low, high = low - 0.5 * (abs(low) or 1.0), high + 0.5 * (abs(high) or 1.0)
        pad = 0.03 * (high - low)
        self.low, self.high, self.start, self.end = low - pad, high + pad, start, end

    def __call__(self, value: float) -> float:
        return self.start + (value - self.low) / (self.high - self.low) * (self.end - self.start)

    def ticks(self) -> list[float]:
        ticks = _TICKS.tick_values(self.low, self.high)
        return [float(tick) for tick in ticks if self.low <= tick <= self.high]


def _svg(
    title: str,
    texts: Sequence[str],
    chosen: int | None,
    second: int | None,
    tag: str,
    marks: Sequence[str],
    **values: object,
) -> Markup:
    """SVG of `marks`, each the attributes of a `tag`; emphasized ones last, on top."""
    order = sorted(range(len(texts)), key=lambda i: (i == chosen, i == second))
    names = [f"mark{' chosen' * (i == chosen)}{' second' * (i == second)}" for i in order]
    rows = [
        (i, name, texts[i], Markup(marks[i]))  # noqa: S704 numbers
        for i, name in zip(order, names, strict=True)
    ]
    return fill(
        "marks.svg", title=title, width=_WIDTH, height=_HEIGHT, tag=tag, marks=rows, **values
    )
