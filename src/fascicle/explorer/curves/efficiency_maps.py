"""Efficiency maps of a bundle with and without resistance, and averages by number of states."""

from dataclasses import dataclass

import numpy as np

from ...bundle import Bundle
from ...energetics import EfficiencyMap, average_efficiency, constant_cross_section, efficiency_map
from ...muscle import Muscle
from ..state import View, scaled


STATES = (1, 2, 3, 4, 5)  # the first is the single equivalent motor unit, the SEMU


@dataclass(frozen=True)
class Maps:
    """Maps along one `path` [-]: `resisted`, and `free` of resistance."""

    path: str
    resisted: EfficiencyMap
    free: EfficiencyMap

    @property
    def difference(self) -> np.ndarray:
        """What resistance takes [-], over the points that both reach."""
        return self.free.efficiency - self.resisted.efficiency


def maps(bundle: Bundle, path: str) -> Maps:
    """The maps of a `bundle` [-] along a `path` [-], on the points of the one with resistance."""
    resisted = efficiency_map(bundle, path=path, resistance=True)
    free = efficiency_map(
        bundle, path=path, force=resisted.force, strain=resisted.strain, resistance=False
    )
    return Maps(path, resisted, free)


def semu(view: View) -> Muscle:
    """The one muscle whose cross-section is that of all of the bundle's [-]."""
    radius = float(view.muscle.outer_radius)
    total = sum(unit.count * float(view.muscle_of(unit).outer_radius) ** 2 for unit in view.units)
    return scaled(view.muscle, float(np.sqrt(total)) / radius)


def averages(whole: Muscle, supply: float, path: str) -> dict[bool, np.ndarray]:
    """Average efficiency [-] of `STATES` equal units in a muscle's section, by resistance.

    **Arguments:**

    - `whole`: the muscle, a bundle's `semu` [-].
    - `supply`: the supply's pressure [Pa].
    - `path`: "isobaric" or "isotonic" [-].

    **Returns:** averages [-], with resistance under `True`.
    """
    return {
        resistance: np.array([
            average_efficiency(
                constant_cross_section(whole, count, supply), path=path, resistance=resistance
            )
            for count in STATES
        ])
        for resistance in (True, False)
    }  # fmt: skip
