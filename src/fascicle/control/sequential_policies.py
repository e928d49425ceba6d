r"""Sequential recruitment: one unit after the other, with different crossings of the transition.

Their memory is the number of recruited units, whole except during a hand-over, when its fraction is
that of the onset that the next unit's pressure has reached. Units are filled in turn; a recruited
unit stays at its onset or above.

- `orderly`: the plain inverse. The next unit is pressurized when the earlier ones don't suffice.
- `threshold`: as `orderly`, and back only when the demand is lower by a band.
- `hand_over`: begins while the reserve just suffices for the dip, (X6); the unit's ramp is held
  back by the pressure that the unit before lacks.

If the reserve is already less than the dip, no crossing without a dip exists any more: the unit is
pressurized when it must be. Units are vented by the same rule, at a demand lower by the band.

The reserve at which a hand-over begins is

$$\rho = \rho_{near} + (1 + m) D + \dot F \left[s \max\left(\frac{p_d}{p_{on}} t_c, t_k\right)
    + \tau\right], \qquad
  t_k = \int_{P_k}^{0.95 P_s} \frac{\mathrm{d}m_k}{\dot m_k}: \tag{X6}$$

at the deepest dip unit $k$ must have climbed, wide open, in $t_k$, as far as its valve still flows
well; the force that it lacks there, $\rho_{near}$, is never available in time. $m$ is a margin, $s$
how much longer than with open valves a hand-over lasts, $\tau$ the lag of the pressures. A slow
hand-over leaves the observer, (K2a), time for what the model gets wrong; where the reserve falls
too fast for it, the ramp is as much faster, up to the valves' own. Up to half of $p_d$ the next
unit takes little force, and its valve is wide open; from there on it rises no faster than

$$\dot p \le \frac{p_d}{2 D}\, \frac{\partial F_k}{\partial P} \dot P_k: \tag{X8}$$

it takes no more force than unit $k$ can add, its valve wide open. No hand-over is faster than in
$8 \tau$, so that late loops correct in time what the model gets wrong, and don't overshoot. Up to
$p_d$ it may be faster where the demand rises by more than $D/2$ in that time.

The policy withholds force that the dip would take back. While the next unit, at the pressure $p$,
still has a dip ahead, it follows the demand only up to

$$F \le F_{max} - \rho_{near} - (1 + m) \max_{p' \ge p} \left[-g(p')\right], \tag{X9}$$

and withholds the rest, but no more than $(1 + m) D$ and no more than the rise of the demand. While
it does, (X8) alone limits the pace up to $1.2 p_d$; from there on most muscles pull, and the
unit rises as fast as its valve and $8 \tau$ permit. The policy withholds nothing where it is too
late to begin a hand-over.

**Source:** derived here.
"""

from typing import Any, NamedTuple

import numpy as np

from ..core.array_namespace import array_namespace, maximum, minimum, where
from ..core.module import Module
from ..core.types import Batch, Numbers
from ..core.validation import check_positive
from .units import (
    SLACK,
    ControlledUnits,
    UnitCapability,
    UnitDemand,
    hand_over_times,
    select_unit,
    share_demand,
)


_MARGIN = 0.1  # of the dip: a model's error, as of 10 % of its stiffness
# of the dip, how much more reserve begins a slow hand-over: with 1 a random muscle dips by 0.27 D,
# with 2.5 small sines recruit a unit that they don't need
_EARLIEST = 1.5
_SLOW = 20.0  # times of the valve: what a slower ramp gets wrong is corrected in time
# of the dip's pressure: up to there a unit takes a tenth to a third of its dip, its valve wide open
_FLAT = 0.5
_STEEP = 2.0  # times the dip's mean slope: beyond `_FLAT` a unit takes its dip about so steeply
# times the dip's pressure: from there on a late unit hurries. With 1, a random muscle whose dip is
# at a higher pressure than the model's dips by 0.28 D in place of 0.10
_PAST_DIP = 1.2
# of the pressures: a faster rise overshoots, by 0.3 D more at valves late by 20 ms; with 6 of them
# dips are larger by 0.03 D there, with 12 the rms error of a 4 s ramp by 0.04 to 0.06 D
_LAGS = 8.0
_ABOVE = 0.01  # of the supply over the onset, at which a recruited unit is parked: no less force
_SHORT = 0.02  # of the supply: a unit before that is so far off stops the next one's ramp
_NOISE = 5e-3  # s, of a filter of pressures: 5 kPa of noise at 1 kHz become 1.6


class SequentialState(NamedTuple):
    """Memory of a sequential policy: the number of `recruited` units, the `direction` of its
    change, 1, 0 or -1, of each unit the `target`, the `prediction` of its pressure by now, and the
    `deficit` below that, filtered [Pa]; the force `withheld` from the demand [N].
    """

    recruited: Batch
    direction: Batch
    target: Numbers
    prediction: Numbers
    deficit: Numbers
    withheld: Batch


class SequentialPolicy(Module):
    """Policy that recruits one unit after the other; its switches make the named policies.

    `band` [N] of the demand, by which a unit is vented later; `anticipates`: 1 if it hands over
    before it must; `parks`: 1 if recruited units stay at their onset; `margin`: of the dip;
    `longest` hand-over, in times of the valve.
    """

    band: Batch
    anticipates: Batch
    parks: Batch
    margin: Batch
    longest: Batch

    def begin(self, units: ControlledUnits) -> SequentialState:
        """Initial memory of the policy for `units`."""
        zero = 0.0 * units.counts
        return SequentialState(zero[0] + 1.0, zero[0], zero, zero, zero, zero[0])

    def __call__(
        self,
        memory: SequentialState,
        units: ControlledUnits,
        demand: UnitDemand,
        capability: UnitCapability,
    ) -> tuple[SequentialState, Numbers]:
        """Next memory, and pressures [Pa] of `units` for a `demand`, within their `capability`."""
        xp = array_namespace(demand.strains, demand.force)
        indices = xp.arange(units.count)
        top = minimum(demand.supply, units.branches.top)
        parked = minimum(capability.onset + _ABOVE * top, top)
        # a sum of steps falls short of a whole by rounding
        k = minimum(maximum(xp.floor(memory.recruited + 1e-9), 1.0), float(units.count))
        fraction = memory.recruited - k
        # the last unit that is recruited and the next one; and those one back
        last = where(indices == xp.stack([k - 1, k - 2])[:, None], 1.0, 0.0)
        next_ = where(indices == xp.stack([k, k - 1])[:, None], 1.0, 0.0)
        withheld, gained, beyond_dip = self._withhold(
            memory, units, demand, capability, (last[0], next_[0])
        )
        demand = demand._replace(force=demand.force - withheld)
        reserve, dip, need = self._reserves(capability, demand, last, next_)
        late = reserve[0] < 0
        in_time = (self.anticipates > 0) & (reserve[0] <= need[0]) & (reserve[0] >= dip[0] / 2)
        next_unit = xp.sum(next_[0] * where(capability.adds_force, 1.0, 0.0)) > 0
        up = next_unit & (late | in_time)
        down = (k > 1) & (fraction == 0) & (reserve[1] > need[1] + self.band)
        direction = where(up, 1.0, where(down, -1.0, where(fraction > 0, memory.direction, 0.0)))

        rush = late | (reserve[0] + gained < 0)
        # the further off the unit before is, the slower the ramp; the lag of its loop alone
        # doesn't count, and in a rush only what it has too much of
        prediction = where(xp.sum(memory.prediction) > 0, memory.prediction, demand.pressures)
        change = prediction - demand.pressures - memory.deficit
        deficit = memory.deficit + change * demand.dt / (demand.dt + _NOISE)
        error = xp.abs(where(rush, minimum(deficit, 0.0), deficit))
        hold = maximum(1.0 - xp.sum(last[0] * error) / (_SHORT * top), 0.0)
        # a unit before that has nothing left to give up: the ramp waits for a higher demand
        excess = xp.sum(last[0] * (memory.target - capability.onset)) / (_SHORT * top)
        hold = where(memory.direction > 0, minimum(hold, maximum(excess, 0.0)), hold)
        falls = down | ((fraction > 0) & (direction < 0))
        times = where(falls, capability.vent, capability.time)
        time = xp.sum(where(down, next_[1], next_[0]) * times)
        time = maximum(time, maximum(_late_time(demand, dip[0], beyond_dip), demand.dt))
        pace = self._hand_over_rate(
            capability, demand, (last[0], next_[0]), reserve[0], fraction, time, withheld > 0
        )
        pace = where(direction > 0, where(rush, 1 / time, pace), 1 / (SLACK * time))
        speed = where(self.anticipates > 0, hold * pace, 1 / demand.dt)
        recruited = memory.recruited + direction * speed * demand.dt
        recruited = minimum(maximum(recruited, where(down, k - 1, k)), where(down, k, k + 1))
        recruited = minimum(recruited, float(units.count))

        k = xp.floor(recruited + 1e-9)  # a sum of steps falls short of a whole by rounding
        ramp = where(indices == k, (recruited - k) * parked, 0.0)
        low = where((indices > 0) & (indices < k), parked * self.parks, ramp)
        high = where(indices < k, top, ramp)
        # in a rush, and as long as a unit is vented, even after its ramp, the unit before makes up
        # for the present pressure, not for the target
        hurried = (demand.pressures < low) & rush
        vented = (indices >= k) & (demand.pressures > low) & (direction <= 0)
        measured = maximum(demand.pressures, 0.0)
        throttled = where(
            (indices > 0) & (self.anticipates > 0) & (hurried | vented), measured, low
        )
        target, _ = share_demand(units, capability, demand, low, high, throttled)
        target = where(
            self.anticipates > 0, _first_below_onset(units, capability, demand, target), target
        )
        prediction = prediction + (target - prediction) * demand.dt / (demand.dt + demand.lag)
        state = SequentialState(recruited, direction, target, prediction, deficit, withheld)
        return state, target

    def _withhold(
        self, memory: SequentialState, units: ControlledUnits, demand: UnitDemand,
        capability: UnitCapability, pair: tuple[Numbers, Numbers],
    ) -> tuple[Batch, Batch, Any]:  # fmt: skip
        """Force to withhold from a demand during the hand-over between a `pair` of units, (X9),
        force that the next one has added so far [N], and if its pressure is beyond its dip's.
        """
        last, next_ = pair
        force = units.counts * units.branches.force(demand.pressures, demand.strains)
        gained = select_unit(next_, force - capability.empty)
        dip_pressure = select_unit(next_, capability.dip_pressure)
        beyond_dip = select_unit(next_, demand.pressures) >= dip_pressure
        dip = select_unit(next_, capability.dip)
        ahead = (1 + self.margin) * where(beyond_dip, maximum(-gained, 0.0), dip)
        reserve = select_unit(last, capability.largest) - demand.force
        excess = ahead + select_unit(last, capability.shortfall) - reserve
        # a demand that has not risen is followed: less force would be a dip as well
        rise = memory.withheld + demand.rate * demand.dt
        withheld = maximum(minimum(minimum(excess, (1 + self.margin) * dip), rise), 0.0)
        adds_force = select_unit(next_, where(capability.adds_force, 1.0, 0.0)) > 0
        # without a hand-over the force would never be given
        hands_over = adds_force & ((memory.direction > 0) | (reserve + withheld >= dip / 2))
        withheld = where((self.anticipates > 0) & hands_over, withheld, 0.0)
        return withheld, gained, beyond_dip

    def _hand_over_rate(
        self, capability: UnitCapability, demand: UnitDemand,
        pair: tuple[Numbers, Numbers], reserve: Batch, fraction: Batch, time: Batch,
        is_behind: Any,
    ) -> Batch:  # fmt: skip
        """Rate [1/s] of a hand-over between the `pair` of units at a `fraction` of it, with a
        `reserve` [N] and the valve's `time` [s]; `is_behind`: true while force is withheld.

        It is as slow as the reserve permits, as what a slow ramp gets wrong is corrected in time;
        but once past the dip, force that is withheld is given without delay.
        """
        last, next_ = pair
        # 1e-9 N/s and 1e-9 N keep quotients finite; valves never get so slow
        dip, rise = select_unit(next_, capability.dip), maximum(demand.rate, 1e-9)
        onset = maximum(select_unit(next_, capability.onset), 1.0)
        deepest = select_unit(next_, capability.dip_pressure) / onset
        spare = reserve - dip
        late_force = self.margin * dip + select_unit(last, capability.shortfall)
        # N: without any reserve a hand-over is as fast as its limit below
        spare = maximum(maximum(spare - late_force, spare / 2), 1e-9)
        needed = maximum(
            maximum(deepest - fraction, 0.0) * rise / spare,
            (1 - fraction) * rise / maximum(reserve, 1e-9),
        )
        # no faster than the unit before, its valve wide open, can make up for [N/s]
        growth = select_unit(last, capability.slope * capability.speed)
        # N: where there is no dip, nothing limits the pace
        limit = growth / maximum(_STEEP * dip / maximum(deepest, 1e-9), 1e-9)
        needed = where(is_behind, limit, minimum(needed, limit))
        slow = maximum(needed, 1 / (self.longest * time))
        fast = 1 / (SLACK * time)
        hurries = (fraction < _FLAT * deepest) | (is_behind & (fraction >= _PAST_DIP * deepest))
        return where(hurries, fast, minimum(slow, fast))

    def _reserves(
        self, capability: UnitCapability, demand: UnitDemand, last: Numbers, next_: Numbers
    ) -> tuple[Numbers, Numbers, Numbers]:
        """Reserve of the states that end with the `last` unit, dip of the `next_` unit, and the
        reserve at which a hand-over to it begins [N]; units as one-hot rows, the first for going
        up, the second for going down.
        """
        reserve = select_unit(last, capability.largest) - demand.force
        dip = select_unit(next_, capability.dip)
        rise = maximum(demand.rate, 0.0)
        # a slow ramp begins earlier, but not at a fast demand long before the unit is needed
        deepest, end = (
            (SLACK * time + demand.lag) * rise
            + minimum((self.longest - SLACK) * time * rise, _EARLIEST * dip)
            for time in hand_over_times(capability, last, next_)
        )
        need = maximum(dip * (1 + self.margin) + deepest, end)
        need = need + select_unit(last, capability.shortfall)
        return reserve, dip, where((self.anticipates > 0) & (dip > 0), need, 0.0)


def _late_time(demand: UnitDemand, dip: Batch, beyond_dip: Any) -> Batch:
    """Shortest hand-over [s] of late loops. Until the next unit is `beyond_dip`, it need not be
    longer than the `demand` takes to rise by half the `dip` [N].
    """
    lags = _LAGS * demand.lag
    # 1e-9 N/s keeps the quotient finite: a demand at rest leaves all the time
    rising = dip / 2 / maximum(demand.rate, 1e-9)
    return where(beyond_dip, lags, minimum(lags, rising))


def _first_below_onset(
    units: ControlledUnits, capability: UnitCapability, demand: UnitDemand, target: Numbers
) -> Numbers:
    """Target pressures [Pa] with the first unit held below its onset where it would pull too much
    if it were vented.

    `target`: those that would vent it [Pa]. Between the pressure of its dip and its onset its force
    rises, too.
    """
    xp = array_namespace(target)
    empty = xp.sum(units.counts * units.branches.force(target, demand.strains))
    # N: where no unit has a dip, nothing divides by zero
    gap = (demand.force - empty) / maximum(capability.dip[0], 1e-9)
    lower = capability.onset + gap * (capability.onset - capability.dip_pressure)
    is_on = demand.pressures[0] > capability.dip_pressure[0]
    stays = (target[0] == 0) & (gap > -1) & is_on
    return where((xp.arange(units.count) == 0) & stays, lower, target)


_DEFAULTS = {"anticipates": 0.0, "parks": 1.0, "margin": _MARGIN, "longest": _SLOW}


def _sequential_policy(**options: float) -> Any:
    """Function that makes a sequential policy with a given band; `options`: switches other than the
    default.
    """

    def policy_with_band(band: Any) -> SequentialPolicy:
        """Policy that vents a unit when the demand has fallen by a `band` [N]."""
        values = _DEFAULTS | options
        numbers = map(np.float64, values.values())
        return SequentialPolicy(check_positive(band, "band", "N"), *numbers)

    return policy_with_band


def orderly(band: Any = None) -> SequentialPolicy:
    """Policy `orderly`, the plain inverse of the model; it ignores the `band` [N]."""
    del band
    return SequentialPolicy(*np.zeros(5))


threshold = _sequential_policy()
hand_over = _sequential_policy(anticipates=1.0)
