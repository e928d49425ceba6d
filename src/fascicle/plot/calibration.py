"""A fit beside what was measured: forces over strain, what is left of them, and readings.

Points are thinned to as many as print can hold; curves end where their readings do. Colors
go with pressure, dark where it is low. A clipped reading is a hollow triangle that points
down: the force was not above it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from .style import (
    BLACK,
    BLUE,
    DOUBLE,
    GRAY,
    SINGLE,
    VERMILION,
    force_strain_axes,
    letter,
    new_figure,
    pressure_colors,
    styled,
)
from .theme import WHITE


_POINTS = 40  # drawn of one level of pressure
_RESIDUALS = 2000  # drawn in all, where outliers matter
_CURVES = 25  # levels with a curve; a swept pressure has hundreds
_MANY = 9
_TICKS = 14  # more levels than this get round numbers beside the colors
_STRETCHES = 16  # of strain, in which residuals' means are drawn
CRITICAL = 2.705543454095404  # 90 % of a squared normal deviate
_TOP, _BAR = 8.0, -0.55  # of a profile's panel; where the interval by the covariance is drawn
_DECADES = 20.0  # largest over least value of a profile, from which the axis is logarithmic
_RESISTS = -0.005  # of the largest force: a push that is more than a zero's error


@dataclass(frozen=True, eq=False)
class Fitted:
    """Readings by level of pressure, and the fitted muscle's curve at each.

    - `pressure`: of each level [Pa], rising.
    - `strain`, `force`: of the readings [-], [N], a row for each level; NaN fills a row up.
    - `censored`: whether a reading only says "not above" [-].
    - `residual`: measured less fitted force [N]; NaN where clipped.
    - `noise`: standard deviation of a reading about the fit [N].
    - `curve_strain`, `curve_force`: the curves [-], [N], a row for each level.
    - `low`, `high`: ends of what a reading is expected between [N], or `None`.
    - `label`: what the curves are called [-].
    - `follows`: what residuals follow, and which share of their squares that explains [-].
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
    follows: Mapping[str, float] = field(default_factory=dict)

    @property
    def resists(self) -> bool:
        """Whether a push was measured [-]."""
        push, pull = np.nanmin(self._measured), np.nanmax(self._measured)
        return bool(push < _RESISTS * pull)

    @property
    def _measured(self) -> np.ndarray:
        return np.where(self.censored, np.nan, self.force)


@dataclass(frozen=True, eq=False)
class Read:
    """Blocked force and free strain as read at each pressure, and the smooth curves.

    - `pressure`: where they were read [Pa].
    - `blocked_force`, `free_strain`: what was read [N], [-].
    - `blocked_force_error`, `free_strain_error`: half of their 90 % intervals [N], [-].
    - `curve_pressure`: where the curves are drawn [Pa].
    - `blocked_force_curve`, `free_strain_curve`: least, middle and largest [N], [-], rows.
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
class Profiled:
    """A parameter's profile, in the unit that it is shown in.

    - `name`, `unit`: of the parameter [-].
    - `value`: where it was held [unit]. `rise`: of the squared deviations there [-].
    - `estimate`: the fitted value [unit].
    - `low`, `high`: ends of its 90 % interval by the covariance [unit].
    - `crosses`: where the profile crosses 2.71 [unit]; infinite where it doesn't.
    - `identifiable`: whether the data know it [-].
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


def figures(
    fitted: Fitted, read: Read | None = None, profiled: Sequence[Profiled] = ()
) -> dict[str, Figure]:
    """All figures of a calibration.

    **Arguments:**

    - `fitted`: readings and curves [-].
    - `read`: what was read at each pressure [-], or `None`.
    - `profiled`: profiles of its parameters [-].

    **Returns:** figures by name: "fit", "residuals", then "readings" and "profiles" if there
    are any [-].
    """
    panels = {"fit": fit(fitted), "residuals": residuals(fitted)}
    if read is not None:
        panels["readings"] = readings(read)
    if profiled:
        panels["profiles"] = profiles(profiled)
    for figure in panels.values():
        # a layout moves a little each time it is made: the files of one figure would differ
        figure.draw_without_rendering()
        figure.set_layout_engine("none")
    return panels


@styled
def fit(fitted: Fitted) -> Figure:
    """Measured points and fitted curves over strain; beside them, larger, what resists.

    **Arguments:** `fitted`: both [-].

    **Returns:** the figure [-].
    """
    if not fitted.resists:
        figure, axes = new_figure(width=0.72 * DOUBLE, height=0.48 * DOUBLE)
        _draw_fit(axes[0, 0], fitted)
        _limit(axes[0, 0], fitted)
    else:
        figure, axes = new_figure(1, 2, DOUBLE, 0.45 * DOUBLE)
        for ax in axes[0]:
            _draw_fit(ax, fitted)
        _limit(axes[0, 0], fitted)
        _zoom(axes[0, 1], fitted)
        letter(axes[0, 0], "a", "all forces")
        letter(axes[0, 1], "b", "resistance, enlarged")
    _pressure_bar(figure, axes, fitted.pressure)
    figure.legend(handles=_fit_legend(fitted), loc="outside lower center", ncols=4)
    return figure


@styled
def residuals(fitted: Fitted) -> Figure:
    """What the fit leaves, over strain and over pressure.

    **Arguments:** `fitted`: the residuals, with their noise [-].

    **Returns:** the figure [-].
    """
    figure, axes = new_figure(1, 2, DOUBLE, 0.4 * DOUBLE, sharey=True)
    over_strain, over_pressure = axes[0]
    P, norm = fitted.pressure, _norm(fitted.pressure)
    # readings of one level side by side in the order of their strain, as far as there is room
    room = 0.35 * np.min(np.diff(P), initial=0.1 * max(P[-1], 1.0))
    least, most = np.nanmin(fitted.strain), np.nanmax(fitted.strain)
    for i, pressure in enumerate(P):
        used = np.flatnonzero(np.isfinite(fitted.residual[i]))
        shown = _thinned(used, fitted.strain[i], max(_POINTS, _RESIDUALS // P.size))
        dots = {"color": _COLORS(norm(pressure)), "linestyle": "", "marker": "o",
                "markersize": 2.4, "markeredgewidth": 0, "alpha": 0.75}  # fmt: skip
        strain, left = fitted.strain[i][shown], fitted.residual[i][shown]
        over_strain.plot(strain, left, **dots)
        aside = room * (2 * (strain - least) / max(most - least, 1e-12) - 1)
        over_pressure.plot((pressure + aside) / 1e3, left, **dots)
        if used.size:
            wide = max(room, 0.008 * (P[-1] - P[0]))
            ends = np.array([pressure - wide, pressure + wide]) / 1e3
            over_pressure.plot(ends, 2 * [fitted.residual[i][used].mean()], color=BLACK,
                               linewidth=1.2, label="mean of the level")  # fmt: skip
    _strain_means(over_strain, fitted)
    titles = [_followed(fitted, name) for name in ("strain", "pressure")]
    for ax, mark, title in zip(axes[0], "ab", titles, strict=True):
        ax.axhline(0, color=GRAY, linewidth=0.6, zorder=1)
        for side in (-2, 2):
            ax.axhline(side * fitted.noise, color=VERMILION, linewidth=0.9,
                       linestyle=(0, (4, 2)), zorder=1, label="± 2 σ")  # fmt: skip
        letter(ax, mark, title)
    over_strain.set_xlabel("Contraction ε [–]")
    over_strain.set_ylabel("Measured less fitted force [N]")
    over_pressure.set_xlabel("Pressure P [kPa]")
    reach = max(np.nanmax(np.abs(fitted.residual), initial=0.0), 2 * fitted.noise)
    over_strain.set_ylim(-1.12 * reach, 1.12 * reach)
    _pressure_bar(figure, axes, P)
    figure.legend(
        handles=[
            Line2D([], [], color=GRAY, linestyle="", marker="o", markersize=3, label="residual"),
            Line2D([], [], color=BLACK, linewidth=1.2, label="mean there"),
            Line2D([], [], color=VERMILION, linewidth=0.9, linestyle=(0, (4, 2)),
                   label=f"± 2 σ, σ = {fitted.noise:.3g} N"),
        ],
        loc="outside lower center", ncols=3,
    )  # fmt: skip
    return figure


def _followed(fitted: Fitted, name: str) -> str:
    """A panel's title, with what residuals show along its axis."""
    if name not in fitted.follows:
        return f"over {name}"
    return f"over {name}: a trend, {100 * fitted.follows[name]:.2g} % of squares"


def _strain_means(ax: Axes, fitted: Fitted) -> None:
    """Means of residuals near each strain that was measured, or in stretches of it."""
    finite = np.isfinite(fitted.residual)
    strain, left = fitted.strain[finite], fitted.residual[finite]
    if strain.size < 2 or not np.ptp(strain) > 0:
        return
    edges = np.linspace(strain.min(), strain.max(), _STRETCHES + 1)
    place = np.clip(np.searchsorted(edges, strain, "right") - 1, 0, _STRETCHES - 1)
    half = 0.4 * (edges[1] - edges[0])
    for stretch in np.unique(place):
        inside = place == stretch
        ends = np.mean(strain[inside]) + np.array([-half, half])
        ax.plot(ends, 2 * [left[inside].mean()], color=BLACK, linewidth=1.2)


@styled
def readings(read: Read) -> Figure:
    """Blocked force and free strain at each pressure, and the curves through them.

    **Arguments:** `read`: both [-].

    **Returns:** the figure [-].
    """
    figure, axes = new_figure(1, 2, DOUBLE, 0.38 * DOUBLE)
    panels = (
        (read.blocked_force, read.blocked_force_error, read.blocked_force_curve,
         "Blocked force $F_b$ [N]"),
        (read.free_strain, read.free_strain_error, read.free_strain_curve,
         "Free strain $ε_f$ [–]"),
    )  # fmt: skip
    titles = ("blocked force", "free strain")
    for ax, mark, title, (value, error, (low, middle, high), label) in zip(
        axes[0], "ab", titles, panels, strict=True
    ):
        P = read.curve_pressure / 1e3
        ax.fill_between(P, low, high, color=BLUE, alpha=0.22, linewidth=0, label="curve, 90 %")
        ax.plot(P, middle, color=BLUE, label="smooth curve")
        ax.errorbar(
            read.pressure / 1e3, value, error, color=BLACK, linestyle="", marker="o",
            markersize=2.8, elinewidth=0.8, capsize=1.8, capthick=0.8, zorder=3,
            label="read at a pressure, 90 %",
        )  # fmt: skip
        ax.set_xlabel("Pressure P [kPa]")
        ax.set_ylabel(label)
        ax.set_xlim(0, 1.03 * P[-1])
        ax.set_ylim(bottom=min(0.0, float(np.min(value, initial=0.0))))
        letter(ax, mark, title)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles[::-1], labels[::-1], loc="outside lower center", ncols=3)
    return figure


_COLORS = ListedColormap(pressure_colors(256))


def _norm(pressure: np.ndarray) -> Normalize:
    # never of zero width: one pressure alone is dark
    return Normalize(pressure[0], max(pressure[-1], pressure[0] + 1.0))


def _pressure_bar(figure: Figure, axes: np.ndarray, pressure: np.ndarray) -> None:
    norm = Normalize(pressure[0] / 1e3, max(pressure[-1], pressure[0] + 1.0) / 1e3)
    bar = figure.colorbar(
        ScalarMappable(norm, _COLORS), ax=list(axes.flat), label="Pressure P [kPa]", aspect=35,
        pad=0.015,
    )  # fmt: skip
    bar.outline.set_visible(False)
    if pressure.size <= _TICKS:
        bar.set_ticks(list(pressure / 1e3), labels=[f"{p / 1e3:.4g}" for p in pressure])


def _draw_fit(ax: Axes, fitted: Fitted) -> None:
    force_strain_axes(ax)
    norm, levels = _norm(fitted.pressure), fitted.pressure.size
    with_curve = set(
        np.unique(np.linspace(0, levels - 1, min(levels, _CURVES)).round().astype(int))
    )
    for i, pressure in enumerate(fitted.pressure):
        color = _COLORS(norm(pressure))
        used = np.flatnonzero(np.isfinite(fitted.force[i]))
        for clipped, style in ((False, _MEASURED), (True, _CLIPPED)):
            shown = _thinned(used[fitted.censored[i][used] == clipped], fitted.strain[i])
            paint = {"markeredgecolor": color} if clipped else {"color": color}
            ax.plot(fitted.strain[i][shown], fitted.force[i][shown], **style, **paint)
        if i in with_curve:
            curve = fitted.curve_strain[i]
            if fitted.low is not None and fitted.high is not None:
                # bands of many levels lie on one another
                alpha = 0.22 if levels < _MANY else 0.11
                ax.fill_between(curve, fitted.low[i], fitted.high[i], color=color, alpha=alpha,
                                linewidth=0)  # fmt: skip
            ax.plot(curve, fitted.curve_force[i], color=color, linewidth=1.0)


_MEASURED: dict[str, Any] = {"linestyle": "", "marker": "o", "markersize": 2.6,
                             "markeredgewidth": 0, "alpha": 0.8}  # fmt: skip
_CLIPPED: dict[str, Any] = {"linestyle": "", "marker": "v", "markersize": 4.2,
                            "markeredgewidth": 0.8, "markerfacecolor": "none"}  # fmt: skip


def _fit_legend(fitted: Fitted) -> list[Any]:
    handles: list[Any] = [Line2D([], [], **{**_MEASURED, "color": GRAY}, label="measured")]
    if np.any(fitted.censored):
        label = "clipped: not above it"
        handles.append(Line2D([], [], **_CLIPPED, markeredgecolor=GRAY, label=label))
    handles.append(Line2D([], [], color=GRAY, linewidth=1.0, label=fitted.label))
    if fitted.low is not None:
        handles.append(Patch(color=GRAY, alpha=0.3, linewidth=0, label="90 % of readings"))
    return handles


def _limit(ax: Axes, fitted: Fitted) -> None:
    """Show what was measured, and of the curves what lies there."""
    low, high = (float(f(fitted.force)) for f in (np.nanmin, np.nanmax))
    span = max(high - min(low, 0.0), 1e-9)
    ax.set_ylim(min(low, 0.0) - 0.06 * span, high + 0.06 * span)
    ax.margins(x=0.02)


def _zoom(ax: Axes, fitted: Fitted) -> None:
    """Show forces up to as large a pull as the largest push."""
    measured = np.where(fitted.censored, np.nan, fitted.force)
    push = -float(np.nanmin(measured))
    ax.set_ylim(-1.15 * push, 0.6 * push)
    shown = fitted.strain[measured < 0.6 * push]
    least, most = float(np.min(shown)), float(np.max(shown))
    away = 0.03 * (most - least)
    ax.set_xlim(least - away, most + away)


def _thinned(places: np.ndarray, strain: np.ndarray, most: int = _POINTS) -> np.ndarray:
    """Of readings at `places` at most so many, evenly by their `strain` [-]."""
    if places.size <= most:
        return places
    ordered = places[np.argsort(strain[places], kind="stable")]
    return ordered[np.linspace(0, places.size - 1, most).round().astype(int)]


@styled
def profiles(profiled: Sequence[Profiled]) -> Figure:
    """The profile of each parameter, a panel each.

    **Arguments:** `profiled`: at least one [-].

    **Returns:** the figure [-].
    """
    columns = 2 if len(profiled) == 4 else min(len(profiled), 3)
    rows = -(-len(profiled) // columns)
    width = SINGLE if columns == 1 else DOUBLE
    figure, axes = new_figure(rows, columns, width, rows * 0.27 * DOUBLE + 0.25, sharey=True)
    for ax in axes.flat[len(profiled) :]:
        ax.set_visible(False)
    for i, (ax, profile) in enumerate(zip(axes.flat, profiled, strict=False)):
        _draw_profile(ax, profile)
        letter(ax, chr(ord("a") + i), profile.name.replace("_", " "))
        if i % columns == 0:
            ax.set_ylabel("Rise of squares Δ [–]")
    figure.legend(
        handles=_profile_legend(profiled), loc="outside lower center", ncols=len(profiled) + 2
    )
    return figure


def _draw_profile(ax: Axes, profile: Profiled) -> None:
    color = BLUE if profile.identifiable else VERMILION
    style = "-" if profile.identifiable else (0, (4, 2))
    order = np.argsort(profile.value, kind="stable")
    value, rise = profile.value[order], np.maximum(profile.rise[order], 0.0)
    ax.axhline(CRITICAL, color=GRAY, linewidth=0.8, linestyle=(0, (1, 1.5)))
    ends = [np.clip(x, value[0], value[-1]) for x in profile.crosses]
    ax.axvspan(ends[0], ends[1], color=color, alpha=0.12, linewidth=0)
    ax.plot(value, rise, color=color, linestyle=style, marker="o", markersize=2.2)
    # a value may lie outside of what was held, at the end of a step
    left, right = max(profile.low, value[0]), min(profile.high, value[-1])
    ax.plot([left, right], 2 * [_BAR], color=BLACK, linewidth=1.2, marker="|", markersize=5)
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


def _profile_legend(profiled: Sequence[Profiled]) -> list[Line2D | Patch]:
    handles: list[Line2D | Patch] = []
    if any(profile.identifiable for profile in profiled):
        handles.append(Line2D([], [], color=BLUE, marker="o", markersize=2.2, label="profile"))
    if not all(profile.identifiable for profile in profiled):
        handles.append(Line2D([], [], color=VERMILION, linestyle=(0, (4, 2)), marker="o",
                              markersize=2.2, label="profile, unidentifiable"))  # fmt: skip
    return [
        *handles,
        Line2D([], [], color=GRAY, linewidth=0.8, linestyle=(0, (1, 1.5)), label="2.71"),
        Patch(color=GRAY, alpha=0.25, linewidth=0, label="90 % by profile"),
        Line2D([], [], color=BLACK, linewidth=1.2, marker="o", markersize=3.2,
               label="estimate, 90 % by covariance"),
    ]  # fmt: skip
