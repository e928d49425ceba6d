r"""A cascade of controllers: position, force, pressures of the units, valves.

With the errors $e = r - q$ of the position and $e_F = F_r - F$ of the force,

$$F_r = F_{load} + F_{friction} + k_p e + k_i \int e\,\mathrm{d}t - k_d \dot q, \qquad
  F_{demand} = F_r + k_F e_F + k_{Fi} \int e_F\,\mathrm{d}t - \hat d: \tag{K2}$$

forces of load and friction are fed forward, the damping acts on the measured velocity. $\hat d$
is an observer of the disturbance: the force beyond the model's at the measured pressures,

$$\tau_o \dot{\hat d} = F - F_{model}(P, \varepsilon) - \hat d. \tag{K2a}$$

A saturated or late valve doesn't wind it up, and a model whose slope $\partial F/\partial P$ is
right within a factor of two doesn't make it unstable, however late force and pressures are measured
together.

A policy turns the demand into pressures, and each valve opens for the flow that brings its
chamber's content $m$ there with a time constant $\tau$,

$$z\, \dot m_{open}(P) = \frac{\partial m}{\partial P} \frac{P_r - P}{\tau}
  + \frac{\partial m}{\partial \varepsilon} \dot\varepsilon, \tag{K3}$$

within what it can. A valve that follows its command with a time constant $\tau_v$, measurements
that are late by $\theta$ and commands that are held for $\Delta t$ are in this loop as well, so
that it needs, with the mean delay of pulses in $\theta$,

$$\tau \ge 2 \left(\tau_v + \theta + \Delta t\right): \tag{K3a}$$

damped by $\sqrt{1/2}$ where the valve alone is late, a phase margin of 61° where the measurement
alone is. Pressures that follow with $\tau$ hold the force, so that muscles of the stiffness $K$ at
constant pressures resist motion like a damper $K \tau$. With a load's damping $c$ the position's
loop is $M \tau s^3 + (M + c \tau) s^2 + (c + k_d + K \tau) s + k_p$, stable by Routh if

$$k_p < K + \frac{c + k_d}{\tau}; \tag{K3b}$$

$c (c + k_d + K \tau)/M$ more is left as a reserve, as delays are worse than a lag. Integrals stand
still while no unit can give more in their direction. Each bundle of a joint gets half of the
moment, over its pulley's radius, and a `co_contraction` on top.

**Sign:** as of the load's coordinate. **Source:** anti-windup by conditional integration: Åström
and Hägglund (2006), Advanced PID Control; (K3) and (K3a) derived here, for an integrator with a lag
or a delay.
"""

import warnings
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from ..core.array_namespace import array_namespace, maximum, minimum, where
from ..core.errors import InvalidInputError
from ..core.findings import Finding, Severity
from ..core.module import Module, static
from ..core.types import Batch, Numbers, Values
from ..core.validation import check_choice, check_interval, check_nonnegative, check_positive
from ..dynamics import Measurement, Plant, PrescribedMotion, holding_pressures
from ..muscle.hysteresis import AbstractHysteresis, Motion
from .policies import POLICIES, Policy
from .step_response import LoopMargins, loop_margins
from .units import ControlledUnits, UnitDemand, evaluate_capability


RATE_FILTER = 0.02  # s, of a demand's rate: longer than its steps, shorter than a hand-over
_STEP = 1e3  # Pa, for a content's slope: far above rounding, far below a supply
_STRAIN = 1e-4  # for the same slope by strain
FASTEST = 3e-3  # s, a pressure's time constant without any lateness
OBSERVER = 5e-3  # s: 5 kPa of noise at 1 kHz become 2; faster than any hand-over
OF = ("force", "position")  # values of the argument `of`
_BAND = 0.02  # of the largest unit's force at rest: more than noise
_ROUNDED = 5e-3  # of the force a load holds: a demand in a file has three digits at least
DAMPED = 2.0  # times all lateness in the loop, equation (K3a)


class Gains(NamedTuple):
    """Gains and time constants of a cascade.

    - Position: `position` $k_p$, `integral` $k_i$, `velocity` $k_d$ [SI].
    - Force: `force` $k_F$ [-], `force_integral` $k_{Fi}$ [1/s].
    - Pressures: `pressure_time` $\\tau$ [s]; by default as (K3a) requires, at least 3 ms.
    - Observer of the disturbance: `observer_time` $\\tau_o$ [s]; by default 5 ms for a policy that
      hands over, and infinite, which is no observer, for others.
    """

    position: Batch = 0.0
    integral: Batch = 0.0
    velocity: Batch = 0.0
    force: Batch = 0.0
    force_integral: Batch = 2.0
    pressure_time: Values = None
    observer_time: Values = None


class CascadeMemory(NamedTuple):
    """Memory of a cascade between steps: integrals of its errors [SI], the `disturbance` [SI], the
    previous `demand` without corrections and its filtered `rate` [SI], the model's `friction`
    forces [N], the previous `reference` [SI], each bundle's policy, the present `commands` [-], and
    `steps` since the start.
    """

    integral: Batch
    force_integral: Batch
    disturbance: Batch
    demand: Batch
    rate: Batch
    friction: Numbers
    reference: Batch
    policies: tuple
    commands: Numbers
    steps: Batch


def valve_lag(plant: Plant) -> float:
    """Lag of the slowest spool of a `plant` [s]."""
    return float(np.max(getattr(plant.spool, "time_constant", 0.0)))


def pulse_delay(plant: Plant) -> float:
    """Mean delay of the slowest pulses of a `plant`'s valves [s]."""
    return float(np.max(plant.spool.pulse_delay))


class Cascade(Module):
    """Controller of a plant, as `simulate` takes it, made by `control.cascade`.

    `plant`: its model. `units`, `policies`: of each bundle. `friction`: the law that is
    compensated, or none. `every`: its period in steps of `dt` [s]. Others are arguments of
    `cascade` [SI].
    """

    plant: Plant
    units: tuple[ControlledUnits, ...]
    policies: tuple[Policy, ...]
    gains: Gains
    highest_pressure: Batch
    flow_limit: Batch
    friction: AbstractHysteresis | None
    co_contraction: Batch
    delay: Batch
    dt: Batch
    of: str = static()
    every: int = static()

    @property
    def lateness(self) -> float:
        """Total lateness of valves, measurements and samples [s], the bracket of (K3a)."""
        return valve_lag(self.plant) + self._total_delay

    @property
    def margins(self) -> LoopMargins:
        """Margins of its pressure loops, (K8): of gain, a factor [-], and of phase [rad]."""
        return loop_margins(self.gains.pressure_time, valve_lag(self.plant), self._total_delay)

    def loop_response(self, frequency: Values) -> np.ndarray:
        """Response $L$ [-] of its pressure loops, (K8), complex, at each `frequency` [Hz]."""
        s = 2j * np.pi * np.asarray(frequency, float)
        lag, tau = valve_lag(self.plant), float(self.gains.pressure_time)
        return np.exp(-s * self._total_delay) / (tau * s * (1 + lag * s))

    @property
    def _total_delay(self) -> float:
        """Delay of valves, measurements and samples [s]."""
        return pulse_delay(self.plant) + float(self.delay) + float(self.dt) * self.every

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Gains that are likely to be unstable: "control.pressure_time_short" or, of valves whose
        dead time exceeds the declared `delay`, "control.dead_time_undeclared".
        """
        pressure_time, dead_time = (
            float(self.gains.pressure_time),
            float(self.plant.spool.dead_time),
        )
        undeclared = max(dead_time - float(self.delay), 0.0)
        late = self.lateness + undeclared
        if pressure_time >= late:
            return ()
        data = {"pressure_time": pressure_time, "lateness": late, "stable": DAMPED * late}
        if undeclared:
            data |= {"dead_time": dead_time}
            return (Finding("control.dead_time_undeclared", Severity.WARNING, data),)
        return (Finding("control.pressure_time_short", Severity.WARNING, data),)

    def demand_findings(self, reference: Values) -> tuple[Finding, ...]:
        """Findings on the demands of a `reference` [SI]: "control.force_not_held", a force that a
        free load doesn't hold at rest at any position; "control.position_gain_high", beyond (K3b)
        at one of nine positions between its ends, of one bundle.
        """
        plant, r = self.plant, np.asarray(reference, float)
        load, ends = plant.load, (float(r.min()), float(r.max()))
        if self.of == "force":
            if load.prescribed or load.stop is not None:
                return ()
            held = -np.asarray(load.force(np.linspace(*plant.stroke, 101)))
            least, most = float(held.min()), float(held.max())
            rounding = _ROUNDED * max(abs(least), abs(most))
            if ends[0] >= least - rounding and ends[1] <= most + rounding:
                return ()
            data = {"least": least, "most": most, "lowest": ends[0], "highest": ends[1]}
            data |= {"unit": "N" if load.unit == "m" else "N·m"}
            return (Finding("control.force_not_held", Severity.WARNING, data),)
        if len(plant.bundles) > 1:
            return ()
        damping = float(load.damping + self.gains.velocity)
        limits = {}
        for q in np.linspace(*ends, 9):
            slopes = plant.muscles.at(holding_pressures(plant, q), plant.strains(q)).force_by_strain
            stiffness = -np.sum(plant.counts * plant.lengths * plant.gains**2 * slopes)
            limits[float(stiffness) + damping / float(self.gains.pressure_time)] = float(q)
        limit, gain = min(limits), float(self.gains.position)
        if gain <= limit:
            return ()
        data = {"gain": gain, "limit": limit, "position": limits[limit]}
        return (Finding("control.position_gain_high", Severity.WARNING, data),)

    @property
    def memory(self) -> CascadeMemory:
        """Initial memory."""
        zero, n = jnp.zeros(()), self.plant.units
        springs = jnp.zeros((n, self.friction.count if self.friction else 0))
        policies = jax.tree.map(jnp.asarray, tuple(policy.begin for policy in self.policies))
        sums = zero, zero, zero, zero, zero
        return CascadeMemory(*sums, springs, zero, policies, jnp.zeros(n), zero)

    def __call__(
        self, memory: CascadeMemory, measurement: Measurement, reference: Numbers
    ) -> tuple[CascadeMemory, Numbers]:
        """Next memory and commands [-], from a `memory`, a `measurement` [SI] and the present
        `reference` [SI].
        """

        def update() -> CascadeMemory:
            return self._update(memory, measurement, reference)

        if self.every == 1:
            following = update()
        else:  # between its samples nothing is computed
            following = lax.cond(memory.steps % self.every == 0, update, lambda: memory)
        return following._replace(steps=memory.steps + 1), following.commands

    def _update(
        self, memory: CascadeMemory, measurement: Measurement, reference: Numbers
    ) -> CascadeMemory:
        """Next memory of one sample, from a `measurement` [SI], with its new commands [-]."""
        dt, plant, gains = self.dt * self.every, self.plant, self.gains
        started = memory.steps > 0
        if self.of == "position":
            error = reference - measurement.position
            prediction, friction = self._predict_friction(memory, reference, measurement)
            force = prediction - plant.load.force(reference) + memory.integral
            force = force + gains.position * error - gains.velocity * measurement.velocity
            integral = memory.integral + gains.integral * error * dt
            last = jnp.asarray(reference, float)
        else:
            force, integral = reference + 0.0 * measurement.position, memory.integral
            last, friction = memory.reference, memory.friction
        force_error = force - measurement.force
        strains = plant.strains(measurement.position)
        disturbance = self._estimate_disturbance(memory, measurement, strains)
        command = force + gains.force * force_error
        demand = command + memory.force_integral - disturbance
        force_integral = memory.force_integral + gains.force_integral * force_error * dt
        change = jnp.where(started, (command - memory.demand) / dt, 0.0)
        fraction = dt / (dt + RATE_FILTER)
        if self.of == "force":
            # at first the mean of all changes: a filter that begins at zero would see a ramp too
            # late. Of a position the first changes are its error's, whose mean says nothing
            fraction = jnp.maximum(fraction, self.every / jnp.maximum(memory.steps, self.every))
        rate = memory.rate + (change - memory.rate) * fraction

        observer = jnp.where(jnp.isfinite(gains.observer_time), gains.observer_time, 0.0)
        speed = plant.gains * measurement.velocity
        supply = minimum(measurement.supply_pressure, self.highest_pressure)
        joint = len(self.units) == 2
        decisions, short, excess = [], [], []
        for side, (policy, units) in enumerate(zip(self.policies, self.units, strict=True)):
            indices, arm = plant.unit_indices(side), plant.load.arms[side][1]
            force_ratio = (1 / (2 * arm)) if joint else 1 / arm
            bundle_force = demand * force_ratio + (self.co_contraction if joint else 0.0)
            of_units = strains[indices], measurement.pressures[indices], supply
            times = gains.pressure_time, gains.pressure_time + observer, dt
            unit_demand = UnitDemand(bundle_force, rate * force_ratio, *of_units, *times)
            capability = evaluate_capability(units, unit_demand)
            step = policy(memory.policies[side], units, unit_demand, capability)
            decisions.append(step)
            too_much = (unit_demand.force > capability.largest[-1]) | (step.withheld > 0)
            too_little = unit_demand.force < jnp.sum(capability.empty)
            short.append(where(force_ratio > 0, too_much, too_little))
            excess.append(where(force_ratio > 0, too_little, too_much))
        # a larger output is out of reach if the bundle that pulls on can't, or the other one less
        is_short, is_excess = jnp.any(jnp.stack(short)), jnp.any(jnp.stack(excess))

        def without_windup(value: Batch, before: Batch) -> Batch:
            """Integral `value`, or that `before` if it winds further past a reached limit."""
            winds_up = (is_short & (value > before)) | (is_excess & (value < before))
            return jnp.where(winds_up, before, value)

        memories, targets, _ = zip(*decisions, strict=True)
        commands = self._valve_commands(jnp.concatenate(targets), measurement, strains, speed)
        integrals = (
            without_windup(integral, memory.integral),
            without_windup(force_integral, memory.force_integral),
        )
        sums = *integrals, disturbance, command, rate
        return CascadeMemory(*sums, friction, last, memories, commands, memory.steps)

    def _valve_commands(
        self, target: Numbers, measurement: Measurement, strains: Numbers, speed: Numbers
    ) -> Numbers:
        """Valve commands [-] that bring pressures to their `target` [Pa], equation (K3)."""
        commands = []
        for side, units in enumerate(self.units):
            indices = self.plant.unit_indices(side)
            P, eps, v = measurement.pressures[indices], strains[indices], speed[indices]
            P_r = minimum(maximum(target[indices], 0.0), self.highest_pressure)
            m = units.fluid_mass(P, eps)
            by_pressure = (units.fluid_mass(P + _STEP, eps) - m) / _STEP
            by_strain = (units.fluid_mass(P, eps + _STRAIN) - m) / _STRAIN
            flow = by_pressure * (P_r - P) / self.gains.pressure_time + by_strain * v
            into, out = units.valve_flows(P, measurement.supply_pressure + 0.0 * P)
            # a valve without pressure difference has no flow: it opens wide
            opening = where(flow > 0, flow / maximum(into, 1e-9), flow / maximum(out, 1e-9))
            # an idle unit is open to the room: shut, it would be sucked empty as it is shortened,
            # and its refill needn't come from the supply
            opening = where(P_r > 0, opening, -1.0)
            commands.append(minimum(maximum(opening, -self.flow_limit), self.flow_limit))
        return self.plant.spool.command_at(jnp.concatenate(commands))

    def _estimate_disturbance(
        self, memory: CascadeMemory, measurement: Measurement, strains: Numbers
    ) -> Batch:
        """Measured force beyond the model's at the measured pressures [SI], filtered, (K2a)."""
        plant, model = self.plant, 0.0
        arms = plant.counts * plant.lengths * plant.gains
        for side, units in enumerate(self.units):
            i = plant.unit_indices(side)
            pulls = units.branches.force(measurement.pressures[i], strains[i])
            model = model + jnp.sum(arms[i] * pulls)
        dt = self.dt * self.every
        fraction = dt / (dt + self.gains.observer_time)
        started = (memory.steps > 0) | ~jnp.isfinite(self.gains.observer_time)
        fraction = where(started, fraction, 1.0)  # a filter that begins at zero would kick
        return memory.disturbance + (measurement.force - model - memory.disturbance) * fraction

    def _predict_friction(
        self, memory: CascadeMemory, reference: Batch, measurement: Measurement
    ) -> tuple[Batch, Numbers]:
        """Predicted friction along the reference [SI], and its springs' forces [N] after it."""
        if self.friction is None:
            return 0.0 * reference, memory.friction
        plant, P = self.plant, maximum(measurement.pressures, 0.0)
        arms = plant.lengths * plant.gains
        before = jnp.where(memory.steps > 0, memory.reference, reference)
        travel = arms * (reference - before)
        speed = travel / (self.dt * self.every)
        muscles = plant.muscles.at(P, plant.strains(reference))
        motion = Motion(travel, speed, (P, P), muscles.force_by_pressure)
        slid = self.friction.advance(memory.friction, motion)
        return array_namespace(P).sum(plant.counts * arms * slid.force), slid.spring_forces


def cascade(
    plant: Plant,
    policy: str,
    of: str = "force",
    gains: Gains = Gains(),  # noqa: B008 a tuple of numbers
    band: Values = None,
    dt: Values = 1e-3,
    sample_time: Values = None,
    delay: Values = 0.0,
    highest_pressure: Values = None,
    flow_limit: Values = 1.0,
    compensate: bool = False,
    co_contraction: Values = 0.0,
) -> Cascade:
    """Controller of a plant, as `simulate` takes it.

    **Arguments:**

    - `plant`: the plant, which is its model, too.
    - `policy`: name of the policy, one of `POLICIES`.
    - `of`: quantity of the reference, "force" or "position".
    - `gains`: of the cascade, `Gains` [SI], none below zero; a `pressure_time` too fast for the
      plant raises a warning.
    - `band`: decrease of the demand before a unit is vented [N]; left out, 2 % of the largest
      unit's force at rest.
    - `dt`: the simulation's step [s].
    - `sample_time`: period of its commands [s], whole steps; left out, each step.
    - `delay`: dead time of the bench's valves and measurements [s]. It is declared, for a
      `pressure_time` that fits, and adds none; the lag of valves is the plant's.
    - `highest_pressure`: of its targets [Pa]; left out, the supply's.
    - `flow_limit`: largest opening of a valve [-].
    - `compensate`: feedforward of the plant's friction.
    - `co_contraction`: of each of a joint's bundles [N].

    **Raises:** `InvalidInputError` for arguments that don't fit.
    """
    check_choice(policy, POLICIES, "policy")
    check_choice(of, OF, "of")
    if of == "position" and isinstance(plant.load, PrescribedMotion):
        raise InvalidInputError("of", "must be force where the motion is given", of)
    if of == "position" and gains.position == 0:
        rule = "must be positive: without it the position isn't controlled"
        remedy = "begin with the stiffness of your load and muscles"
        raise InvalidInputError("position_gain", rule, 0.0, remedy)
    for name, value in gains._asdict().items():
        if name not in ("pressure_time", "observer_time"):
            check_nonnegative(value, f"{name} gain", "SI")
    step = float(check_positive(dt, "dt", "s", "such as 0.001"))
    period = check_positive(step if sample_time is None else sample_time, "sample_time", "s")
    every = round(float(period) / step)
    # whole but for the rounding of numbers in a file
    if every < 1 or abs(every - float(period) / step) > 1e-6 * every:
        rule = f"must be whole steps of {step:g} s"
        raise InvalidInputError("sample_time", rule, float(period), shown=f"{period:g} s")
    dead_time = check_nonnegative(delay, "delay", "s")
    supply, to_end = plant.supply_pressure, (False, True)
    highest = supply if highest_pressure is None else highest_pressure
    limits = 0.0, supply, "highest_pressure", "Pa", "of the supply", to_end
    highest = check_interval(highest, *limits)
    opening = check_interval(flow_limit, 0.0, 1.0, "flow_limit", "-", closed=to_end)
    units = tuple(ControlledUnits.from_plant(plant, side) for side in range(len(plant.bundles)))
    if band is None:
        at_rest = [x.branches.force(supply + 0 * x.counts, 0 * x.counts) for x in units]
        band = _BAND * float(np.max(plant.counts * np.concatenate(at_rest)))
    band = check_positive(band, "band", "N")
    policies = tuple(POLICIES[policy](band) for _ in units)
    derived, pressure_time = gains.pressure_time is None, gains.pressure_time
    if derived:
        late = valve_lag(plant) + pulse_delay(plant) + dead_time + step * every
        pressure_time = max(FASTEST, DAMPED * late)
    pressure_time = check_positive(pressure_time, "pressure_time", "s")
    observer = gains.observer_time
    if observer is None:
        observer = OBSERVER if policy == "hand_over" else np.inf
    observer = check_interval(observer, 0.0, np.inf, "observer_time", "s", closed=to_end)
    gains = gains._replace(pressure_time=pressure_time, observer_time=observer)
    gains = Gains(*map(np.float64, gains))
    friction = plant.hysteresis if compensate else None
    tension = check_nonnegative(co_contraction, "co_contraction", "N")
    highest, opening, tension, dead_time = map(np.float64, (highest, opening, tension, dead_time))
    parts = plant, units, policies, gains, highest, opening, friction, tension, dead_time
    controller = Cascade(*parts, np.float64(step), of, every)
    if controller.findings and not derived:
        late = f"{controller.findings[0].data['lateness']:g} s"
        text = f"pressure_time must be at least {late}, as late as valves and samples are: it is"
        warnings.warn(f"{text} {pressure_time:g} s.", stacklevel=2)
    return controller
