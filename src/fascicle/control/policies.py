r"""Policies: which motor units are pressurized for a demand, and to which pressures.

- `orderly`: the plain inverse of the model. The next unit is pressurized when those before it no
  longer suffice.
- `threshold`: as `orderly`, and back only when the demand is lower by a band. A recruited unit
  stays at its onset or above.
- `batch`: as few units as suffice, all at one pressure.
- `hand_over`: the next unit is filled along a path of constant force, before it is needed.

With the units before $k$ full and the next unit at the pressure $p$, unit $k$ gives the rest, (X5):
a path $(P_k(p), p)$ from 0 to the onset. It exists as long as the force is at most

$$F \le F_{max} - \rho_{near} - \max_{p' \ge p} \left[-g(p')\right], \tag{X9}$$

where $\rho_{near}$ is what unit $k$ lacks near the supply's pressure, where its valve hardly flows.
The path is walked with the speed

$$\dot p = \min\left[\frac{p_{on}}{s\,t_c},\; \frac{\dot F_k}{s\,\max(-g')},\;
  \frac{\delta D}{2 \max|g'| (\tau + \tau_o)}\right] \tag{X8}$$

that both valves and the lag permit: $t_c$ is the time in which the next unit's valve fills it,
$\dot F_k$ the force that unit $k$ gains with its valve wide open, $s$ leaves a sixth of both valves
to corrections; slopes are the steepest ahead. Within the lag $\tau$ of the pressures and $\tau_o$
of the observer, which corrects what the model gets wrong, each of the two units changes its force
by no more than half of the share $\delta$ of the dip: together they are off by $\delta D$ at most
if the model's slopes are right within a factor of two. The walk begins when the reserve has fallen
to the dip and what the demand rises until the dip is passed:

$$\rho = \rho_{near} + D + \dot F \left(\frac{p_d}{\dot p} + \tau\right). \tag{X6}$$

If the demand turns out to rise faster, the walk is faster, as valves permit, but takes no more than
a share $\delta$ of the path within $\tau + \tau_o$, and the force stays at (X9): it is late, and
doesn't dip. Where the reserve is less than the dip when the walk should begin, there is no such
path, and the policy is `threshold`. Units are vented on the same path, at a demand lower by the
band.

**Source:** orderly and batch recruitment as the schemes of that name, Kim, Mazzoleni and Bryant
(2021); `hand_over` derived here.
"""

from collections.abc import Callable, Mapping
from typing import ClassVar, NamedTuple

import numpy as np

from ..core.array_namespace import absolute, array_namespace, maximum, minimum, where
from ..core.module import Module
from ..core.types import Batch, Marks, Numbers, PyTree
from .units import SLACK, ControlledUnits, UnitCapability, UnitDemand, select_unit, share_demand


TOLERANCE = 0.1  # δ: a tenth of a dip is what docs and tests call no dip
_NODES = np.linspace(0.0, 1.0, 33)  # of a path: a dip is 10 of them wide
_HALVINGS = 30  # of a common pressure's bracket: to 1e-9 of the supply


class PolicyStep(NamedTuple):
    """Decision of a policy for a demand on units within their capability: its next `memory`,
    `pressures` of units [Pa], and force that is `withheld` from the demand [N].
    """

    memory: PyTree
    pressures: Numbers
    withheld: Batch


class SequentialPolicy(Module):
    """Policy that recruits one unit after the other; its memory is the number of recruited ones.

    `band` [N] of the demand, by which a unit is vented later; `parks`: 1 if recruited units stay at
    their onset.
    """

    begin: ClassVar = np.float64(1.0)
    band: Batch
    parks: Batch

    def __call__(
        self, memory: Batch, units: ControlledUnits, demand: UnitDemand, capability: UnitCapability
    ) -> PolicyStep:
        xp = array_namespace(demand.strains, demand.force)
        indices, k = xp.arange(units.count), memory
        last, before, next_ = (_unit(indices, k - i) for i in (1, 2, 0))
        adds_force = select_unit(next_, where(capability.adds_force, 1.0, 0.0)) > 0
        up = adds_force & (select_unit(last, capability.largest) < demand.force)
        down = (k > 1) & (select_unit(before, capability.largest) > demand.force + self.band)
        k = k + where(up, 1.0, where(down, -1.0, 0.0))
        top, parked = capability.top, capability.parked
        low = where((indices > 0) & (indices < k), parked * self.parks, 0.0)
        high = where(indices < k, top, 0.0 * parked)
        target = share_demand(units, capability, demand, low, high)
        return PolicyStep(k, target, 0.0 * demand.force)


class BatchPolicy(Module):
    """Policy `batch`: as few units as suffice, all at one pressure, and fewer only when the demand
    is lower than their force by a `band` [N]; its memory is their number.
    """

    begin: ClassVar = np.float64(1.0)
    band: Batch

    def __call__(
        self, memory: Batch, units: ControlledUnits, demand: UnitDemand, capability: UnitCapability
    ) -> PolicyStep:
        xp, n = array_namespace(demand.strains, demand.force), units.counts
        top = capability.top
        needed, with_band = (
            1.0 + xp.sum(where(demand.force > capability.largest - band, 1.0, 0.0))
            for band in (0.0, self.band)
        )
        k = minimum(where(needed > memory, needed, minimum(memory, with_band)), units.count)
        on = np.arange(units.count) < k
        low, high = 0.0 * top, top
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            pull = xp.sum(n * units.branches.force(where(on, middle, 0.0), demand.strains))
            short = pull < demand.force
            low, high = where(short, middle, low), where(short, high, middle)
        return PolicyStep(k + 0.0, where(on, high, 0.0), 0.0 * demand.force)


class HandOverState(NamedTuple):
    """Memory of `hand_over`: number of `recruited` units, whose fraction is the next one's share of
    its path; `direction` of the walk, 1, 0 or -1; force `withheld` from the demand [N].
    """

    recruited: Batch
    direction: Batch
    withheld: Batch


class _Path(NamedTuple):
    """Path from a unit to the next one: the `reserve` of the demand on it, less what is not to be
    had in time [N]; the next unit's `dip` [N], the dip `ahead` of its present pressure [N], and its
    `deepest` point as a fraction of the path [-]; the `speed` of (X8) and the `fastest` of valves
    alone [1/s]; true if the next unit `adds_force`.
    """

    reserve: Batch
    dip: Batch
    ahead: Batch
    deepest: Batch
    speed: Batch
    fastest: Batch
    adds_force: Marks


class HandOverPolicy(Module):
    """Policy that hands over along a path of constant force.

    `band` [N] of the demand, by which a unit is vented later; `tolerance` $\\delta$ of a dip [-].
    """

    begin: ClassVar = HandOverState(*np.array([1.0, 0.0, 0.0]))
    band: Batch
    tolerance: Batch = np.float64(TOLERANCE)

    def __call__(
        self,
        memory: HandOverState,
        units: ControlledUnits,
        demand: UnitDemand,
        capability: UnitCapability,
    ) -> PolicyStep:
        xp = array_namespace(demand.strains, demand.force)
        indices, n = xp.arange(units.count), float(units.count)
        top, parked = capability.top, capability.parked
        # a sum of steps falls short of a whole by rounding
        k = minimum(maximum(xp.floor(memory.recruited + 1e-9), 1.0), n)
        fraction = memory.recruited - k
        rate = maximum(demand.rate, 0.0)

        path = self._path(units, demand, capability, k, memory.direction < 0)
        walking = fraction > 0
        # a demand that has not risen is followed: less force would be a dip as well
        risen = memory.withheld + demand.rate * demand.dt
        withheld = maximum(minimum(path.ahead - path.reserve, risen), 0.0)
        withheld = where(walking & (memory.direction > 0), withheld, 0.0)
        demand = demand._replace(force=demand.force - withheld)
        reserve = path.reserve + withheld
        # up to the deepest point, while the reserve is more than the dip
        needed = path.dip + rate * (path.deepest / path.speed + demand.lag)
        begins = path.adds_force & (reserve <= needed) & (reserve >= path.dip)
        largest = select_unit(_unit(indices, k - 1), capability.largest)
        late = path.adds_force & (largest < demand.force)
        back = self._path(units, demand, capability, k - 1, True)
        released = back.dip + rate * (back.deepest / back.speed + demand.lag) + self.band
        down = (k > 1) & ~walking & (back.reserve > released)
        direction = where(down, -1.0, where(walking, memory.direction, 0.0))
        direction = where(begins | late, 1.0, direction)
        # as fast as the demand makes it, if need be
        left = maximum(reserve - path.dip, 1e-9)  # N: no division by zero
        hurry = maximum(path.deepest - fraction, 0.0) * rate / left
        speed = minimum(maximum(path.speed, hurry), path.fastest)
        speed = where((withheld > 0) & (fraction > path.deepest), path.fastest, speed)
        speed = where(down, back.speed, speed)
        # without a path the unit is recruited at once, as by `threshold`
        speed = where(late & ~walking, 1 / demand.dt, speed)
        recruited = memory.recruited + direction * speed * demand.dt
        recruited = minimum(maximum(recruited, where(down, k - 1, k)), where(down, k, k + 1))
        recruited = minimum(recruited, n)

        k = xp.floor(recruited + 1e-9)
        ramp = where(indices == k, (recruited - k) * parked, 0.0)
        low = where((indices > 0) & (indices < k), parked, ramp)
        high = where(indices < k, top, ramp)
        # where a unit is slower than its ramp, or was recruited without one, the unit before makes
        # up for its present pressure
        measured = maximum(demand.pressures, 0.0)
        vented = (indices >= k) & (measured > low) & (direction <= 0)
        hurried = (indices < k) & (measured < low)
        throttled = where((indices > 0) & (vented | hurried), measured, low)
        target = share_demand(units, capability, demand, low, high, throttled)
        return PolicyStep(HandOverState(recruited, direction, withheld), target, withheld)

    def _path(
        self,
        units: ControlledUnits,
        demand: UnitDemand,
        capability: UnitCapability,
        k: Batch,
        falls: Marks | bool,
    ) -> _Path:
        """Path from unit `k`, counted from 1, to the next one; `falls`: true if it is vented."""
        xp = array_namespace(demand.strains, demand.force)
        indices = xp.arange(units.count)
        last, next_ = _unit(indices, k - 1), _unit(indices, k)
        length = maximum(select_unit(next_, capability.parked), 1.0)  # Pa: no division by zero
        p = minimum(maximum(select_unit(next_, demand.pressures) / length, 0.0), 1.0)
        shares = xp.append(xp.asarray(_NODES), p)
        pressures = shares[:, None] * capability.parked
        forces = units.counts * units.branches.force(pressures, demand.strains + 0.0 * pressures)
        gain = xp.sum(next_ * (forces - capability.empty), axis=-1)
        changes = where(shares[1:-1] > p, gain[1:-1] - gain[:-2], 0.0) / _NODES[1]
        # N: at an end of all units there is no path
        steepest, falling = (maximum(xp.max(x), 1e-9) for x in (absolute(changes), -changes))
        dip = select_unit(next_, capability.dip)
        ahead = maximum(xp.max(where(shares >= p, -gain, 0.0)), 0.0)
        time = select_unit(next_, where(falls, capability.vent, capability.time))
        growth = select_unit(last, capability.growth)
        fastest = minimum(1 / maximum(time, demand.dt), growth / falling) / SLACK
        fastest = minimum(fastest, self.tolerance / demand.correction)
        # without a dip nothing but valves limits the speed
        steady = self.tolerance / 2 * dip / (steepest * demand.correction)
        speed = minimum(fastest, where(dip > 0, steady, fastest))
        reserve = select_unit(last, capability.largest - capability.shortfall) - demand.force
        adds_force = select_unit(next_, where(capability.adds_force, 1.0, 0.0)) > 0
        deepest = minimum(select_unit(next_, capability.dip_pressure) / length, 1.0)
        # 1/s: a path takes a quarter of an hour at most
        speed, fastest = maximum(speed, 1e-3), maximum(fastest, 1e-3)
        return _Path(reserve, dip, ahead, deepest, speed, fastest, adds_force)


def _unit(indices: Numbers, index: Batch) -> Numbers:
    """One-hot row of the unit with an `index`, from 0."""
    return where(indices == index, 1.0, 0.0)


Policy = SequentialPolicy | BatchPolicy | HandOverPolicy
POLICIES: Mapping[str, Callable[[Batch], Policy]] = {  # of a band [N]
    "orderly": lambda _: SequentialPolicy(*np.zeros(2)),
    "batch": BatchPolicy,
    "threshold": lambda band: SequentialPolicy(band, np.float64(1.0)),
    "hand_over": HandOverPolicy,
}
