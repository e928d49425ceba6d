r"""How sure a design is: the same objectives for bundles as they come out.

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
from ..muscle import Muscle
from ..records.dynamometer import Scatter
from .designs import Designs, Sizes
from .evaluation import design_outcome, room_for_units
from .exhaustive_search import as_minimization, non_dominated
from .objectives import (
    Limits,
    check_turns,
    known,
    needs,
    objective_values,
    with_reach_limits,
    within_limits,
)
from .outcome import Demand
from .tables import MIXED, Resolution
from .task import Task


_LARGEST_ANGLE = 0.95  # rad, short of where a muscle no longer contracts


class Scales(NamedTuple):
    """What a draw multiplies the drawing's sizes by, and what it adds to angles [rad]."""

    length: Float[Array, " draw"]
    radius: Float[Array, "draw unit"]
    wall: Float[Array, "draw unit"]
    angle: Float[Array, "draw unit"]


@dataclass(frozen=True, eq=False)
class Spread:
    """Objectives of designs over draws. `values` [SI] by name, draws last; `met`: whether a
    draw reaches what must be of the task and keeps all limits.
    """

    values: dict[str, Float[np.ndarray, "design draw"]]
    met: Bool[np.ndarray, "design draw"]

    @property
    def probability(self) -> Float[np.ndarray, " design"]:
        """Share of the draws that meet the task and the limits [-]."""
        return self.met.mean(axis=1)

    def quantile(self, share: float) -> dict[str, Float[np.ndarray, " design"]]:
        """A quantile of every objective [SI]; `share`: of the draws below it [-]."""
        return {name: np.quantile(one, share, axis=1) for name, one in self.values.items()}

    def front(
        self, senses: Mapping[str, str], confidence: float = 0.9
    ) -> Bool[np.ndarray, " design"]:
        """Designs whose sure values none betters.

        **Arguments:**

        - `senses`: "min" or "max" by objective.
        - `confidence`: share of the draws that do at least as well as a sure value [-].

        **Returns:** a mask.
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
    - `scatter`: of length and braid angle; left out, none.
    - `muscles`: draws of the calibrated drawing, on the first axis of their numbers [-]; left
      out, the drawing itself.
    - `draws`: how many [-], the same for every design.
    - `seed`: of chance.

    **Returns:** values over the draws [SI].

    **Raises:** `ValueError` for designs of several drawings and unknown objectives.
    """
    limits = with_reach_limits(limits)
    names = known([*objectives, *limits])
    check_turns(names, task.scheme)
    drawing = _only(designs)
    generator = np.random.default_rng(seed)
    units = designs.counts.shape[1]
    draw = np.arange(draws) if muscles is None else generator.integers(0, _size(muscles), draws)
    kinds = _repeated(drawing, draws) if muscles is None else _picked(muscles, drawing, draw)
    scales = _scales(drawing, kinds, scatter, generator, draws, units)
    demand = Demand.from_task(task)
    values = np.empty((len(names), len(designs), draws))
    for place in range(len(designs)):
        values[:, place] = drawn_objectives(
            kinds,
            *_arrays(designs, place, task),
            scales,
            demand,
            names=names,
            needs=needs(names),
        )
    by_name = dict(zip(names, values, strict=True))
    met = within_limits({k: v.ravel() for k, v in by_name.items()}, limits)
    return Spread(by_name, met.reshape(len(designs), draws))


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
    """Objectives of a design in every draw.

    **Arguments:**

    - `kinds`: the drawing as drawn, on the first axis of all its numbers [-].
    - `counts`: muscles in each unit of the design.
    - `sizes`: of them.
    - `scales`: what each draw does to them.
    - `demand`: the task's.
    - `names`: of the objectives.
    - `needs`: what these need beyond the task's points.
    - `resolution`: of levels and strains [-].

    **Returns:** them, a row for each name, in its unit [SI].
    """
    units = sizes.radius.size

    def one(drawn: tuple[Muscle, Scales]) -> Array:
        kind, by = drawn
        own = Sizes(
            sizes.length * by.length,
            sizes.radius * by.radius[:units],
            sizes.wall * by.wall[:units],
            jnp.clip(sizes.angle + by.angle[:units], 1e-3, _LARGEST_ANGLE),
        )
        return objective_values(design_outcome(kind, counts, own, demand, needs, resolution), names)

    return lax.map(one, (kinds, scales), batch_size=8).T


def sensitivities(
    designs: Designs,
    place: int,
    task: Task,
    ranges: Mapping[str, float],
    objectives: tuple[str, ...],
    samples: int = 64,
    seed: int = 0,
) -> dict[str, dict[str, np.ndarray]]:
    """Sobol's first and total order of each objective, by SALib.

    **Arguments:**

    - `designs`: of one drawing.
    - `place`: which of them.
    - `task`: what is demanded.
    - `ranges`: how far each of `VARIED` may be off, over its value, either way [-].
    - `objectives`: by name.
    - `samples`: a power of two; this times twice the number of ranges plus two are computed.
    - `seed`: of chance.

    **Returns:** for each objective `S1` and `ST` and the half-widths of their 95 % intervals,
    `S1_conf` and `ST_conf`, in the order of the ranges; an objective that doesn't change
    has zeros.

    **Raises:** `ValueError` for unknown objectives and quantities; `ModuleNotFoundError`
    without SALib.
    """
    from SALib.analyze import sobol as analyze
    from SALib.sample import sobol as sample

    from ..core.validation import check_choice

    names, drawing = known(objectives), _only(designs)
    check_turns(names, task.scheme)
    for name in ranges:
        check_choice(name, VARIED, "ranges")
    problem = {
        "num_vars": len(ranges),
        "names": list(ranges),
        "bounds": [[1 - half, 1 + half] for half in ranges.values()],
    }
    # without second orders a sample takes as many again as there are names, and two
    drawn = sample.sample(problem, samples, calc_second_order=False, seed=seed)
    factor = dict(zip(ranges, drawn.T, strict=True))
    count, demand = len(drawn), Demand.from_task(task)
    kinds = _repeated(drawing, count)
    for name in set(_MATERIAL) & set(factor):
        material = getattr(kinds.material, name) * jnp.asarray(factor[name])
        kinds = with_fields(kinds, material=with_fields(kinds.material, **{name: material}))
    counts, sizes = _arrays(designs, place, task)
    one, each = np.ones(count), np.ones((count, sizes.radius.size))
    angle = (factor.get("braid_angle", one) - 1)[:, None] * np.asarray(sizes.angle)
    scales = Scales(
        jnp.asarray(factor.get("length", one)),
        jnp.asarray(factor.get("outer_radius", one)[:, None] * each),
        jnp.asarray(factor.get("wall_thickness", one)[:, None] * each),
        jnp.asarray(angle),
    )
    values = np.asarray(
        drawn_objectives(kinds, counts, sizes, scales, demand, names=names, needs=needs(names))
    )
    found = {}
    for name, row in zip(names, values, strict=True):
        if np.ptp(row) == 0:
            zeros = np.zeros(len(ranges))
            found[name] = dict.fromkeys(("S1", "S1_conf", "ST", "ST_conf"), zeros)
            continue
        indices: Any = analyze.analyze(problem, row, calc_second_order=False, seed=seed)
        found[name] = {key: np.asarray(indices[key]) for key in ("S1", "S1_conf", "ST", "ST_conf")}
    return found


_MATERIAL = ("c10", "c01", "youngs_modulus")
VARIED = ("length", "outer_radius", "wall_thickness", "braid_angle", *_MATERIAL)


def _only(designs: Designs) -> Muscle:
    kinds = set(designs.kind.tolist())
    if len(kinds) != 1:
        raise InvalidInputError("designs", "must be of one drawing", len(kinds))
    return list(designs.drawings.values())[kinds.pop()]


def _arrays(designs: Designs, index: int, task: Task) -> tuple[np.ndarray, Sizes]:
    """Muscles in each unit of a design, and their sizes."""
    units = int(room_for_units(designs, task.scheme)[index])
    return designs.counts[index, :units], designs.sizes(index).take(slice(units))


def _size(muscles: Muscle) -> int:
    return max(leaf.shape[0] for leaf in jax.tree.leaves(muscles) if jnp.ndim(leaf))


def _repeated(drawing: Muscle, draws: int) -> Muscle:
    return jax.tree.map(lambda leaf: jnp.broadcast_to(leaf, (draws, *jnp.shape(leaf))), drawing)


def _picked(muscles: Muscle, drawing: Muscle, draw: np.ndarray) -> Muscle:
    """Some of the draws; what a draw doesn't change has no axis for it yet."""

    def one(many: Values, single: Values) -> Array:
        if jnp.ndim(many) > jnp.ndim(single):
            return many[draw]
        return jnp.broadcast_to(many, (len(draw), *jnp.shape(many)))

    return jax.tree.map(one, muscles, drawing)


def _scales(
    drawing: Muscle,
    kinds: Muscle,
    scatter: Scatter | None,
    generator: np.random.Generator,
    draws: int,
    units: int,
) -> Scales:
    off = Scatter() if scatter is None else scatter
    long = 1 + off.length * generator.standard_normal(draws)
    tilt = off.braid_angle * generator.standard_normal((draws, units))
    each = np.ones((draws, units))
    ratio = [
        np.asarray(getattr(kinds, name) / getattr(drawing, name))
        for name in ("length", "outer_radius", "wall_thickness")
    ]
    turned = np.asarray(kinds.braid_angle - drawing.braid_angle)
    return Scales(
        jnp.asarray(long * ratio[0]),
        jnp.asarray(ratio[1][:, None] * each),
        jnp.asarray(ratio[2][:, None] * each),
        jnp.asarray(tilt + turned[:, None]),
    )
