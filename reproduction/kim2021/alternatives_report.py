"""The report's last part: what changes with other laws and readings, in figures and numbers."""

from collections.abc import Callable, Sequence
from html import escape

import numpy as np

from fascicle.reports.page import Page

from ..reproduced import Written
from . import setting
from .variants import VARIANTS, Variant, all_variants
from .variants import muscle as variant_muscle


_FIGURE_6 = [f"{P / 1e3:g}" for P in setting.PRESSURES[setting.FIGURE_6]]


def add_alternatives(
    page: Page, figures: Sequence[Written], add: Callable[[Page, Written], None]
) -> None:
    """Put the part on a page.

    **Arguments:**

    - `page`: where it goes [-].
    - `figures`: what was written [-].
    - `add`: puts one of them on the page [-].
    """
    page.heading("Other laws and readings", "alternatives")
    page.paragraph(
        "Where the paper can be read in several ways, or a law of another kind exists, fascicle "
        "offers them by name. Here they stand against the laws that every figure above uses."
    )
    page.links({one.record.title: f"#{one.record.key}" for one in figures})
    page.heading("Numbers", "numbers", 3)
    page.paragraph(
        f"Fig. 6's muscle, untuned: {setting.sizes(setting.muscle('figure_6'))}. Pressures in kPa; "
        "resistances within the tested range, which ends at the free strain at 413.7 kPa."
    )
    shown = all_variants()
    rows = [
        [escape(title), *(f"{tell(one)}" for one in shown.values())]
        for title, tell in _ROWS.items()
    ]
    page.table(("", *VARIANTS), rows)
    page.heading("What that means", level=3)
    page.points(_reading(shown))
    for one in figures:
        add(page, one)


def _collapses(one: Variant) -> str:
    chosen = one.collapse_strain[setting.FIGURE_6]
    return "<br>".join(
        f"{name}: {strain:.4f}" if np.isfinite(strain) else f"{name}: never"
        for name, strain in zip(_FIGURE_6, chosen, strict=True)
    )


def _as_paper(one: Variant) -> str:
    low, high = one.collapse_strain[setting.FIGURE_6[:2]], one.collapse_strain[setting.FIGURE_6[2:]]
    return _yes(bool(np.all(low < one.tested) and np.all(high > one.tested)))


def _peaks(one: Variant) -> str:
    pairs = zip(_FIGURE_6, setting.FIGURE_6, strict=True)
    return "<br>".join(f"{name}: {one.peak(row):.2f}" for name, row in pairs)


def _lasts(one: Variant) -> str:
    pairs = zip(_FIGURE_6, setting.FIGURE_6, strict=True)
    return "<br>".join(f"{name}: {one.last(row):.2f}" for name, row in pairs)


def _calm(one: Variant) -> str:
    muscle = variant_muscle(one.name)
    ratios = [
        setting.resistance_after(muscle, float(P), one.tested)
        for P in setting.PRESSURES[setting.FIGURE_12]
    ]
    worst = float(np.nanmax(ratios))
    return _yes(worst <= 1) + ("" if worst <= 1 else f", up to {worst:.3f} of it")


def _yes(condition: bool) -> str:
    return "yes" if condition else "no"


_ROWS: dict[str, Callable[[Variant], str]] = {
    "Collapse strain, by pressure": _collapses,
    "Collapses at 0 and 34.5 kPa, and not at 137.9 and 344.7, in the tested range": _as_paper,
    "Largest resistance, N": _peaks,
    "Resistance at the end of the range, N": _lasts,
    "Resistance after collapse never exceeds that at collapse (pressures of Fig. 12)": _calm,
    "Overlap of 1 + 1 below 344.7 kPa, N": lambda one: f"{one.overlap():.3f}",
    "Depth of the reversal, 1 + 1": lambda one: f"{one.depth((1, 1)):.4f}",
    "Depth of the reversal, 1 + 4": lambda one: f"{one.depth((1, 4)):.4f}",
}


def _reading(shown: dict[str, Variant]) -> list[str]:
    """What the numbers say, in words that hold whatever they are."""
    paper, elastica, wood, consistent, printed = shown.values()
    low = setting.FIGURE_6[1]
    number = sum(bool(c < wood.tested) for c in wood.collapse_strain[setting.FIGURE_12])
    as_printed = sum(bool(c < paper.tested) for c in paper.collapse_strain[setting.FIGURE_12])
    return [
        f"elastica: at 34.5 kPa the largest resistance is {elastica.peak(low):.2f} N against "
        f"{paper.peak(low):.2f} N, and the reversal of 1 + 4 is {elastica.depth((1, 4)):.4f} deep "
        f"against {paper.depth((1, 4)):.4f}. The muscle first shortens straight, then buckles at "
        "the load of a real column; the paper's law bends from the free strain on, and stiffens "
        "faster than an exact column as it bends.",
        f"wood1958: of Fig. 12's five pressures {number} collapse within the tested range against "
        f"{as_printed}; with the cube pressure stiffens the tube more, so collapse comes later.",
        f"The readings after collapse differ at large strain: at the end of the range and 34.5 kPa "
        f"{paper.last(low):.2f} N (derived), {consistent.last(low):.2f} N (consistent), "
        f"{printed.last(low):.2f} N (printed). Up to the collapse all three are the same.",
    ]
