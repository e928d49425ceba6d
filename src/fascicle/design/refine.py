r"""Gradient-based refinement of sizes, from a design whose split is chosen.

An objective is improved by Adam steps on coordinates that keep every size within its bounds,
$x = l + (h - l)/(1 + e^{-z})$, from several starts. What must be reached enters as a penalty
on the shortfalls, each over what is demanded there and counting the same, whose slope, unlike
that of the points not reached, leads there. The laws are differentiable; where the state that
meets a point changes, the objective has a step, which a gradient doesn't see: the best of all
steps is the result. One that reaches the task is better than any that doesn't, whatever its
objective.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from ..core.errors import InvalidInputError
from ..core.types import Float
from ..core.validation import check_choice
from .designs import Designs, Sizes
from .evaluation import design_outcome, evaluate
from .objectives import OBJECTIVES, SHARES, check_objectives, needs, objective_values
from .outcome import Demand
from .task import Task


BOUNDED = ("length", "radius", "wall_ratio", "angle")
_RATE = 0.2  # of Adam, in coordinates: a bound is some 30 steps away
_PENALTY_GROWTH = 1.1  # of the penalty in a step that misses the task: tenfold in 24 steps
_LARGEST_PENALTY = 1e4  # over the first one; larger ones hide the objective in rounding
_LARGEST_COORDINATE = 6.0  # a part in 400 from a bound
_INSIDE = 1e-2  # share of an interval from its bounds at which the first start begins
_STARTS = 2.0  # coordinates of the other starts, at random: 12 to 88 % of an interval


def refine_sizes(
    designs: Designs,
    index: int,
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
    """Improve the sizes of one design, its split fixed, by gradient steps from several starts: the
    best design of each start, and its objective over the first design's, smaller is better [-].

    **Arguments:**

    - `designs`: with the split among them.
    - `index`: of the split.
    - `task`: what is demanded.
    - `objective`: to improve, by name.
    - `bounds`: least and largest `length` and `radius` [m], `wall_ratio` [-] and `angle` [rad];
      a size without bounds is fixed.
    - `sense`: "min" or "max"; default: the objective's usual one.
    - `penalty`: on the shortfalls over what is demanded, their mean and their largest, in units
      of the objective's first value [-]; it grows where the task isn't reached.
    - `steps`: of each start.
    - `starts`: their number; the first is the design itself [-].
    - `seed`: random seed of the others.
    - `may_miss`: share of the task that may be missed [-], by weight and by points.

    **Returns:** the best design of each start, and its objective, turned so that smaller is
    better, over the first design's objective [-]; infinite for a start that never came to
    reach the task, whose design is the one that came nearest.

    **Raises:** `ValueError` for unknown names and bounds that the design's sizes are outside of.
    """
    import optax

    (name,) = check_objectives([objective])
    sense = check_choice(sense or OBJECTIVES[name].sense, ("min", "max"), "sense")
    design = designs.take(np.array([index]))
    design = design.take(np.array([0]), int(design.units[0]))
    demand, counts, sizes = Demand.from_task(task), design.counts[0], design.sizes(0)
    drawing = list(design.drawings.values())[int(design.kind[0])]
    low, high, first = _size_coordinates(sizes, bounds)
    initial = float(evaluate(design, task, [name])[name][0]) or 1.0
    sign = (1.0 if sense == "min" else -1.0) / abs(initial)

    def sizes_at(z: Array) -> Sizes:
        """Sizes at coordinates `z`; those without bounds unchanged."""
        values = low + (high - low) / (1 + jnp.exp(-z))
        length, radius, wall, angle = sizes
        new = {"length": length, "radius": radius, "wall_ratio": wall / radius, "angle": angle}
        start = 0
        for key in bounds:
            stop = start + (1 if key == "length" else radius.size)
            new[key] = values[start:stop] + 0.0 * new[key]  # the length for every unit
            start = stop
        return Sizes(new["length"], new["radius"], new["wall_ratio"] * new["radius"], new["angle"])

    def cost(z: Array, weight: Array) -> tuple[Array, tuple[Array, Array]]:
        """Objective plus `weight` times the distance from the task; and both of them, apart."""
        outcome = design_outcome(drawing, counts, sizes_at(z), demand, needs((name,)))
        names = (name, "relative_shortfall", *SHARES)
        objective, worst, *missed = objective_values(outcome, names)
        mean = jnp.mean(outcome.shortfall / outcome.reference)
        enough = jnp.max(jnp.stack(missed)) <= may_miss
        miss = jnp.where(enough, 0.0, worst + mean)
        return sign * objective + weight * miss, (sign * objective, miss)

    gradient = jax.value_and_grad(cost, has_aux=True)
    slopes = jax.jit(lambda *start: jax.lax.map(lambda row: gradient(*row), start))
    random = np.random.default_rng(seed).uniform(-_STARTS, _STARTS, (starts - 1, first.size))
    z = jnp.asarray(np.concatenate([first[None], random]))
    adam: Any = optax.adam(_RATE)
    state, weight = jax.vmap(adam.init)(z), np.full(starts, penalty)
    # the best that reaches the task, and the nearest to it
    best, least_miss = np.full(starts, np.inf), np.full(starts, np.inf)
    best_z = nearest_z = np.asarray(z)
    for _ in range(steps + 1):
        (_, (value, miss)), slope = slopes(z, jnp.asarray(weight))
        miss, position = np.asarray(miss), np.asarray(z)
        value = np.where(miss > 0, np.inf, np.asarray(value))
        best_z = np.where((value < best)[:, None], position, best_z)
        nearest_z = np.where((miss < least_miss)[:, None], position, nearest_z)
        best, least_miss = np.fmin(best, value), np.fmin(least_miss, miss)
        growth = np.minimum(_PENALTY_GROWTH * weight, _LARGEST_PENALTY * penalty)
        weight = np.where(miss > 0, growth, weight)
        update, state = jax.vmap(adam.update)(slope, state)
        z = jnp.clip(z + update, -_LARGEST_COORDINATE, _LARGEST_COORDINATE)
    positions = np.where(np.isfinite(best)[:, None], best_z, nearest_z)
    refined = [sizes_at(jnp.asarray(z)) for z in positions]
    length, radius, wall, angle = (np.stack(arrays) for arrays in zip(*refined, strict=True))
    copies = design.take(np.zeros(starts, int))
    return replace(copies, length=length[:, 0], radius=radius, wall=wall, angle=angle), best


def _size_coordinates(
    sizes: Sizes, bounds: Mapping[str, tuple[float, float]]
) -> tuple[Array, Array, np.ndarray]:
    """Bounds and initial coordinates $z$ of the sizes in `bounds`: one of each for every unit, a
    single one for the length.
    """
    lows, highs, fractions = [], [], []
    for key, (low, high) in bounds.items():
        check_choice(key, BOUNDED, "bounds")
        values = sizes.wall / sizes.radius if key == "wall_ratio" else getattr(sizes, key)
        values = values[:1] if key == "length" else values
        if not low < high or np.any(values < low) or np.any(values > high):
            rule = f"of {key} must hold the design's {values[0]:g}"
            raise InvalidInputError("bounds", rule, (low, high), shown=f"{low:g} to {high:g}")
        lows.append(np.full(values.size, low))
        highs.append(np.full(values.size, high))
        fractions.append((values - low) / (high - low))
    low, high, fraction = (np.concatenate([[], *x]) for x in (lows, highs, fractions))
    fraction = np.clip(fraction, _INSIDE, 1 - _INSIDE)
    return jnp.asarray(low), jnp.asarray(high), np.log(fraction / (1 - fraction))
