"""Four states of Fig. 6's muscle, from rest to past collapse: what Figs 2 to 5 draw."""

from dataclasses import dataclass

import numpy as np

from fascicle.muscle import Muscle
from fascicle.plot.shapes import Outline, outlines

from . import setting


PRESSURE = float(setting.PRESSURES[1])  # the lower of Fig. 6's two pressures with all three regions
FREE, BENT, HINGED = 1, 2, 3  # places of the states; rest is 0
JUST = 0.001  # of strain past the free strain
_SHARE = 0.9  # of the way from free strain to collapse


@dataclass(frozen=True)
class Progression:
    """States in order: rest, free strain, post-buckling, post-collapse. Pressure [Pa],
    strain [-] and largest moment [N·m] of each, with the strains and moment of collapse; and
    the deflection [m] just past the free strain.
    """

    muscle: Muscle
    pressure: np.ndarray
    strain: np.ndarray
    moment: np.ndarray
    outlines: list[Outline]
    free_strain: float
    collapse_strain: float
    collapse_moment: float
    moment_at_collapse: float
    first_deflection: float

    @property
    def free_length(self) -> float:
        """$L_{fs}$ [m]."""
        return float(self.muscle.length) * (1 - self.free_strain)

    def compression(self, state: int) -> float:
        """$x$ [m], how far a state is past the free strain."""
        return float(self.muscle.length) * (float(self.strain[state]) - self.free_strain)


@setting.cached
def progression() -> Progression:
    """The four states, computed once."""
    muscle = setting.muscle("figure_6")
    P = np.array([0.0, PRESSURE, PRESSURE, PRESSURE])
    collapse = setting.forces("figure_6").collapse_strain[[0, 1, 1, 1]]
    free = float(muscle.free_strain(PRESSURE))
    bent = free + _SHARE * (collapse[1] - free)
    eps = np.array([0.0, free, bent, setting.tested(muscle)])
    # a fifth state: exactly at collapse, and just past free strain
    five = np.r_[P, PRESSURE]
    moments = setting.array(muscle.moment(five, np.r_[eps, collapse[1]]))
    drawn = outlines(muscle, five, np.r_[eps, free + JUST], np.r_[collapse, collapse[1]])
    return Progression(
        muscle, P, eps, moments[:4], drawn[:4], free, float(collapse[1]),
        float(muscle.collapse_moment(PRESSURE)), float(moments[4]), float(-drawn[4].y.min()),
    )  # fmt: skip
