"""Free strain against the second unit's pressure, for several splits of the same muscle."""

from dataclasses import dataclass

import numpy as np

from ...bundle import Bundle, MotorUnit
from ...bundle.reversal import Reversal, free_strain_curve, reversal
from ...muscle import Muscle


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
    turn = one.turn
    if turn.depth <= 0:
        return one.pressure, one.resisted
    after = int(np.searchsorted(one.pressure, turn.pressure))
    strain = [turn.free_strain]
    if turn.jump:
        ends = np.abs(one.resisted[[max(after - 1, 0), min(after, POINTS - 1)]] - turn.free_strain)
        strain = [np.nan, turn.free_strain] if ends[0] > ends[1] else [turn.free_strain, np.nan]
    at = [after] * len(strain)
    return (
        np.insert(one.pressure, at, [turn.pressure] * len(strain)),
        np.insert(one.resisted, at, strain),
    )


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
