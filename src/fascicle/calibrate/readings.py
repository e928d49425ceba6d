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

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .._math import guarded
from ..muscle import Muscle
from ..muscle.tuning import TunedTension, Tuning
from .grid import Grid, Table


_NEAR = 0.3  # of the free strain: how far a reading looks, as a Gaussian's deviation
_PULLING = 0.15  # of the level's largest force: readings above it surely pull
_NO_PRESSURE = 0.01  # of the highest pressure: below, nothing can be read [R13]
_ORDERS = 4  # of the free strain's quotient: constant to cubic

Level = Float[Array, "level"]


class Readings(eqx.Module):
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
    """

    pressure: Level
    free_strain: Level
    free_strain_deviation: Level
    blocked_force: Level
    blocked_force_deviation: Level
    valid: Bool[Array, "level"]
    noise: Float[Array, ""]
    coefficients: Float[Array, "coefficient"]
    covariance: Float[Array, "coefficient coefficient"]
    order: Int[Array, ""]
    misfit: Float[Array, "2"]


def read(muscle: Muscle, data: Grid) -> Readings:
    """Readings [-] of `data` [-] against the `muscle`'s untuned tension law [-]."""
    law = _untuned(muscle)
    P = data.pressure[:, 0]
    T = law.force(data.pressure, data.strain)
    at_rest = law.force(P, jnp.zeros_like(P))
    top = _top(P)
    pressed = _NO_PRESSURE * top < P
    free_th = law.free_strain(P)

    # which readings pull: a first line through those that surely do tells where force ends
    F, w = data.force, jnp.where(data.uncensored, data.count, 0.0)
    surely = w * (_PULLING * jnp.max(jnp.where(w > 0, F, 0.0), axis=1, keepdims=True) < F)
    pilot = _line(T, F, surely, data.count)
    ends = _strain_at(law, P, pilot.offset, free_th)
    pulling = w * (data.strain <= ends[:, None])

    scale = _NEAR * ends[:, None]
    near_rest = pulling * jnp.exp(-0.5 * (data.strain / scale) ** 2)
    near_end = pulling * jnp.exp(-0.5 * ((data.strain - ends[:, None]) / scale) ** 2)
    start, end = _line(T, F, near_rest, data.count), _line(T, F, near_end, data.count)
    noise = _scatter(T, F, pulling * pressed[:, None])

    blocked = start.value + start.slope * (at_rest - start.center)
    blocked_sd = noise * jnp.sqrt(start.at(at_rest))
    c1 = end.offset
    c1_sd = noise * jnp.sqrt(end.at(c1)) / jnp.abs(guarded(end.slope != 0, end.slope))
    free = _strain_at(law, P, c1, free_th)
    fall = _slope(law, P, free)
    free_sd = c1_sd / jnp.abs(guarded(fall != 0, fall))
    enough = (jnp.sum(pulling > 0, axis=1) >= 2) & (end.slope > 0) & (start.slope > 0) & pressed
    valid = enough & jnp.isfinite(blocked_sd + free_sd + free) & (free > 0)
    smooth = _smooth(P / top, free / guarded(pressed, free_th), free_sd / guarded(pressed, free_th),
                     blocked, blocked_sd, valid)  # fmt: skip
    coefficients, covariance, order, misfit = smooth
    return Readings(P, free, free_sd, blocked, blocked_sd, valid, noise, coefficients, covariance,
                    order, misfit)  # fmt: skip


def free_strain_of(
    muscle: Muscle, coefficients: Float[Array, "coefficient"], pressure: Level, top: Any = None
) -> Level:
    """Free strain [-] of the smooth curves with `coefficients` at each `pressure` [Pa], which
    they take over `top` [Pa], the largest one if left out; 0 without pressure [R13].
    """
    share = pressure / (_top(pressure) if top is None else top)
    quotient = jnp.polyval(coefficients[:_ORDERS][::-1], share)
    free = _untuned(muscle).free_strain(pressure) * quotient
    return jnp.where(share > _NO_PRESSURE, free, 0.0)


def free_strain_deviation(muscle: Muscle, readings: Readings) -> Level:
    """Standard deviation [-] of the smooth curve's free strain at each level."""
    share = readings.pressure / _top(readings.pressure)
    basis = share[:, None] ** jnp.arange(_ORDERS)
    covariance = readings.covariance[:_ORDERS, :_ORDERS]
    variance = jnp.einsum("li,ij,lj->l", basis, covariance, basis)
    free = _untuned(muscle).free_strain(readings.pressure)
    return jnp.where(share > _NO_PRESSURE, free * jnp.sqrt(jnp.maximum(variance, 0.0)), 0.0)


def tables(
    muscle: Muscle, coefficients: Float[Array, "coefficient"], pressure: Level, top: Any = None
) -> tuple[Level, Level]:
    """$C_1$ [N] and $C_2$ [-] of the smooth curves, (34) and (35); arguments and the case
    without pressure, where they are 0 and 1, as `free_strain_of`.
    """
    law, share = _untuned(muscle), pressure / (_top(pressure) if top is None else top)
    some = share > _NO_PRESSURE
    blocked = coefficients[_ORDERS] + coefficients[_ORDERS + 1] * share
    c1 = law.force(pressure, free_strain_of(muscle, coefficients, pressure, top))
    pull = law.force(pressure, jnp.zeros_like(pressure)) - c1
    c2 = blocked / guarded(some, pull)
    return jnp.where(some, c1, 0.0), jnp.where(some, c2, 1.0)


class _Line(eqx.Module):
    """A weighted straight line through forces over the law's own, level by level."""

    center: Level
    value: Level
    slope: Level
    spread: tuple[Level, Level, Level]

    @property
    def offset(self) -> Level:
        """Where the line crosses zero [N]."""
        return self.center - self.value / guarded(self.slope != 0, self.slope)

    def at(self, T: Level) -> Level:
        """Variance of the line at `T` [N], over that of a single reading [-]."""
        away = T - self.center
        a, b, c = self.spread
        return a + 2 * away * b + away**2 * c


def _line(T: Table, F: Table, weight: Table, count: Table) -> _Line:
    """The line of `F` over `T` [N] with `weight` [-], of readings that average `count` [-]."""

    def mean(values: Table) -> Level:
        return jnp.sum(weight * values, axis=1) / guarded(total > 0, total)

    total = jnp.sum(weight, axis=1)
    center, value = mean(T), mean(F)
    away = T - center[:, None]
    moment = jnp.sum(weight * away**2, axis=1)
    moment = guarded(moment > 0, moment, jnp.inf)
    slope = jnp.sum(weight * away * F, axis=1) / moment
    # readings differ in how many they average: variances add up by the weights' squares
    square = jnp.where(count > 0, weight**2 / guarded(count > 0, count), 0.0)
    sums = [jnp.sum(square * away**power, axis=1) for power in range(3)]
    safe = guarded(total > 0, total)
    return _Line(
        center, value, slope, (sums[0] / safe**2, sums[1] / (safe * moment), sums[2] / moment**2)
    )


def _scatter(T: Table, F: Table, weight: Table) -> Float[Array, ""]:
    """Standard deviation of a reading [N], about a parabola in `T` at each level."""
    height = jnp.max(jnp.abs(T), axis=1, keepdims=True)
    t = T / guarded(height > 0, height)
    basis = jnp.stack([jnp.ones_like(t), t, t**2], axis=-1) * jnp.sqrt(weight)[..., None]
    target = F * jnp.sqrt(weight)
    gram = jnp.einsum("lri,lrj->lij", basis, basis) + 1e-12 * jnp.eye(3)
    best = jnp.linalg.solve(gram, jnp.einsum("lri,lr->li", basis, target)[..., None])[..., 0]
    squares = jnp.sum((target - jnp.einsum("lri,li->lr", basis, best)) ** 2, axis=1)
    free = jnp.sum(weight > 0, axis=1) - 3
    left = jnp.sum(jnp.where(free > 0, free, 0))
    total = jnp.sum(jnp.where(free > 0, squares, 0.0))
    # too few readings to see any scatter: a hundredth of the largest force is a load cell's
    blind = 0.01 * jnp.maximum(jnp.max(jnp.abs(F)), 1e-9)
    return jnp.where(left > 0, jnp.sqrt(total / guarded(left > 0, left)), blind)


def _smooth(
    share: Level, quotient: Level, quotient_sd: Level, force: Level, force_sd: Level, valid: Any
) -> tuple[Any, ...]:
    """The smooth curves' coefficients, their covariance, the polynomial's order, misfits."""
    n = jnp.sum(valid)
    fits = [
        _polynomial(share, quotient, quotient_sd, valid, order, _ORDERS) for order in range(_ORDERS)
    ]
    # the order by Schwarz's criterion; never more terms than readings
    scores = jnp.stack(
        [
            jnp.where(order + 1 <= jnp.maximum(n, 1), chi + (order + 1) * jnp.log(n + 1.0), jnp.inf)
            for order, (_, _, chi, _) in enumerate(fits)
        ]
    )
    order = jnp.argmin(scores)
    coefficients, covariance, _, misfit = (jnp.stack(x)[order] for x in zip(*fits, strict=True))
    line, line_covariance, _, line_misfit = _polynomial(share, force, force_sd, valid, 1, 2)
    zeros = jnp.zeros((_ORDERS, 2))
    return (
        jnp.concatenate([coefficients, line]),
        jnp.block([[covariance, zeros], [zeros.T, line_covariance]]),
        order,
        jnp.stack([misfit, line_misfit]),
    )


def _polynomial(
    x: Level, y: Level, deviation: Level, valid: Any, order: int, size: int
) -> tuple[Any, Any, Any, Any]:
    """Coefficients, covariance, squared deviation and its ratio to the expected one."""
    weight = jnp.where(valid, 1 / guarded(valid, deviation) ** 2, 0.0)
    basis = jnp.stack([x**power for power in range(order + 1)], axis=-1)
    scale = jnp.maximum(jnp.max(weight), 1e-300)
    gram = jnp.einsum("l,li,lj->ij", weight / scale, basis, basis) + 1e-14 * jnp.eye(order + 1)
    # a single reading carries a line through the origin
    gram = gram.at[0, 0].add(jnp.where((jnp.sum(valid) < 2) & (order > 0), 1e9, 0.0))
    inverse = jnp.linalg.inv(gram)
    best = inverse @ jnp.einsum("l,li,l->i", weight / scale, basis, jnp.where(valid, y, 0.0))
    squares = jnp.sum(weight * (jnp.where(valid, y, 0.0) - basis @ best) ** 2)
    free = jnp.maximum(jnp.sum(valid) - (order + 1), 0)
    ratio = squares / guarded(free > 0, free)
    # where the curve misses by more than chance lets the readings, it is that uncertain
    chance = 1 + 3 * jnp.sqrt(2 / guarded(free > 0, free))
    misfit = jnp.where((free > 0) & (ratio > chance), ratio, 1.0)
    pad = size - (order + 1)
    covariance = jnp.pad(misfit * inverse / scale, ((0, pad), (0, pad)))
    return jnp.pad(best, (0, pad)), covariance, squares, misfit


def _strain_at(law: TunedTension, pressure: Level, force: Level, otherwise: Level) -> Level:
    """Strain [-] at which the untuned law has `force` [N]; `otherwise` without pressure."""
    some = pressure > 0
    found = law.law.free_strain(law.bladder, guarded(some, pressure), lambda _: force)
    return jnp.where(some, found, otherwise)


def _slope(law: TunedTension, pressure: Level, strain: Level) -> Level:
    """Slope of the untuned law with strain [N]."""
    return jax.jvp(lambda eps: law.force(pressure, eps), (strain,), (jnp.ones_like(strain),))[1]


def _top(pressure: Level) -> Float[Array, ""]:
    # a passive muscle's record has no pressure to refer to
    return jnp.maximum(jnp.max(pressure), 1.0)


def _untuned(muscle: Muscle) -> TunedTension:
    return TunedTension(muscle.tension, muscle.bladder, Tuning())
