r"""Spread of a design's objectives over bundles as they are made, and over the model's error.

A draw changes the sizes of a bundle's muscles, by fabrication, (D2); the material and the laws'
numbers, from a calibrated muscle's covariance; and all forces by one factor,
$\exp(\sigma z)$ with a standard normal $z$, the model's error $\sigma$. Calibrated sizes change in
proportion. **Assumes** that the muscles of a bundle are one batch, whose lengths, walls and braid
angles deviate alike, and that the model is wrong by the same share everywhere. Deviations of single
muscles, which average out over a bundle, aren't drawn: so the same muscles are as safe in one motor
unit as in several.

A bundle whose forces are $f$ times as large meets the demand $F$ in the state in which the
drawn one meets $F/f$: draws are evaluated together as designs are, with demands of their own.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..core.module import with_fields
from ..core.types import Bool, Float
from ..core.validation import check_interval
from ..muscle import Muscle
from ..records.dynamometer import Scatter
from .designs import Designs, Sizes
from .evaluation import evaluated_units
from .objectives import (
    as_minimization,
    needs,
    non_dominated,
    objective_values,
)
from .outcome import Demand, Outcome, outcome, with_axes
from .tables import MIXED, largest_force_table
from .task import Task


SMALLEST_ANGLE = 1e-3  # rad; no braid is wound so steeply
LARGEST_ANGLE = 0.95  # rad, just below the neutral angle, at which a muscle doesn't contract
USUAL_SHARE = 0.95  # of the draws that must meet the task
USUAL_DRAWS = 2000  # a share of 95 % is then known within 0.5 %, a standard error
_THINNEST, _THICKEST = 0.05, 0.95  # of a drawn wall, over drawing and radius: stays a tube
_LARGEST_SCATTER = 0.5  # of a wall or the model's error; more is a slip
_BATCH = 2**20  # numbers computed together, some ten megabytes


@dataclass(frozen=True)
class DesignScatter(Scatter):
    """Standard deviations of `length` [-] and `wall_thickness` [-], over their values, of
    `braid_angle` [rad], and of the logarithm of all forces, `model_error` [-].
    """

    wall_thickness: float = 0.0
    model_error: float = 0.0

    def __post_init__(self):
        """**Raises:** `InvalidInputError` for a scatter that is negative or huge."""
        super().__post_init__()
        for name in ("wall_thickness", "model_error"):
            check_interval(getattr(self, name), 0.0, _LARGEST_SCATTER, name, "-",
                           closed=(True, True))  # fmt: skip


# of a task file without [scatter]; the docs (design, Uncertainty) say why
USUAL_SCATTER = DesignScatter(0.01, float(np.radians(1.5)), 0.05, 0.15)


class Draws(NamedTuple):
    """Factors on `length`, `wall` and `force` [-], and what is added to the braid `angle` [rad]."""

    length: Float[np.ndarray, " draw"]
    wall: Float[np.ndarray, " draw"]
    angle: Float[np.ndarray, " draw"]
    force: Float[np.ndarray, " draw"]


def sample_draws(scatter: Scatter, draws: int, seed: int = 0) -> Draws:
    """Draw the fabrication of bundles, and the model's error: for any design the same.

    **Arguments:**

    - `scatter`: standard deviations; `Scatter` has no wall and no model error.
    - `draws`: number of draws [-].
    - `seed`: random seed.

    **Returns:** the draws.
    """
    wall = getattr(scatter, "wall_thickness", 0.0)
    error = getattr(scatter, "model_error", 0.0)
    z = np.random.default_rng(seed).standard_normal((draws, 4)).T
    return Draws(
        1 + scatter.length * z[0],
        np.maximum(1 + wall * z[2], _THINNEST),
        scatter.braid_angle * z[3],
        np.exp(error * z[1]),
    )


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


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """What is uncertain of a design, and how sure it must be.

    - `scatter`: of fabrication, and the model's error.
    - `draws`: number of random draws.
    - `muscles`: draws of a calibrated muscle, on the first axis of its numbers, or `None`.
    - `share`: of the draws that must meet the task and all limits [-].
    - `basis`: of the model's error, in words.
    """

    scatter: DesignScatter = USUAL_SCATTER
    draws: int = USUAL_DRAWS
    muscles: Muscle | None = None
    share: float = USUAL_SHARE
    basis: str = "assumed of a muscle that isn't calibrated"

    @property
    def assumptions(self) -> str:
        """Standard deviations in a line."""
        scatter = self.scatter
        texts = [
            f"{name} {100 * value:.3g} %"
            for name, value in (("length", scatter.length), ("wall", scatter.wall_thickness))
        ]
        texts.append(f"braid angle {np.degrees(scatter.braid_angle):.3g}°")
        texts.append(f"all forces {100 * scatter.model_error:.3g} % ({self.basis})")
        if self.muscles is not None:
            texts.append("constants by the calibration's covariance")
        return ", ".join(texts)


@dataclass(frozen=True, eq=False)
class Safety:
    """Judgement of designs in draws.

    - `uncertainty`: what was drawn.
    - `probability`: share of the draws in which the recommended design, or the surest one, meets
      the task and all limits [-].
    - `judged`: number of designs that were judged; `complete`: true if these are all that do the
      task, or the recommended design was among them.
    - `spread`: of the reported designs.
    """

    uncertainty: Uncertainty
    probability: float
    judged: int
    complete: bool
    spread: Spread

    @cached_property
    def margin_quantiles(self) -> Float[np.ndarray, " design"]:
        """5 % quantile of each reported design's relative margin over the draws [-]."""
        return np.quantile(self.spread.values["relative_margin"], 0.05, axis=1)

    @property
    def holds(self) -> bool:
        """True if a design meets the task in the demanded share of the draws."""
        return self.probability >= self.uncertainty.share


def scale_forces(outcome: Outcome, demand: Demand, length: np.ndarray, factor: Any) -> Outcome:
    """Outcome for a `demand` of bundles with `factor` times the model's forces [-].

    `outcome`: of the model's forces, for the demanded forces divided by `factor`; the states, and
    so the fluid energy, are the same in both. `length`: of the bundles at rest [m].
    """
    axes = np.ndim(length)
    return outcome._replace(
        force=with_axes(demand.force, axes), work=with_axes(demand.work(length), axes),
        shortfall=factor * outcome.shortfall, spare=factor * outcome.spare,
        blocked=factor * outcome.blocked,
    )  # fmt: skip


def batch_objectives(
    designs: Designs, task: Task, names: tuple[str, ...], draws: Draws
) -> Float[np.ndarray, "objective design draw"]:
    """Objectives of designs in every draw [SI], many draws in one evaluation."""
    number, demand = len(draws.length), Demand.from_task(task)
    values = np.empty((len(names), len(designs), number))
    keys = np.stack([designs.kind, evaluated_units(designs, task.scheme)], axis=1)
    for key in np.unique(keys, axis=0):
        index, units = np.flatnonzero(np.all(keys == key, axis=1)), int(key[1])
        step = max(1, _BATCH // (number * len(task) * units))
        for start in range(0, len(index), step):
            rows = index[start : start + step]
            drawn = _drawn_outcome(designs.take(rows, units), demand, names, draws)
            values[:, rows] = objective_values(drawn, names).reshape(-1, len(rows), number)
    return values


def _drawn_outcome(
    designs: Designs, demand: Demand, names: tuple[str, ...], draws: Draws
) -> Outcome:
    """Outcome of designs of one drawing in every draw, draws fastest on the last axis."""
    (D, U), N = designs.counts.shape, len(draws.length)
    columns = 1 if np.all(designs.uniform) else U  # a draw changes all muscles of a bundle alike
    zero = np.zeros((columns, D, N))
    radius = designs.radius.T[:columns, :, None] + zero
    wall = designs.wall.T[:columns, :, None] * draws.wall
    angle = designs.angle.T[:columns, :, None] + draws.angle
    length = designs.length[:, None] * draws.length
    sizes = Sizes(
        (length + zero).ravel(), radius.ravel(), np.minimum(wall, _THICKEST * radius).ravel(),
        np.clip(angle, SMALLEST_ANGLE, LARGEST_ANGLE).ravel(),
    )  # fmt: skip
    counts = np.repeat(designs.counts.T, N, axis=1)
    table = largest_force_table(designs.drawing(0), sizes, demand, needs(names), MIXED)
    table = table.take(np.resize(np.arange(columns * D * N), (U, D * N)))  # units repeat a column
    factor, length = np.tile(draws.force, D), length.ravel()
    demanded = with_fields(demand, force=demand.force[:, None] / factor)
    return scale_forces(outcome(counts, table, length, demanded), demand, length, factor)
