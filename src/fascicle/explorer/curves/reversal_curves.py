"""Free strain against the second unit's pressure, for several splits of the same muscle."""

from dataclasses import dataclass

import numpy as np

from ...bundle import Bundle, MotorUnit
from ...bundle.reversal import Reversal, free_strain_curve, reversal
from ...muscle import Muscle
from ...plot.jumps import broken


POINTS = 97


@dataclass(frozen=True)
class Split:
    """One split: `counts` of muscles by unit [-]; free strains `resisted` and `free` of
    resistance [-] over `pressure` [Pa]; where they turn.
    """

    counts: tuple[int, ...]
    pressure: np.ndarray
    resisted: np.ndarray
    free: np.ndarray
    turn: Reversal

    @property
    def name(self) -> str:
        """As it is written: 1 + 4."""
        return " + ".join(map(str, self.counts))


def through(one: Split) -> tuple[np.ndarray, np.ndarray]:
    """A split's curve through its turning point, as it is drawn: with a gap where it jumps.

    **Arguments:** `one`: the split [-].

    **Returns:** pressures [Pa] and free strains [-], NaN in the gap.
    """
    return broken(one.pressure, one.resisted, one.turn)[0]


def jump(one: Split) -> tuple[np.ndarray, np.ndarray]:
    """The two ends of a split's jump.

    **Arguments:** `one`: the split [-].

    **Returns:** pressures [Pa] and free strains [-]; empty where it doesn't jump.
    """
    return broken(one.pressure, one.resisted, one.turn)[1]


def split_curves(muscle: Muscle, splits: tuple[tuple[int, ...], ...], supply: float) -> list[Split]:
    """The free strain of each split as its second unit is fed, the first at supply.

    **Arguments:**

    - `muscle`: of which all units are [-].
    - `splits`: how many of it each unit has [-].
    - `supply`: the highest pressure [Pa].

    **Returns:** strains [-] over pressures [Pa].
    """
    pressure = np.linspace(0.0, supply, POINTS)
    out = []
    for counts in splits:
        bundle = Bundle([MotorUnit(muscle, count) for count in counts], supply)
        resisted, free = (
            free_strain_curve(bundle, 2, pressure, supply, resistance)
            for resistance in (True, False)
        )
        out.append(Split(counts, pressure, resisted, free, reversal(bundle, 2, supply)))
    return out
