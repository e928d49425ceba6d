"""What tabs other than the muscle's share: drawn when looked at, and only if something changed."""

import html
from typing import Any, ClassVar

import numpy as np
import panel as pn

from ..bundle.plates import muscle_strain
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
from ..plot.theme import APART, FAR, LARGE, TEXT
from .muscle_curves import is_tuned
from .state import Session, View, changed
from .theme import NARROW, Look
from .widgets import Message, factor, in_units, shown


# of a bar for what lasts nobody knows how long
_BAR = """<style>
@keyframes to-and-fro { from { left: 0; } to { left: 70%; } }
.bar { position: relative; height: 8px; border-radius: var(--round); background: var(--line);
  overflow: hidden; margin: var(--near) 0; }
.bar div { position: absolute; width: 30%; height: 100%; background: var(--accent);
  animation: to-and-fro 1.2s ease-in-out infinite alternate; }
@media (prefers-reduced-motion: reduce) { .bar div { animation: none; width: 100%; } }
</style>"""


class Tab:
    """A tab that is drawn anew where one of its fields of the view changes."""

    name: ClassVar[str]
    fields: ClassVar[tuple[str, ...]]
    panel: Any

    def __init__(self, session: Session, look: Look):
        """**Arguments:** `session` [-]; `look`: the page's [-]."""
        self.session, self.look = session, look
        self.message = Message(self.name)
        self._stale = True
        session.watch(self._changed)

    def refresh(self) -> None:
        """Draw it, if anything that it shows has changed since it was drawn."""
        if self._stale:
            self._stale = False
            self.draw(self.session.view)

    def draw(self, view: View) -> None:
        """Show a `view` [-]."""
        raise NotImplementedError

    def moved(self, before: View, after: View) -> None:
        """Follow what is not among the fields: a slider."""

    def _changed(self, before: View, after: View) -> None:
        if changed(before, after, *self.fields):
            self._stale = True
        if after.tab != self.name:
            return
        if self._stale:
            self.refresh()
        else:
            self.moved(before, after)


def moving(what: str) -> str:
    """A bar [-] that moves while `what` [-] is done."""
    return f'{_BAR}<div class="bar" role="progressbar" aria-label="{what}"><div></div></div>'


def card(title: str, text: str, *more: Any) -> Any:
    """A framed panel [-] where a picture will be: a `title` and a `text` [-], and `more` [-]."""
    told = (
        f'<h2 style="font-size:{LARGE}px;margin:0 0 var(--apart)">{title}</h2>'
        f'<p style="margin:0;font-size:{TEXT}px">{text}</p>'
    )
    framed = {"border": "2px dashed var(--line)", "border-radius": "var(--round)",
              "padding": "var(--wide)", "max-width": "640px"}  # fmt: skip
    return pn.Column(
        pn.pane.HTML(told, sizing_mode="stretch_width"), *more,
        styles=framed, sizing_mode="stretch_width", align="center", margin=(FAR, APART),
        stylesheets=[NARROW],
    )  # fmt: skip


def remarks(view: View, tab: str) -> str:
    """What a reader must know of what a `tab` [-] shows of a `view` [-], doubts marked [-]."""
    marked = "border-left:3px solid var(--bad);padding-left:var(--apart);margin:var(--near) 0"
    told = (f'<p style="{marked}">{html.escape(one)}</p>' for one in doubts(view, tab))
    return "".join(told) + status(" ".join(notes(view, tab)))


def status(text: str) -> str:
    """A quiet line [-] that says what is going on [-]."""
    return f'<div role="status" style="font-size:13px;opacity:.8">{text}</div>' if text else ""


_FACTORS = {"youngs_modulus": "Young's modulus", "collapse_moment": "collapse moment",
            "hinge_stiffness": "hinge stiffness"}  # fmt: skip


def notes(view: View, tab: str) -> list[str]:
    """Remarks on what a tab shows.

    **Arguments:**

    - `view`: what is shown [-].
    - `tab`: which tab shows it [-].

    **Returns:** sentences [-]; none where the picture is all there is to say.
    """
    own = sum(unit.own is not None for unit in view.units)
    sized = any(unit.size != 1 for unit in view.units)
    said = []
    if tab == "muscle" and own:
        said.append(
            f"This is the muscle of unit 1. {_units(own)} of the bundle {_has(own)} of its own."
        )
    if tab == "reversal" and (own or sized):
        said.append("All units here are of unit 1's muscle, not of the bundle's several.")
    if tab == "reversal" and len({sum(split) for split in view.splits}) > 1:
        said.append(
            "These splits don't have equally many muscles: what differs is not their order alone."
        )
    if tab == "efficiency" and (own or sized):
        said.append(
            "On the right, unit 1's muscle alone is scaled to the section of the whole bundle."
        )
    scaled = (tab == "bundle" and sized) or tab == "efficiency"
    changed = tab == "muscle" and view.name.endswith(", changed")
    if (scaled or changed) and is_tuned(view.muscle):
        said.append(
            "The tuning was measured on a muscle of another size and is kept as it is: how far it"
            " holds for this one nobody has measured."
        )
    return said


def doubts(view: View, tab: str) -> list[str]:
    """Why what a tab shows may be wrong: constants of a muscle of another size, a fit at another
    length, pressures above those that were measured, a radius out of proportion to the length,
    muscles that the plates stretch.

    **Arguments:** those of `notes` [-].

    **Returns:** sentences [-], each once.
    """
    alone = tab in ("muscle", "reversal")
    muscles = [view.muscle] if alone else [view.muscle_of(unit) for unit in view.units]
    said = [
        told
        for one in muscles
        for told in (
            published_range_message(one),
            fitted_length_mismatch(one),
            one.tuning.extrapolation_message(view.supply),
            in_units(proportions_message(one.length, one.outer_radius), view.shown),
        )
    ]
    if not alone and view.distance is not None:
        said += [
            extension_message(
                muscle_strain(view.distance / one.length, 0.0), lowest_strain(*strain_domain(one))
            )
            for one in muscles
        ]
    if tab == "muscle":
        compared = (key.partition(":") for key in view.compared)
        laws = (TENSION_LAWS.get(name) for kind, _, name in compared if kind == "tension")
        said += [published_range_message(view.muscle, law) for law in laws if law]
    return [told[0].upper() + told[1:] for told in dict.fromkeys(said) if told]


def tuned(muscle: Muscle, unit: str) -> str:
    """With what a `muscle` [-] is tuned, pressures in a `unit` [-]; empty where it isn't."""
    if not is_tuned(muscle):
        return ""
    tuning, said = muscle.tuning, []
    for name, called in _FACTORS.items():
        by = float(getattr(tuning, f"{name}_factor"))
        rise = float(tuning.hinge_stiffness_slope) if name == "hinge_stiffness" else 0.0
        if by != 1 or rise:
            rises = f"({by:.4g} + {rise * factor(unit, 'pressure'):.3g} per {unit})"
            said.append(f"{called} × {rises if rise else f'{by:.4g}'}")
    # a fit writes down the muscle's own beside what it has fitted
    rate = muscle.transition_rate if tuning.transition_rate is None else tuning.transition_rate
    if float(rate) != float(muscle.transition_rate):
        said.append(f"transition rate β = {float(rate):.4g}")
    if (rows := tuning.pressures.shape[-1]) > 1:
        last = shown(float(tuning.pressures[-1]), unit, "pressure", 4)
        said.append(f"C₁ and C₂ in {rows} rows up to {last}")
    if tuning.dead_band:
        said.append(f"dead band {shown(float(tuning.dead_band), unit, 'pressure', 4)}")
    if not said:
        return ""
    return (
        f"This muscle is tuned: {', '.join(said)}. Choose `untuned` below"
        " Compare with to see it without."
    )


def equilibria(strain: np.ndarray, stable: np.ndarray) -> str:
    """Where a bundle rests.

    **Arguments:**

    - `strain`: strains of no force [-], rising.
    - `stable`: which of them it keeps [-].

    **Returns:** a phrase [-]: its free strain, and what else there is.
    """
    if not strain.size:
        return "none: it pulls at every strain"
    first, *others = (
        f"{at:.4f}{'' if kept else ' (not stable)'}"
        for at, kept in zip(strain, stable, strict=True)
    )
    return first + (f"; it also rests at {', '.join(others)}" if others else "")


def branches(strain: np.ndarray, several: np.ndarray) -> str:
    """Where other equilibria exist beside the drawn curve.

    **Arguments:**

    - `strain`: along the curve [-].
    - `several`: where there are several [-].

    **Returns:** a phrase [-]; empty where the curve is the only one.
    """
    there = strain[several]
    if not there.size:
        return ""
    return (
        f"ε {there[0]:.3f} to {there[-1]:.3f}; drawn is the one that is followed from the free"
        " strain"
    )


def _units(number: int) -> str:
    return "Another unit" if number == 1 else f"{number} other units"


def _has(number: int) -> str:
    return "has one" if number == 1 else "have muscles"
