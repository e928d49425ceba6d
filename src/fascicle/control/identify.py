r"""Delay and lag of a valve from its step response, and the margins of a pressure loop.

A valve opens at once at $t_0$. Its spool follows with the lag $\tau_v$, the chamber fills with a
time constant $T$ that is longer, and all is seen late by $\theta$:

$$P = P_0 + \Delta P \left[1 - \frac{T e^{-u/T} - \tau_v e^{-u/\tau_v}}{T - \tau_v}\right], \qquad
  u = \max(t - t_0 - \theta, 0). \tag{K7}$$

The pressure loop (K3) is an integrator with that lag and delay,

$$L(s) = \frac{e^{-\theta s}}{\tau s\,(1 + \tau_v s)}: \tag{K8}$$

its phase margin is $\pi/2 - \omega_c \theta - \arctan \omega_c \tau_v$ where $|L| = 1$, its gain
margin $1/|L|$ where the phase is $-\pi$.

**Assumes** a chamber that fills at one rate: take a step at rest without collapse on its way.
**Source:** Åström and Hägglund (2006), Advanced PID Control, for margins and models of processes;
(K7) is the step response of two lags and a delay.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, least_squares

from ..core.errors import InvalidInputError
from ..core.types import Values
from ..core.validation import check_finite, check_interval, check_positive


_STARTS = (0.02, 0.1, 0.3)  # of the response's length: delays and lags where a search begins
_LEAST = 10  # samples after the step: five numbers are fitted
_RESPONSE = 0.5  # of the record's variance that (K7) must explain: else noise hides the step
_RATIO = 1.01  # of the chamber's time constant over the lag at least: (K7) has no pole there


class StepResponse(NamedTuple):
    """Parameters of a step response of valve, chamber and measurement, (K7).

    `delay` $\\theta$ [s], `lag` $\\tau_v$ [s], `fill_time` $T$ [s]; `error`: root mean square of
    the pressure that (K7) misses [Pa].
    """

    delay: float
    lag: float
    fill_time: float
    error: float

    @property
    def lateness(self) -> float:
        """Delay and lag together [s], which a record determines better than each of them."""
        return self.delay + self.lag


class LoopMargins(NamedTuple):
    """Margins of a pressure loop: `gain` [-] and `phase` [rad]."""

    gain: float
    phase: float


def identify(time: Values, command: Values, pressure: Values) -> StepResponse:
    """Identify delay and lag of a valve from its step response.

    **Arguments:**

    - `time`: of the samples, rising [s].
    - `command`: to the valve [-], constant but for one step.
    - `pressure`: measured in the unit's chamber [Pa].

    **Returns:** the `StepResponse` [s].

    **Raises:** `InvalidInputError` for rows of unequal length, times that don't rise, a command
    without a step or with several, fewer than ten samples after it, and a pressure that doesn't
    follow it.
    """
    t = np.atleast_1d(check_finite(time, "time", "s"))
    z = np.atleast_1d(check_finite(command, "command", "-"))
    P = np.atleast_1d(check_finite(pressure, "pressure", "Pa"))
    if t.ndim != 1 or np.any(np.diff(t) <= 0):
        raise InvalidInputError("time", "must be a row that rises", None)
    for name, row in (("command", z), ("pressure", P)):
        if row.shape != t.shape:
            raise InvalidInputError(name, "must have one value for each time", np.size(row))
    steps = np.flatnonzero(np.diff(z) != 0)
    if len(steps) != 1:
        raise InvalidInputError("command", "must have one step", len(steps), "cut the record")
    first = int(steps[0]) + 1
    if len(t) - first < _LEAST:
        rule = f"must have at least {_LEAST} samples after the step"
        raise InvalidInputError("time", rule, len(t) - first, "record longer")
    elapsed, span = t - t[first], float(t[-1] - t[first])

    def response(values: np.ndarray) -> np.ndarray:
        delay, lag, ratio = np.exp(values)
        T = lag * (_RATIO + ratio)
        u = np.maximum(elapsed - delay, 0.0)
        return 1 - (T * np.exp(-u / T) - lag * np.exp(-u / lag)) / (T - lag)

    def residuals(values: np.ndarray) -> np.ndarray:
        columns = np.stack([np.ones_like(t), response(values)], axis=1)
        return P - columns @ np.linalg.lstsq(columns, P, rcond=None)[0]

    # 1e-3 of the span is less than a sample; a chamber slower than 1e3 lags fills evenly
    low = np.log([1e-4 * span, 1e-4 * span, 1e-2])
    high = np.log([0.9 * span, 0.9 * span, 1e3])
    starts = [np.log([a * span, b * span, 5.0]) for a in _STARTS for b in _STARTS]
    scale = max(float(np.ptp(P)), 1.0)
    fits = [
        least_squares(lambda x: residuals(x) / scale, x, bounds=(low, high), x_scale=0.1)
        for x in starts
    ]
    best = min(fits, key=lambda fit: fit.cost)
    delay, lag, ratio = np.exp(best.x)
    error = float(np.sqrt(np.mean(residuals(best.x) ** 2)))
    spread = float(np.std(P))
    if not error**2 < (1 - _RESPONSE) * spread**2:
        rule = "must follow the step, but its noise is as large as its change"
        remedy = "record a larger step, or check sensor and valve"
        text = f"a standard deviation of {spread:.3g} Pa"
        raise InvalidInputError("pressure", rule, spread, remedy, shown=text)
    return StepResponse(float(delay), float(lag), float(lag * (_RATIO + ratio)), error)


def loop_margins(pressure_time: Values, lag: Values, delay: Values) -> LoopMargins:
    """Gain and phase margin of a pressure loop, (K8).

    **Arguments:**

    - `pressure_time`: time constant $\\tau$ of the loop [s].
    - `lag`: of the valve [s], zero or more.
    - `delay`: of measurement and samples together [s], zero or more.

    **Returns:** the margins; a gain margin of inf without a delay.

    **Raises:** `InvalidInputError` for times below zero.
    """
    tau = float(check_positive(pressure_time, "pressure_time", "s"))
    tau_v = float(check_interval(lag, 0.0, np.inf, "lag", "s", closed=(True, False)))
    theta = float(check_interval(delay, 0.0, np.inf, "delay", "s", closed=(True, False)))
    # |L| = 1: a quadratic in the frequency's square, in a form that is exact without a lag
    crossover = np.sqrt(2 / tau**2 / (1 + np.sqrt(1 + 4 * (tau_v / tau) ** 2)))
    phase = np.pi / 2 - crossover * theta - np.arctan(crossover * tau_v)
    if theta == 0:
        return LoopMargins(np.inf, float(phase))
    last = np.pi / 2 / theta  # where the delay alone turns the phase

    def excess(frequency: float) -> float:
        return frequency * theta + float(np.arctan(frequency * tau_v)) - np.pi / 2

    turn: float = brentq(excess, 0.0, last)  # pyright: ignore[reportAssignmentType] no full output
    return LoopMargins(turn * tau * float(np.hypot(1, turn * tau_v)), float(phase))
