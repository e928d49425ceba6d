"""A fit beside the measurements: forces over strain, residuals, readings, profiles, strokes of
its hysteresis loops, and a comparison of laws.

Points are thinned to as many as print can hold; curves end where their readings do. Colors
go with pressure, dark at low pressures. A clipped reading is a hollow triangle that points
down: the force was not above it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from textwrap import fill
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ..records.record import DOWN
from .theme import (
    BLACK,
    BLUE,
    CYCLE,
    DOUBLE,
    GRAY,
    SINGLE,
    VERMILION,
    WHITE,
    force_strain_axes,
    in_kilopascals,
    letters,
    new_figure,
    new_panels,
    pressure_colors,
    styled,
)


_POINTS = 40  # of one level of pressure: more touch one another
_RESIDUALS = 2000  # of all levels: outliers matter, and a page holds them
_CURVES = 25  # levels with a curve; a swept pressure has hundreds
_CROWDED, _BANDS = 9, 5  # levels from which on bands lie on one another, and bands drawn then
_TICKS = 14  # more levels than this get round numbers at the color bar
_BINS = 16  # of strain, of pressure or time, for means of residuals
_CRITICAL = 2.705543454095404  # 90 % of a squared normal deviate
_TOP, _BAR = 8.0, -0.55  # of a profile's panel; height of the interval by the covariance
_DECADES = 20.0  # largest over least value of a profile, from which the axis is logarithmic
_RESISTS = -0.005  # of the largest force: a push that is more than a zero's error
_DASHED, _DOTTED = (0, (4, 2)), (0, (1, 1.5))
_LAWS = 6  # with a color of their own: more would look alike
_LABEL = 48  # characters of a law's name in a line of the legend
_MARKS = 25  # of a stroke: more touch one another
_DASHES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1, 1.2)))
_BLACK_DOTS: dict[str, Any] = {"linestyle": "", "marker": "o", "markersize": 2.8, "color": BLACK}
_COLORS = ListedColormap(pressure_colors(256))
_MEASURED: dict[str, Any] = {"linestyle": "", "marker": "o", "markersize": 2.6,
                             "markeredgewidth": 0, "alpha": 0.8}  # fmt: skip
_CLIPPED: dict[str, Any] = {"linestyle": "", "marker": "v", "markersize": 4.2,
                            "markeredgewidth": 0.8, "markerfacecolor": "none"}  # fmt: skip
_BACK: dict[str, Any] = {**_MEASURED, "markersize": 2.8, "markeredgewidth": 0.7,
                         "markerfacecolor": "none"}  # fmt: skip
_DOTS: dict[str, Any] = {"linestyle": "", "marker": "o", "markersize": 2.4, "markeredgewidth": 0,
                         "alpha": 0.75}  # fmt: skip
_LIMIT: dict[str, Any] = {"color": VERMILION, "linewidth": 0.9, "linestyle": _DASHED}


@dataclass(frozen=True, eq=False)
class FitPlot:
    """Readings by level of pressure, and the fitted muscle's curve at each level.

    - `pressure`: of each level [Pa], rising.
    - `strain`, `force`: of the readings [-], [N], a row for each level, filled up with NaN.
    - `censored`: readings that are only an upper bound.
    - `residual`: measured less fitted force [N]; NaN at clipped readings.
    - `noise`: standard deviation of a reading about the fit [N].
    - `curve_strain`, `curve_force`: the curves [-], [N], a row for each level.
    - `low`, `high`: ends of the band of readings [N], or `None`.
    - `label`: name of the curves.
    - `trends`: share of the residuals' squares [-] that a trend explains, by its axis.
    - `branch`, `time`: of the readings; 1, −1 or 0, and [s] or NaN; `None` if unknown.
    """

    pressure: np.ndarray
    strain: np.ndarray
    force: np.ndarray
    censored: np.ndarray
    residual: np.ndarray
    noise: float
    curve_strain: np.ndarray
    curve_force: np.ndarray
    low: np.ndarray | None = None
    high: np.ndarray | None = None
    label: str = "fitted"
    trends: Mapping[str, float] = field(default_factory=dict)
    branch: np.ndarray | None = None
    time: np.ndarray | None = None

    @property
    def measured(self) -> np.ndarray:
        """Forces of the readings that aren't clipped [N], else NaN."""
        return np.where(self.censored, np.nan, self.force)

    @property
    def resists(self) -> bool:
        """True if a push was measured."""
        return bool(np.nanmin(self.measured) < _RESISTS * np.nanmax(self.measured))


@dataclass(frozen=True, eq=False)
class ReadingsPlot:
    """Readings of blocked force and free strain by pressure, and the smooth curves.

    - `pressure`: of the readings [Pa].
    - `blocked_force`, `free_strain`: the readings [N], [-].
    - `blocked_force_error`, `free_strain_error`: half of their 90 % intervals [N], [-].
    - `curve_pressure`: of the curves [Pa].
    - `blocked_force_curve`, `free_strain_curve`: lowest, middle and largest [N], [-], rows.
    """

    pressure: np.ndarray
    blocked_force: np.ndarray
    blocked_force_error: np.ndarray
    free_strain: np.ndarray
    free_strain_error: np.ndarray
    curve_pressure: np.ndarray
    blocked_force_curve: np.ndarray
    free_strain_curve: np.ndarray


@dataclass(frozen=True, eq=False)
class ProfilePlot:
    """Profile of a parameter, in the unit that it is shown in.

    - `name`, `unit`: of the parameter.
    - `value`: fixed values [unit]. `rise`: of the squared deviations at each of them [-].
    - `estimate`: the fitted value [unit].
    - `low`, `high`: ends of its 90 % interval by the covariance [unit].
    - `crosses`: values at which the profile crosses 2.71 [unit], or infinity.
    - `identifiable`: true if the data determine it.
    """

    name: str
    unit: str
    value: np.ndarray
    rise: np.ndarray
    estimate: float
    low: float
    high: float
    crosses: tuple[float, float]
    identifiable: bool


@styled
def fit(data: FitPlot) -> Figure:
    """Figure of measured points and fitted curves over strain, with resistance enlarged."""
    if data.resists:
        figure, axes = new_figure(1, 2, DOUBLE, 0.45 * DOUBLE)
        letters(axes, ("all forces", "resistance, enlarged"))
    else:
        figure, axes = new_figure(width=0.72 * DOUBLE, height=0.48 * DOUBLE)
    for ax in axes[0]:
        _draw_fit(ax, data)
    low, high = float(np.nanmin(data.force)), float(np.nanmax(data.force))
    span = max(high - min(low, 0.0), 1e-9)  # N: forces may all be zero
    axes[0, 0].set_ylim(min(low, 0.0) - 0.06 * span, high + 0.06 * span)
    axes[0, 0].margins(x=0.02)
    if data.resists:  # forces up to a pull as large as the push
        push = -float(np.nanmin(data.measured))
        axes[0, 1].set_ylim(-1.15 * push, 0.6 * push)
        strain = data.strain[data.measured < 0.6 * push]
        margin = 0.03 * np.ptp(strain)
        axes[0, 1].set_xlim(np.min(strain) - margin, np.max(strain) + margin)
    _add_pressure_scale(figure, axes, data.pressure)
    handles: list[Any] = []
    for label, style, paint, mask in _marks(data):
        if np.any(mask & np.isfinite(data.force)):
            gray: dict[str, Any] = {**style, paint: GRAY, "label": label}
            handles.append(Line2D([], [], **gray))
    handles.append(Line2D([], [], color=GRAY, linewidth=1.0, label=data.label))
    if data.low is not None:
        handles.append(Patch(color=GRAY, alpha=0.3, linewidth=0, label="90 % of readings"))
    figure.legend(handles=handles, loc="outside lower center", ncols=5)
    return figure


def _marks(data: FitPlot) -> list[tuple[str, dict[str, Any], str, np.ndarray]]:
    """Label, style, name of the color, and mask of each kind of reading."""
    back = np.zeros(data.force.shape, bool) if data.branch is None else data.branch == DOWN
    both = np.any(back)
    return [
        (
            "contracting or inflating" if both else "measured",
            _MEASURED,
            "color",
            ~data.censored & ~back,
        ),
        ("extending or deflating", _BACK, "markeredgecolor", ~data.censored & back),
        ("clipped or no pull: not above it", _CLIPPED, "markeredgecolor", data.censored),
    ]


def _draw_fit(ax: Axes, data: FitPlot) -> None:
    """Draw points, fitted curves and bands of force over strain, a color for each pressure."""
    force_strain_axes(ax)
    norm, levels = _pressure_scale(data.pressure), data.pressure.size
    with_curve = _even_indices(levels, _CURVES)
    with_band = with_curve if levels < _CROWDED else _even_indices(levels, _BANDS)
    for i, pressure in enumerate(data.pressure):
        color = _COLORS(norm(pressure))
        for _, style, paint, mask in _marks(data):
            points = _subsample(
                np.flatnonzero(mask[i] & np.isfinite(data.force[i])), data.strain[i]
            )
            if points.size:  # an empty line costs as much to draw as a full one
                ax.plot(data.strain[i][points], data.force[i][points], **style, **{paint: color})
        strain = data.curve_strain[i]
        if data.low is not None and data.high is not None and i in with_band:
            ax.fill_between(strain, data.low[i], data.high[i], color=color, alpha=0.2, linewidth=0)
        if i in with_curve:
            ax.plot(strain, data.curve_force[i], color=color, linewidth=1.0)


def _even_indices(levels: int, count: int) -> set[int]:
    """Indices of at most `count` of the `levels`, evenly."""
    return set(np.linspace(0, levels - 1, min(levels, count)).round().astype(int).tolist())


@styled
def residuals(data: FitPlot) -> Figure:
    """Figure of residuals over strain and over pressure, and over time where it is known."""
    timed = data.time is not None and bool(np.any(np.isfinite(data.time)))
    count = 3 if timed else 2
    figure, axes = new_figure(1, count, DOUBLE, 0.4 * DOUBLE, sharey=True)
    P, norm = data.pressure, _pressure_scale(data.pressure)
    # readings of one level side by side in the order of their strain, as far as there is room
    room = 0.35 * np.min(np.diff(P), initial=0.1 * max(P[-1], 1.0))
    lowest = np.nanmin(data.strain)
    # readings may have a single strain
    span = max(np.nanmax(data.strain) - lowest, 1e-12)
    for i, pressure in enumerate(P):
        valid = np.flatnonzero(np.isfinite(data.residual[i]))
        points = _subsample(valid, data.strain[i], max(_POINTS, _RESIDUALS // P.size))
        strain = data.strain[i][points]
        columns = [strain, (pressure + room * (2 * (strain - lowest) / span - 1)) / 1e3]
        if timed and data.time is not None:
            columns.append(data.time[i][points])
        for ax, column in zip(axes[0], columns, strict=True):
            ax.plot(column, data.residual[i][points], color=_COLORS(norm(pressure)), **_DOTS)
    finite = np.isfinite(data.residual)
    for ax, values in zip(axes[0], (data.strain, np.broadcast_to(P[:, None] / 1e3, finite.shape),
                                    data.time), strict=False):  # fmt: skip
        if values is not None:
            _draw_means(ax, values[finite], data.residual[finite])
        ax.axhline(0, color=GRAY, linewidth=0.6, zorder=1)
        for side in (-2, 2):
            ax.axhline(side * data.noise, **_LIMIT, zorder=1)
    titles = (
        f"over {name}: {100 * data.trends[name]:.2g} % of squares"
        if name in data.trends else f"over {name}" for name in ("strain", "pressure", "time")
    )  # fmt: skip
    letters(axes, titles)
    labels = ("Contraction ε [–]", "Pressure P [kPa]", "Time t [s]")
    for ax, label in zip(axes[0], labels, strict=False):
        ax.set_xlabel(label)
    axes[0, 0].set_ylabel("Measured less fitted force [N]")
    reach = max(np.nanmax(np.abs(data.residual), initial=0.0), 2 * data.noise)
    axes[0, 0].set_ylim(-1.12 * reach, 1.12 * reach)
    _add_pressure_scale(figure, axes, P)
    handles = [
        Line2D([], [], color=GRAY, label="residual", linestyle="", marker="o", markersize=3),
        Line2D([], [], color=BLACK, linewidth=1.2, label="mean there"),
        Line2D([], [], label=f"± 2 σ, σ = {data.noise:.3g} N", **_LIMIT),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def _draw_means(ax: Axes, x: np.ndarray, residual: np.ndarray) -> None:
    """Draw means of residuals near each measured `x`, or in bins of it."""
    if x.size < 2 or not np.all(np.isfinite(x)) or not np.ptp(x) > 0:
        return
    edges = np.linspace(x.min(), x.max(), _BINS + 1)
    bins = np.clip(np.searchsorted(edges, x, "right") - 1, 0, _BINS - 1)
    half = 0.4 * (edges[1] - edges[0])
    for number in np.unique(bins):
        inside = bins == number
        middle = float(np.mean(x[inside]))
        ends = [middle - half, middle + half]
        ax.plot(ends, 2 * [residual[inside].mean()], color=BLACK, linewidth=1.2)


@styled
def readings(read: ReadingsPlot) -> Figure:
    """Figure of blocked force and free strain at each pressure, and the curves through them."""
    figure, axes = new_figure(1, 2, DOUBLE, 0.38 * DOUBLE)
    panels = (
        (read.blocked_force, read.blocked_force_error, read.blocked_force_curve,
         "Blocked force $F_b$ [N]"),
        (read.free_strain, read.free_strain_error, read.free_strain_curve,
         "Free strain $ε_f$ [–]"),
    )  # fmt: skip
    P = read.curve_pressure / 1e3
    for ax, (value, error, (low, middle, high), label) in zip(axes[0], panels, strict=True):
        ax.fill_between(P, low, high, color=BLUE, alpha=0.22, linewidth=0, label="curve, 90 %")
        ax.plot(P, middle, color=BLUE, label="smooth curve")
        ax.errorbar(
            read.pressure / 1e3, value, error, color=BLACK, linestyle="", marker="o",
            markersize=2.8, elinewidth=0.8, capsize=1.8, capthick=0.8, zorder=3,
            label="read at a pressure, 90 %",
        )  # fmt: skip
        ax.set(xlabel="Pressure P [kPa]", ylabel=label, xlim=(0, 1.03 * P[-1]))
        ax.set_ylim(bottom=min(0.0, float(np.min(value, initial=0.0))))
    letters(axes, ("blocked force", "free strain"))
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles[::-1], labels[::-1], loc="outside lower center", ncols=3)
    return figure


@styled
def profiles(profile_plots: Sequence[ProfilePlot]) -> Figure:
    """Figure of the profiles of at least one parameter, a panel each."""
    count = len(profile_plots)
    columns = 2 if count == 4 else min(count, 3)
    rows = -(-count // columns)
    width = SINGLE if columns == 1 else DOUBLE
    height = rows * 0.27 * DOUBLE + 0.25
    figure, axes = new_panels(count, columns, width, height, sharey=True)
    for ax, profile in zip(axes.flat, profile_plots, strict=False):
        _draw_profile(ax, profile)
    letters(axes, (profile.name.replace("_", " ") for profile in profile_plots))
    for ax in axes[:, 0]:
        ax.set_ylabel("Rise of squares Δ [–]")
    dot: dict[str, Any] = {"marker": "o", "markersize": 2.2}
    handles: list[Line2D | Patch] = []
    if any(profile.identifiable for profile in profile_plots):
        handles.append(Line2D([], [], color=BLUE, label="profile", **dot))
    if not all(profile.identifiable for profile in profile_plots):
        unidentifiable = {**dot, "color": VERMILION, "linestyle": _DASHED}
        handles.append(Line2D([], [], label="profile, unidentifiable", **unidentifiable))
    handles += [
        Line2D([], [], color=GRAY, linewidth=0.8, linestyle=_DOTTED, label="2.71"),
        Patch(color=GRAY, alpha=0.25, linewidth=0, label="90 % by profile"),
        Line2D([], [], color=BLACK, linewidth=1.2, marker="o", markersize=3.2,
               label="estimate, 90 % by covariance"),
    ]  # fmt: skip
    figure.legend(handles=handles, loc="outside lower center", ncols=count + 2)
    return figure


def _draw_profile(ax: Axes, profile: ProfilePlot) -> None:
    color = BLUE if profile.identifiable else VERMILION
    style = "-" if profile.identifiable else _DASHED
    order = np.argsort(profile.value, kind="stable")
    value, rise = profile.value[order], np.maximum(profile.rise[order], 0.0)
    ax.axhline(_CRITICAL, color=GRAY, linewidth=0.8, linestyle=_DOTTED)
    ax.axvspan(*np.clip(profile.crosses, value[0], value[-1]), color=color, alpha=0.12, linewidth=0)
    ax.plot(value, rise, color=color, linestyle=style, marker="o", markersize=2.2)
    # the interval may reach beyond the profile's last values
    ends = [max(profile.low, value[0]), min(profile.high, value[-1])]
    ax.plot(ends, 2 * [_BAR], color=BLACK, linewidth=1.2, marker="|", markersize=5)
    ax.plot([profile.estimate], [_BAR], color=BLACK, marker="o", markersize=3.2)
    if value[0] > 0 and value[-1] > _DECADES * value[0]:
        ax.set_xscale("log")
    ax.set_ylim(2 * _BAR, _TOP)
    ax.set_xlabel(f"[{profile.unit or '–'}]", labelpad=1)
    if not profile.identifiable:
        ax.text(
            0.5, 0.96, "unidentifiable", color=VERMILION, ha="center", va="top",
            transform=ax.transAxes, weight="bold",
            bbox={"facecolor": WHITE, "alpha": 0.85, "linewidth": 0, "pad": 1.5},
        )  # fmt: skip


def _pressure_scale(pressure: np.ndarray) -> Normalize:
    # never of zero width: one pressure alone is dark
    return Normalize(pressure[0], max(pressure[-1], pressure[0] + 1.0))


def _add_pressure_scale(figure: Figure, axes: np.ndarray, pressure: np.ndarray) -> None:
    """Add a color bar of the pressures [Pa], or a title for a single one."""
    if pressure.size == 1:
        axes.flat[0].set_title(f"P = {in_kilopascals(pressure[0])}", loc="right")
        return
    bar = figure.colorbar(
        ScalarMappable(_pressure_scale(pressure / 1e3), _COLORS), ax=list(axes.flat),
        label="Pressure P [kPa]", aspect=35, pad=0.015,
    )  # fmt: skip
    bar.outline.set_visible(False)
    if pressure.size <= _TICKS:
        bar.set_ticks(list(pressure / 1e3), labels=[f"{p / 1e3:.4g}" for p in pressure])


def _subsample(indices: np.ndarray, strain: np.ndarray, limit: int = _POINTS) -> np.ndarray:
    """At most `limit` of the `indices` of readings, evenly by their `strain` [-]."""
    if indices.size <= limit:
        return indices
    ordered = indices[np.argsort(strain[indices], kind="stable")]
    return ordered[np.linspace(0, indices.size - 1, limit).round().astype(int)]


class Stroke(NamedTuple):
    """One stroke of a loop at a constant `level` [Pa] or [-].

    - `branch`: 1 contracting or inflating, −1 back.
    - `x`, `force`: strains [-] or pressures [Pa], and forces [N].
    """

    level: float
    branch: int
    x: np.ndarray
    force: np.ndarray


@dataclass(frozen=True, eq=False)
class LoopsPlot:
    """Loops of a record.

    - `kind`: the constant quantity of a loop, "pressure" or "strain".
    - `strokes`: a few loops.
    - `pressure`, `width`: mean width of the loops [N] at each pressure [Pa].
    - `fitted`: width of the fitted friction there [N], or `None`.
    """

    kind: str
    strokes: Sequence[Stroke]
    pressure: np.ndarray
    width: np.ndarray
    fitted: np.ndarray | None


@dataclass(frozen=True, eq=False)
class LawsPlot:
    """Laws compared at a few pressures.

    - `pressure`: of each panel [Pa].
    - `strain`, `force`, `censored`: of the readings [-], [N], a row for each panel.
    - `curve_strain`: of the curves [-], a row for each panel.
    - `laws`: label, error [N] and forces [N] of each law, the best first.
    """

    pressure: np.ndarray
    strain: np.ndarray
    force: np.ndarray
    censored: np.ndarray
    curve_strain: np.ndarray
    laws: Sequence[tuple[str, float, np.ndarray]]


@styled
def loops(data: LoopsPlot) -> Figure:
    """Figure of loops with both strokes, and of their width over pressure."""
    figure, axes = new_figure(1, 2, DOUBLE, 0.42 * DOUBLE)
    over, width = axes[0]
    levels = sorted({stroke.level for stroke in data.strokes})
    colors = dict(zip(levels, pressure_colors(len(levels)), strict=True))
    scale = 1.0 if data.kind == "pressure" else 1e3
    for stroke in data.strokes:
        contracting = stroke.branch > 0
        over.plot(
            stroke.x / scale, stroke.force, color=colors[stroke.level], marker="o", markersize=3,
            linewidth=0.9, linestyle="-" if contracting else _DASHED, markeredgewidth=0.7,
            markerfacecolor=colors[stroke.level] if contracting else WHITE,
            markevery=max(1, stroke.x.size // _MARKS),
        )  # fmt: skip
    force_strain_axes(over)
    isometric = data.kind == "strain"
    if isometric:
        over.set_xlabel("Pressure P [kPa]")
    width.plot(data.pressure / 1e3, data.width, **_BLACK_DOTS, label="mean width")
    if data.fitted is not None:
        width.plot(
            data.pressure / 1e3, data.fitted, color=BLUE, label="fitted friction, full width"
        )
    width.set(xlabel="Pressure P [kPa]", ylabel="Width of the loop [N]")
    width.set_ylim(bottom=min(0.0, float(np.min(data.width))))
    width.legend(loc="best")
    letters(axes, ("loops at one length each" if isometric else "loops at one pressure each",
                   "width of the loops"))  # fmt: skip
    stroke_names = ("inflating", "deflating") if isometric else ("contracting", "extending")
    handles = [
        Line2D([], [], color=GRAY, linewidth=0.9, marker="o", markersize=3, label=stroke_names[0]),
        Line2D([], [], color=GRAY, linewidth=0.9, marker="o", markersize=3, label=stroke_names[1],
               linestyle=_DASHED, markerfacecolor=WHITE),
        *(Line2D([], [], color=color, linewidth=2,
                 label=f"ε = {level:.3g}" if isometric else in_kilopascals(level))
          for level, color in colors.items()),
    ]  # fmt: skip
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    return figure


@styled
def laws(data: LawsPlot) -> Figure:
    """Figure of the readings and all laws' curves, a panel for each pressure."""
    count = data.pressure.size
    columns, rows = min(count, 3), -(-count // 3)
    best = data.laws[:_LAWS]
    height = rows * 0.27 * DOUBLE + 0.16 * len(best) + 0.4
    figure, axes = new_panels(count, columns, DOUBLE, height, sharex=True)
    for i, ax in enumerate(axes.flat[:count]):
        force_strain_axes(ax)
        for _, _, force in data.laws[_LAWS:]:
            ax.plot(data.curve_strain[i], force[i], color=GRAY, linewidth=0.5, alpha=0.6)
        for rank, (_, _, force) in reversed([*enumerate(best)]):
            ax.plot(data.curve_strain[i], force[i], color=CYCLE[rank], linewidth=1.1,
                    linestyle=_DASHES[rank % len(_DASHES)])  # fmt: skip
        for clipped, marker in ((False, "o"), (True, "v")):
            mask = np.isfinite(data.force[i]) & (data.censored[i] == clipped)
            ax.plot(data.strain[i][mask], data.force[i][mask], linestyle="", marker=marker,
                    color=BLACK, markersize=2.6, zorder=3,
                    markerfacecolor="none" if clipped else BLACK)  # fmt: skip
        # a law that is far off must not flatten the others
        low, high = float(np.nanmin(data.force[i])), float(np.nanmax(data.force[i]))
        margin = 0.25 * max(high - low, 1e-9)  # N: forces may all be equal
        ax.set_ylim(low - margin, high + margin)
        if i % columns:
            ax.set_ylabel("")
        if i + columns < count:
            ax.set_xlabel("")
    letters(axes, map(in_kilopascals, data.pressure))
    handles = [Line2D([], [], **_BLACK_DOTS, label="measured (▽: clipped)")]
    handles += [
        Line2D([], [], color=CYCLE[rank], linestyle=_DASHES[rank % len(_DASHES)],
               label=fill(f"{label}: {rmse:.3g} N", _LABEL))
        for rank, (label, rmse, _) in enumerate(best)
    ]  # fmt: skip
    if other_count := len(data.laws) - len(best):
        handles.append(Line2D([], [], color=GRAY, linewidth=0.5, label=f"{other_count} other laws"))
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return figure
