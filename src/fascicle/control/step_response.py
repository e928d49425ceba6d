r"""Delay and lag of a valve from its step response, and the margins of a pressure loop.

A valve is opened at $t_0$. Its spool follows with the lag $\tau_v$, and all is seen late by the
delay $\theta$. With a share $\varphi$ of its final flow at a share of its travel, the pressure is a
function of the sum of the flow's share, whatever its course was,

$$P = \Phi(c\, s), \qquad s = \int_0^u \varphi\left(1 - e^{-u'/\tau_v}\right) \mathrm{d}u',
  \qquad u = \max(t - t_0 - \theta, 0), \tag{K7}$$

and the plant's chamber and valve, opened by the command at once, give $\Phi$. Without a hose the
flow is proportional to the opening, $\varphi(x) = x$: exact for an isothermal gas and a liquid, it
misses only what heat flows while the spool moves. A hose's $\varphi$ is the plant's at the first
pressure, which hardly changes while the spool moves. Delay, lag, the first pressure, and $c$, what
the valve lets pass over the plant's, are fitted by least squares. Residuals of a plant that differs
from the bench are alike from sample to sample. So many count as fewer, $n (1 - \rho)/(1 + \rho)$
with their autocorrelation $\rho$ (Bayley and Hammersley, 1946). What delay and lag change by if $c$
may vary along the way, $c\,(1 + a s)$, is added to their standard errors, and $\Delta t/\sqrt{12}$,
as no record shows what happens between its samples.

The pressure loop (K3) is an integrator with that lag and delay,

$$L(s) = \frac{e^{-\theta s}}{\tau s\,(1 + \tau_v s)}: \tag{K8}$$

its phase margin is $\pi/2 - \omega_c \theta - \arctan \omega_c \tau_v$ where $|L| = 1$, its gain
margin $1/|L|$ where the phase is $-\pi$.

**Assumes** a held load, a constant supply, and noise that is independent from sample to sample.
**Source:** Åström and Hägglund (2006), Advanced PID Control, for margins; (K7) derived here.
"""

import itertools
from typing import NamedTuple

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.optimize import brentq, least_squares

from ..core.errors import InvalidInputError
from ..core.module import with_fields
from ..core.types import Numbers, Values
from ..core.validation import check_finite, check_nonnegative, check_positive
from ..dynamics import Plant, State
from ..dynamics.chamber_pressure import evaluate_chambers
from ..dynamics.motion import evaluate_flows
from ..fluid import Direct


_LEAST = 10  # samples after the step: twice the numbers that are fitted
_STEPS = 400  # of a chamber's curve in the record's time: within 1e-4 of its change
_LONGEST = 10  # times the record's time, if the valve lets pass as much less than the plant's
_SHARE = 0.8  # of the pressure's change: the slow end tells nothing of the spool
_UNSURE = 0.1  # of delay and lag together: margins of a loop change by as much
_TWO_SIDED = 2.0  # standard errors, within which 95 % of estimates lie
_TRAVEL = np.linspace(0.0, 20.0, 2001)  # time over lag: at its end a spool is open to 2e-9
_BEYOND = 1.2  # times the change of a record, up to which a curve goes
# first guesses, of the record's time: closer where a valve's times usually are
_GUESSES = (0.005, 0.02, 0.05, 0.1, 0.2, 0.3, 0.45)


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
    """Margins of a pressure loop: `gain`, a factor on its gain, not decibels [-], and `phase`, in
    radians [rad].
    """

    gain: float
    phase: float


def identify(
    time: Values,
    command: Values,
    pressure: Values,
    plant: "Plant",
    unit: int = 1,
    position: Values = 0.0,
) -> StepResponse:
    """Delay and lag of a valve from a record of its step response.

    **Arguments:**

    - `time`: of each sample, rising [s].
    - `command`: at each sample, zero up to one step [-].
    - `pressure`: in the unit's chamber at each sample [Pa].
    - `plant`: whose chamber and valve are recorded; its spool and delays don't count.
    - `unit`: the motor unit, counted from 1.
    - `position`: at which the load is held [m or rad]; a prescribed motion has its own.

    **Returns:** a `StepResponse` [s]. **Raises:** `InvalidInputError` for rows of unequal length,
    times that don't rise, a command without one step from zero, fewer than ten samples after it, a
    unit that doesn't exist, and a pressure that can't follow the step or doesn't tell delay and lag
    apart.
    """
    t = np.atleast_1d(check_finite(time, "time", "s"))
    z = np.atleast_1d(check_finite(command, "command", "-"))
    P = np.atleast_1d(check_finite(pressure, "pressure", "Pa"))
    if t.ndim != 1 or np.any(np.diff(t) <= 0):
        raise InvalidInputError("time", "must be a row that rises", None)
    for name, row in (("command", z), ("pressure", P)):
        if row.shape != t.shape:
            raise InvalidInputError(name, "must have one value for each time", np.size(row))
    if unit not in range(1, plant.units + 1):
        raise InvalidInputError("unit", f"must be from 1 to {plant.units}", unit)
    steps = np.flatnonzero(np.diff(z) != 0)
    if len(steps) != 1 or z[0] != 0:
        rule = "must be zero and then have one step"
        raise InvalidInputError("command", rule, len(steps), "cut the record", f"{len(steps)}")
    first = int(steps[0]) + 1
    if len(t) - first < _LEAST:
        rule = f"must have at least {_LEAST} samples after the step"
        raise InvalidInputError("time", rule, len(t) - first, "record longer")
    start = float(np.median(P[:first]))
    change = np.abs(P - start)
    change[:first] = 0.0
    # the first sample of most of the change, and no fewer than are needed
    end = max(int(np.argmax(change >= _SHARE * change.max())) + 1, first + _LEAST)
    q = plant.load.motion_at(0.0, float(check_finite(position, "position", "SI")), 0.0)[0]
    opening, filling = float(z[first]), bool(z[first] > 0)
    start = max(start, 0.0)
    if start >= plant.supply_pressure if filling else start <= 0:
        rule = "must begin below the supply's" if filling else "must begin above the room's"
        raise InvalidInputError("pressure", f"{rule} for this step", start, shown=f"{start:g} Pa")
    rows = t[:end] - t[first], P[:end]
    chamber = plant, unit - 1, float(q), start, opening
    # heat flows in time, so that the curve depends on the valve's size, by little
    _, size = _fit(*rows, _chamber_curve(*chamber, 1.0, *rows), 1.0, bends=0)
    curve = _chamber_curve(*chamber, size, *rows)
    (best, _), (bent, _) = (_fit(*rows, curve, size, bends) for bends in (0, 1))
    sample = float(np.median(np.diff(t)))
    misfit = np.array([best.delay - bent.delay, best.lag - bent.lag])
    errors = np.array([best.delay_error, best.lag_error])
    errors = np.sqrt(errors**2 + misfit**2 + sample**2 / 12)
    doubt = _TWO_SIDED * float(np.max(errors))
    # written so that a doubt that isn't a number is one as well
    if not doubt <= _UNSURE * best.lateness:
        rule = f"must tell delay and lag apart, each within {100 * _UNSURE:.0f} % of their sum"
        remedy = "record faster, a larger step, or with less noise, where `plant` is right"
        text = f"an uncertainty of {1e3 * doubt:.3g} ms of {1e3 * best.lateness:.3g} ms"
        raise InvalidInputError("pressure", rule, doubt, remedy, shown=text)
    return best._replace(delay_error=float(errors[0]), lag_error=float(errors[1]))


class _Curve(NamedTuple):
    """Pressures in a chamber [Pa] after each of the `sums` of its flow's share [s]; `shares`: that
    sum over the spool's lag, after each time of `_TRAVEL` [-].
    """

    sums: Numbers
    pressures: Numbers
    shares: Numbers


def _chamber_curve(
    plant: Plant,
    index: int,
    position: float,
    start: float,
    opening: float,
    size: float,
    elapsed: Numbers,
    pressure: Numbers,
) -> _Curve:
    """Pressures in the chamber of a `plant`'s unit of an `index`, with the load at a `position`
    [SI], from a pressure `start` [Pa] to beyond a record's last `pressure` [Pa], by Heun's method
    in steps of its `elapsed` time [s], with the valve at an `opening` [-], negative to the room,
    and `size` times the plant's [-].
    """
    chamber, supply, strains = plant.chamber, plant.supply.initial_state(), plant.strains(position)
    plant = with_fields(plant, spool=Direct())
    P, command = np.zeros(plant.units), np.zeros(plant.units)
    P[index], command[index] = start, opening
    s, rows = plant.chambers_at(P, position), [start]
    h, target = elapsed[-1] / _STEPS, _BEYOND * abs(pressure[-1] - start)

    def rates(s: Numbers, P: Numbers) -> tuple[Numbers, Numbers]:
        fluid = evaluate_chambers(plant, s, strains, P)
        flows = evaluate_flows(plant, State(position, 0.0, P[:0], s, P, supply), P, command)
        inflow = size * flows.mass, size * flows.enthalpy
        P_dot = fluid.pressure_rate(chamber.rates(s, P, *inflow, 0.0), 0.0)
        return chamber.rates(s, P, *inflow, fluid.by_pressure * P_dot), P_dot

    with np.errstate(all="ignore"):  # of branches that aren't taken
        point, travels = State(position, 0.0, P[:0], s, P, supply), -np.expm1(-_TRAVEL)[:, None]
        flow = evaluate_flows(plant, point, P, travels * command).mass[:, index]
        while abs(rows[-1] - start) < target and len(rows) < _LONGEST * _STEPS:
            s_1, P_1 = rates(s, P)
            s_2, P_2 = rates(s + h * s_1, P + h * P_1)
            s, P = s + h / 2 * (s_1 + s_2), P + h / 2 * (P_1 + P_2)
            rows.append(float(P[index]))
    shares = cumulative_trapezoid(flow / flow[-1], _TRAVEL, initial=0.0)
    return _Curve(size * h * np.arange(len(rows)), np.array(rows), shares)


def _fit(
    elapsed: Numbers, pressure: Numbers, curve: _Curve, size: float, bends: int
) -> tuple[StepResponse, float]:
    """Fit (K7) with a chamber's `curve` [Pa] to a `pressure` [Pa] at times since a step, from
    a guess of the valve's `size` [-]: the response, and $c$ [-], which varies along the way with
    one of `bends`.
    """
    span = float(elapsed[-1])
    scale = max(float(np.ptp(pressure)), 1.0)

    def residuals(values: np.ndarray) -> np.ndarray:
        delay, lag, offset, log_size, *bend = values
        u, lag = np.maximum(elapsed - delay * span, 0.0), max(lag, 1e-9) * span
        # beyond the spool's travel the valve is open
        s = lag * np.interp(u / lag, _TRAVEL, curve.shares)
        s += np.maximum(u - lag * _TRAVEL[-1], 0.0)
        flow_sum = np.exp(log_size) * s * (1 + sum(bend) * s / span)
        return (np.interp(flow_sum, curve.sums, curve.pressures) - pressure) / scale + offset

    sizes = np.log(size) + np.log([0.5, 1.0, 2.0])
    guesses = [np.array(row) for row in itertools.product(_GUESSES, _GUESSES, [0.0], sizes)]
    guess = min(guesses, key=lambda values: float(np.sum(residuals(values) ** 2)))
    guess = np.append(guess, np.zeros(bends))
    low, high = np.array([0.0, 0.0, -1.0, -9.0, -9.0]), np.array([1.0, 1.0, 1.0, 9.0, 9.0])
    n = len(guess)
    fit = least_squares(residuals, guess, bounds=(low[:n], high[:n]), x_scale=0.05, diff_step=1e-4)
    variance = 2 * fit.cost / max(len(elapsed) - n, 1)
    correlation = max(float(fit.fun[1:] @ fit.fun[:-1] / max(fit.fun @ fit.fun, 1e-300)), 0.0)
    variance *= (1 + correlation) / (1 - correlation)
    covariance = variance * np.linalg.pinv(fit.jac.T @ fit.jac)
    errors = span * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    # a pressure that hasn't moved yet, or never does, says nothing, and with no doubt
    if np.sum(elapsed > fit.x[0] * span) < n or not np.any(fit.jac[:, 0]):
        errors += np.inf
    rmse = scale * float(np.sqrt(np.mean(fit.fun**2)))
    response = StepResponse(*map(float, (*(span * fit.x[:2]), *errors[:2], rmse)))
    return response, float(np.exp(fit.x[3]))


def loop_margins(pressure_time: Values, lag: Values, delay: Values) -> LoopMargins:
    """Gain margin, a factor [-], inf without a delay, and phase margin [rad] of a pressure loop,
    (K8), with the time constant $\\tau$ `pressure_time` [s], the valve's `lag` [s], and the `delay`
    [s] of measurement and samples together; `InvalidInputError` for times below zero.
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
