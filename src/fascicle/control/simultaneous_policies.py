"""Recruiting sets of units at once: `batch`, one pressure for all of them, and `energy_aware`.

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
from .units import UnitCapability, UnitDemand, Units, share_demand


_HALVINGS = 30  # of a common pressure's bracket: to 1e-9 of the supply
_MOST = 6  # units, of which there are 63 sets
_SAVED = 0.1  # of the fluid, for which another set is worth its change


class PolicyState(NamedTuple):
    """Memory: which state or set was `chosen` [-]."""

    chosen: Batch


class Batched(Module):
    """`batch`: as few units as suffice, all at one pressure, and fewer only when the demand is
    lower than they hold by a `band` [N].
    """

    band: Batch

    def begin(self, units: Units) -> PolicyState:
        """The memory [-] to begin with, for so many `units` [-]."""
        return PolicyState(1.0 + 0.0 * units.counts[0])

    def __call__(
        self, memory: PolicyState, units: Units, demand: UnitDemand, capability: UnitCapability
    ) -> tuple[PolicyState, Numbers]:
        """Next memory, and pressures [Pa] of `units` for a `demand`, within their `capability`."""
        xp, n = array_namespace(demand.strains, demand.force), units.counts
        indices = np.arange(units.many)
        top = minimum(demand.supply, units.branches.top)
        fewest = 1.0 + xp.sum(where(demand.force > capability.largest, 1.0, 0.0))
        few_with_band = 1.0 + xp.sum(where(demand.force > capability.largest - self.band, 1.0, 0.0))
        k = minimum(
            where(fewest > memory.chosen, fewest, minimum(memory.chosen, few_with_band)), units.many
        )
        on = indices < k
        low, high = 0.0 * top, top
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            pull = xp.sum(n * units.branches.force(where(on, middle, 0.0), demand.strains))
            low, high = (
                where(pull < demand.force, middle, low),
                where(pull < demand.force, high, middle),
            )
        return PolicyState(k + 0.0), where(on, high, 0.0)


class EnergyAware(Module):
    """`energy_aware`: of all sets of units that pull as much, each filled in turn, the one whose
    chambers hold least; another one where that saves a tenth of it, or the last no longer suffices.
    """

    def begin(self, units: Units) -> PolicyState:
        """The memory [-] to begin with, for so many `units` [-]."""
        if units.many > _MOST:
            raise InvalidInputError(
                "policy", f"energy_aware takes at most {_MOST} units", units.many
            )
        return PolicyState(0.0 * units.counts[0])

    def __call__(
        self, memory: PolicyState, units: Units, demand: UnitDemand, capability: UnitCapability
    ) -> tuple[PolicyState, Numbers]:
        """Next memory, and pressures [Pa] of `units` for a `demand`, within their `capability`."""
        xp = array_namespace(demand.strains, demand.force)
        top = minimum(demand.supply, units.branches.top)
        sets = np.array([[m >> i & 1 for i in range(units.many)] for m in range(1, 2**units.many)])
        none = 0.0 * demand.strains
        pressures = share_demand(units, capability, demand, none + 0.0 * sets, top * sets)[0] * sets
        holding = xp.sum(units.content(pressures, demand.strains), axis=-1)
        full = xp.sum(xp.asarray(sets) * (capability.full - capability.empty), axis=-1)
        highest = full + xp.sum(capability.empty)
        suffices = highest >= demand.force
        last = memory.chosen.astype(int)
        cost = where(suffices, holding, 1e3 - 1e-6 * highest)
        best = xp.argmin(cost)
        keep = (highest[last] >= demand.force) & (cost[best] > (1 - _SAVED) * cost[last])
        chosen = xp.where(keep, last, best)
        return PolicyState(chosen + 0.0), pressures[chosen]


def batch(band: Any) -> Batched:
    """`Batched` [-] with a `band` [N]."""
    return Batched(check_positive(band, "band", "N"))


def energy_aware(band: Any) -> EnergyAware:
    """`EnergyAware` [-], which has no `band` [N]: what it would save decides."""
    del band
    return EnergyAware()
