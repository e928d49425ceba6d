r"""Draws of a calibrated muscle one after another, by one compiled program, and Sobol's indices.

Muscles whose constants differ can't share a batch's tables: each draw is a design of its own here.
"""

from collections.abc import Mapping
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from ..core.errors import InvalidInputError
from ..core.module import with_fields
from ..core.types import Float, Int, Values
from ..core.validation import check_choice
from ..muscle import Muscle
from .designs import Designs, Sizes
from .evaluation import design_outcome, evaluated_units
from .objectives import check_objectives, needs, objective_values
from .outcome import Demand
from .scatter import LARGEST_ANGLE, SMALLEST_ANGLE, Draws
from .tables import MIXED, Resolution
from .task import Task


_MATERIAL = ("c10", "c01", "youngs_modulus")
VARIED = ("length", "outer_radius", "wall_thickness", "braid_angle", *_MATERIAL)
_TOGETHER = 8  # draws computed in one call of the compiled program: as fast as more
_INDICES = ("S1", "S1_conf", "ST", "ST_conf")  # SALib's keys


class Scales(NamedTuple):
    """Factors of each draw on the drawing's sizes and forces, and what it adds to angles [rad]."""

    length: Float[Array, " draw"]
    radius: Float[Array, " draw"]
    wall: Float[Array, " draw"]
    angle: Float[Array, " draw"] | Float[Array, "draw unit"]
    force: Float[Array, " draw"]


def compiled_objectives(
    designs: Designs,
    task: Task,
    names: tuple[str, ...],
    draws: Draws,
    muscles: Muscle,
    seed: int = 0,
) -> dict[str, Float[np.ndarray, " draw"]]:
    """Objectives of designs in every draw [SI], by compiled code of JAX, one design at a time.

    **Arguments:**

    - `designs`: of one drawing.
    - `task`: what is demanded.
    - `names`: of the objectives.
    - `draws`: of fabrication and forces.
    - `muscles`: draws of the calibrated drawing, on the first axis of their numbers [-], of which
      each draw has one at random.
    - `seed`: random seed of that choice; `draws` are drawn already.

    **Returns:** the values by name, all draws of the first design first [SI].

    **Raises:** `ValueError` for designs of several drawings.
    """
    drawing, demand = _single_drawing(designs), Demand.from_task(task)
    size = max(leaf.shape[0] for leaf in jax.tree.leaves(muscles) if jnp.ndim(leaf))
    picks = np.random.default_rng(seed).integers(0, size, len(draws.length))
    kinds = _pick_draws(muscles, drawing, picks)
    scales = _draw_scales(kinds, drawing, draws)
    values = [
        drawn_objectives(
            kinds, *_counts_and_sizes(designs, index, task), scales, demand,
            names=names, needs=needs(names),
        )
        for index in range(len(designs))
    ]  # fmt: skip
    return dict(zip(names, np.concatenate(values, axis=1), strict=True))


def _draw_scales(kinds: Muscle, drawing: Muscle, draws: Draws) -> Scales:
    """Scales of each draw from the sizes of `drawing` to drawn ones: factors on length, radius,
    wall and force [-], and what is added to the braid angle [rad].

    Scatter of fabrication and model (`draws`) and the sizes of calibrated muscles (`kinds`, one for
    each draw) both count.
    """
    scales = (
        draws.length * kinds.length / drawing.length,
        kinds.outer_radius / drawing.outer_radius,
        draws.wall * kinds.wall_thickness / drawing.wall_thickness,
        draws.angle + kinds.braid_angle - drawing.braid_angle,
        draws.force,
    )
    return Scales(*map(jnp.asarray, scales))


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

    def objectives(draw: tuple[Muscle, Scales]) -> Array:
        kind, scale = draw
        drawn = Sizes(
            sizes.length * scale.length,
            sizes.radius * scale.radius,
            sizes.wall * scale.wall,
            jnp.clip(sizes.angle + scale.angle, SMALLEST_ANGLE, LARGEST_ANGLE),
        )
        outcome = design_outcome(kind, counts, drawn, demand, needs, resolution, scale.force)
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
    """Sobol's sensitivity indices of each objective, of first and total order, by SALib.

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
    lengths, radii, walls = (factors[name] for name in VARIED[:3])
    angle_changes = (factors["braid_angle"] - 1)[:, None] * np.asarray(sizes.angle)
    scales = Scales(*map(jnp.asarray, (lengths, radii, walls, angle_changes, np.ones(len(draws)))))
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
