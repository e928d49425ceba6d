r"""Spread of designs' objectives over bundles as they are made, and over the model's error.

A draw changes the sizes of a bundle's muscles, by fabrication, (D2); the material and the laws'
numbers, from a calibrated muscle's covariance; and all forces by one factor,
$\exp(\sigma z)$ with a standard normal $z$, the model's error $\sigma$. Calibrated sizes change in
proportion. **Assumes** that the muscles of a bundle are one batch, whose lengths, walls and braid
angles deviate alike, and that the model is wrong by the same share everywhere: so the same muscles
are as safe in one motor unit as in several.
"""

from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import attrs
import numpy as np

from ..core.array_namespace import slices
from ..core.errors import InvalidInputError
from ..core.module import to_numpy, tree_leaves, tree_map
from ..core.types import Bool, Float, Values
from ..fluid.fields import interval_field
from ..muscle import Muscle
from ..records.dynamometer import Scatter
from .designs import Designs
from .evaluation import MIXED, evaluate
from .objectives import Limits, check_objectives, with_reach_limits, within_limits
from .task import Task


SMALLEST_ANGLE = 1e-3  # rad; no braid is wound so steeply
LARGEST_ANGLE = 0.95  # rad, just below the neutral angle, at which a muscle doesn't contract
USUAL_SHARE = 0.95  # of the draws that must meet the task
USUAL_DRAWS = 2000  # a share of 95 % is then known within 0.5 %, a standard error
_THINNEST, _THICKEST = 0.05, 0.95  # of a drawn wall, over drawing and radius: stays a tube
_LARGEST_SCATTER = 0.5  # of a wall or the model's error; more is a slip
_BATCH = 2**20  # units of designs in all draws that are in memory together: some 100 megabytes

_CLOSED = (True, True)


@attrs.frozen(slots=False)
class DesignScatter(Scatter):
    """Standard deviations of `length` [-] and `wall_thickness` [-], over their values, of
    `braid_angle` [rad], and of the logarithm of all forces, `model_error` [-].
    """

    wall_thickness: Values = interval_field(
        "wall_thickness", 0.0, _LARGEST_SCATTER, _CLOSED, default=0.0
    )
    model_error: Values = interval_field("model_error", 0.0, _LARGEST_SCATTER, _CLOSED, default=0.0)


# of a task file without [scatter]; the docs (design, Uncertainty) say why
USUAL_SCATTER = DesignScatter(0.01, float(np.radians(1.5)), 0.05, 0.15)


class Draws(NamedTuple):
    """Factors on `length`, `wall` and `force` [-], and what is added to the braid `angle` [rad]."""

    length: Float[np.ndarray, " draw"]
    wall: Float[np.ndarray, " draw"]
    angle: Float[np.ndarray, " draw"]
    force: Float[np.ndarray, " draw"]


def sample_draws(scatter: Scatter, draws: int, seed: int = 0) -> Draws:
    """Draw deviations of fabrication and model errors at random; they serve any design. A plain
    `Scatter` has no wall and no model error.
    """
    wall = getattr(scatter, "wall_thickness", 0.0)
    error = getattr(scatter, "model_error", 0.0)
    z = np.random.default_rng(seed).standard_normal((draws, 4)).T
    thickness = np.maximum(1 + wall * z[2], _THINNEST)
    angle = scatter.braid_angle * z[3]
    return Draws(1 + scatter.length * z[0], thickness, angle, np.exp(error * z[1]))


@dataclass(frozen=True, eq=False)
class Spread:
    """Objectives over draws: `values` [SI] by name, draws last; `met`: mask of the draws that reach
    the task and keep all limits.
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


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Random draws of designs, and the share of them that must hold: `scatter` of fabrication and
    the model's error; number of `draws`; `muscles`: draws of a calibrated muscle, on the first axis
    of its numbers, or `None`; `share` of the draws that must meet the task and all limits [-];
    `basis` of the model's error: "given", of the "fit", or "assumed", of a muscle without a fit or
    of a "product" in other sizes than were measured.
    """

    scatter: DesignScatter = USUAL_SCATTER
    draws: int = USUAL_DRAWS
    muscles: Muscle | None = None
    share: float = USUAL_SHARE
    basis: Literal["given", "fit", "assumed", "product"] = "assumed"


@dataclass(frozen=True, eq=False)
class Safety:
    """Safety of a search's designs: how often they hold the task in random draws.

    `uncertainty`: what was drawn; `probability`: share of the draws in which the recommended
    design, or the surest one, meets the task and all limits [-], and the 5th percentile of its
    relative margin, `low_margin` [-]; `judged`: number of designs that were judged; `complete`:
    true if no other can be on the front of the safe ones; `spread`: of the designs on the front;
    `nearest_unsafe`: index of the surest recorded design that fails too often, or `None`, with its
    share of the draws in `nearest_share` [-].
    """

    uncertainty: Uncertainty
    probability: float
    low_margin: float
    judged: int
    complete: bool
    spread: Spread
    nearest_unsafe: int | None = None
    nearest_share: float = np.nan

    @property
    def holds(self) -> bool:
        """True if a design meets the task in the demanded share of the draws."""
        return self.probability >= self.uncertainty.share


def _draw_designs(designs: Designs, draws: Draws) -> Designs:
    """Designs with the sizes of every draw: all draws of the first design first."""
    number, drawn = len(designs), designs.take(np.repeat(np.arange(len(designs)), len(draws.wall)))
    length, wall, angle = (np.tile(x, number) for x in (draws.length, draws.wall, draws.angle))
    return replace(
        drawn,
        length=drawn.length * length,
        wall=np.minimum(drawn.wall * wall[:, None], _THICKEST * drawn.radius),
        angle=np.clip(drawn.angle + angle[:, None], SMALLEST_ANGLE, LARGEST_ANGLE),
    )


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
    """Spread of designs' objectives under fabrication scatter, model error and uncertain constants.

    **Arguments:**

    - `designs`: any; of one drawing, if `muscles` are given.
    - `task`: what is demanded.
    - `objectives`: by name.
    - `limits`: on objectives, by name [SI], as `search` takes them: all must be reached.
    - `scatter`: of fabrication, and with a `DesignScatter` of all forces; default: none.
    - `muscles`: draws of the calibrated drawing, on the first axis of their numbers [-]; default:
      the drawing itself.
    - `draws`: their number [-], the same for every design.
    - `seed`: random seed.

    **Raises:** `ValueError` for `muscles` and designs of several drawings, and unknown objectives.
    """
    limits, scatter = with_reach_limits(limits), Scatter() if scatter is None else scatter
    names = check_objectives([*objectives, *limits], task.scheme)
    sample, muscle_of = sample_draws(scatter, draws, seed), np.zeros(draws, int)
    if muscles is not None:
        muscles = to_numpy(muscles)
        number = max(len(leaf) for leaf in tree_leaves(muscles) if np.ndim(leaf))
        muscle_of = np.random.default_rng(seed).integers(0, number, draws)
    values = {name: np.empty((len(designs), draws)) for name in names}
    for index in np.unique(muscle_of):
        (members,) = np.nonzero(muscle_of == index)
        batch = Draws(*(x[members] for x in sample))
        nominal = designs if muscles is None else _calibrated_designs(designs, muscles, int(index))
        step = max(1, _BATCH // (len(members) * designs.counts.shape[1]))
        for block in slices(len(designs), step):
            drawn = _draw_designs(nominal.take(block), batch)
            factor = np.resize(batch.force, len(drawn))  # all draws of one design after another
            for name, row in evaluate(drawn, task, names, MIXED, factor).items():
                values[name][block, members] = row.reshape(-1, len(members))
    return Spread(values, within_limits(values, limits))


def _calibrated_designs(designs: Designs, muscles: Muscle, index: int) -> Designs:
    """Designs of the calibrated muscle with an `index`, all sizes changed in proportion to it."""
    if len(kinds := set(designs.kind.tolist())) != 1:
        raise InvalidInputError("designs", "must be of one drawing", len(kinds))
    drawing = list(designs.drawings.values())[kinds.pop()]

    def pick(leaf: Values, single: Values) -> Values:
        return leaf[index] if np.ndim(leaf) > np.ndim(single) else leaf

    muscle = tree_map(pick, muscles, drawing)
    return replace(
        designs,
        drawings={"calibrated": muscle},
        kind=np.zeros(len(designs), int),
        length=designs.length * float(muscle.length / drawing.length),
        radius=designs.radius * float(muscle.outer_radius / drawing.outer_radius),
        wall=designs.wall * float(muscle.wall_thickness / drawing.wall_thickness),
        angle=designs.angle + float(muscle.braid_angle - drawing.braid_angle),
    )
