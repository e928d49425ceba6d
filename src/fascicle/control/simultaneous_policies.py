"""Simultaneous recruitment of units: `batch`, one pressure for all.

**Source:** the scheme of that name, Kim, Mazzoleni and Bryant (2021).
"""

from typing import Any, NamedTuple

import numpy as np

from ..core.array_namespace import array_namespace, minimum, where
from ..core.module import Module
from ..core.types import Batch, Numbers
from ..core.validation import check_positive
from .units import ControlledUnits, UnitCapability, UnitDemand


_HALVINGS = 30  # of a common pressure's bracket: to 1e-9 of the supply


class PolicyState(NamedTuple):
    """Memory of a policy: number of its present recruitment state."""

    number: Batch


class BatchPolicy(Module):
    """Policy `batch`: as few units as suffice, all at one pressure, and fewer only when the demand
    is lower than their force by a `band` [N].
    """

    band: Batch

    def begin(self, units: ControlledUnits) -> PolicyState:
        """Initial memory of the policy for `units`."""
        return PolicyState(1.0 + 0.0 * units.counts[0])

    def __call__(
        self,
        memory: PolicyState,
        units: ControlledUnits,
        demand: UnitDemand,
        capability: UnitCapability,
    ) -> tuple[PolicyState, Numbers]:
        """Next memory, and pressures [Pa] of `units` for a `demand`, within their `capability`."""
        xp, n = array_namespace(demand.strains, demand.force), units.counts
        indices = np.arange(units.count)
        top = minimum(demand.supply, units.branches.top)
        needed, with_band = (
            1.0 + xp.sum(where(demand.force > capability.largest - band, 1.0, 0.0))
            for band in (0.0, self.band)
        )
        present = memory.number
        k = minimum(where(needed > present, needed, minimum(present, with_band)), units.count)
        on = indices < k
        low, high = 0.0 * top, top
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            pull = xp.sum(n * units.branches.force(where(on, middle, 0.0), demand.strains))
            short = pull < demand.force
            low, high = where(short, middle, low), where(short, high, middle)
        return PolicyState(k + 0.0), where(on, high, 0.0)


def batch(band: Any) -> BatchPolicy:
    """Policy `batch` with a `band` [N]."""
    return BatchPolicy(check_positive(band, "band", "N"))
