r"""Sizes refined by gradients, from a design whose split is chosen.

An objective is bettered by Adam steps on coordinates that keep every size within its bounds,
$x = l + (h - l)/(1 + e^{-z})$, from several starts. What must be reached enters as a penalty
on the shortfalls, each over what is demanded there and counting the same, whose slope, unlike
that of the points not reached, leads there. The laws are differentiable; where the state that
meets a point changes, the objective has a step, which a gradient doesn't see: the best of all
steps is kept, as the slow way judges it. One that reaches the task is better than any that
doesn't, whatever its objective.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from ..core.errors import InvalidInputError
from ..core.types import Float, Int
from ..core.validation import check_choice
from ..muscle import Muscle
from .designs import Designs, Sizes, concatenate
from .evaluation import design_outcome, evaluate
from .objectives import OBJECTIVES, SHARES, known, needs, objective_values
from .outcome import Demand
from .task import Task


BOUNDED = ("length", "radius", "wall_ratio", "angle")
_RATE = 0.2
_STERNER, _STERNEST = 1.1, 1e4  # the penalty grows while the task isn't reached
_INSIDE = 6.0  # a coordinate's largest size: a part in 400 from a bound


def refine_sizes(
    designs: Designs,
    place: int,
    task: Task,
    objective: str,
    bounds: Mapping[str, tuple[float, float]],
    sense: str | None = None,
    penalty: float = 10.0,
    steps: int = 60,
    starts: int = 4,
    seed: int = 0,
    may_miss: float = 0.0,
) -> tuple[Designs, Float[np.ndarray, " start"]]:
    """Better sizes for a split.

    **Arguments:**

    - `designs`: among which the split is.
    - `place`: which of them.
    - `task`: what is demanded.
    - `objective`: to better, by name.
    - `bounds`: least and largest `length` and `radius` [m], `wall_ratio` [-] and `angle` [rad];
      what isn't bounded is held.
    - `sense`: "min" or "max"; left out, the objective's usual one.
    - `penalty`: on the shortfalls over what is demanded, their mean and their largest, in units
      of what the objective is at first [-]; it grows where the task isn't reached.
    - `steps`: of each start.
    - `starts`: how many; the first is the design itself [-].
    - `seed`: of the others.
    - `may_miss`: share of the task that may be missed [-], by weight and by points.

    **Returns:** the best design of each start, and its objective, turned so that smaller is
    better, over the first design's objective [-]; infinite for a start that never came to
    reach the task, whose design is the one that came nearest.

    **Raises:** `ValueError` for unknown names and bounds that the design's sizes are outside of.
    """
    import optax

    (name,) = known([objective])
    sense = check_choice(sense or OBJECTIVES[name].sense, ("min", "max"), "sense")
    demand, one = Demand.from_task(task), designs.take(np.array([place]))
    drawing = list(designs.drawings.values())[int(one.kind[0])]
    one = one.take(np.array([0]), int(one.units[0]))
    counts, sizes = one.counts[0], one.sizes(0)
    low, high, first = _box(sizes, bounds)
    initial = float(evaluate(one, task, [name])[name][0]) or 1.0
    rng = np.random.default_rng(seed)
    others = rng.uniform(-2.0, 2.0, (starts - 1, first.size))
    z = jnp.asarray(np.concatenate([first[None], others]))
    sign = (1.0 if sense == "min" else -1.0) / abs(initial)
    adam: Any = optax.adam(_RATE)
    state, weight = jax.vmap(adam.init)(z), np.full(starts, penalty)
    # the best that reaches the task, and the nearest to it
    best, near = (_Best(np.full(starts, np.inf), np.asarray(z).copy()) for _ in range(2))
    for _ in range(steps + 1):
        (_, (value, far)), slope = _slopes(
            drawing, counts, sizes, demand, z, low, high, sign, jnp.asarray(weight), may_miss,
            name=name, bounded=tuple(bounds),
        )  # fmt: skip
        value, far = np.asarray(value), np.asarray(far)
        best = best.or_better(np.where(far > 0, np.inf, value), np.asarray(z))
        near = near.or_better(far, np.asarray(z))
        weight = np.where(far > 0, np.minimum(_STERNER * weight, _STERNEST * penalty), weight)
        update, state = jax.vmap(adam.update)(slope, state)
        z = jnp.clip(z + update, -_INSIDE, _INSIDE)
    kept = np.where(np.isfinite(best.value)[:, None], best.place, near.place)
    made = [
        _designed(one, _placed(sizes, jnp.asarray(row), low, high, tuple(bounds))) for row in kept
    ]
    return concatenate(made), best.value


class _Best(NamedTuple):
    """The smallest `value` [-] of each start so far, and its `place`."""

    value: Float[np.ndarray, " start"]
    place: Float[np.ndarray, "start coordinate"]

    def or_better(self, value: np.ndarray, place: np.ndarray) -> "_Best":
        better = value < self.value
        return _Best(
            np.where(better, value, self.value), np.where(better[:, None], place, self.place)
        )


@partial(jax.jit, static_argnames=("name", "bounded"))
def _slopes(
    drawing: Muscle,
    counts: Int[np.ndarray, " unit"],
    sizes: Sizes,
    demand: Demand,
    z: Float[Array, "start coordinate"],
    low: Array,
    high: Array,
    sign: Array | float,
    weight: Float[Array, " start"],
    may_miss: Array | float,
    *,
    name: str,
    bounded: tuple[str, ...],
) -> tuple[Any, Float[Array, "start coordinate"]]:
    """The cost of each start, with the objective and how far it is from the task; its slopes."""

    def cost(z: Array, weight: Array) -> tuple[Array, tuple[Array, Array]]:
        own = _placed(sizes, z, low, high, bounded)
        outcome = design_outcome(drawing, counts, own, demand, needs((name,)))
        names = (name, "relative_shortfall", *SHARES)
        objective, worst, *missed = objective_values(outcome, names)
        F = outcome.force
        mean = jnp.mean(outcome.shortfall / jnp.where(F > 0, F, jnp.max(F)))
        enough = jnp.max(jnp.stack(missed)) <= may_miss
        far = jnp.where(enough, 0.0, worst + mean)
        return sign * objective + weight * far, (sign * objective, far)

    sloped = jax.value_and_grad(cost, has_aux=True)
    return jax.lax.map(lambda start: sloped(*start), (z, weight))


def _box(sizes: Sizes, bounds: Mapping[str, tuple[float, float]]) -> tuple[Array, Array, Any]:
    """Bounds of every coordinate, and the design's own place between them."""
    low, high, own = [], [], []
    for key, (least, most) in bounds.items():
        check_choice(key, BOUNDED, "bounds")
        values = sizes.wall / sizes.radius if key == "wall_ratio" else getattr(sizes, key)
        values = values[:1] if key == "length" else values
        if not least < most or np.any(values < least) or np.any(values > most):
            raise InvalidInputError(
                "bounds",
                f"of {key} must hold the design's own {values[0]:g}",
                (least, most),
                shown=f"{least:g} to {most:g}",
            )
        low += [least] * values.size
        high += [most] * values.size
        own += values.tolist()
    lows, highs = np.array(low), np.array(high)
    share = np.clip((np.array(own) - lows) / (highs - lows), 1e-2, 1 - 1e-2)
    return jnp.asarray(lows), jnp.asarray(highs), np.log(share / (1 - share))


def _placed(sizes: Sizes, z: Array, low: Array, high: Array, bounded: tuple[str, ...]) -> Sizes:
    values = low + (high - low) / (1 + jnp.exp(-z))
    units, start, given = sizes.radius.size, 0, {}
    for key in bounded:
        size = 1 if key == "length" else units
        part = values[start : start + size]
        given[key] = part[0] if key == "length" else part
        start += size
    radius = given.get("radius", sizes.radius)
    ratio = given.get("wall_ratio", sizes.wall / sizes.radius)
    length = given.get("length", sizes.length[0]) + 0.0 * sizes.length
    return Sizes(length, radius, ratio * radius, given.get("angle", sizes.angle))


def _designed(one: Designs, sizes: Sizes) -> Designs:
    arrays = {key: np.asarray(getattr(sizes, key))[None] for key in ("radius", "wall", "angle")}
    return replace(one, length=np.asarray(sizes.length)[:1], **arrays)
