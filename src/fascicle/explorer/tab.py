"""Base of the tabs, and the remarks that stand beside their pictures.

A tab is drawn when it is looked at, and only if something that it shows has changed.
"""

import html
from typing import Any, ClassVar

import numpy as np
import panel as pn

from ..bundle.pressurized import muscle_strain
from ..core.validation import proportions_message
from ..muscle import Muscle
from ..muscle.fitted_length import fitted_length_mismatch
from ..muscle.tension import TENSION_LAWS
from ..muscle.validation import (
    extension_message,
    lowest_strain,
    published_range_message,
    strain_domain,
)
from ..plot.theme import APART, FAR, LARGE, TEXT, Colors
from .muscle_curves import is_tuned
from .state import Session, View, changed
from .theme import NARROW
from .widgets import Message, format_quantity, message_in_units, status_line, unit_factor


_FACTORS = {"youngs_modulus": "Young's modulus", "collapse_moment": "collapse moment",
            "hinge_stiffness": "hinge stiffness"}  # fmt: skip
_PROGRESS = """<style>
@keyframes to-and-fro { from { left: 0; } to { left: 70%; } }
.bar { position: relative; height: 8px; border-radius: var(--round); background: var(--line);
  overflow: hidden; margin: var(--near) 0; }
.bar div { position: absolute; width: 30%; height: 100%; background: var(--accent);
  animation: to-and-fro 1.2s ease-in-out infinite alternate; }
@media (prefers-reduced-motion: reduce) { .bar div { animation: none; width: 100%; } }
</style>"""


class Tab:
    """A tab of the page: `panel` shows it, once it is drawn.

    `fields`: those of the view after whose change it is drawn anew; other changes it follows.
    """

    name: ClassVar[str]
    fields: ClassVar[tuple[str, ...]]
    panel: Any
    message: Message

    def __init__(self, session: Session, colors: Colors):
        """**Arguments:** `session`: the visitor's; `colors`: the page's."""
        self.session, self.colors = session, colors
        self._drawn: View | None = None
        session.watch(lambda _, after: self.refresh() if after.tab == self.name else None)

    def refresh(self) -> None:
        """Draw the session's view, or follow what changed since it was drawn."""
        before, view = self._drawn, self.session.view
        if before is view:
            return
        self._drawn = view
        if before is None or changed(before, view, *self.fields):
            self.draw(view)
        else:
            self.follow(before, view)

    def draw(self, view: View) -> None:
        """Show a `view`."""
        raise NotImplementedError

    def follow(self, before: View, after: View) -> None:
        """Follow a change that is not among `fields`, such as a slider's."""


def progress_bar(label: str) -> str:
    """A bar in HTML that moves as long as it is shown, for work of unknown duration."""
    return f'{_PROGRESS}<div class="bar" role="progressbar" aria-label="{label}"><div></div></div>'


def card(title: str, text: str) -> Any:
    """A framed panel with a progress bar, in the place of a figure that is being computed."""
    content = (
        f'<h2 style="font-size:{LARGE}px;margin:0 0 var(--apart)">{title}</h2>'
        f'<p style="margin:0;font-size:{TEXT}px">{text}</p>{progress_bar(title)}'
    )
    frame = {"border": "2px dashed var(--line)", "border-radius": "var(--round)",
             "padding": "var(--wide)", "max-width": "640px"}  # fmt: skip
    return pn.pane.HTML(
        content, styles=frame, sizing_mode="stretch_width", align="center", margin=(FAR, APART),
        stylesheets=[NARROW],
    )  # fmt: skip


def remarks_html(view: View, tab: str) -> str:
    """Validity warnings, marked, and notes on what a `tab` shows of a `view`."""
    style = "border-left:3px solid var(--bad);padding-left:var(--apart);margin:var(--near) 0"
    warnings = (
        f'<p style="{style}">{html.escape(text)}</p>' for text in validity_warnings(view, tab)
    )
    return "".join(warnings) + status_line(" ".join(notes(view, tab)))


def notes(view: View, tab: str) -> list[str]:
    """Sentences on what a `tab` shows of a `view`; none where the picture says it all."""
    several = sum(unit.own is not None for unit in view.units)
    sized = any(unit.size != 1 for unit in view.units)
    lines = []
    if tab == "muscle" and several:
        units = "Another unit" if several == 1 else f"{several} other units"
        has = "has one" if several == 1 else "have muscles"
        lines.append(f"This is the muscle of unit 1. {units} of the bundle {has} of its own.")
    if tab == "reversal" and (several or sized):
        lines.append("All units here are of unit 1's muscle, not of the bundle's several.")
    if tab == "reversal" and len({sum(split) for split in view.splits}) > 1:
        lines.append("These splits have different numbers of muscles, not only another order.")
    if tab == "efficiency" and (several or sized):
        lines.append(
            "On the right, unit 1's muscle alone is scaled to the section of the whole bundle."
        )
    scaled = (tab == "bundle" and sized) or tab == "efficiency"
    edited = tab == "muscle" and view.name.endswith(", changed")
    if (scaled or edited) and is_tuned(view.muscle):
        lines.append(
            "The tuning was measured on a muscle of another size and is used unchanged: nobody has"
            " measured how well it holds for this one."
        )
    return lines


def validity_warnings(view: View, tab: str) -> list[str]:
    """Reasons why what a `tab` shows of a `view` may be wrong, each once.

    Constants of a muscle of another size, a fit at another length, pressures above those that were
    measured, a radius out of proportion to the length, muscles that the plates stretch.
    """
    single = tab in ("muscle", "reversal")
    muscles = [view.muscle] if single else [view.muscle_of(unit) for unit in view.units]
    lines = [
        line
        for muscle in muscles
        for line in (
            published_range_message(muscle),
            fitted_length_mismatch(muscle),
            muscle.tuning.extrapolation_message(view.supply),
            message_in_units(proportions_message(muscle.length, muscle.outer_radius), view.shown),
        )
    ]
    if not single and view.distance is not None:
        for muscle in muscles:
            strain = muscle_strain(view.distance / muscle.length, 0.0)
            lines.append(extension_message(strain, lowest_strain(*strain_domain(muscle))))
    if tab == "muscle":
        keys = (key.partition(":") for key in view.compared)
        laws = (TENSION_LAWS.get(name) for kind, _, name in keys if kind == "tension")
        lines += [published_range_message(view.muscle, law) for law in laws if law]
    return [line[0].upper() + line[1:] for line in dict.fromkeys(lines) if line]


def tuning_note(muscle: Muscle, unit: str) -> str:
    """Sentence on the tuning of a `muscle`, pressures in a `unit`; empty where it has none."""
    if not is_tuned(muscle):
        return ""
    tuning, parts = muscle.tuning, []
    for name, label in _FACTORS.items():
        factor = float(getattr(tuning, f"{name}_factor"))
        slope = float(tuning.hinge_stiffness_slope) if name == "hinge_stiffness" else 0.0
        rising = f"({factor:.4g} + {slope * unit_factor(unit, 'pressure'):.3g} per {unit})"
        if factor != 1 or slope:
            parts.append(f"{label} × {rising if slope else f'{factor:.4g}'}")
    # a fit writes the muscle's rate into its tuning beside what it has fitted
    rate = muscle.transition_rate if tuning.transition_rate is None else tuning.transition_rate
    if float(rate) != float(muscle.transition_rate):
        parts.append(f"transition rate β = {float(rate):.4g}")
    if (rows := tuning.pressures.shape[-1]) > 1:
        highest = format_quantity(float(tuning.pressures[-1]), unit, "pressure", 4)
        parts.append(f"C₁ and C₂ in {rows} rows up to {highest}")
    if tuning.dead_band:
        parts.append(f"dead band {format_quantity(float(tuning.dead_band), unit, 'pressure', 4)}")
    if not parts:
        return ""
    return (
        f"This muscle is tuned: {', '.join(parts)}. Choose `untuned` below"
        " Compare with to see it without."
    )


def equilibria_text(strain: np.ndarray, stable: np.ndarray) -> str:
    """Strains of equilibrium of a bundle without load.

    **Arguments:** `strain`: rising [-]; `stable`: whether each is stable.
    """
    if not strain.size:
        return "none: it pulls at every strain"
    first, *others = (
        f"{value:.4f}{'' if is_stable else ' (not stable)'}"
        for value, is_stable in zip(strain, stable, strict=True)
    )
    return first + (f"; it also rests at {', '.join(others)}" if others else "")


def branches_text(strain: np.ndarray, several: np.ndarray) -> str:
    """Range of strains with other equilibria beside the drawn curve; empty where there are none.

    **Arguments:** `strain`: along the curve [-]; `several`: where there are several equilibria.
    """
    there = strain[several]
    if not there.size:
        return ""
    return f"ε {there[0]:.3f} to {there[-1]:.3f}; the curve shows the branch from the free strain"
