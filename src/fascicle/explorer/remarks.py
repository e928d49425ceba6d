"""Texts beside the pictures: warnings that numbers may be wrong, notes, and words explained."""

from collections.abc import Mapping

import numpy as np

from ..bundle.pressurized import muscle_strain
from ..muscle import Muscle
from ..muscle.validation import (
    extension_message,
    fitted_length_mismatch,
    lowest_strain,
    proportions_message,
    published_range_message,
)
from .muscle_curves import is_tuned
from .state import View
from .texts import TEXTS
from .widgets import SIZES, status_line, text_html


def words_html(*words: str) -> str:
    """Explanations of `words`, folded until a visitor opens them."""
    return glossary_html("Explain the words", {word: TEXTS["words"][word] for word in words})


def glossary_html(title: str, meanings: Mapping[str, str]) -> str:
    """Words with their `meanings` under a `title`, folded until a visitor opens them."""
    entries = "".join(f"<dt>{word}</dt><dd>{text}</dd>" for word, text in meanings.items())
    return f"<details><summary>{title}</summary><dl>{entries}</dl></details>"


def remarks_html(view: View, tab: str, opened: Muscle | None = None) -> str:
    """Validity warnings, marked, and notes of a `tab` on a `view`; `opened`: the muscle that was
    opened, which the view's comes from.
    """
    lines = []
    unequal = sum(unit.own is not None for unit in view.units)
    if tab == "muscle" and unequal:
        lines.append(f"This is the muscle of unit 1; {unequal} of the others have their own.")
    resized = opened is not None and any(
        getattr(view.muscle, name) != getattr(opened, name) for name in SIZES
    )
    if tab == "muscle" and resized and is_tuned(view.muscle):
        lines.append(TEXTS["remarks"]["unmeasured_size"])
    warnings = [f'<p class="warning">{text_html(x)}</p>' for x in validity_warnings(view, tab)]
    return "".join(warnings) + status_line(" ".join(lines))


def validity_warnings(view: View, tab: str) -> list[str]:
    """Reasons why a `tab` with a `view` may be wrong, each once: constants of a muscle of another
    size, a fit at another length, pressures above those that were measured, a radius out of
    proportion to the length, muscles that the plates stretch.
    """
    units = [] if tab == "muscle" else view.units
    lines = []
    for muscle in [unit.own or view.muscle for unit in units] or [view.muscle]:
        lines += [
            published_range_message(muscle),
            fitted_length_mismatch(muscle),
            muscle.tuning.extrapolation_message(view.supply),
            proportions_message(muscle.length, muscle.outer_radius),
        ]
        if units and view.distance is not None:
            strain = muscle_strain(view.distance / muscle.length, 0.0)
            lines.append(extension_message(strain, lowest_strain(muscle.law)))
    return [line for line in dict.fromkeys(lines) if line]


def tuning_note(muscle: Muscle) -> str:
    """Sentence on the tuning of a `muscle`; empty where it has none."""
    return TEXTS["remarks"]["tuned"] if is_tuned(muscle) else ""


def equilibria_text(strain: np.ndarray, stable: np.ndarray) -> str:
    """Strains [-] of equilibrium of a bundle without load, rising, and which are `stable`."""
    if not strain.size:
        return "none: it pulls at every strain"
    first, *further = (
        f"{value:.4f}{'' if is_stable else ' (unstable)'}"
        for value, is_stable in zip(strain, stable, strict=True)
    )
    return first + (f"; it also rests at {', '.join(further)}" if further else "")


def branches_text(strain: np.ndarray, several: np.ndarray) -> str:
    """Range of strains [-] with `several` equilibria; empty where there are none."""
    inside = strain[several]
    if not inside.size:
        return ""
    return f"ε {inside[0]:.3f} to {inside[-1]:.3f}; the curve shows the branch from the free strain"
