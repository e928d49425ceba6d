r"""Spread of a design's objectives over bundles as they are made, and over the model's error.

A draw changes the sizes of a bundle's muscles, by fabrication, (D2); the material and the laws'
numbers, from a calibrated muscle's covariance; and all forces by one factor,
$\exp(\sigma z)$ with a standard normal $z$, the model's error $\sigma$. Calibrated sizes change in
proportion. **Assumes** that the muscles of a bundle are one batch, whose lengths, walls and braid
angles deviate alike, and that the model is wrong by the same share everywhere. Deviations of single
muscles, which average out over a bundle, aren't drawn: so the same muscles are as safe in one motor
unit as in several.

Draws are evaluated together, as designs are.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..core.types import Bool, Float
from ..core.validation import check_interval
from ..muscle import Muscle
from ..records.dynamometer import Scatter
from .designs import Designs
from .objectives import as_minimization, non_dominated


SMALLEST_ANGLE = 1e-3  # rad; no braid is wound so steeply
LARGEST_ANGLE = 0.95  # rad, just below the neutral angle, at which a muscle doesn't contract
USUAL_SHARE = 0.95  # of the draws that must meet the task
USUAL_DRAWS = 2000  # a share of 95 % is then known within 0.5 %, a standard error
_THINNEST, _THICKEST = 0.05, 0.95  # of a drawn wall, over drawing and radius: stays a tube
_LARGEST_SCATTER = 0.5  # of a wall or the model's error; more is a slip


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
    """Draw deviations of fabrication and model errors at random; they serve any design.

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
    """Spread of objectives over draws: `values` [SI] by name, draws last; `met`: mask of the draws
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
    """Uncertainty of designs: what is drawn at random, and the share of draws that must hold.

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
    basis: str = "assumed, as the muscle isn't calibrated"

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
    """Safety of a search's designs: how often they hold the task in random draws.

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


def draw_designs(designs: Designs, draws: Draws) -> Designs:
    """Designs with the sizes of every draw: all draws of the first design first."""
    number, copies = len(designs), np.repeat(np.arange(len(designs)), len(draws.length))
    drawn = designs.take(copies)
    length, wall, angle = (np.tile(x, number) for x in (draws.length, draws.wall, draws.angle))
    return replace(
        drawn,
        length=drawn.length * length,
        wall=np.minimum(drawn.wall * wall[:, None], _THICKEST * drawn.radius),
        angle=np.clip(drawn.angle + angle[:, None], SMALLEST_ANGLE, LARGEST_ANGLE),
    )
