r"""Blocked force and free strain, read from the data, and $C_1(P)$, $C_2(P)$ from them.

At each pressure the measured pull is regressed on the law's own untuned force $T$, near
zero strain for the blocked force and near the free strain for the free strain: locally
$F = a + b T$, so

$$\hat F_{blocked} = a + b\, T(0), \qquad \hat C_1 = -a/b, \qquad
  T(\hat\varepsilon_f) = \hat C_1. \tag{34}$$

The law carries the curve's shape, so a straight line is enough, and few readings do.
The variances follow from the regression's.

Between the measured pressures both are smooth: the blocked force is linear above a
threshold, $\hat F_{blocked} = a (P - P_0)$, as the paper says, and the free strain is the
untuned law's times a low-order polynomial in pressure, $\hat\varepsilon_f(P) = \varepsilon_f(P)\,
q(P)$. The paper makes the free strain itself such a polynomial; the quotient needs a lower
order, since the law knows how the strain saturates, and vanishes without pressure of itself.
With them

$$C_1(P) = T(\hat\varepsilon_f, P), \qquad
  C_2(P) = \frac{\hat F_{blocked}}{T(0, P) - C_1}. \tag{35}$$

**Source:** Kim, Mazzoleni and Bryant (2021), (31)-(35); Meller, Bryant and Garcia (2014).
"""

from dataclasses import dataclass
from typing import Any

import jax.numpy as jnp
import numpy as np

from ...core.roots import guarded
from ...core.types import AnyArray, Float
from ...muscle import Muscle
from .grid import Grid
from .pulling import force_of, free_strain_at, strain_of, tension_of, untuned
from .regression import Polynomial, line, polynomial, safe, scatter


_NEAR = 0.3  # of the free strain: how far a reading looks, as a Gaussian's deviation
_PULLING = 0.15  # of the level's largest force: readings above it surely pull
_NO_PRESSURE = 0.01  # of the highest pressure: below, nothing can be read [R13]
ORDERS = 4  # of the free strain's quotient: constant to cubic

Level = Float[AnyArray, "level"]


@dataclass(frozen=True, eq=False)
class Readings:
    """What was read at each level of pressure, and the smooth curves through it.

    - `pressure`: of each level [Pa].
    - `free_strain`, `blocked_force`: read there [-], [N], with standard deviations.
    - `valid`: whether there was enough to read [-].
    - `noise`: standard deviation of a single force reading [N].
    - `coefficients`: the quotient's polynomial [-] in pressure over the highest, then the
      blocked force's level and slope [N] over the same; `covariance` theirs.
    - `order`: of the polynomial [-].
    - `misfit`: squared deviations from the curves, over their expectation [-]; 1 where the
      curves are as good as the readings.
    - `alone`: where the curves were fitted together with what resists (`joint`), the coefficients
      and covariance that the pull alone gives them [-], [N]; else `None`.
    """

    pressure: np.ndarray
    free_strain: np.ndarray
    free_strain_deviation: np.ndarray
    blocked_force: np.ndarray
    blocked_force_deviation: np.ndarray
    valid: np.ndarray
    noise: float
    coefficients: np.ndarray
    covariance: np.ndarray
    order: int
    misfit: np.ndarray
    alone: tuple[np.ndarray, np.ndarray] | None = None


def read(muscle: Muscle, data: Grid) -> Readings:
    """Readings [-] of `data` [-] against the `muscle`'s untuned tension law [-]."""
    law = untuned(muscle)
    P, strain = np.asarray(data.pressure)[:, 0], np.asarray(data.strain)
    count, F = np.asarray(data.count), np.asarray(data.force)
    top, zero = _top(P), np.zeros(P.shape)
    pressed = (_NO_PRESSURE * top < P) & np.any(count > 0, axis=1)
    T, at_rest = force_of(law, P[:, None], strain)[0], force_of(law, P, zero)[0]
    free_th = strain_of(law, P, zero)

    # which readings pull: a first line through those that surely do tells where force ends
    w = np.where(np.asarray(data.uncensored), count, 0.0)
    surely = w * (_PULLING * np.max(np.where(w > 0, F, 0.0), axis=1, keepdims=True) < F)
    ends = strain_of(law, P, line(T, F, surely, count).offset)
    pulling = w * (strain <= ends[:, None])

    scale = safe(_NEAR * ends[:, None])
    near_rest = pulling * np.exp(-0.5 * (strain / scale) ** 2)
    near_end = pulling * np.exp(-0.5 * ((strain - ends[:, None]) / scale) ** 2)
    start, end = line(T, F, near_rest, count), line(T, F, near_end, count)
    noise = scatter(T, F, pulling * pressed[:, None])

    blocked = start.value + start.slope * (at_rest - start.center)
    blocked_sd = noise * np.sqrt(start.at(at_rest))
    c1 = end.offset
    c1_sd = noise * np.sqrt(end.at(c1)) / safe(np.abs(end.slope))
    free = strain_of(law, P, c1)
    fall = force_of(law, P, free)[1]
    free_sd = c1_sd / safe(np.abs(fall))
    enough = (np.sum(pulling > 0, axis=1) >= 2) & (end.slope > 0) & (start.slope > 0) & pressed
    valid = enough & np.isfinite(blocked_sd + free_sd + free) & (free > 0) & (free_th > 0)
    over, share = safe(free_th), P / top
    quotient = _quotient(share[valid], (free / over)[valid], (free_sd / over)[valid])
    straight = polynomial(share[valid], blocked[valid], blocked_sd[valid], 1, 2)
    none = np.zeros((ORDERS, 2))
    return Readings(
        P, free, free_sd, blocked, blocked_sd, valid, noise,
        np.concatenate([quotient[1].coefficients, straight.coefficients]),
        np.block([[quotient[1].covariance, none], [none.T, straight.covariance]]),
        quotient[0], np.array([quotient[1].misfit, straight.misfit]),
    )  # fmt: skip


def _quotient(
    share: np.ndarray, value: np.ndarray, deviation: np.ndarray
) -> tuple[int, Polynomial]:
    """The order of the free strain's quotient, and its polynomial in pressure."""
    n = share.size
    fits = [
        polynomial(share, value, deviation, order, ORDERS)
        for order in range(min(ORDERS, max(n, 1)))  # never more terms than readings
    ]
    # by Schwarz's criterion
    scores = [one.squares + (order + 1) * np.log(n + 1.0) for order, one in enumerate(fits)]
    order = int(np.argmin(scores))
    return order, fits[order]


def free_strain_of(
    muscle: Muscle, coefficients: Float[AnyArray, "coefficient"], pressure: Level, top: Any = None
) -> Level:
    """Free strain [-] of the smooth curves with `coefficients` at each `pressure` [Pa], which
    they take over `top` [Pa], the largest one if left out; 0 without pressure [R13].
    """
    share = pressure / (_highest(pressure) if top is None else top)
    quotient = jnp.polyval(coefficients[:ORDERS][::-1], share)
    free = free_strain_at(untuned(muscle), pressure, jnp.zeros_like(pressure)) * quotient
    return jnp.where(share > _NO_PRESSURE, free, 0.0)


def smooth_free_strain(muscle: Muscle, readings: Readings) -> tuple[np.ndarray, np.ndarray]:
    """The smooth curve's free strain [-] at each level, and its standard deviation [-]."""
    P = readings.pressure
    share = P / _top(P)
    basis = share[:, None] ** np.arange(ORDERS)
    mean, covariance = readings.coefficients[:ORDERS], readings.covariance[:ORDERS, :ORDERS]
    variance = np.einsum("li,ij,lj->l", basis, covariance, basis)
    free = np.where(share > _NO_PRESSURE, strain_of(untuned(muscle), P, np.zeros(P.shape)), 0.0)
    return free * (basis @ mean), free * np.sqrt(np.maximum(variance, 0.0))


def tables_of(
    muscle: Muscle, readings: Readings, pressure: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """`tables` of `readings` [-] at any `pressure` [Pa]."""
    law, share = untuned(muscle), pressure / _top(readings.pressure)
    some = (share > _NO_PRESSURE) & (pressure > float(muscle.tuning.dead_band))
    quotient = np.polyval(readings.coefficients[:ORDERS][::-1], share)
    free = strain_of(law, pressure, np.zeros(pressure.shape)) * quotient
    blocked = readings.coefficients[ORDERS] + readings.coefficients[ORDERS + 1] * share
    c1, at_rest = (force_of(law, pressure, strain)[0] for strain in (free, 0 * free))
    return np.where(some, c1, 0.0), np.where(some, blocked / safe(at_rest - c1), 1.0)


def tables(
    muscle: Muscle, coefficients: Float[AnyArray, "coefficient"], pressure: Level, top: Any = None
) -> tuple[Level, Level]:
    """$C_1$ [N] and $C_2$ [-] of the smooth curves, (34) and (35); arguments and the case
    without pressure, where they are 0 and 1, as `free_strain_of`.
    """
    law = tension_of(untuned(muscle))
    share = pressure / (_highest(pressure) if top is None else top)
    some = (share > _NO_PRESSURE) & (law.tuning.effective_pressure(pressure) > 0)
    blocked = coefficients[ORDERS] + coefficients[ORDERS + 1] * share
    c1 = law.force(pressure, free_strain_of(muscle, coefficients, pressure, top))
    above = law.force(pressure, jnp.zeros_like(pressure)) - c1
    c2 = blocked / guarded(some, above)
    return jnp.where(some, c1, 0.0), jnp.where(some, c2, 1.0)


def no_curves() -> np.ndarray:
    """Coefficients in the place of the curves' where these don't hold [-], [N]."""
    return np.zeros(ORDERS + 2)


def _top(pressure: np.ndarray) -> float:
    # a passive muscle's record has no pressure to refer to
    return max(float(np.max(pressure)), 1.0)


def _highest(pressure: Level) -> Float[AnyArray, ""]:
    return jnp.maximum(jnp.max(pressure), 1.0)
