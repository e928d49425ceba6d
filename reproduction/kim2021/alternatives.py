"""Fig. 6's muscle under other laws and readings: three figures, and a table of numbers.

A bundle's force is a sum over its muscles, so one muscle's table, at pressures of unit 2 and
of unit 1, gives the workspace and the free strains of bundles of it, to the grid's resolution.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fascicle.muscle import Muscle
from fascicle.muscle.post_collapse import POST_COLLAPSE_LAWS
from fascicle.plot.theme import (
    BLACK,
    BLUE,
    DOUBLE,
    GRAY,
    GREEN,
    PURPLE,
    SKY,
    VERMILION,
    force_strain_axes,
    in_kilopascals,
    letter,
    new_figure,
    styled,
)
from fascicle.report.page import lines
from fascicle.results.labelled import Variable

from ..figures import PaperFigure
from . import setting


PAPER = "paper's laws"
VARIANTS: Mapping[str, tuple[str, dict]] = {  # by name: how it is called and drawn in figures
    PAPER: ("kim2021, derived (every reproduced figure)", {"color": BLACK, "linewidth": 1.8}),
    "resolved": ("springs in equilibrium [R19]", {"color": SKY, "linestyle": (0, (5, 1.5))}),
    "elastica": ("buckling: elastica", {"color": BLUE}),
    "wood1958": ("collapse: wood1958", {"color": VERMILION, "linestyle": (0, (4, 2))}),
    "consistent": ("after collapse: consistent", {"color": GREEN, "linestyle": (0, (6, 2))}),
    "printed": ("after collapse: printed", {"color": PURPLE, "linestyle": (0, (2, 1.5))}),
}
LEVELS = np.linspace(0.0, setting.UNIT_1, 121)  # Pa, of unit 2
_PRESSURES = np.r_[setting.PRESSURES, LEVELS]
_STRAIN = np.linspace(0.0, 0.3, 601)
_BUNDLES = ((1, 1), (1, 4))


@dataclass(frozen=True)
class Variant:
    """Forces [N] of one muscle: at `setting.PRESSURES` (`force`), at `LEVELS` (`throttled`)
    and at unit 1's pressure (`full`); strains [-] on the last axis. Collapse strains [-] at
    `setting.PRESSURES`, and the `tested` strain [-].
    """

    name: str
    muscle: Muscle
    strain: np.ndarray
    force: np.ndarray
    throttled: np.ndarray
    full: np.ndarray
    collapse_strain: np.ndarray
    tested: float

    def free_strain(self, counts: tuple[int, int]) -> np.ndarray:
        """Free strain [-] of two units of `counts` muscles, over unit 2's pressure."""
        total = counts[0] * self.full + counts[1] * self.throttled
        after = np.argmax(total < 0, axis=1)
        rows = np.arange(len(total))
        left, right = total[rows, after - 1], total[rows, after]
        step = self.strain[1] - self.strain[0]
        crossing = self.strain[after - 1] + step * left / (left - right)
        # where nothing is below zero, the last unit's own free strain is the bundle's
        return np.where(total.min(axis=1) < 0, crossing, np.nan)

    def depth(self, counts: tuple[int, int]) -> float:
        """Fall of that free strain before it turns [-]."""
        strain = self.free_strain(counts)
        return float(strain[0] - np.nanmin(strain))

    def overlap(self) -> float:
        """Area [N] that both states of 1 + 1 reach, force times strain."""
        first = np.maximum(self.full + self.throttled[0], 0.0)
        second = np.maximum((self.full + self.throttled).min(axis=0), 0.0)
        return float(np.trapezoid(np.maximum(first - second, 0.0), self.strain))

    def peak(self, row: int) -> float:
        """Largest resistance [N] at one of `setting.PRESSURES` within the tested range."""
        inside = float(-self.force[row, self.strain <= self.tested].min())
        return max(inside, self.last(row))

    def last(self, row: int) -> float:
        """Resistance [N] at the end of the tested range."""
        return float(-np.interp(self.tested, self.strain, self.force[row]))


@cache
def variant(name: str) -> Variant:
    """Table of one of the `VARIANTS`."""
    base = setting.muscle("figure_6")
    if name == "elastica":
        muscle = base.replace(buckling=name)
    else:
        with setting.reading("derived" if name == PAPER else name):
            muscle = setting.muscle("figure_6")
    force = np.asarray(muscle.force(_PRESSURES[:, None], _STRAIN))
    tested = setting.PRESSURES.size
    return Variant(
        name=name,
        muscle=muscle,
        strain=_STRAIN,
        force=force[:tested],
        throttled=force[tested:],
        full=force[int(np.argmin(np.abs(setting.PRESSURES - setting.UNIT_1)))],
        # laws after collapse don't move the collapse itself
        collapse_strain=setting.forces("figure_6").collapse_strain
        if name == PAPER or name in POST_COLLAPSE_LAWS
        else np.asarray(muscle.collapse_strain(setting.PRESSURES)),
        tested=setting.tested(base),  # the tension law is the same in all
    )


def buckling() -> PaperFigure:
    """Resolved springs, the elastica and Wood's moment beside the paper's laws, as in Fig. 6."""
    conditions = (
        f"Fig. 6's muscle: {setting.sizes(setting.muscle('figure_6'))}.",
        "springs in equilibrium: the joint of (13) to (16) resolved instead of projected. "
        "elastica: one energy, an axis that shortens and bends exactly, nothing fitted. "
        "wood1958: (17) with the cube on r₀/t₀, as in the work that it cites. Dotted: the end "
        "of the tested range.",
    )
    title = "Another buckling law, another collapse moment"
    names = (PAPER, "resolved", "elastica", "wood1958")
    return _forces("alternatives_buckling", title, conditions, names, setting.FIGURE_6)


def after_collapse() -> PaperFigure:
    """The three readings of (25), where the muscle collapses."""
    conditions = (
        "Fig. 6's muscle. The first term of (25) has the unit of a moment in the text that we "
        "read: derived is what (24) leads to, consistent follows from halves that keep their "
        "length, printed is the number as it stands.",
    )
    title = "Three readings of the force after collapse"
    names = (PAPER, "consistent", "printed")
    return _forces("alternatives_after_collapse", title, conditions, names, setting.FIGURE_6[:2])


def bundles() -> PaperFigure:
    """Free strain of two bundles against unit 2's pressure, all variants."""
    strains = {
        counts: {name: variant(name).free_strain(counts) for name in VARIANTS}
        for counts in _BUNDLES
    }
    data = {"pressure": Variable(("pressure",), LEVELS, "Pa", "motor unit 2's")}
    for counts, rows in strains.items():
        for name, row in rows.items():
            key = f"{_key(name)}_{counts[0]}_{counts[1]}"
            data[key] = Variable(("pressure",), row, "-", f"free strain, {name}")
    return PaperFigure(
        key="alternatives_bundles",
        title="Free strain of two bundles",
        conditions=(
            f"Fig. 6's muscle, untuned, as 1 + 1 and as 1 + 4; unit 1 at {setting.UNIT_1 / 1e3:g} "
            "kPa. From tables of force in steps of 0.0005 of strain.",
        ),
        data=data,
        draw=lambda: _draw_bundles(strains),
    )


def _forces(
    key: str, title: str, conditions: tuple[str, ...], names: Sequence[str], rows: list[int]
) -> PaperFigure:
    data = {
        "pressure": Variable(("pressure",), setting.PRESSURES, "Pa", "gauge pressure"),
        "strain": Variable(("strain",), _STRAIN, "-", "contraction"),
    }
    for name in names:
        force = variant(name).force
        data[f"force_{_key(name)}"] = Variable(("pressure", "strain"), force, "N", f"force, {name}")
        data[f"collapse_strain_{_key(name)}"] = Variable(
            ("pressure",), variant(name).collapse_strain, "-", f"collapse; inf: never, {name}"
        )
    return PaperFigure(key, title, conditions, data, draw=lambda: _draw(names, rows))


def _key(name: str) -> str:
    return name.replace(" ", "_").replace("'", "")


@styled
def _draw(names: Sequence[str], rows: list[int]) -> Figure:
    """Panels by pressure, a curve for each variant: what is past the free strain fills them."""
    lines = len(rows) // 2
    figure, axes = new_figure(lines, 2, DOUBLE, (0.72 if lines > 1 else 0.42) * DOUBLE)
    for ax, mark, row in zip(axes.flat, "abcd"[: len(rows)], rows, strict=True):
        force_strain_axes(ax)
        _plot(ax, {name: variant(name).force[row] for name in names}, _STRAIN)
        least = min(float(variant(name).force[row].min()) for name in names)
        ax.axvline(variant(PAPER).tested, color=GRAY, linewidth=0.8, linestyle=":")
        ax.set(xlim=(0.0, 0.3), ylim=(1.1 * least, -0.35 * least))
        letter(ax, mark, in_kilopascals(setting.PRESSURES[row]))
    for ax in axes[:, 1:].flat:
        ax.set_ylabel("")
    for ax in axes[:-1].flat:
        ax.set_xlabel("")
    _add_legend(figure, axes[0, 0])
    return figure


@styled
def _draw_bundles(strains: Mapping[tuple[int, int], Mapping[str, np.ndarray]]) -> Figure:
    """A panel for each bundle."""
    figure, axes = new_figure(1, 2, DOUBLE, 0.45 * DOUBLE, sharey=True)
    for ax, mark, (counts, rows) in zip(axes.flat, "ab", strains.items(), strict=True):
        _plot(ax, rows, LEVELS / 1e3)
        ax.set(xlabel="Pressure $P_2$ [kPa]", xlim=(0, LEVELS[-1] / 1e3))
        letter(ax, mark, f"{counts[0]} + {counts[1]}")
    axes[0, 0].set_ylabel("Free strain $ε_f$ [–]")
    _add_legend(figure, axes[0, 0])
    return figure


def _plot(ax: Axes, rows: Mapping[str, np.ndarray], x: np.ndarray) -> None:
    for name, row in rows.items():
        label, style = VARIANTS[name]
        ax.plot(x, row, label=label, **style)


def _add_legend(figure: Figure, ax: Axes) -> None:
    handles, labels = ax.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3)


FIGURES: tuple[Callable[[], PaperFigure], ...] = (buckling, after_collapse, bundles)
_NAMES = [f"{P / 1e3:g}" for P in setting.PRESSURES[setting.FIGURE_6]]  # kPa


def comparison() -> list[list[str]]:
    """Rows of the table that compares the variants: a heading, then an entry for each variant."""
    return [[title, *(entry(variant(name)) for name in VARIANTS)] for title, entry in _ROWS.items()]


def _by_pressure(number: Callable[[Variant, int], float], digits: int) -> Callable[[Variant], str]:
    def entry(variant: Variant) -> str:
        numbers = [number(variant, row) for row in setting.FIGURE_6]
        return lines(
            [
                f"{name}: {x:.{digits}f}" if np.isfinite(x) else f"{name}: never"
                for name, x in zip(_NAMES, numbers, strict=True)
            ]
        )

    return entry


def _at_collapse(variant: Variant) -> float:
    """Resistance [N] at collapse without pressure."""
    return -float(variant.muscle.force(0.0, float(variant.collapse_strain[0])))


def _collapses_as_paper(variant: Variant) -> str:
    low, high = np.split(variant.collapse_strain[setting.FIGURE_6], 2)
    return "yes" if np.all(low < variant.tested) and np.all(high > variant.tested) else "no"


def _never_more(variant: Variant) -> str:
    pressures = setting.PRESSURES[setting.FIGURE_12]
    ratios = [setting.resistance_after(variant.muscle, float(P), variant.tested) for P in pressures]
    worst = float(np.nanmax(ratios))
    return "yes" if worst <= 1 else f"no, up to {worst:.3f} of it"


_ROWS: dict[str, Callable[[Variant], str]] = {
    "Collapse strain, by pressure": _by_pressure(lambda v, row: v.collapse_strain[row], 4),
    "Collapses at 0 and 34.5 kPa, and not at 137.9 and 344.7, in the tested range":
        _collapses_as_paper,
    "Largest resistance, N": _by_pressure(Variant.peak, 2),
    "Resistance at the end of the range, N": _by_pressure(Variant.last, 2),
    "Resistance after collapse never exceeds that at collapse (pressures of Fig. 12)": _never_more,
    "Overlap of 1 + 1 below 344.7 kPa, N": lambda variant: f"{variant.overlap():.3f}",
    "Depth of the reversal, 1 + 1": lambda variant: f"{variant.depth((1, 1)):.4f}",
    "Depth of the reversal, 1 + 4": lambda variant: f"{variant.depth((1, 4)):.4f}",
}  # fmt: skip


def conclusions() -> list[str]:
    """Sentences on what the numbers say, true whatever they are."""
    paper, resolved, elastica, wood, consistent, printed = (variant(name) for name in VARIANTS)
    low = setting.FIGURE_6[1]
    by_wood, by_paper = (
        sum(bool(strain < v.tested) for strain in v.collapse_strain[setting.FIGURE_12])
        for v in (wood, paper)
    )
    return [
        f"Springs in equilibrium: without pressure the muscle pushes at collapse with "
        f"{_at_collapse(resolved):.2f} N instead of {_at_collapse(paper):.2f} N. It stays straight "
        "until nearly Euler's load, so the soft onset at the free strain is gone.",
        f"elastica: at 34.5 kPa the largest resistance is {elastica.peak(low):.2f} N against "
        f"{paper.peak(low):.2f} N, and the reversal of 1 + 4 is {elastica.depth((1, 4)):.4f} deep "
        f"against {paper.depth((1, 4)):.4f}. The muscle first shortens straight, then buckles at "
        "the load of a real column; the paper's law bends from the free strain on, and stiffens "
        "faster than an exact column as it bends.",
        f"wood1958: of Fig. 12's five pressures {by_wood} collapse within the tested range against "
        f"{by_paper}; with the cube pressure stiffens the tube more, so collapse comes later.",
        f"The readings after collapse differ at large strain: at the end of the range and 34.5 kPa "
        f"{paper.last(low):.2f} N (derived), {consistent.last(low):.2f} N (consistent), "
        f"{printed.last(low):.2f} N (printed). Up to the collapse all three are the same.",
    ]
