"""Pictures that tell about a mark when the mouse is on it: SVG drawn by hand, and ten lines of
script in the page. Without the script a browser still shows each mark's title.

By hand, since a page is to be sent around and read for years: Bokeh brings 1.27 MB of script to
each, where a page has 0.5 MB in all, and shows nothing where scripts are off or cut out.
"""

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..units import figures


_WIDTH, _HEIGHT = 760.0, 420.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 78.0, 20.0, 18.0, 54.0
_TICKS = 6

_TEMPLATES = Path(__file__).with_name("templates")
STYLE = f"<style>\n{(_TEMPLATES / 'hover.css').read_text(encoding='utf-8')}</style>\n"
SCRIPT = (
    '<div id="hover"></div>\n<script>\n'
    f"{(_TEMPLATES / 'hover.js').read_text(encoding='utf-8')}</script>\n"
)


class Axis(NamedTuple):
    """A quantity along an axis: its `label`, and its `values` for every mark."""

    label: str
    values: np.ndarray


def scatter(
    across: Axis,
    up: Axis,
    texts: Sequence[str],
    chosen: int | None,
    others: tuple[np.ndarray, np.ndarray] | None = None,
    second: int | None = None,
) -> str:
    """Marks over two quantities.

    **Arguments:**

    - `across`: the horizontal one [-].
    - `up`: the vertical one [-].
    - `texts`: what each mark tells [-].
    - `chosen`: the mark that is emphasized [-]; or none.
    - `others`: points without a text, behind the marks [-]; or none.
    - `second`: a mark that is emphasized less, by a rim [-]; or none.

    **Returns:** the SVG [-].
    """
    xs, ys = [across.values], [up.values]
    if others is not None:
        xs.append(others[0])
        ys.append(others[1])
    x, y = _Scale(xs, _LEFT, _WIDTH - _RIGHT), _Scale(ys, _HEIGHT - _BOTTOM, _TOP)
    parts = []
    for value, text in x.ticks():
        parts.append(_line(x(value), _TOP, x(value), _HEIGHT - _BOTTOM, "grid"))
        parts.append(_text(x(value), _HEIGHT - _BOTTOM + 18, text, "middle"))
    for value, text in y.ticks():
        parts.append(_line(_LEFT, y(value), _WIDTH - _RIGHT, y(value), "grid"))
        parts.append(_text(_LEFT - 8, y(value) + 4, text, "end"))
    parts.append(_text((_LEFT + _WIDTH - _RIGHT) / 2, _HEIGHT - 12, across.label, "middle"))
    middle = (_TOP + _HEIGHT - _BOTTOM) / 2
    parts.append(
        f'<text transform="translate(16 {middle:.1f}) rotate(-90)" text-anchor="middle">'
        f"{escape(up.label)}</text>"
    )
    if others is not None:
        parts += [
            f'<circle class="other" cx="{x(a):.1f}" cy="{y(b):.1f}" r="1.6"/>'
            for a, b in zip(*others, strict=True)
        ]
    for i in _order(len(texts), chosen, second):
        at = f'cx="{x(across.values[i]):.1f}" cy="{y(up.values[i]):.1f}"'
        large = i in (chosen, second)
        shape = f'{at} r="{6 if large else 4.5}"'
        parts.append(_mark("circle", shape, i, texts[i], chosen, second))
    return _svg(parts, f"{up.label} over {across.label}")


def parallel(
    axes: Sequence[Axis], texts: Sequence[str], chosen: int | None, second: int | None = None
) -> str:
    """A line for each mark across an axis for each quantity.

    **Arguments:**

    - `axes`: the quantities [-].
    - `texts`: what each line tells [-].
    - `chosen`: the line that is emphasized [-]; or none.
    - `second`: a line that is emphasized less [-]; or none.

    **Returns:** the SVG [-].
    """
    places = np.linspace(_LEFT, _WIDTH - _LEFT, max(2, len(axes)))[: len(axes)]
    scales = [_Scale([axis.values], _HEIGHT - _BOTTOM, _TOP + 14) for axis in axes]
    parts = []
    for i, (place, axis, scale) in enumerate(zip(places, axes, scales, strict=True)):
        parts.append(_line(place, _TOP + 14, place, _HEIGHT - _BOTTOM, "axis"))
        for value, text in scale.ends():
            above = scale(value) < _HEIGHT / 2
            parts.append(_text(place, scale(value) + (-6 if above else 16), text, "middle"))
        drop = 34 if i % 2 == 0 else 48
        parts.append(_text(place, _HEIGHT - _BOTTOM + drop, axis.label, "middle"))
    for i in _order(len(texts), chosen, second):
        points = " L".join(
            f"{place:.1f} {scale(axis.values[i]):.1f}"
            for place, axis, scale in zip(places, axes, scales, strict=True)
        )
        parts.append(_mark("path", f'd="M{points}"', i, texts[i], chosen, second))
    return _svg(parts, "Objectives of every design of the front")


class _Scale:
    """From values to places; a little more than they span goes to `start` to `end`."""

    def __init__(self, values: Sequence[np.ndarray], start: float, end: float):
        every = np.concatenate([np.asarray(x, float) for x in values])
        every = every[np.isfinite(every)]
        low, high = (float(every.min()), float(every.max())) if every.size else (0.0, 1.0)
        self.least, self.most, self.start, self.end = low, high, start, end
        if low == high:
            low, high = low - 0.5 * (abs(low) or 1.0), high + 0.5 * (abs(high) or 1.0)
        pad = 0.03 * (high - low)
        self.low, self.high = low - pad, high + pad

    def __call__(self, value: float) -> float:
        return self.start + (value - self.low) / (self.high - self.low) * (self.end - self.start)

    def ticks(self) -> list[tuple[float, str]]:
        rough = (self.high - self.low) / _TICKS
        power = 10.0 ** np.floor(np.log10(rough))
        step = next(m * power for m in (1, 2, 5, 10) if m * power >= rough)
        first = np.ceil(self.low / step)
        count = int(np.floor((self.high - first * step) / step)) + 1
        return [(step * (first + i), f"{step * (first + i):.6g}") for i in range(count)]

    def ends(self) -> list[tuple[float, str]]:
        return [(x, figures(x)) for x in sorted({self.least, self.most})]


def _order(count: int, chosen: int | None, second: int | None) -> list[int]:
    """What is emphasized last, above the others."""
    return sorted(range(count), key=lambda i: (i == chosen, i == second))


def _mark(
    kind: str, shape: str, place: int, text: str, chosen: int | None, second: int | None
) -> str:
    names = " ".join(["mark", *["chosen"] * (place == chosen), *["second"] * (place == second)])
    told = escape(text, quote=True)
    return (
        f'<{kind} class="{names}" data-place="{place}" data-text="{told}" {shape}>'
        f"<title>{told}</title></{kind}>"
    )


def _line(x1: float, y1: float, x2: float, y2: float, kind: str) -> str:
    return f'<line class="{kind}" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"/>'


def _text(x: float, y: float, text: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(text)}</text>'


def _svg(parts: Sequence[str], title: str) -> str:
    return (
        f'<svg class="plot" viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}" role="img"'
        f' aria-label="{escape(title, quote=True)}">{"".join(parts)}</svg>'
    )


def scaled(values: Mapping[str, np.ndarray], name: str, unit: str) -> Axis:
    """An objective as an axis in a unit that is handy to read.

    **Arguments:**

    - `values`: of all marks by name [SI].
    - `name`: which [-].
    - `unit`: its own [-].

    **Returns:** the axis [-].
    """
    shown, factor = {"m": ("mm", 1e3), "-": ("", 1.0)}.get(unit, (unit, 1.0))
    words = name.replace("_", " ")
    return Axis(f"{words} [{shown}]" if shown else words, factor * values[name])
