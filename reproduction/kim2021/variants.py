"""Fig. 6's muscle under other laws and readings: one table of forces for each.

A bundle's force is a sum over its muscles, so one muscle's table, at pressures of unit 2 and
of unit 1, gives the space and the free strains of bundles of it, to the grid's resolution.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from fascicle.muscle import Muscle
from fascicle.muscle.laws import LAWS
from fascicle.muscle.post_collapse import POST_COLLAPSE_LAWS

from . import setting


PAPER = "paper's laws"
VARIANTS = (PAPER, "elastica", "wood1958", "consistent", "printed")
LEVELS = np.linspace(0.0, setting.UNIT_1, 121)  # Pa, of unit 2
_PRESSURES = np.r_[setting.PRESSURES, LEVELS]
_STRAIN = np.linspace(0.0, 0.3, 601)


@dataclass(frozen=True)
class Variant:
    """Forces [N] of one muscle: at `setting.PRESSURES` (`force`), at `LEVELS` (`throttled`)
    and at unit 1's pressure (`full`); strains [-] on the last axis. Collapse strains [-] at
    `setting.PRESSURES`, and the `tested` strain [-].
    """

    name: str
    strain: np.ndarray
    force: np.ndarray
    throttled: np.ndarray
    full: np.ndarray
    collapse_strain: np.ndarray
    tested: float

    def free_strain(self, counts: tuple[int, int]) -> np.ndarray:
        """Free strain [-] of two units of `counts` muscles, over unit 2's pressure."""
        total = counts[0] * self.full + counts[1] * self.throttled
        after = np.argmax(total < 0, axis=1)
        rows = np.arange(len(total))
        left, right = total[rows, after - 1], total[rows, after]
        step = self.strain[1] - self.strain[0]
        crossing = self.strain[after - 1] + step * left / (left - right)
        # where nothing is below zero, the last unit's own free strain is the bundle's
        return np.where(total.min(axis=1) < 0, crossing, np.nan)

    def depth(self, counts: tuple[int, int]) -> float:
        """How far that free strain falls before it turns [-]."""
        strain = self.free_strain(counts)
        return float(strain[0] - np.nanmin(strain))

    def overlap(self) -> float:
        """Area [N] that both states of 1 + 1 reach, force times strain."""
        first = np.maximum(self.full + self.throttled[0], 0.0)
        second = np.maximum((self.full + self.throttled).min(axis=0), 0.0)
        return float(np.trapezoid(np.maximum(first - second, 0.0), self.strain))

    def peak(self, row: int) -> float:
        """Largest resistance [N] at one of `setting.PRESSURES` within the tested range."""
        inside = float(-self.force[row, self.strain <= self.tested].min())
        return max(inside, self.last(row))

    def last(self, row: int) -> float:
        """Resistance [N] at the end of the tested range."""
        return float(-np.interp(self.tested, self.strain, self.force[row]))


def muscle(name: str) -> Muscle:
    """Fig. 6's muscle with one of the `VARIANTS`."""
    base = setting.muscle("figure_6")
    for kind in ("buckling", "collapse", "post_collapse"):
        if name in LAWS[kind]:
            return base.replace(**{kind: name})
    return base


@cache
def variant(name: str) -> Variant:
    """The table of one of the `VARIANTS`, computed once."""
    one, base = muscle(name), setting.forces("figure_6")
    force = np.asarray(one.force(_PRESSURES[:, None], _STRAIN))
    told = setting.PRESSURES.size
    at_unit_1 = int(np.argmin(np.abs(setting.PRESSURES - setting.UNIT_1)))
    return Variant(
        name=name,
        strain=_STRAIN,
        force=force[:told],
        throttled=force[told : told + LEVELS.size],
        full=force[at_unit_1],
        # the readings differ only after it
        collapse_strain=base.collapse_strain
        if name == PAPER or name in POST_COLLAPSE_LAWS
        else np.asarray(one.collapse_strain(setting.PRESSURES)),
        tested=setting.tested(setting.muscle("figure_6")),  # the tension law is the same in all
    )


def all_variants() -> dict[str, Variant]:
    """Every variant by name."""
    return {name: variant(name) for name in VARIANTS}
