"""Efficiency that a bundle loses to the resistance of inactive muscles, as maps on one grid."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..bundle import Bundle
from ..bundle.energetics import EfficiencyMap, efficiency_map
from ..bundle.recruitment import Outline, boundary


_THIN = 1e-6  # of the largest force: edges that are equal differ by rounding


class Maps(NamedTuple):
    """Efficiency maps with resistance, `resisted`, and `free` of it, on the same points, with the
    outlines (strain [-], force [N]) of the points that a state reaches without resistance alone.
    """

    resisted: EfficiencyMap
    free: EfficiencyMap
    resistance_gaps: tuple[Outline, ...]

    @property
    def loss(self) -> EfficiencyMap:
        """Map of the efficiency lost to resistance [-]; where resistance changes the state, in
        strips thinner than a cell, that of the nearest point below or above where it doesn't.

        Negative on isobaric paths where the higher pressure against resistance does more work for
        the same fluid energy.
        """
        values = self.free.efficiency - self.resisted.efficiency
        empty = np.isfinite(values) & (self.free.state != self.resisted.state)
        for rows, step in ((range(1, len(values)), -1), (range(len(values) - 2, -1, -1), 1)):
            for i in rows:
                fill = empty[i] & ~empty[i + step] & np.isfinite(values[i + step])
                values[i, fill], empty[i, fill] = values[i + step, fill], False
        return replace(self.resisted, efficiency=np.where(empty, np.nan, values))


def efficiency_maps(bundle: Bundle, path: str) -> Maps:
    """Efficiency maps on a `path`, "isobaric" or "isotonic"."""
    resisted = efficiency_map(bundle, path=path, resistance=True)
    force, strain = resisted.force, resisted.strain
    free = efficiency_map(bundle, path=path, force=force, strain=strain, resistance=False)
    return Maps(resisted, free, _resistance_gaps(bundle, strain))


def _resistance_gaps(bundle: Bundle, strain: np.ndarray) -> tuple[Outline, ...]:
    """Outlines of the points that a recruitment state reaches without resistance alone, over the
    strains [-] of a map; none for units of independent pressures.
    """
    if bundle.scheme.independent:
        return ()
    strain = np.r_[0.0, strain]
    with_resistance, without = (
        np.maximum(bundle.workspace(levels=2, strain=strain, resistance=resistance).high, 0.0)
        for resistance in (True, False)
    )
    outlines = []
    for low, high in zip(with_resistance, without, strict=True):
        inside = np.flatnonzero(high - low > _THIN * without.max())
        if inside.size:
            outlines.append(boundary(strain, low, high, slice(inside[0], inside[-1] + 1)))
    return tuple(outlines)
