r"""Delay and lag of a valve from its step response, and the margins of a pressure loop.

A valve opens at once at $t_0$. Its spool follows with the lag $\tau_v$ and all is seen late by the
delay $\theta$. The flow is proportional to the opening, so pressure is a function of the sum of
the opening alone, whatever the chamber is. That function is smooth, a polynomial of low degree:

$$P = \sum_k c_k s^k, \qquad s = u - \tau_v \left(1 - e^{-u/\tau_v}\right), \qquad
  u = \max(t - t_0 - \theta, 0). \tag{K7}$$

A record tells delay and lag apart only if it has enough samples while the spool moves, and little
noise. The polynomial has the highest degree with which both are known to 10 % of their sum: twice
the standard error, for 95 %. One degree less has to give the same within 10 %; else the record is
refused. Residuals of a curve that the polynomial misses are alike from sample to sample. So many
count as fewer, $n (1 - \rho)/(1 + \rho)$ with their autocorrelation $\rho$ (Bayley and Hammersley,
1946), and the standard errors grow.

The pressure loop (K3) is an integrator with that lag and delay,

$$L(s) = \frac{e^{-\theta s}}{\tau s\,(1 + \tau_v s)}: \tag{K8}$$

its phase margin is $\pi/2 - \omega_c \theta - \arctan \omega_c \tau_v$ where $|L| = 1$, its gain
margin $1/|L|$ where the phase is $-\pi$.

**Assumes** a constant supply, no collapse of the muscle on the way, and noise that is independent
from sample to sample. **Source:** Åström and Hägglund (2006), Advanced PID Control, for margins;
(K7) derived here.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, least_squares

from ..core.errors import InvalidInputError
from ..core.types import Values
from ..core.validation import check_finite, check_nonnegative, check_positive


_LEAST = 10  # samples after the step: more than the six numbers that are fitted
_DEGREES = (2, 3, 4)  # of the polynomial: 5 follows a kink of the chamber as if it were a lag
_SHARE = 0.8  # of the pressure's change: nearer its end the flow vanishes like a square root
_UNSURE = 0.1  # of delay and lag together: margins of a loop change by as much
_TWO_SIDED = 2.0  # standard errors, within which 95 % of estimates lie
# of the record: first guesses, closer where a valve's times usually are
_GUESSES = (0.005, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.55)


class StepResponse(NamedTuple):
    """Parameters of a step response of valve, chamber and measurement, (K7).

    `delay` $\\theta$ [s] and `lag` $\\tau_v$ [s], their standard errors `delay_error` and
    `lag_error` [s]; `error`: root mean square of the pressure that (K7) misses [Pa].
    """

    delay: float
    lag: float
    delay_error: float
    lag_error: float
    error: float

    @property
    def lateness(self) -> float:
        """Delay and lag together [s]."""
        return self.delay + self.lag


class LoopMargins(NamedTuple):
    """Margins of a pressure loop: `gain` [-] and `phase` [rad]."""

    gain: float
    phase: float


def identify(time: Values, command: Values, pressure: Values) -> StepResponse:
    """The `StepResponse` [s] of a valve: samples at each `time` [s] of its `command` [-], constant
    but for one step, and of the `pressure` in the unit's chamber [Pa].

    **Raises:** `InvalidInputError` for rows of unequal length, times that don't rise, a command
    without a step or with several, fewer than ten samples after it, and a pressure that doesn't
    tell delay and lag apart.
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
    change = np.abs(P - np.median(P[:first]))
    change[:first] = 0.0
    # the first sample of most of the change, and no fewer than are needed
    end = max(int(np.argmax(change >= _SHARE * change.max())) + 1, first + _LEAST)
    fits = [_fit(t[:end] - t[first], P[:end], degree) for degree in _DEGREES]
    # the highest degree that noise permits, and the one below
    errors = [_TWO_SIDED * max(fit.delay_error, fit.lag_error) for fit in fits]
    certain = [e <= _UNSURE * fit.lateness for e, fit in zip(errors, fits, strict=True)]
    last = max(1, len(fits) - 1 - int(np.argmax(certain[::-1])))
    best, other = fits[last], fits[last - 1]
    difference = max(abs(best.delay - other.delay), abs(best.lag - other.lag))
    doubt = max(difference, errors[last])
    sample = float(np.median(np.diff(t)))  # a delay within a sample is none that matters
    # written so that a doubt that isn't a number is one as well
    if not doubt <= max(_UNSURE * best.lateness, sample / 2):
        rule = f"must tell delay and lag apart, each within {100 * _UNSURE:.0f} % of their sum"
        remedy = "record a step between other pressures, faster samples, or less noise"
        text = f"an uncertainty of {1e3 * doubt:.3g} ms of {1e3 * best.lateness:.3g} ms"
        raise InvalidInputError("pressure", rule, doubt, remedy, shown=text)
    return best


def _fit(elapsed: np.ndarray, pressure: np.ndarray, degree: int) -> StepResponse:
    """Fit (K7) with a polynomial of a `degree` to a `pressure` [Pa] at times since the step [s]."""
    span = float(elapsed[-1])
    scale = max(float(np.ptp(pressure)), 1.0)

    def residuals(values: np.ndarray) -> np.ndarray:
        delay, lag = values * span
        u, lag = np.maximum(elapsed - delay, 0.0), max(lag, 1e-9 * span)  # no division by zero
        s = (u + lag * np.expm1(-u / lag)) / span
        columns = (s / max(s[-1], 1e-9))[:, None] ** np.arange(degree + 1)
        return (pressure - columns @ np.linalg.lstsq(columns, pressure, rcond=None)[0]) / scale

    guesses = [np.array([delay, lag]) for delay in _GUESSES for lag in _GUESSES]
    guess = min(guesses, key=lambda values: float(np.sum(residuals(values) ** 2)))
    fit = least_squares(residuals, guess, bounds=(0.0, 1.0), x_scale=0.05, diff_step=1e-3)
    variance = 2 * fit.cost / max(len(elapsed) - degree - 3, 1)
    correlation = max(float(fit.fun[1:] @ fit.fun[:-1] / max(fit.fun @ fit.fun, 1e-300)), 0.0)
    variance *= (1 + correlation) / (1 - correlation)
    covariance = variance * np.linalg.pinv(fit.jac.T @ fit.jac)
    errors = span * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    # a flat row has no slope, whose inverse would claim certainty
    errors = np.where(np.any(fit.jac != 0, axis=0), errors, np.inf)
    missed = scale * float(np.sqrt(np.mean(fit.fun**2)))
    return StepResponse(*map(float, (*(span * fit.x), *errors, missed)))


def loop_margins(pressure_time: Values, lag: Values, delay: Values) -> LoopMargins:
    """Gain margin [-], inf without a delay, and phase margin [rad] of a pressure loop, (K8), with
    the time constant $\\tau$ `pressure_time` [s], the valve's `lag` [s], and the `delay` [s] of
    measurement and samples together; `InvalidInputError` for times below zero.
    """
    tau = float(check_positive(pressure_time, "pressure_time", "s"))
    tau_v = float(check_nonnegative(lag, "lag", "s"))
    theta = float(check_nonnegative(delay, "delay", "s"))
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
