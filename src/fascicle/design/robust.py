r"""Spread of a design's objectives over bundles as they are made.

A draw changes what is not known well: the material and the laws' numbers, from a calibrated
muscle's covariance, and what no two muscles have alike, from fabrication scatter, (D2). Sizes
that were calibrated change in proportion. **Assumes** that the muscles of a unit come out
alike, so that their scatter doesn't average out, and that a bundle's are cut to one length.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from ..core.errors import InvalidInputError
from ..core.module import with_fields
from ..core.types import Bool, Float, Int, Values
from ..core.validation import check_choice
from ..muscle import Muscle
from ..records.dynamometer import Scatter
from .designs import Designs, Sizes
from .evaluation import design_outcome, evaluated_units
from .exhaustive_search import as_minimization, non_dominated
from .objectives import (
    Limits,
    check_objectives,
    needs,
    objective_values,
    with_reach_limits,
    within_limits,
)
from .outcome import Demand
from .tables import MIXED, Resolution
from .task import Task


_MATERIAL = ("c10", "c01", "youngs_modulus")
VARIED = ("length", "outer_radius", "wall_thickness", "braid_angle", *_MATERIAL)
_SMALLEST_ANGLE = 1e-3  # rad; no braid is wound so steeply
_LARGEST_ANGLE = 0.95  # rad, just below the neutral angle, at which a muscle doesn't contract
_TOGETHER = 8  # draws computed in one call of the compiled program: as fast as more
_INDICES = ("S1", "S1_conf", "ST", "ST_conf")  # SALib's keys


class Scales(NamedTuple):
    """Factors of a draw on the drawing's sizes, and what it adds to angles [rad]."""

    length: Float[Array, " draw"]
    radius: Float[Array, "draw unit"]
    wall: Float[Array, "draw unit"]
    angle: Float[Array, "draw unit"]


@dataclass(frozen=True, eq=False)
class Spread:
    """Objectives of designs over draws: `values` [SI] by name, draws last; `met`: mask of the draws
    that reach the task and keep all limits.
    """

    values: dict[str, Float[np.ndarray, "design draw"]]
    met: Bool[np.ndarray, "design draw"]

    @property
    def probability(self) -> Float[np.ndarray, " design"]:
        """Share of the draws that meet the task and the limits [-]."""
        return self.met.mean(axis=1)

    def quantile(self, fraction: float) -> dict[str, Float[np.ndarray, " design"]]:
        """A quantile of every objective [SI]; `fraction`: of the draws below it [-]."""
        return {name: np.quantile(draws, fraction, axis=1) for name, draws in self.values.items()}

    def front(
        self, senses: Mapping[str, str], confidence: float = 0.9
    ) -> Bool[np.ndarray, " design"]:
        """Mask of the designs that no other dominates in sure values, those that most draws attain.

        **Arguments:**

        - `senses`: "min" or "max" by objective.
        - `confidence`: share of the draws that do at least as well as a sure value [-].

        **Returns:** the mask.
        """
        low, high = self.quantile(1 - confidence), self.quantile(confidence)
        sure = {name: (high if sense == "min" else low)[name] for name, sense in senses.items()}
        return non_dominated(as_minimization(sure, senses))


def spread(
    designs: Designs,
    task: Task,
    objectives: tuple[str, ...],
    limits: Limits | None = None,
    scatter: Scatter | None = None,
    muscles: Muscle | None = None,
    draws: int = 200,
    seed: int = 0,
) -> Spread:
    """Objectives of designs under fabrication scatter and uncertain constants.

    **Arguments:**

    - `designs`: of one drawing.
    - `task`: what is demanded.
    - `objectives`: by name.
    - `limits`: on objectives, by name [SI], as `search` takes them: all must be reached.
    - `scatter`: of length and braid angle; default: none.
    - `muscles`: draws of the calibrated drawing, on the first axis of their numbers [-]; default:
      the drawing itself.
    - `draws`: their number [-], the same for every design.
    - `seed`: random seed.

    **Returns:** values over the draws [SI].

    **Raises:** `ValueError` for designs of several drawings and unknown objectives.
    """
    limits = with_reach_limits(limits)
    names = check_objectives([*objectives, *limits], task.scheme)
    drawing, scatter = _single_drawing(designs), Scatter() if scatter is None else scatter
    generator, shape = np.random.default_rng(seed), (draws, designs.counts.shape[1])
    kinds = _repeat(drawing, draws)
    if muscles is not None:
        size = max(leaf.shape[0] for leaf in jax.tree.leaves(muscles) if jnp.ndim(leaf))
        kinds = _pick_draws(muscles, drawing, generator.integers(0, size, draws))
    length_factor = 1 + scatter.length * generator.standard_normal(draws)
    tilt = scatter.braid_angle * generator.standard_normal(shape)
    length, radius, wall = (
        np.asarray(getattr(kinds, name) / getattr(drawing, name))
        for name in ("length", "outer_radius", "wall_thickness")
    )
    turn = np.asarray(kinds.braid_angle - drawing.braid_angle)
    scales = Scales(
        jnp.asarray(length_factor * length),
        jnp.asarray(radius[:, None] * np.ones(shape)),
        jnp.asarray(wall[:, None] * np.ones(shape)),
        jnp.asarray(tilt + turn[:, None]),
    )
    demand, values = Demand.from_task(task), np.empty((len(names), len(designs), draws))
    for index in range(len(designs)):
        counts, sizes = _counts_and_sizes(designs, index, task)
        values[:, index] = drawn_objectives(
            kinds, counts, sizes, scales, demand, names=names, needs=needs(names)
        )
    by_name = dict(zip(names, values, strict=True))
    satisfied = within_limits({name: rows.ravel() for name, rows in by_name.items()}, limits)
    return Spread(by_name, satisfied.reshape(len(designs), draws))


@partial(jax.jit, static_argnames=("names", "needs", "resolution"))
def drawn_objectives(
    kinds: Muscle,
    counts: Int[np.ndarray, " unit"],
    sizes: Sizes,
    scales: Scales,
    demand: Demand,
    *,
    names: tuple[str, ...],
    needs: tuple[str, ...],
    resolution: Resolution = MIXED,
) -> Float[Array, "objective draw"]:
    """Objectives of a design in every draw, a row for each of their `names` [SI].

    `kinds`: the drawing in each draw, on the first axis of all its numbers; `counts` and `sizes`:
    of the design by unit; `needs`: of the objectives beyond the task's points.
    """
    units = sizes.radius.size

    def objectives(draw: tuple[Muscle, Scales]) -> Array:
        kind, scale = draw
        drawn = Sizes(
            sizes.length * scale.length,
            sizes.radius * scale.radius[:units],
            sizes.wall * scale.wall[:units],
            jnp.clip(sizes.angle + scale.angle[:units], _SMALLEST_ANGLE, _LARGEST_ANGLE),
        )
        outcome = design_outcome(kind, counts, drawn, demand, needs, resolution)
        return objective_values(outcome, names)

    return lax.map(objectives, (kinds, scales), batch_size=_TOGETHER).T


def sensitivities(
    designs: Designs,
    index: int,
    task: Task,
    ranges: Mapping[str, float],
    objectives: tuple[str, ...],
    samples: int = 64,
    seed: int = 0,
) -> dict[str, dict[str, np.ndarray]]:
    """Sobol's indices of first and total order of each objective, by SALib.

    **Arguments:**

    - `designs`: of one drawing.
    - `index`: of one of them.
    - `task`: what is demanded.
    - `ranges`: largest deviation of each of `VARIED`, over its value, either way [-].
    - `objectives`: by name.
    - `samples`: a power of two; this times the number of ranges plus two are computed.
    - `seed`: random seed.

    **Returns:** for each objective `S1` and `ST` and the half-widths of their 95 % intervals,
    `S1_conf` and `ST_conf`, in the order of the ranges; an objective that doesn't change
    has zeros.

    **Raises:** `ValueError` for unknown objectives and quantities; `ModuleNotFoundError`
    without SALib.
    """
    from SALib.analyze import sobol as analyze
    from SALib.sample import sobol as sample

    names, drawing = check_objectives(objectives, task.scheme), _single_drawing(designs)
    for name in ranges:
        check_choice(name, VARIED, "ranges")
    problem = {
        "num_vars": len(ranges),
        "names": list(ranges),
        "bounds": [[1 - half, 1 + half] for half in ranges.values()],
    }
    # without second orders a sample takes as many again as there are names, and two
    draws = sample.sample(problem, samples, calc_second_order=False, seed=seed)
    factors = dict.fromkeys(VARIED, np.ones(len(draws))) | dict(zip(ranges, draws.T, strict=True))
    kinds = _repeat(drawing, len(draws))
    for name in set(_MATERIAL) & set(ranges):
        material = getattr(kinds.material, name) * jnp.asarray(factors[name])
        kinds = with_fields(kinds, material=with_fields(kinds.material, **{name: material}))
    counts, sizes = _counts_and_sizes(designs, index, task)
    every_unit = np.ones((len(draws), sizes.radius.size))
    scales = Scales(
        jnp.asarray(factors["length"]),
        jnp.asarray(factors["outer_radius"][:, None] * every_unit),
        jnp.asarray(factors["wall_thickness"][:, None] * every_unit),
        jnp.asarray((factors["braid_angle"] - 1)[:, None] * np.asarray(sizes.angle)),
    )
    values = drawn_objectives(
        kinds, counts, sizes, scales, Demand.from_task(task), names=names, needs=needs(names)
    )
    results: dict[str, dict[str, np.ndarray]] = {}
    for name, row in zip(names, np.asarray(values), strict=True):
        if np.ptp(row) == 0:
            results[name] = dict.fromkeys(_INDICES, np.zeros(len(ranges)))
            continue
        indices: Any = analyze.analyze(problem, row, calc_second_order=False, seed=seed)
        results[name] = {key: np.asarray(indices[key]) for key in _INDICES}
    return results


def _single_drawing(designs: Designs) -> Muscle:
    """The drawing of all `designs`; `ValueError` for several."""
    kinds = set(designs.kind.tolist())
    if len(kinds) != 1:
        raise InvalidInputError("designs", "must be of one drawing", len(kinds))
    return list(designs.drawings.values())[kinds.pop()]


def _counts_and_sizes(designs: Designs, index: int, task: Task) -> tuple[np.ndarray, Sizes]:
    """Muscles in each unit that is evaluated of a design, and their sizes."""
    units = int(evaluated_units(designs, task.scheme)[index])
    return designs.counts[index, :units], designs.sizes(index).take(slice(units))


def _repeat(drawing: Muscle, draws: int) -> Muscle:
    """The drawing with each number repeated on a first axis of so many `draws`."""
    return jax.tree.map(lambda leaf: jnp.broadcast_to(leaf, (draws, *jnp.shape(leaf))), drawing)


def _pick_draws(muscles: Muscle, drawing: Muscle, draw: np.ndarray) -> Muscle:
    """Muscles with the indices `draw` on their first axis; numbers without it are repeated."""

    def pick(drawn: Values, single: Values) -> Array:
        if jnp.ndim(drawn) > jnp.ndim(single):
            return drawn[draw]
        return jnp.broadcast_to(drawn, (len(draw), *jnp.shape(drawn)))

    return jax.tree.map(pick, muscles, drawing)
