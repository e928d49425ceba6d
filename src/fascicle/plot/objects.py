"""Figures of `muscle.plot()` and `bundle.plot()`, with the usual pressures and strains."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..bundle import Bundle, recruitment
from ..bundle.recruitment import overlap
from ..core.errors import InvalidInputError
from ..core.validation import HIGHEST_PRESSURE, LARGEST_STRAIN, to_si
from ..muscle import Muscle
from .curves import bundle_force_strain, force_strain
from .workspace import workspace


_POINTS = 301  # along a curve: smooth in print
_HIGHEST = 400e3  # Pa, a usual supply, for a muscle whose tuning has no range of pressure


def of_muscle(
    muscle: Muscle, pressures: Any = None, strains: Any = None, components: bool = False
) -> Figure:
    """Figure of a muscle's forces, as `Muscle.plot` draws it.

    **Arguments:**

    - `muscle`: one muscle.
    - `pressures`: gauge pressures [Pa], or `None`.
    - `strains`: contractions [-], rising, or `None`.
    - `components`: a panel for each pressure with mesh and bladder force.

    **Raises:** `InvalidInputError` for arrays of muscles and values off the domain.
    """
    if np.ndim(muscle.length + muscle.outer_radius + muscle.wall_thickness + muscle.braid_angle):
        raise InvalidInputError("muscle", "must be a single one to be drawn, got an array", None)
    if pressures is None:
        rows = np.asarray(muscle.tuning.pressures)
        measured = float(np.max(rows)) + float(muscle.tuning.dead_band)
        highest = min(measured, HIGHEST_PRESSURE) if rows.size > 1 else _HIGHEST
        pressures = np.linspace(0.0, highest, 4 if components else 5)
    P = np.atleast_1d(np.asarray(to_si(pressures, "pressure", "Pa"), float))
    if strains is None:
        strains = _strains(np.max(muscle.free_strain(P)))
    return force_strain(muscle, P, strains, components)


def of_bundle(
    bundle: Bundle, pressures: Any = None, strains: Any = None, resistance: bool = True
) -> Figure:
    """Figure of a bundle's workspace, or of its forces at `pressures`, as `Bundle.plot` draws it.

    **Arguments:**

    - `bundle`: the bundle.
    - `pressures`: one for each motor unit [Pa], or `None`.
    - `strains`: contractions [-], rising, or `None`.
    - `resistance`: resisting force of units past their own free strain.

    **Raises:** `InvalidInputError` without pressures and without a supply pressure.
    """
    if pressures is None and bundle.supply_pressure is None:
        raise InvalidInputError(
            "pressures",
            "must be given in Pa, one for each motor unit",
            None,
            "the bundle has no supply pressure, for which its states would be drawn",
        )
    if pressures is None:
        space = recruitment.workspace(bundle, strain=strains, resistance=resistance)
        return workspace(space, overlap(space))
    if strains is None:
        strains = _strains(bundle.free_strain(pressures, resistance=False))
    return bundle_force_strain(bundle, pressures, strains, resistance)


def _strains(free_strain: Any) -> np.ndarray:
    """Strains [-] from rest to a quarter past the largest free strain, where resistance shows."""
    return np.linspace(0.0, min(max(1.25 * float(free_strain), 0.05), LARGEST_STRAIN), _POINTS)
