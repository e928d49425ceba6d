r"""Recruiting one unit after the other, and how the transition is crossed.

All of these have the same memory: how many units are recruited, a whole number but while one is
handed over to, when its fraction is the share of the onset that its pressure has come to. Units are
filled in turn; one that is recruited stays at its onset or above.

- `orderly`: the plain inverse. The next unit is fed when those before it no longer suffice.
- `threshold`: the same, and back only when the demand is lower by a band.
- `hand_over`: begins while there is just reserve enough for the dip, (X6); the unit's ramp is held
  back by the pressure that the one before it is short of.
- `pre_charge`: as much earlier as the valve takes: the unit is parked at its onset before.
- `fast_cross`: when those before no longer suffice, with its valve wide open up to the onset.

Where the reserve is less than the dip when it is noticed, no crossing without one exists any more:
the unit is fed when it must be. Back they go by the same rule, at a demand lower by the band.

The reserve at which a hand-over begins is

$$\rho = \rho_{near} + (1 + m) D + \dot F \left[s \max\left(\frac{p_d}{p_{on}} t_c, t_k\right)
    + \tau \frac{D}{c\, P_s\, n_k F'_k}\right], \qquad
  t_k = \int_{P_k}^{0.95 P_s} \frac{\mathrm{d}m_k}{\dot m_k}: \tag{X6}$$

where the dip is deepest unit $k$ must have climbed, wide open, in $t_k$, as far as its valve still
flows well, and what it lacks there, $\rho_{near}$, is never to be had in time. $m$ is a margin, $s$
the valves' slack; the last term is how long the ramp is held by a unit $k$ that is late by $\tau$.

**Source:** derived here.
"""

from typing import Any, NamedTuple

import numpy as np

from ..core.array_namespace import array_namespace, maximum, minimum, where
from ..core.module import Module
from ..core.types import Batch, Numbers
from ..core.validation import check_positive
from .units import SLACK, UnitCapability, UnitDemand, Units, hand_over_times, share_demand


_MARGIN = 0.02  # of the dip that is kept, for what the tables don't know
_ABOVE = 0.01  # of the supply over the onset, where a recruited unit is parked
_SHORT = 0.02  # of the supply: so far off, the unit before holds the next one's ramp


class SequentialState(NamedTuple):
    """Memory: how many units are `recruited` [-], and the `direction` it goes [-]: 1, 0 or -1; the
    `target` of each unit [Pa].
    """

    recruited: Batch
    direction: Batch
    target: Numbers


class SequentialPolicy(Module):
    """One of the policies above: `band` [N], and whether [-] it is `early`, held back, by how many
    of its valve's times it leads, whether it opens `wide`, and whether it stays at the onset.
    """

    band: Batch
    early: Batch
    lead: Batch
    wide: Batch
    parked: Batch

    def begin(self, units: Units) -> SequentialState:
        """The memory [-] to begin with, for so many `units` [-]."""
        none = 0.0 * units.counts
        return SequentialState(none[0] + 1.0, none[0], none)

    def __call__(
        self, memory: SequentialState, units: Units, demand: UnitDemand, capability: UnitCapability
    ) -> tuple[SequentialState, Numbers]:
        """Next memory, and pressures [Pa] of `units` for a `demand`, within their `capability`."""
        xp = array_namespace(demand.strains, demand.force)
        indices = xp.arange(units.many)
        top = minimum(demand.supply, units.branches.top)
        parked = minimum(capability.onset + _ABOVE * top, top)
        k = minimum(maximum(xp.floor(memory.recruited + 1e-9), 1.0), float(units.many))
        fraction = memory.recruited - k
        # the last unit that is recruited and the next one; and those one back
        last = where(indices == xp.stack([k - 1, k - 2])[:, None], 1.0, 0.0)
        next_ = where(indices == xp.stack([k, k - 1])[:, None], 1.0, 0.0)
        reserve, dip, need = self._needed(capability, demand, last, next_)
        next_unit = xp.sum(next_[0] * where(capability.gains, 1.0, 0.0)) > 0
        late = reserve[0] < 0
        in_time = (self.early > 0) & (reserve[0] <= need[0]) & (reserve[0] >= dip[0])
        up = next_unit & (late | in_time)
        down = (k > 1) & (fraction == 0) & (reserve[1] > need[1] + self.band)
        direction = where(up, 1.0, where(down, -1.0, where(fraction > 0, memory.direction, 0.0)))

        # the further off the unit before is, the more the ramp is held; what it is late behind a
        # demand that rises alone doesn't count
        follows = demand.lag * minimum(
            maximum(demand.rate, 0.0) / capability.slope, capability.speed
        )
        behind = maximum(xp.abs(memory.target - demand.pressures) - follows, 0.0)
        off = xp.sum(last[0] * behind) / (_SHORT * top)
        holding = maximum(1.0 - off, 0.0)
        pulls = units.counts * units.branches.force(demand.pressures, demand.strains)
        gained = xp.sum(next_[0] * (pulls - capability.empty))
        rush = late | (reserve[0] + gained < 0)
        falls = down | ((fraction > 0) & (direction < 0))
        times = where(falls, capability.vent, capability.time)
        time = SLACK * xp.sum(where(down, next_[1], next_[0]) * times)
        slow = (self.early > 0) & ~(rush & (direction > 0))
        pace = where(slow, holding / maximum(time, demand.dt), 1 / demand.dt)
        moving = memory.recruited + direction * pace * demand.dt
        moving = minimum(maximum(moving, where(down, k - 1, k)), where(down, k, k + 1))
        recruited = minimum(moving, float(units.many))

        k = xp.floor(recruited + 1e-9)
        ramp = where(indices == k, (recruited - k) * parked, 0.0)
        low = where((indices > 0) & (indices < k), parked * self.parked, ramp)
        high = where(indices < k, top, ramp)
        # in a rush, and as long as a unit is being vented, also after its ramp has ended, the one
        # before gives room for what is felt, not for what is meant to come
        hurried = (demand.pressures < low) & rush
        vented = (indices >= k) & (demand.pressures > low) & (direction <= 0)
        measured = maximum(demand.pressures, 0.0)
        felt = where((indices > 0) & (self.early > 0) & (hurried | vented), measured, low)
        target, _ = share_demand(units, capability, demand, low, high, felt)
        # wide open to the onset, and no further
        opened = (
            (self.wide > 0) & (indices > 0) & (indices < k) & (demand.pressures < capability.onset)
        )
        return SequentialState(recruited, direction, target), where(opened, top, target)

    def _needed(
        self, capability: UnitCapability, demand: UnitDemand, last: Numbers, next_: Numbers
    ) -> tuple[Numbers, Numbers, Numbers]:
        """Of the states that end with the `last` unit [-], as ones among zeros: the reserve, the
        `next_` unit's dip, and the reserve at which a hand-over to it begins [N].
        """

        def of(index: Numbers, values: Numbers) -> Numbers:
            return array_namespace(values).sum(index * values, axis=-1)

        reserve, dip = of(last, capability.largest) - demand.force, of(next_, capability.dip)
        rise = maximum(demand.rate, 0.0)
        # by as much the ramp is held while the unit before follows it
        slope = maximum(of(last, capability.slope), 1e-12)  # the first has none before it
        holding = demand.lag * dip / slope / (_SHORT * demand.supply)
        deepest, end = (
            (SLACK * time + holding) * rise for time in hand_over_times(capability, last, next_)
        )
        need = maximum(dip * (1 + _MARGIN) + deepest, end)
        need = need + of(last, capability.near) + self.lead * rise * of(next_, capability.time)
        return reserve, dip, where((self.early > 0) & (dip > 0), need, 0.0)


def _sequential_policy(**ways: float) -> Any:
    def made(band: Any) -> SequentialPolicy:
        is_known = {"early": 0.0, "lead": 0.0, "wide": 0.0, "parked": 1.0} | ways
        return SequentialPolicy(
            check_positive(band, "band", "N"), *map(np.float64, is_known.values())
        )

    return made


def orderly(band: Any = None) -> SequentialPolicy:
    """The plain inverse [-], which has no `band` [N]."""
    del band
    return SequentialPolicy(*np.zeros(5))


threshold = _sequential_policy()
hand_over = _sequential_policy(early=1.0)
pre_charge = _sequential_policy(early=1.0, lead=1.0)
fast_cross = _sequential_policy(wide=1.0)
