r"""A cascade of controllers: position, force, pressures of the units, valves.

With the errors $e = r - q$ of the position and $e_F = F_r - F$ of the force,

$$F_r = F_{load} + F_{friction} + k_p e + k_i \int e\,\mathrm{d}t - k_d \dot q, \qquad
  F_{demand} = F_r + k_F e_F + k_{Fi} \int e_F\,\mathrm{d}t: \tag{K2}$$

what the load and friction take is fed forward, the damping acts on what is measured. A policy makes
pressures of the demand, and each valve opens as the flow is that brings its chamber's content $m$
there with a time constant $\tau$,

$$z\, \dot m_{open}(P) = \frac{\partial m}{\partial P} \frac{P_r - P}{\tau}
  + \frac{\partial m}{\partial \varepsilon} \dot\varepsilon, \tag{K3}$$

within what it can. A valve that follows its command with a time constant $\tau_v$, measurements
that are late by $\theta$ and commands that are held for $\Delta t$ are in this loop as well, so
that it needs

$$\tau \ge 2 \left(\tau_v + \theta + \Delta t\right): \tag{K3a}$$

damped by $\sqrt{1/2}$ where the valve alone is late, a phase margin of 61° where the measurement
alone is. Integrals stand still while no unit can give what is asked of it in their
direction. Of a joint each bundle gets half of the moment, over its pulley's radius, and a
`co_contraction` on top.

**Sign:** as of the load's coordinate. **Source:** anti-windup by conditional integration: Åström
and Hägglund (2006), Advanced PID Control; (K3) and (K3a) derived here, for an integrator with a lag
or a delay.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from ..core.array_namespace import array_namespace, maximum, minimum, where
from ..core.module import Module, static
from ..core.types import Batch, Numbers, Values
from ..dynamics import Measurement, Plant
from ..dynamics.hysteresis import AbstractHysteresis
from .units import UnitDemand, Units, evaluate_capability


_FILTER = 0.02  # s, of a demand's rate
_STEP = 1e3  # Pa, over which a content's slope is taken
_STRAIN = 1e-4
FASTEST = 3e-3  # s, a pressure's time constant where nothing is late
DAMPED = 2.0  # of all that is late in the loop, equation (K3a)


class Gains(NamedTuple):
    """Of the position: `position` $k_p$, `integral` $k_i$, `velocity` $k_d$ [SI]; of the force:
    `force` $k_F$ [-], `force_integral` $k_{Fi}$ [1/s]; of pressures: `pressure_time` $\\tau$ [s],
    left out, as (K3a) asks, 3 ms at least.
    """

    position: Batch = 0.0
    integral: Batch = 0.0
    velocity: Batch = 0.0
    force: Batch = 0.0
    force_integral: Batch = 2.0
    pressure_time: Values = None


class Memory(NamedTuple):
    """Memory of a controller: integrals of its errors [SI], the `demand` of before and its
    filtered `rate` [SI], friction's forces as it was `reckoned` [N], the reference before [SI],
    each bundle's policy, measurements that are on their `queue` [SI], commands that are `held` [-]
    and for how many steps yet [-].
    """

    integral: Batch
    force_integral: Batch
    demand: Batch
    rate: Batch
    reckoned: Numbers
    before: Batch
    policies: tuple
    queue: Numbers
    held: Numbers
    wait: Batch
    fresh: Batch


class Cascade(Module):
    """A controller of a plant, as `simulate` takes it: `control.cascade` makes it.

    `plant`: that it knows [-]. `units`: of each bundle [-]. `policies`: one for each [-].
    `gains`: `Gains` [SI]. `highest_pressure` [Pa], `flow_limit`: share of a valve's opening [-].
    `friction`: that is compensated [-], or none. `co_contraction` [N]. `of`: "force" or "position";
    `delay` of measurements and `every` how many steps it acts [-], in steps of `dt` [s].
    """

    plant: Plant
    units: tuple[Units, ...]
    policies: tuple[Any, ...]
    gains: Gains
    highest_pressure: Batch
    flow_limit: Batch
    friction: AbstractHysteresis | None
    co_contraction: Batch
    dt: Batch
    of: str = static()
    delay: int = static()
    every: int = static()

    @property
    def lateness(self) -> float:
        """How late valves, measurements and samples are in all [s], in brackets in (K3a)."""
        valve = float(np.max(getattr(self.plant.spool, "time_constant", 0.0)))
        return valve + float(self.dt) * (self.delay + self.every)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of gains that are likely to be unstable, one sentence each."""
        pressure_time, late = float(self.gains.pressure_time), self.lateness
        if pressure_time >= late:
            return ()
        return (
            f"`pressure_time` of {pressure_time:g} s is too fast: valves, measurements"
            f" and samples are {late:g} s late, and pressures will swing; take"
            f" {DAMPED * late:g} s, or leave it out",
        )

    @property
    def memory(self) -> Memory:
        """With which it begins [-]."""
        none = jnp.zeros(())
        n = self.plant.units
        policy_memories = tuple(p.begin(u) for p, u in zip(self.policies, self.units, strict=True))
        return Memory(
            none,
            none,
            none,
            none,
            jnp.zeros((n, self.friction.count if self.friction else 0)),
            none,
            jax.tree.map(jnp.asarray, policy_memories),
            jnp.zeros((self.delay, n + 4)),
            jnp.zeros(n),
            none,
            none,
        )

    def __call__(
        self, memory: Memory, measurement: Measurement, reference: Any
    ) -> tuple[Memory, Numbers]:
        """Its next memory [-] and the commands [-], from its `memory` [-], a `measurement` [SI] and
        the `reference` now [SI].
        """
        delayed, queue = self._delayed(memory, measurement)
        memory = memory._replace(queue=queue)
        if self.every == 1:
            memory_next, commands = self._act(memory, delayed, reference)
        else:  # between its samples nothing is reckoned
            memory_next, commands = lax.cond(
                memory.wait <= 0,
                lambda: self._act(
                    memory._replace(wait=self.every + 0.0 * memory.wait), delayed, reference
                ),
                lambda: (memory, memory.held),
            )
        wait = memory_next.wait - 1
        return memory_next._replace(held=commands, wait=wait, fresh=memory.fresh + 1), commands

    def _act(
        self, memory: Memory, measurement: Measurement, reference: Any
    ) -> tuple[Memory, Numbers]:
        dt, plant, gains = self.dt * self.every, self.plant, self.gains
        if self.of == "position":
            error = reference - measurement.position
            goal = -plant.load.force(reference)
            before = jnp.where(memory.fresh > 0, memory.before, reference)
            friction, reckoned = self._friction(memory, reference, before, measurement)
            pulled = (
                goal + friction + gains.position * error - gains.velocity * measurement.velocity
            )
            pulled = pulled + memory.integral
            integral = memory.integral + gains.integral * error * dt
        else:
            error, pulled, integral = (
                0.0 * measurement.position,
                reference + 0.0 * measurement.position,
                memory.integral,
            )
            before, reckoned = memory.before, memory.reckoned
        missing = pulled - measurement.force
        demand = pulled + gains.force * missing + memory.force_integral
        force_integral = memory.force_integral + gains.force_integral * missing * dt
        change = jnp.where(memory.fresh > 0, (demand - memory.demand) / dt, 0.0)
        fraction = dt / (dt + _FILTER)
        if self.of == "force":
            # at first the mean of all changes: a filter that begins at zero would see a ramp too
            # late. Of a position the first changes are its error's, whose mean says nothing
            fraction = jnp.maximum(fraction, self.every / jnp.maximum(memory.fresh, self.every))
        rate = memory.rate + (change - memory.rate) * fraction

        strains, speed = plant.strains(measurement.position), plant.gains * measurement.velocity
        joint = len(self.units) == 2
        policies, targets, lacks = [], [], []
        for side, (policy, units) in enumerate(zip(self.policies, self.units, strict=True)):
            indices = plant.unit_indices(side)
            arm = plant.load.arms[side][1]
            shared = (1 / (2 * arm)) if joint else 1 / arm
            extra = self.co_contraction if joint else 0.0
            unit_demand = UnitDemand(
                demand * shared + extra,
                rate * shared,
                strains[indices],
                measurement.pressures[indices],
                minimum(measurement.supply_pressure, self.highest_pressure),
                gains.pressure_time,
                dt,
            )
            capability = evaluate_capability(units, unit_demand)
            after, target = policy(memory.policies[side], units, unit_demand, capability)
            policies.append(after)
            targets.append(target)
            lacks.append(
                (
                    unit_demand.force > capability.largest[-1],
                    unit_demand.force < jnp.sum(capability.empty),
                    shared,
                )
            )
        # more isn't to be had where the bundle that pulls on can't, nor the other one less
        is_short = jnp.any(jnp.stack([where(s > 0, a, b) for a, b, s in lacks]))
        less = jnp.any(jnp.stack([where(s > 0, b, a) for a, b, s in lacks]))

        def still(capability: Batch, before: Batch) -> Batch:
            return jnp.where(
                (is_short & (capability > before)) | (less & (capability < before)),
                before,
                capability,
            )

        commands = self._valves(jnp.concatenate(targets), measurement, strains, speed)
        return memory._replace(
            integral=still(integral, memory.integral),
            force_integral=still(force_integral, memory.force_integral),
            demand=demand, rate=rate, reckoned=reckoned,
            before=jnp.asarray(reference, float) if self.of == "position" else before,
            policies=tuple(policies),
        ), commands  # fmt: skip

    def _valves(
        self, target: Numbers, measurement: Measurement, strains: Numbers, speed: Numbers
    ) -> Numbers:
        """Commands [-], equation (K3)."""
        commands = []
        for side, units in enumerate(self.units):
            indices = self.plant.unit_indices(side)
            P, eps, v = measurement.pressures[indices], strains[indices], speed[indices]
            P_r = minimum(maximum(target[indices], 0.0), self.highest_pressure)
            m = units.content(P, eps)
            by_pressure = (units.content(P + _STEP, eps) - m) / _STEP
            by_strain = (units.content(P, eps + _STRAIN) - m) / _STRAIN
            flow = by_pressure * (P_r - P) / self.gains.pressure_time + by_strain * v
            into, out = units.flows(P, measurement.supply_pressure + 0.0 * P)
            opening = where(flow > 0, flow / maximum(into, 1e-9), flow / maximum(out, 1e-9))
            # one that idles is open to the room: shut, it would be sucked empty as it is shortened,
            # and what comes back into it needn't come from the supply
            opening = where(P_r > 0, opening, -1.0)
            commands.append(minimum(maximum(opening, -self.flow_limit), self.flow_limit))
        return jnp.concatenate(commands)

    def _friction(
        self, memory: Memory, reference: Batch, before: Batch, measurement: Measurement
    ) -> tuple[Batch, Numbers]:
        """Predicted friction along the reference [SI], and its forces there [N]."""
        if self.friction is None:
            return 0.0 * reference, memory.reckoned
        plant, P = self.plant, maximum(measurement.pressures, 0.0)
        per = plant.lengths * plant.gains
        queue = per * (reference - before)
        speed = queue / (self.dt * self.every)
        at = plant.muscles.at(P, plant.strains(reference))
        slid = self.friction.advance(memory.reckoned, queue, speed, (P, P), at.force_by_pressure)
        return array_namespace(P).sum(plant.counts * per * slid.force), slid.spring_forces

    def _delayed(self, memory: Memory, measurement: Measurement) -> tuple[Measurement, Numbers]:
        """Delayed measurement, and the queue of later ones."""
        if not self.delay:
            return measurement, memory.queue
        row = jnp.concatenate(
            [
                jnp.stack(
                    [
                        measurement.position,
                        measurement.velocity,
                        measurement.force,
                        measurement.supply_pressure,
                    ]
                ),
                measurement.pressures,
            ]
        )
        queue = jnp.where(memory.fresh > 0, memory.queue, row)
        q, v, F, P_s = (queue[0, i] for i in range(4))
        old = measurement._replace(
            position=q, velocity=v, force=F, supply_pressure=P_s, pressures=queue[0, 4:]
        )
        return old, jnp.concatenate([queue[1:], row[None]])
