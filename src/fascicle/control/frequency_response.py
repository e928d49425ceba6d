r"""Frequency response: tracking of sines of many amplitudes and frequencies, and its energy.

All sines are one batch of a compiled program. The reference grows into its amplitude $A$ within a
first second; then whole periods are evaluated, so that stored energy doesn't count. The useful work
of a period is that of the muscles on the load while they pull it on,

$$W = \oint \max(F \dot q, 0)\, \mathrm{d}t, \tag{K5}$$

the work on the muscles as the load comes down is not subtracted.

A power unit feeds the bundle at the supply's pressure $P_s$. With the bundle's flow $Q$, over a
period,

$$W_{relief} = \frac{P_s \max Q}{\eta f}, \qquad
  W_{accumulator} = \frac{(P_s + b/2)}{\eta} \oint Q\, \mathrm{d}t, \qquad
  W_{sensing} = \frac{1}{\eta} \oint \min(P_{top} + c,\, P_s)\, Q\, \mathrm{d}t: \tag{K6}$$

`relief`, a pump of fixed displacement with the largest flow of that sine, the rest over a relief
valve; `accumulator`, a switched one that charges an accumulator over a band $b$ above $P_s$, from
which a reducer feeds the bundle; `sensing`, one that delivers the flow at the pressure $P_{top}$ of
the highest unit that takes fluid and $c$ more.

**Assumes** a supply of constant pressure, one overall efficiency $\eta$ everywhere, which real
pumps don't have, and a sensing pump whose lower pressure still drives the flow: it is a bound.
**Source:** a map of frequency and amplitude as by Kim and Bryant (2024); Merritt (1967), Hydraulic
Control Systems, for the kinds of power units, with sizes of our own; derived here.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Batch, Numbers, Values
from ..core.validation import check_interval, check_positive
from ..dynamics import Plant, State, simulate
from ..dynamics.outputs import STATUS, PlantOutputs
from ..dynamics.step_size import estimate_substeps
from .cascade import Cascade
from .metrics import reachability


POWER_UNITS = ("relief", "accumulator", "sensing")  # keys of `shaft_work`
_GROWTH_TIME = 1.0  # s, in which an amplitude is reached: several time constants of the loop
# bits of all statuses but harmless events
_DISTRUSTED = sum(1 << k for k, name in enumerate(STATUS) if name not in ("stop", "supply_empty"))


class FrequencyResponse(NamedTuple):
    """Tracking error, work and flow of a plant that follows sines of its reference.

    Amplitudes are on the first axis, frequencies on the second.

    `error`: root mean square over that of the reference [-]; `reachable_share`: fraction of steps
    whose reference was in reach [-]; useful `work` of a period [J]; `supply_flow` from the supply
    [kg/s] and `highest_pressure` [Pa] of the units that take fluid, with time on the last axis,
    `dt` [s] apart, over a `time` [s]; `is_valid`: true without a doubtful event.
    """

    amplitudes: Numbers
    frequencies: Numbers
    error: Numbers
    reachable_share: Numbers
    work: Numbers
    supply_flow: Numbers
    highest_pressure: Numbers
    dt: Batch
    time: Batch
    is_valid: Numbers


def frequency_response(
    plant: Plant,
    controller: Cascade,
    mean: Values,
    amplitudes: Values,
    frequencies: Values,
    start: State,
    time: Values = 2.0,
) -> FrequencyResponse:
    """Error, work and flow of a position-controlled plant that follows sines; no gain or phase.

    **Arguments:**

    - `plant`: the plant.
    - `controller`: of position, that acts at each step.
    - `mean`: of the sines [SI].
    - `amplitudes`: a row of them [SI].
    - `frequencies`: a row of them [1/s], each with whole periods in `time`.
    - `start`: initial state [SI].
    - `time`: that is evaluated [s].

    **Raises:** `InvalidInputError` for a controller of force, and periods that aren't whole.
    """
    A = np.atleast_1d(check_positive(amplitudes, "amplitudes", "SI"))
    f = np.atleast_1d(check_positive(frequencies, "frequencies", "1/s"))
    middle = float(check_interval(mean, -np.inf, np.inf, "mean", "SI"))
    span, dt = float(check_positive(time, "time", "s")), float(controller.dt)
    if controller.of != "position":
        raise InvalidInputError("controller", "must be one of position", controller.of)
    # whole but for rounding of the product, and not zero
    is_whole = (np.abs(f * span - np.round(f * span)) < 1e-9) & (f * span > 0.5)
    if not np.all(is_whole):
        rule = f"must have whole periods in {span:g} s"
        raise InvalidInputError("frequencies", rule, float(f[~is_whole][0]))
    steps = round((_GROWTH_TIME + span) / dt)
    times = dt * np.arange(steps)
    growth = np.minimum(times / _GROWTH_TIME, 1.0)
    growth = growth**2 * (3 - 2 * growth)  # without a jerk at either end
    sines = np.sin(2 * np.pi * f[:, None] * (times - _GROWTH_TIME))
    batch = (middle + A[:, None, None] * growth * sines).reshape(-1, steps)
    step_size = estimate_substeps(plant, dt)

    def simulate_reference(reference: Numbers) -> PlantOutputs:
        substeps = step_size.substeps
        return simulate(plant, controller, reference, dt=dt, start=start, substeps=substeps).outputs

    outputs = jax.tree.map(np.asarray, jax.vmap(simulate_reference)(jnp.asarray(batch)))
    late = slice(round(_GROWTH_TIME / dt), steps)

    def per_sine(values: Numbers) -> Numbers:
        """The `values` of all runs with axes of amplitudes and frequencies."""
        return np.reshape(values, (len(A), len(f), *np.shape(values)[1:]))

    deviation = outputs.position[:, 1:][:, late] - batch[:, late]
    rms = per_sine(np.sqrt(np.mean(deviation**2, axis=-1)))
    pull = np.sum(plant.lengths * plant.gains * outputs.forces, axis=-1)
    power = np.maximum(pull * outputs.velocity, 0.0)[:, late]
    work = per_sine(np.sum(power, axis=-1)) * dt / (span * f)
    runs = (PlantOutputs(*(field[k] for field in outputs)) for k in range(len(batch)))
    can = [
        np.mean(reachability(controller, run_outputs, reference).is_reachable[late])
        for run_outputs, reference in zip(runs, batch, strict=True)
    ]
    top = np.max(np.where(outputs.supply > 0, outputs.pressures, 0.0), axis=-1)[:, late]
    drawn = np.sum(np.maximum(outputs.drawn, 0.0), axis=-1)[:, late]
    trusted = ~np.any((outputs.status & _DISTRUSTED) > 0, axis=-1) & (not step_size.stiff)
    return FrequencyResponse(
        A, f, rms / (A[:, None] / np.sqrt(2)), per_sine(np.array(can)), work, per_sine(drawn),
        per_sine(top), dt, span, per_sine(trusted),
    )  # fmt: skip


def shaft_work(
    response: FrequencyResponse,
    supply_pressure: Values,
    density: Values,
    efficiency: Values = 0.8,
    band: Values = 80e3,
    margin: Values = 50e3,
) -> dict[str, Numbers]:
    """Shaft work of each of `POWER_UNITS` for a period [J], by name, equation (K6).

    **Arguments:**

    - `response`: the response [SI].
    - `supply_pressure`: gauge [Pa].
    - `density`: of the liquid [kg/m³].
    - `efficiency`: of pump and motor together [-], in (0, 1].
    - `band`: $b$ [Pa].
    - `margin`: $c$ [Pa].

    **Raises:** `InvalidInputError` for values off their intervals.
    """
    P_s = float(check_positive(supply_pressure, "supply_pressure", "Pa"))
    rho = float(check_positive(density, "density", "kg/m³"))
    eta = float(check_interval(efficiency, 0.0, 1.0, "efficiency", "-", closed=(False, True)))
    b = float(check_interval(band, 0.0, np.inf, "band", "Pa", closed=(True, False)))
    c = float(check_interval(margin, 0.0, np.inf, "margin", "Pa", closed=(True, False)))
    periods = response.time * response.frequencies
    Q = response.supply_flow / rho

    def per_period(values: Any) -> Numbers:
        return np.sum(values, axis=-1) * response.dt / periods

    return {
        "relief": P_s * np.max(Q, axis=-1) / (eta * response.frequencies),
        "accumulator": (P_s + b / 2) * per_period(Q) / eta,
        "sensing": per_period(np.minimum(response.highest_pressure + c, P_s) * Q) / eta,
    }
