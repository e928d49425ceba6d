"""What changes with other laws and readings: three figures of Fig. 6's muscle."""

from collections.abc import Callable, Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fascicle.plot.style import (
    BLACK,
    BLUE,
    DOUBLE,
    GRAY,
    GREEN,
    PURPLE,
    VERMILION,
    force_strain_axes,
    in_kilopascals,
    letter,
    new_figure,
    styled,
)
from fascicle.results.labelled import Variable

from ..reproduced import Record
from . import setting
from .variants import LEVELS, PAPER, Variant, all_variants, variant


_LINES = {
    PAPER: {"color": BLACK, "linewidth": 1.8},
    "elastica": {"color": BLUE},
    "wood1958": {"color": VERMILION, "linestyle": (0, (4, 2))},
    "consistent": {"color": GREEN, "linestyle": (0, (6, 2))},
    "printed": {"color": PURPLE, "linestyle": (0, (2, 1.5))},
}
_NAMES = {
    PAPER: "kim2021, derived (every reproduced figure)",
    "elastica": "buckling: elastica",
    "wood1958": "collapse: wood1958",
    "consistent": "after collapse: consistent",
    "printed": "after collapse: printed",
}
_BUNDLES = ((1, 1), (1, 4))


def buckling() -> Record:
    """The elastica and Wood's collapse moment beside the paper's laws, as in Fig. 6."""
    shown = {name: variant(name) for name in (PAPER, "elastica", "wood1958")}
    return Record(
        key="alternatives_buckling",
        title="Another buckling law, another collapse moment",
        conditions=(
            f"Fig. 6's muscle: {setting.sizes(setting.muscle('figure_6'))}.",
            "elastica: one energy, an axis that shortens and bends exactly, nothing fitted. "
            "wood1958: (17) with the cube on r₀/t₀, as in the work that it cites. Dotted: the end "
            "of the tested range.",
        ),
        data=_forces(shown),
        draw=lambda: _draw(shown, setting.FIGURE_6, 2),
    )


def after_collapse() -> Record:
    """The three readings of (25), where the muscle collapses."""
    shown = {name: variant(name) for name in (PAPER, "consistent", "printed")}
    return Record(
        key="alternatives_after_collapse",
        title="Three readings of the force after collapse",
        conditions=(
            "Fig. 6's muscle. The first term of (25) has the units of a moment in print: "
            "derived is what (24) leads to, consistent follows from halves that keep their length, "
            "printed is the number as it stands.",
        ),
        data=_forces(shown),
        draw=lambda: _draw(shown, setting.FIGURE_6[:2], 1),
    )


def bundles() -> Record:
    """Free strain of two bundles against unit 2's pressure, all variants."""
    shown = all_variants()
    strains = {
        counts: {name: one.free_strain(counts) for name, one in shown.items()}
        for counts in _BUNDLES
    }
    data = {"pressure": Variable(("pressure",), LEVELS, "Pa", "motor unit 2's")}
    for counts, rows in strains.items():
        for name, row in rows.items():
            key = f"{name.replace(' ', '_').replace(chr(39), '')}_{counts[0]}_{counts[1]}"
            data[key] = Variable(("pressure",), row, "-", f"free strain, {name}")
    return Record(
        key="alternatives_bundles",
        title="Free strain of two bundles",
        conditions=(
            f"Fig. 6's muscle, untuned, as 1 + 1 and as 1 + 4; unit 1 at {setting.UNIT_1 / 1e3:g} "
            "kPa. From tables of force in steps of 0.0005 of strain.",
        ),
        data=data,
        draw=lambda: _draw_bundles(strains),
    )


def _forces(shown: Mapping[str, Variant]) -> dict[str, Variable]:
    data = {
        "pressure": Variable(("pressure",), setting.PRESSURES, "Pa", "gauge pressure"),
        "strain": Variable(("strain",), variant(PAPER).strain, "-", "contraction"),
    }
    for name, one in shown.items():
        key = name.replace(" ", "_").replace("'", "")
        data[f"force_{key}"] = Variable(("pressure", "strain"), one.force, "N", f"force, {name}")
        data[f"collapse_strain_{key}"] = Variable(
            ("pressure",), one.collapse_strain, "-", f"collapse; inf: never, {name}"
        )
    return data


@styled
def _draw(shown: Mapping[str, Variant], rows: list[int], lines: int) -> Figure:
    """Panels by pressure, a curve for each variant: what is past the free strain fills them."""
    figure, axes = new_figure(lines, 2, DOUBLE, (0.72 if lines > 1 else 0.42) * DOUBLE)
    for ax, mark, row in zip(axes.flat, "abcd"[: len(rows)], rows, strict=True):
        force_strain_axes(ax)
        for name, one in shown.items():
            ax.plot(one.strain, one.force[row], label=_NAMES[name], **_LINES[name])
        least = min(float(one.force[row].min()) for one in shown.values())
        ax.axvline(variant(PAPER).tested, color=GRAY, linewidth=0.8, linestyle=":")
        ax.set(xlim=(0.0, 0.3), ylim=(1.1 * least, -0.35 * least))
        letter(ax, mark, in_kilopascals(setting.PRESSURES[row]))
    for ax in axes[:, 1:].flat:
        ax.set_ylabel("")
    for ax in axes[:-1].flat:
        ax.set_xlabel("")
    _legend(figure, axes[0, 0])
    return figure


@styled
def _draw_bundles(strains: Mapping[tuple[int, int], Mapping[str, np.ndarray]]) -> Figure:
    """A panel for each bundle."""
    figure, axes = new_figure(1, 2, DOUBLE, 0.45 * DOUBLE, sharey=True)
    for ax, mark, (counts, rows) in zip(axes.flat, "ab", strains.items(), strict=True):
        for name, row in rows.items():
            ax.plot(LEVELS / 1e3, row, label=_NAMES[name], **_LINES[name])
        ax.set(xlabel="Pressure $P_2$ [kPa]", xlim=(0, LEVELS[-1] / 1e3))
        letter(ax, mark, f"{counts[0]} + {counts[1]}")
    axes[0, 0].set_ylabel("Free strain $ε_f$ [–]")
    _legend(figure, axes[0, 0])
    return figure


def _legend(figure: Figure, ax: Axes) -> None:
    handles, labels = ax.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3)


RECORDS: tuple[Callable[[], Record], ...] = (buckling, after_collapse, bundles)
