"""Marks of a muscle's curve: blocked force, free strain and collapse, and where their names stand
so that none runs out of the picture or over another.
"""

import numpy as np

from .muscle_curves import Picture


_NEAR, _ASIDE = 6, 7  # pixels from a point to its name, above or below it and beside it
_LINE = 16  # pixels from a name to one above it
_BELOW = -22  # pixels: a name below its point
_LOW = 0.06  # of the forces drawn: closer to zero the names of both ends are one above the other
_LONG = {"free": 0.74, "collapse": 0.62}  # of the strains drawn: further right a name stands left
# of its point; on a phone's 300 pixels, too
Marks = dict[str, list[float] | list[str]]


def marks(found: Picture, top: float, scale: float, unit: str) -> Marks:
    """Points of the chosen pressure's curve and their names.

    **Arguments:**

    - `found`: the curves [-].
    - `top`: the largest strain that is drawn [-].
    - `scale`: of the unit of force [N].
    - `unit`: its name [-].

    **Returns:** columns of a figure's source [-]: `x` [-], `y` [shown unit], `label`, how many
    pixels it stands `below` (above, if positive) and `beside`, and its `align`ment.
    """
    free, blocked = float(found.free_strain[-1]), float(found.blocked[-1])
    collapse = float(found.collapse_strain[-1])
    low = abs(blocked) < _LOW * np.ptp(found.force[:-1]) and free < 0.3 * top
    rows = [
        (0.0, blocked, f"blocked {blocked / scale:.4g} {unit}", _NEAR + _LINE * low, 1.0),
        (free, 0.0, f"free {free:.4f}", _NEAR, _LONG["free"]),
    ]
    if collapse <= top:
        force = float(np.interp(collapse, found.strain[-1], found.force[-1]))
        rows.append((collapse, force, f"collapse {collapse:.4f}", _BELOW, _LONG["collapse"]))
    left = [x > most * top for x, *_, most in rows]
    return {
        "x": [x for x, *_ in rows],
        "y": [force / scale for _, force, *_ in rows],
        "label": [label for _, _, label, *_ in rows],
        "below": [below for *_, below, _ in rows],
        "beside": [-_ASIDE if one else _ASIDE for one in left],
        "align": ["right" if one else "left" for one in left],
    }
