"""A search's results as labelled values: the front, or every design that was looked at."""

from typing import Any

import numpy as np

from ..design.designs import Designs
from ..design.objectives import OBJECTIVES
from ..design.robust import Spread
from ..design.searching import Found
from .results import Variable


def front_variables(found: Found, sure: Spread | None = None) -> dict[str, Variable]:
    """The front, a design a row.

    **Arguments:**

    - `found`: by a search [-].
    - `sure`: how the front's designs come out [-]; left out, nothing of it.

    **Returns:** values by name [-]: objectives first, then composition and sizes.
    """
    places = found.front
    recommended = np.zeros(len(places), bool)
    if found.recommended is not None:
        recommended[found.recommended] = True
    return {
        "design": Variable(("design",), found.index[places], "-", "index in the space of designs"),
        **_objectives({name: values[places] for name, values in found.values.items()}),
        "recommended": Variable(("design",), recommended, "-", "least bad in its worst objective"),
        **({} if sure is None else _sure(sure)),
        **design_variables(found.designs),
    }


def every_variables(found: Found) -> dict[str, Variable]:
    """All designs that were looked at, a row each, by index, and whether each is on the front.

    **Arguments:** `found`: by a search [-].

    **Returns:** values by name [-].
    """
    front = np.zeros(len(found.index), bool)
    front[found.front] = True
    return {
        "design": Variable(("design",), found.index, "-", "index in the space of designs"),
        **_objectives(found.values),
        "allowed": Variable(("design",), found.allowed, "-", "whether it keeps all limits"),
        "front": Variable(("design",), front, "-", "whether no other betters it"),
    }


def design_variables(designs: Designs) -> dict[str, Variable]:
    """Composition and sizes, a design a row; `designs` [-]. Gives values by name [-]."""
    names = list(designs.drawings)
    gone = designs.counts == 0

    def sizes(values: np.ndarray) -> np.ndarray:
        return np.where(gone, np.nan, values)

    def by_unit(values: Any, unit: str, about: str) -> Variable:
        return Variable(("design", "unit"), values, unit, about)

    unit = np.arange(1, designs.counts.shape[1] + 1)
    return {
        "unit": Variable(("unit",), unit, "-", "motor unit, in the order of recruitment"),
        "composition": Variable(("design",), np.array(designs.labels, object), "-"),
        "drawing": Variable(
            ("design",), np.array([names[i] for i in designs.kind], object), "-",
            "muscle whose material and laws are taken",
        ),
        "count": by_unit(designs.counts, "-", "muscles in the unit"),
        "length": Variable(("design",), designs.length, "m", "of the muscles at rest"),
        "outer_radius": by_unit(sizes(designs.radius), "m", "of the unit's muscles at rest"),
        "wall_thickness": by_unit(sizes(designs.wall), "m", "of the unit's muscles at rest"),
        "braid_angle": by_unit(sizes(designs.angle), "rad", "from the axis, at rest"),
    }  # fmt: skip


def _sure(sure: Spread) -> dict[str, Variable]:
    about = "share of draws that meet the task and all limits"
    told = {"probability": Variable(("design",), sure.probability, "-", about)}
    for share in (0.05, 0.5, 0.95):
        for name, one in sure.quantile(share).items():
            key = f"{name}_q{100 * share:02.0f}"
            words = f"{100 * share:g} % quantile of: {OBJECTIVES[name].about}"
            told[key] = Variable(("design",), one, OBJECTIVES[name].unit, words)
    return told


def _objectives(values: dict[str, np.ndarray]) -> dict[str, Variable]:
    return {
        name: Variable(("design",), one, OBJECTIVES[name].unit, OBJECTIVES[name].about)
        for name, one in values.items()
    }
