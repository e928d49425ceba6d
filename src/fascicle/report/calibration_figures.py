"""Figures of a calibration: forces over strain, residuals, loops, readings, profiles and laws.

Points are thinned to as many as print can hold; curves end where their readings do. Colors go with
pressure, dark at low pressures. A clipped reading is a hollow triangle that points down: the force
was not above it.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from scipy.special import stdtrit

from ..calibrate.calibration import Calibration, Profile
from ..calibrate.comparison import LawComparison
from ..calibrate.data import Grid, fit_table
from ..calibrate.gauges import strain_scale
from ..calibrate.least_squares import NORMAL
from ..calibrate.readings import (
    NO_PRESSURE,
    Readings,
    invert_force,
    static_force,
    tension_force,
    without_tuning,
)
from ..core.validation import HIGHEST_PRESSURE
from ..muscle import Muscle
from ..plot import theme
from ..plot.theme import BLACK, BLUE, CYCLE, DOUBLE, GRAY, SINGLE, VERMILION, WHITE, styled
from ..records.record import DOWN, UNKNOWN, Record
from ..records.segmentation import runs
from ..units import DIMENSIONS


_POINTS, _ROWS = 161, 41  # of a curve: kinks look sharp; in a file it is exact to a pixel
_MARKS, _RESIDUALS = 40, 2000  # of one level: more touch one another; of all: outliers matter
_CURVES = 25  # levels with a curve; a swept pressure has hundreds
_MANY = 20  # readings: the share of fewer is too coarse
_CROWDED, _BANDS = 9, 5  # levels from which on bands lie on one another, and bands drawn then
_TICKS = 14  # more levels than this get round numbers at the color bar
_BINS = 16  # of strain, of pressure or time, for means of residuals
_LOOPS = 5  # in one picture: more lie on one another
_SAME_LEVEL = 0.02  # of the range of levels: runs that share a level
_PANELS = 6  # pressures at which laws are compared in one picture
_TOP, _BAR = 8.0, -0.55  # of a profile's panel; height of the interval by the covariance
_DECADES = 20.0  # largest over least value of a profile, from which the axis is logarithmic
_RESISTS = -0.005  # of the largest force: a push that is more than a zero's error
_DASHED, _DOTTED = (0, (4, 2)), (0, (1, 1.5))
_LAWS, _LABEL = 6, 48  # laws with a color of their own; characters of a name in a legend's line
_DASHES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1, 1.2)))
_COLORS = ListedColormap(theme.pressure_colors(256))
_DOT: dict[str, Any] = {"linestyle": "", "marker": "o", "markersize": 2.6, "markeredgewidth": 0,
                        "alpha": 0.8}  # fmt: skip
_BACK: dict[str, Any] = {**_DOT, "markeredgewidth": 0.7, "markerfacecolor": "none"}
_CLIPPED: dict[str, Any] = {**_BACK, "marker": "v", "markersize": 4.2}
_BLACK_DOTS: dict[str, Any] = {"linestyle": "", "marker": "o", "markersize": 2.8, "color": BLACK}
_LIMIT: dict[str, Any] = {"color": VERMILION, "linewidth": 0.9, "linestyle": _DASHED}


@styled
def figures(
    calibration: Calibration,
    profiles: Sequence[Profile] = (),
    comparison: LawComparison | None = None,
) -> dict[str, Figure]:
    """Figures of a calibration by name: "fit", "residuals", then "loops", "readings", "profiles"
    and "laws" if any.
    """
    data, readings = fit_plot(calibration), calibration.readings
    panels = {
        "fit": draw_fit(data),
        "residuals": draw_residuals(data),
        "loops": draw_loops(calibration),
        "readings": None if readings is None else draw_readings(calibration.muscle, readings),
        "profiles": draw_profiles(calibration, profiles) if profiles else None,
        "laws": None if comparison is None else draw_laws(calibration, comparison),
    }
    drawn = {name: figure for name, figure in panels.items() if figure is not None}
    for figure in drawn.values():
        # a layout moves a little each time it is made: the files of one figure would differ
        if (layout := figure.get_layout_engine()) is not None:
            layout.execute(figure)
        figure.set_layout_engine(None)
    return drawn


@dataclass(frozen=True, eq=False)
class FitPlot:
    """Readings by level of pressure [Pa], and a muscle's curve at each level.

    - `strain`, `force`: of the readings [-], [N], a row for each level, filled up with NaN;
      `censored`: only an upper bound; `branch`, `time` [s]: `None` if unknown.
    - `residual`: measured less fitted force [N]; NaN at clipped readings.
    - `noise`: standard deviation of a reading about the fit [N].
    - `curve_strain`, `curve_force`: the curves [-], [N], a row for each level, and their `label`.
    - `half_width`: of the band of readings [N], or `None`.
    - `trends`: share of the residuals' squares [-] that a trend explains, by its axis.
    """

    pressure: np.ndarray
    strain: np.ndarray
    force: np.ndarray
    censored: np.ndarray
    residual: np.ndarray
    noise: float
    curve_strain: np.ndarray
    curve_force: np.ndarray
    half_width: np.ndarray | None = None
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


def fit_plot(calibration: Calibration, points: int = _POINTS) -> FitPlot:
    """Data of a fit's figure: curves of some `points`, and bands that hold 90 % of new readings."""
    grid, readings = calibration.grid, calibration.readings
    P = grid.pressure[:, 0]
    strain, force, curve = _plot_strains(calibration.observed, points)
    half_width = _reading_spread(calibration, curve)
    if readings is not None:
        # without readings at a pressure the curves' uncertainty there is meaningless
        half_width[~readings.valid & (NO_PRESSURE * P.max() < P)] = np.nan
    curve_force, data = _curve_forces(calibration, curve), calibration.fit_data
    trends = {trend.along: trend.share for trend in calibration.diagnosis.significant}
    return FitPlot(
        P, strain, force, grid.censored & grid.used, calibration.residual,
        calibration.problem.noise, curve, curve_force, half_width, trends=trends,
        branch=data.branch, time=data.time,
    )  # fmt: skip


def _reading_spread(calibration: Calibration, curve: np.ndarray) -> np.ndarray:
    """Half of the width [N] about the `curve` that holds 90 % of new readings, loops included: by
    the errors of a level's on one side of the free strain, of all on this side, or of all.
    """
    errors, level = np.abs(calibration.errors), calibration.fit_data.level
    ends = np.where(calibration.problem.pulls, np.inf, calibration.free_strain)
    past = calibration.record.strain * calibration.strain_scale > ends[level]
    past_curve = curve * calibration.strain_scale > ends[:, None]
    count, k = int(np.sum(np.isfinite(errors))), calibration.minimum.linear.slopes.shape[1]
    freedom = max(count - k, 1)
    by_noise = float(stdtrit(freedom, 0.95)) * calibration.rmse

    def width(mask: np.ndarray, otherwise: float) -> float:
        values = errors[mask & np.isfinite(errors)]
        # by ranks, so that one more reading lies inside with a probability of 90 %
        many = values.size >= _MANY
        return float(np.quantile(values, 0.9, method="weibull")) if many else otherwise

    spread = np.empty(curve.shape)
    for side in (False, True):
        usual = width(past == side, width(level >= 0, by_noise))
        rows = [width((past == side) & (level == row), usual) for row in range(len(curve))]
        spread = np.where(past_curve == side, np.array(rows)[:, None], spread)
    # a fit comes as much closer to its own readings as it stays further from new ones
    return spread * np.sqrt((count + k) / freedom)


def curves_csv(calibration: Calibration) -> str:
    """CSV of the fitted curves, with the band of 90 % of the readings; units in the headers."""
    data = fit_plot(calibration, _ROWS)
    pressure, force = np.repeat(data.pressure / 1e3, _ROWS), data.curve_force
    low, high = force - data.half_width, force + data.half_width
    columns = (pressure, *map(np.ravel, (data.curve_strain, force, low, high)))
    table = np.stack(columns, axis=1)
    rows = (",".join(f"{x:.6g}" for x in row) for row in table[np.isfinite(table[:, 2])])
    heads = "pressure [kPa],strain [-],force [N],low [N],high [N]"
    return "\n".join([heads, *rows]).replace("nan", "") + "\n"


def measured_with_curves(record: Record, muscle: Muscle, label: str = "the muscle") -> FitPlot:
    """Readings of a `record` with the curves of any `muscle`, and their `label`."""
    grid = fit_table(record).grid
    P = np.clip(grid.pressure, 0.0, HIGHEST_PRESSURE)
    strain, force, curve = _plot_strains(grid)
    scale = strain_scale(record, muscle)
    errors = force - np.asarray(muscle.force(P, np.where(grid.used, strain * scale, 0.0)))
    residual = np.where(grid.measured, errors, np.nan)
    curve_force = np.asarray(muscle.force(P, curve * scale))
    return FitPlot(
        P[:, 0], strain, force, grid.censored & grid.used, residual, float(np.nanstd(residual)),
        curve, curve_force, label=label,
    )  # fmt: skip


def _plot_strains(grid: Grid, points: int = _POINTS) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Strains [-] and forces [N] of a `grid`, NaN for padding, and strains of its curves [-]."""
    strain, force = (np.where(grid.used, values, np.nan) for values in (grid.strain, grid.force))
    low, high = np.nanmin(strain, axis=1), np.nanmax(strain, axis=1)
    return strain, force, np.linspace(low, high, points, axis=1)


def _curve_forces(calibration: Calibration, strain: np.ndarray) -> np.ndarray:
    """Forces [N] of the fitted muscle; without measured pushes, up to the free strain only."""
    # a corrected pressure may lie a little below zero
    muscle, P = calibration.muscle, np.maximum(calibration.grid.pressure, 0.0)
    strain = strain * calibration.strain_scale
    if not calibration.problem.pulls:
        return static_force(muscle, P, strain)
    force = tension_force(muscle, P, strain)
    # up to the first point past the free strain, so that the line meets the axis
    end = np.argmax(force < 0, axis=1)[:, None]
    past = (np.arange(force.shape[1]) > end) & np.any(force < 0, axis=1)[:, None]
    return np.where(past, np.nan, np.maximum(force, 0.0))


@styled
def draw_fit(data: FitPlot) -> Figure:
    """Figure of measured points and fitted curves over strain, with resistance enlarged."""
    if data.resists:
        figure, axes = theme.new_figure(1, 2, DOUBLE, 0.45 * DOUBLE)
        theme.letters(axes, ("all forces", "resistance, enlarged"))
    else:
        figure, axes = theme.new_figure(width=0.72 * DOUBLE, height=0.48 * DOUBLE)
    for ax in axes[0]:
        _draw_levels(ax, data)
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
    handles: list[Line2D | Patch] = [
        Line2D([], [], label=label, **{**style, paint: GRAY})
        for label, style, paint, mask in _marks(data)
        if np.any(mask & np.isfinite(data.force))
    ]
    handles.append(Line2D([], [], color=GRAY, linewidth=1.0, label=data.label))
    if data.half_width is not None:
        handles.append(Patch(color=GRAY, alpha=0.3, linewidth=0, label="90 % of readings"))
    figure.legend(handles=handles, loc="outside lower center", ncols=5)
    return figure


def _marks(data: FitPlot) -> list[tuple[str, dict[str, Any], str, np.ndarray]]:
    """Label, style, name of the color, and mask of each kind of reading."""
    back = np.zeros(data.force.shape, bool) if data.branch is None else data.branch == DOWN
    label = "contracting or inflating" if np.any(back) else "measured"
    edge = "markeredgecolor"
    return [
        (label, _DOT, "color", ~data.censored & ~back),
        ("extending or deflating", _BACK, edge, ~data.censored & back),
        ("clipped or no pull: not above it", _CLIPPED, edge, data.censored),
    ]


def _draw_levels(ax: Axes, data: FitPlot) -> None:
    """Draw points, fitted curves and bands of force over strain, a color for each pressure."""
    theme.force_strain_axes(ax)
    norm, levels = _pressure_norm(data.pressure), data.pressure.size
    with_curve = _even_indices(levels, _CURVES)
    with_band = with_curve if levels < _CROWDED else _even_indices(levels, _BANDS)
    for i, pressure in enumerate(data.pressure):
        color = _COLORS(norm(pressure))
        for _, style, paint, mask in _marks(data):
            valid = np.flatnonzero(mask[i] & np.isfinite(data.force[i]))
            points = _subsample(valid, data.strain[i])
            if points.size:  # an empty line costs as much to draw as a full one
                ax.plot(data.strain[i][points], data.force[i][points], **style, **{paint: color})
        strain, force = data.curve_strain[i], data.curve_force[i]
        if data.half_width is not None and i in with_band:
            low, high = force - data.half_width[i], force + data.half_width[i]
            ax.fill_between(strain, low, high, color=color, alpha=0.2, linewidth=0)
        if i in with_curve:
            ax.plot(strain, force, color=color, linewidth=1.0)


def _even_indices(levels: int, count: int) -> list[int]:
    """Indices of at most `count` of the `levels`, evenly."""
    return np.linspace(0, levels - 1, min(levels, count)).round().astype(int).tolist()


@styled
def draw_residuals(data: FitPlot) -> Figure:
    """Figure of residuals over strain and over pressure, and over time where it is known."""
    shape, P = data.residual.shape, data.pressure
    columns = {
        "strain": ("Contraction ε [–]", data.strain),
        "pressure": ("Pressure P [kPa]", np.broadcast_to(P[:, None] / 1e3, shape)),
    }
    if data.time is not None and np.any(np.isfinite(data.time)):
        columns["time"] = ("Time t [s]", data.time)
    figure, axes = theme.new_figure(1, len(columns), DOUBLE, 0.4 * DOUBLE, sharey=True)
    norm, finite = _pressure_norm(P), np.isfinite(data.residual)
    # readings of one level side by side in the order of their strain, as far as there is room
    room = 0.35 * np.min(np.diff(P), initial=0.1 * max(P[-1], 1.0)) / 1e3
    span = max(float(np.ptp(data.strain[np.isfinite(data.strain)])), 1e-12)  # one strain alone
    shift = room * (2 * (data.strain - np.nanmin(data.strain)) / span - 1)
    marks = max(_MARKS, _RESIDUALS // P.size)
    for ax, (name, (label, values)) in zip(axes[0], columns.items(), strict=True):
        x = values + shift if name == "pressure" else values
        for i, pressure in enumerate(P):
            points = _subsample(np.flatnonzero(finite[i]), data.strain[i], marks)
            ax.plot(x[i][points], data.residual[i][points], **_DOT, color=_COLORS(norm(pressure)))
        _draw_means(ax, values[finite], data.residual[finite])
        ax.axhline(0, color=GRAY, linewidth=0.6, zorder=1)
        for side in (-2, 2):
            ax.axhline(side * data.noise, **_LIMIT, zorder=1)
        ax.set_xlabel(label)
    shares = {name: f": {100 * share:.2g} % of squares" for name, share in data.trends.items()}
    theme.letters(axes, (f"over {name}{shares.get(name, '')}" for name in columns))
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
    """Draw means of residuals in bins of `x`."""
    if x.size < 2 or not np.all(np.isfinite(x)) or not np.ptp(x) > 0:
        return
    edges = np.linspace(x.min(), x.max(), _BINS + 1)
    bins = np.clip(np.searchsorted(edges, x, "right") - 1, 0, _BINS - 1)
    half = 0.4 * (edges[1] - edges[0])
    for number in np.unique(bins):
        middle, mean = np.mean(x[bins == number]), np.mean(residual[bins == number])
        ax.plot([middle - half, middle + half], [mean, mean], color=BLACK, linewidth=1.2)


@styled
def draw_readings(muscle: Muscle, readings: Readings) -> Figure:
    """Figure of blocked force and free strain at each pressure, and the curves through them."""
    good, mean, C = readings.valid, readings.coefficients, readings.covariance
    top = float(np.max(readings.pressure))
    P = np.linspace(1.2 * NO_PRESSURE, 1, _POINTS) * top
    # both curves are linear in their coefficients
    free = invert_force(without_tuning(muscle), P, np.zeros(P.shape))
    shape, line = np.zeros((P.size, mean.size)), np.zeros((P.size, mean.size))
    shape[:, :-2] = free[:, None] * (P / top)[:, None] ** np.arange(mean.size - 2)
    line[:, -2], line[:, -1] = 1.0, P / top
    figure, axes = theme.new_figure(1, 2, DOUBLE, 0.38 * DOUBLE)
    panels = (
        ("Blocked force $F_b$ [N]", line, readings.blocked_force, readings.blocked_force_deviation),
        ("Free strain $ε_f$ [–]", shape, readings.free_strain, readings.free_strain_deviation),
    )
    bars = {"elinewidth": 0.8, "capsize": 1.8, "capthick": 0.8, "zorder": 3}
    for ax, (label, basis, values, deviation) in zip(axes[0], panels, strict=True):
        value, error, middle = values[good], NORMAL * deviation[good], basis @ mean
        half = NORMAL * np.sqrt(np.maximum(np.einsum("pi,ij,pj->p", basis, C, basis), 0))
        band = {"color": BLUE, "alpha": 0.22, "linewidth": 0, "label": "curve, 90 %"}
        ax.fill_between(P / 1e3, middle - half, middle + half, **band)
        ax.plot(P / 1e3, middle, color=BLUE, label="smooth curve")
        dots = {**_BLACK_DOTS, **bars, "label": "read at a pressure, 90 %"}
        ax.errorbar(readings.pressure[good] / 1e3, value, error, **dots)
        ax.set(xlabel="Pressure P [kPa]", ylabel=label, xlim=(0, 1.03 * P[-1] / 1e3))
        ax.set_ylim(bottom=min(0.0, float(np.min(value, initial=0.0))))
    theme.letters(axes, ("blocked force", "free strain"))
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles[::-1], labels[::-1], loc="outside lower center", ncols=3)
    return figure


@styled
def draw_profiles(calibration: Calibration, profiles: Sequence[Profile]) -> Figure:
    """Figure of the profiles of at least one parameter, a panel each."""
    estimates = {estimate.name: estimate for estimate in calibration.parameters}
    count = len(profiles)
    columns = 2 if count == 4 else min(count, 3)
    rows = -(-count // columns)
    width = SINGLE if columns == 1 else DOUBLE
    figure, axes = theme.new_panels(count, columns, width, rows * 0.27 * DOUBLE + 0.25, sharey=True)
    for ax, profile in zip(axes.flat, profiles, strict=False):
        estimate = estimates[profile.name]
        kind = DIMENSIONS[estimate.dimension]
        scale = float(kind.factors[kind.common])
        identifiable = estimate.identifiable
        color, dashes = (BLUE, "-") if identifiable else (VERMILION, _DASHED)
        order = np.argsort(profile.value, kind="stable")
        value, rise = profile.value[order] / scale, np.maximum(profile.rise[order], 0.0)
        ax.axhline(NORMAL**2, color=GRAY, linewidth=0.8, linestyle=_DOTTED)
        crosses = np.clip([profile.low / scale, profile.high / scale], value[0], value[-1])
        ax.axvspan(*crosses, color=color, alpha=0.12, linewidth=0)
        ax.plot(value, rise, color=color, linestyle=dashes, marker="o", markersize=2.2)
        # the interval may reach beyond the profile's last values
        ends = np.clip([estimate.low / scale, estimate.high / scale], value[0], value[-1])
        ax.plot(ends, 2 * [_BAR], color=BLACK, linewidth=1.2, marker="|", markersize=5)
        ax.plot([estimate.value / scale], [_BAR], color=BLACK, marker="o", markersize=3.2)
        if value[0] > 0 and value[-1] > _DECADES * value[0]:
            ax.set_xscale("log")
        ax.set_ylim(2 * _BAR, _TOP)
        ax.set_xlabel(f"[{kind.common or '–'}]", labelpad=1)
        if not identifiable:
            box = {"facecolor": WHITE, "alpha": 0.85, "linewidth": 0, "pad": 1.5}
            bold = {"color": VERMILION, "ha": "center", "va": "top", "weight": "bold"}
            ax.text(0.5, 0.96, "unidentifiable", transform=ax.transAxes, bbox=box, **bold)
    theme.letters(axes, (profile.name.replace("_", " ") for profile in profiles))
    for ax in axes[:, 0]:
        ax.set_ylabel("Rise of squares Δ [–]")
    estimate = {"linewidth": 1.2, "marker": "o", "label": "estimate, 90 % by covariance"}
    handles = [
        Line2D([], [], color=BLUE, label="profile", marker="o", markersize=2.2),
        Line2D([], [], color=GRAY, linewidth=0.8, linestyle=_DOTTED, label="2.71"),
        Patch(color=GRAY, alpha=0.25, linewidth=0, label="90 % by profile"),
        Line2D([], [], color=BLACK, markersize=3.2, **estimate),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=count + 2)
    return figure


@styled
def draw_loops(calibration: Calibration) -> Figure | None:
    """Figure of a few loops, and of their width over pressure; `None` without both strokes."""
    record, loop = calibration.record, calibration.loop
    strokes = [run for run in runs(record) if run.kind != "mixed" and run.branch != UNKNOWN]
    if loop is None or not strokes:
        return None
    kind = Counter(run.kind for run in strokes).most_common(1)[0][0]
    strokes = [run for run in strokes if run.kind == kind]
    isometric = kind == "strain"
    levels = np.unique([run.level for run in strokes])
    gap = _SAME_LEVEL * float(np.ptp(levels))
    groups = np.split(levels, np.flatnonzero(np.diff(levels) > gap) + 1)
    groups = [groups[i] for i in _even_indices(len(groups), _LOOPS)]
    figure, axes = theme.new_figure(1, 2, DOUBLE, 0.42 * DOUBLE)
    over, width = axes[0]

    def style(color: Any, contracting: bool) -> dict[str, Any]:
        line, face = ("-", color) if contracting else (_DASHED, WHITE)
        marks = {"marker": "o", "markersize": 3, "markeredgewidth": 0.7, "markerfacecolor": face}
        return {"color": color, "linewidth": 0.9, "linestyle": line, **marks}

    names = ("inflating", "deflating") if isometric else ("contracting", "extending")
    handles = [Line2D([], [], label=name, **style(GRAY, name == names[0])) for name in names]
    for group, color in zip(groups, theme.pressure_colors(len(groups)), strict=True):
        for run in (run for run in strokes if run.level in group):
            x = record.pressure[run.points] / 1e3 if isometric else record.strain[run.points]
            marks = max(1, x.size // 25)
            force = record.force[run.points]
            over.plot(x, force, markevery=marks, **style(color, run.branch != DOWN))
        mean = float(np.mean(group))
        label = f"ε = {mean:.3g}" if isometric else theme.in_kilopascals(mean)
        handles.append(Line2D([], [], color=color, linewidth=2, label=label))
    theme.force_strain_axes(over)
    if isometric:
        over.set_xlabel("Pressure P [kPa]")
    width.plot(loop.pressure / 1e3, loop.width, **_BLACK_DOTS, label="mean width")
    friction = calibration.friction
    if friction is not None and friction.law is not None:
        fitted = [2 * friction.half_width(P) for P in loop.pressure]
        width.plot(loop.pressure / 1e3, fitted, color=BLUE, label="fitted friction, full width")
    width.set(xlabel="Pressure P [kPa]", ylabel="Width of the loop [N]")
    width.set_ylim(bottom=min(0.0, float(np.min(loop.width))))
    width.legend(loc="best")
    fixed = "length" if isometric else "pressure"
    theme.letters(axes, (f"loops at one {fixed} each", "width of the loops"))
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    return figure


@styled
def draw_laws(calibration: Calibration, comparison: LawComparison) -> Figure:
    """Figure of the readings and all laws' curves, a panel for each of a few pressures."""
    grid = calibration.grid
    levels = np.flatnonzero(grid.measured.any(axis=1))
    levels = levels[_even_indices(levels.size, _PANELS)]
    strain, force, curve = _plot_strains(calibration.observed)
    rows = comparison.rows
    curves = [_curve_forces(comparison.fits[row.label], curve) for row in rows]
    count, best = levels.size, rows[:_LAWS]
    columns = min(count, 3)
    height = -(-count // 3) * 0.27 * DOUBLE + 0.16 * len(best) + 0.4
    figure, axes = theme.new_panels(count, columns, DOUBLE, height, sharex=True)
    styles = [
        {"color": color, "linestyle": _DASHES[rank % len(_DASHES)]}
        for rank, color in enumerate(CYCLE[: len(best)])
    ]
    faint: dict[str, Any] = {"color": GRAY, "linewidth": 0.5}
    for place, (level, ax) in enumerate(zip(levels, axes.flat, strict=False)):
        theme.force_strain_axes(ax)
        for rank, law in reversed([*enumerate(curves)]):
            style = styles[rank] if rank < _LAWS else {**faint, "alpha": 0.6}
            ax.plot(curve[level], law[level], **style)
        censored = grid.censored[level]
        for mask, style in ((~censored, _BLACK_DOTS), (censored, {**_CLIPPED, "color": BLACK})):
            points = mask & grid.used[level]
            ax.plot(strain[level][points], force[level][points], **style)
        # a law that is far off must not flatten the others
        low, high = float(np.nanmin(force[level])), float(np.nanmax(force[level]))
        margin = 0.25 * max(high - low, 1e-9)  # N: forces may all be equal
        ax.set_ylim(low - margin, high + margin)
        if place % columns:
            ax.set_ylabel("")
        if place + columns < count:
            ax.set_xlabel("")
    theme.letters(axes, map(theme.in_kilopascals, grid.pressure[levels, 0]))
    handles = [Line2D([], [], **_BLACK_DOTS, label="measured (▽: clipped)")]
    labels = [fill(f"{row.label}: {row.rmse:.3g} N", _LABEL) for row in best]
    handles += [Line2D([], [], label=x, **y) for x, y in zip(labels, styles, strict=True)]
    if others := len(rows) - len(best):
        handles.append(Line2D([], [], label=f"{others} other laws", **faint))
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return figure


def _pressure_norm(pressure: np.ndarray) -> Normalize:
    # never of zero width: one pressure alone is dark
    return Normalize(pressure[0], max(pressure[-1], pressure[0] + 1.0))


def _add_pressure_scale(figure: Figure, axes: np.ndarray, pressure: np.ndarray) -> None:
    """Add a color bar of the pressures [Pa], or a title for a single one."""
    if pressure.size == 1:
        axes.flat[0].set_title(f"P = {theme.in_kilopascals(pressure[0])}", loc="right")
        return
    scale = ScalarMappable(_pressure_norm(pressure / 1e3), _COLORS)
    bar = figure.colorbar(scale, ax=list(axes.flat), label="Pressure P [kPa]", aspect=35, pad=0.015)
    bar.outline.set_visible(False)
    if pressure.size <= _TICKS:
        bar.set_ticks(list(pressure / 1e3), labels=[f"{p / 1e3:.4g}" for p in pressure])


def _subsample(indices: np.ndarray, strain: np.ndarray, limit: int = _MARKS) -> np.ndarray:
    """At most `limit` of the `indices` of readings, evenly by their `strain` [-]."""
    if indices.size <= limit:
        return indices
    ordered = indices[np.argsort(strain[indices], kind="stable")]
    return ordered[np.linspace(0, indices.size - 1, limit).round().astype(int)]
