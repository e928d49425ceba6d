r"""Sines of many amplitudes and frequencies in one batch: how they are followed, at what price.

Each is a run of its own, all of them one compiled program. The reference grows into its amplitude
$A$ within a first second; then whole periods are looked at, so that nothing that is stored counts.
The useful work of a period is what the muscles do on the load while they pull it on,

$$W = \oint \max(F \dot q, 0)\, \mathrm{d}t, \tag{K5}$$

what they hold back as it comes down is not taken off.

**Assumes** a supply whose pressure stays: what a power unit takes for it follows from the flow.
**Source:** a map of frequency and amplitude as Kim and Bryant (2024) show one; derived here.
"""

from typing import NamedTuple

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


_GROWS = 1.0  # s, in which an amplitude is reached
_DISTRUSTED = sum(1 << k for k, name in enumerate(STATUS) if name not in ("stop", "supply_empty"))


class FrequencyResponse(NamedTuple):
    """Of each amplitude, in rows, and frequency: the `error`, root mean square over the amplitude's
    own [-]; the share of moments that could be `reached` [-]; a period's useful `work` [J]; what
    was `drawn` [kg/s] at each moment and the largest pressure of a unit that was fed then, `top`
    [Pa], both with time on the last axis, `dt` [s] apart, of a `time` [s]; whether each one can be
    `trusted` [-].
    """

    amplitudes: Numbers
    frequencies: Numbers
    error: Numbers
    reached: Numbers
    work: Numbers
    drawn: Numbers
    top: Numbers
    dt: Batch
    time: Batch
    trusted: Numbers


def frequency_response(
    plant: Plant,
    controller: Cascade,
    mean: Values,
    amplitudes: Values,
    frequencies: Values,
    start: State,
    time: Values = 2.0,
) -> FrequencyResponse:
    """A map of amplitude and frequency.

    **Arguments:**

    - `plant`: whose load moves [-].
    - `controller`: of position, that acts at each step [-].
    - `mean`: of the sines [SI].
    - `amplitudes`: a row of them [SI].
    - `frequencies`: a row of them [1/s], each with whole periods in `time`.
    - `start`: the state they begin with [SI].
    - `time`: that is looked at [s].

    **Returns:** `Sines` [SI], amplitudes on the first axis.

    **Raises:** `ValueError` for a controller of force, and periods that aren't whole.
    """
    A = np.atleast_1d(check_positive(amplitudes, "amplitudes", "SI"))
    f = np.atleast_1d(check_positive(frequencies, "frequencies", "1/s"))
    middle = float(check_interval(mean, -np.inf, np.inf, "mean", "SI"))
    span, dt = float(check_positive(time, "time", "s")), float(controller.dt)
    if controller.of != "position":
        raise InvalidInputError("controller", "must be one of position", controller.of)
    is_whole = np.abs(f * span - np.round(f * span)) < 1e-9
    if not np.all(is_whole & (f * span > 0.5)):
        rule = f"must have whole periods in {span:g} s"
        raise InvalidInputError(
            "frequencies", rule, float(f[~is_whole][0]) if np.any(~is_whole) else float(f[0])
        )
    steps = round((_GROWS + span) / dt)
    times = dt * np.arange(steps)
    grown = np.minimum(times / _GROWS, 1.0)
    grown = grown**2 * (3 - 2 * grown)  # without a jerk at either end
    periods = np.sin(2 * np.pi * f[:, None] * (times - _GROWS))
    target = middle + A[:, None, None] * grown * periods
    batch = target.reshape(-1, steps)
    outputs_batch = estimate_substeps(plant, dt)

    def run(reference: Numbers) -> PlantOutputs:
        how = {"dt": dt, "start": start, "substeps": outputs_batch.substeps}
        return simulate(plant, controller, reference, **how).outputs

    outputs = jax.tree.map(np.asarray, jax.vmap(run)(jnp.asarray(batch)))
    late = slice(round(_GROWS / dt), steps)

    def shaped(values: Numbers) -> Numbers:
        return values.reshape(len(A), len(f), *values.shape[1:])

    missed = outputs.position[:, 1:][:, late] - batch[:, late]
    rms = np.sqrt(np.mean(missed**2, axis=-1)).reshape(len(A), len(f))
    pull = np.sum(plant.lengths * plant.gains * outputs.forces, axis=-1)
    power = np.maximum(pull * outputs.velocity, 0.0)[:, late]
    work = np.sum(power, axis=-1).reshape(len(A), len(f)) * dt / (span * f)
    can = [
        np.mean(
            reachability(controller, PlantOutputs(*(field[k] for field in outputs)), target).can[
                late
            ]
        )
        for k, target in enumerate(batch)
    ]
    pressurized = outputs.supply > 0
    top = np.max(np.where(pressurized, outputs.pressures, 0.0), axis=-1)[:, late]
    drawn = np.sum(np.maximum(outputs.drawn, 0.0), axis=-1)[:, late]
    ok = ~np.any((outputs.status & _DISTRUSTED) > 0, axis=-1) & (not outputs_batch.stiff)
    return FrequencyResponse(
        A, f, rms / (A[:, None] / np.sqrt(2)), np.reshape(can, (len(A), len(f))), work,
        shaped(drawn), shaped(top), dt, span, ok.reshape(len(A), len(f)),
    )  # fmt: skip
