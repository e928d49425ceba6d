"""What a reader must know of what a tab shows, said beside it: no picture tells it by itself."""

import numpy as np

from ...bundle.plates import muscle_strain
from ...core.validation import proportions_message
from ...muscle import Muscle
from ...muscle.entry import extension_message, lowest_of, lowest_strain
from ...muscle.fitted import elsewhere
from ...muscle.foreign import foreign
from ...muscle.tension import TENSION_LAWS
from ..curves.other_laws import is_tuned
from ..state import View
from .said import in_units
from .widgets import factor, shown


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
            foreign(one),
            elsewhere(one),
            one.tuning.beyond(view.supply),
            in_units(proportions_message(one.length, one.outer_radius), view.shown),
        )
    ]
    if not alone and view.distance is not None:
        said += [extension_message(muscle_strain(view.distance / one.length, 0.0),
                                   lowest_strain(*lowest_of(one))) for one in muscles]  # fmt: skip
    if tab == "muscle":
        compared = (key.partition(":") for key in view.compared)
        laws = (TENSION_LAWS.get(name) for kind, _, name in compared if kind == "tension")
        said += [foreign(view.muscle, law) for law in laws if law]
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
