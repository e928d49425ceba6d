"""Simultaneous recruitment of units: `batch`, one pressure for all, and `energy_aware`.

**Source:** `batch` as the scheme of that name, Kim, Mazzoleni and Bryant (2021); `energy_aware`
takes the set of units whose chambers hold least fluid for the demand, derived here.
"""

from typing import Any, NamedTuple

import numpy as np

from ..core.array_namespace import array_namespace, minimum, where
from ..core.errors import InvalidInputError
from ..core.module import Module
from ..core.types import Batch, Numbers
from ..core.validation import check_positive
from .units import ControlledUnits, UnitCapability, UnitDemand, share_demand


_HALVINGS = 30  # of a common pressure's bracket: to 1e-9 of the supply
_MAX_UNITS = 6  # with 63 sets, all of which are evaluated at each step
_SAVING = 0.1  # of the fluid, for which another set is worth its change


class PolicyState(NamedTuple):
    """Memory of a policy: number of its present recruitment state, or of its set of units."""

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


class EnergyAwarePolicy(Module):
    """Policy `energy_aware`: of all sets of units that suffice, each filled in turn, the one whose
    chambers contain least; it changes if that saves a tenth, or the present one no longer suffices.
    """

    def begin(self, units: ControlledUnits) -> PolicyState:
        """Initial memory of the policy for `units`."""
        if units.count > _MAX_UNITS:
            raise InvalidInputError(
                "policy", f"energy_aware takes at most {_MAX_UNITS} units", units.count
            )
        return PolicyState(0.0 * units.counts[0])

    def __call__(
        self,
        memory: PolicyState,
        units: ControlledUnits,
        demand: UnitDemand,
        capability: UnitCapability,
    ) -> tuple[PolicyState, Numbers]:
        """Next memory, and pressures [Pa] of `units` for a `demand`, within their `capability`."""
        xp = array_namespace(demand.strains, demand.force)
        top = minimum(demand.supply, units.branches.top)
        sets = np.array(
            [[m >> i & 1 for i in range(units.count)] for m in range(1, 2**units.count)]
        )
        low = 0.0 * demand.strains + 0.0 * sets
        pressures = share_demand(units, capability, demand, low, top * sets)[0] * sets
        content = xp.sum(units.fluid_mass(pressures, demand.strains), axis=-1)
        full = xp.sum(xp.asarray(sets) * (capability.full - capability.empty), axis=-1)
        highest = full + xp.sum(capability.empty)
        suffices = highest >= demand.force
        present = memory.number.astype(int)
        # sets that fall short come after all others, 1e3 kg; the strongest of them first
        cost = where(suffices, content, 1e3 - 1e-6 * highest)
        best = xp.argmin(cost)
        keep = (highest[present] >= demand.force) & (cost[best] > (1 - _SAVING) * cost[present])
        number = xp.where(keep, present, best)
        return PolicyState(number + 0.0), pressures[number]


def batch(band: Any) -> BatchPolicy:
    """Policy `batch` with a `band` [N]."""
    return BatchPolicy(check_positive(band, "band", "N"))


def energy_aware(band: Any) -> EnergyAwarePolicy:
    """Policy `energy_aware`; it ignores the `band` [N], since the saving of fluid decides."""
    del band
    return EnergyAwarePolicy()
