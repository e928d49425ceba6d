"""Figures of `muscle.plot()` and `bundle.plot()`, with the usual pressures and strains."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..bundle import Bundle, recruitment
from ..bundle.workspace import overlap
from ..core.errors import InvalidInputError
from ..core.validation import HIGHEST_PRESSURE, LARGEST_STRAIN, to_si
from ..muscle import Muscle
from .curves import bundle_force_strain, force_strain
from .workspace import workspace


_POINTS = 301  # along a curve
_TOP = 400e3  # Pa, where no tuning says how far it was measured
_PAST = 1.25  # strains go so far past the largest free strain


def of_muscle(
    muscle: Muscle, pressures: Any = None, strains: Any = None, components: bool = False
) -> Figure:
    """A `muscle`'s forces, as `Muscle.plot` draws them.

    **Arguments:**

    - `muscle`: one muscle [-].
    - `pressures`: gauge pressures [Pa], or `None`.
    - `strains`: contractions [-], rising, or `None`.
    - `components`: a panel for each pressure with the force's parts [-].

    **Returns:** the figure [-].

    **Raises:** `ValueError` for rows of muscles and values off the domain.
    """
    if np.ndim(muscle.length + muscle.outer_radius + muscle.wall_thickness + muscle.braid_angle):
        raise InvalidInputError(
            "muscle", "must be a single one to be drawn, got rows of them", None
        )
    if pressures is None:
        rows = np.asarray(muscle.tuning.pressures)
        measured = float(np.max(rows)) + float(muscle.tuning.dead_band)
        top = min(measured, HIGHEST_PRESSURE) if rows.size > 1 else _TOP
        pressures = np.linspace(0.0, top, 4 if components else 5)
    P = np.atleast_1d(np.asarray(to_si(pressures, "pressure", "Pa"), float))
    if strains is None:
        strains = _strains(float(np.max(muscle.free_strain(P))))
    return force_strain(muscle, P, strains, components)


def of_bundle(
    bundle: Bundle, pressures: Any = None, strains: Any = None, resistance: bool = True
) -> Figure:
    """A `bundle`'s workspace, or its forces at `pressures`, as `Bundle.plot` draws them.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `pressures`: one for each motor unit [Pa], or `None`.
    - `strains`: contractions [-], rising, or `None`.
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** the figure [-].

    **Raises:** `ValueError` where there are neither pressures nor a supply's.
    """
    if pressures is None and bundle.supply_pressure is None:
        raise InvalidInputError(
            "pressures",
            "must be given in Pa, one for each motor unit",
            None,
            "the bundle has no supply pressure, for which its states would be drawn",
        )
    if pressures is None:
        space = recruitment.space(bundle, strain=strains, resistance=resistance)
        return workspace(space, overlap(space))
    if strains is None:
        strains = _strains(float(bundle.free_strain(pressures, resistance=False)))
    return bundle_force_strain(bundle, pressures, strains, resistance)


def _strains(free_strain: float) -> np.ndarray:
    """Strains [-] from rest to past the largest `free_strain` [-]."""
    return np.linspace(0.0, min(max(_PAST * free_strain, 0.05), LARGEST_STRAIN), _POINTS)
