r"""What readings and priors say of a model's forces: residuals, and how they change with these.

A measured force $F$, the mean of $n$ readings that scatter by $\sigma$, leaves the residual

$$r = \sqrt{n}\, \frac{F - \mu}{\sigma}, \tag{C1}$$

a censored one, which only says that the force was not above $F$ (zero, or the gauge's floor),

$$r = \sqrt{-2 \ln \Phi((F - \mu)/\sigma)}, \tag{C2}$$

so that half the sum of squares is the negative logarithm of the likelihood: nothing where
the model pushes, and as much as any other deviation where it pulls. Each coordinate's
prior adds $(z - z_0)/\tau$.

**Source:** Tobin (1958) for censored regression.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import erfcx, log_ndtr


LOSSES = ("linear", "soft_l1", "cauchy")
_SURE = 30.0  # deviations below the limit, where a censored reading says nothing in float64


@dataclass(frozen=True, eq=False)
class Misfit:
    """Readings and priors in plain arrays; fields as of `Grid` and `Problem`."""

    force: np.ndarray
    count: np.ndarray
    censored: np.ndarray
    weight: np.ndarray
    noise: np.ndarray
    center: np.ndarray
    deviation: np.ndarray
    loss: str

    def of(self, force: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Residuals of the readings [-], (C1) and (C2), at a model's `force` [N], no loss; and
        their slopes [1/N].
        """
        scaled = np.sqrt(self.count) / self.noise
        missed = (self.force - force) * scaled
        if not np.any(self.censored):
            return self.weight * missed, -self.weight * scaled
        sure = np.minimum(missed, _SURE)
        likely = log_ndtr(sure)
        not_above = np.sqrt(-2 * likely)
        # what chance of a clipped reading is lost with each newton, over the residual
        mills = np.sqrt(2 / np.pi) / erfcx(-sure / np.sqrt(2))
        rises = np.where(sure < _SURE, scaled * mills / not_above, 0.0)
        return (
            self.weight * np.where(self.censored, not_above, missed),
            self.weight * np.where(self.censored, rises, -scaled),
        )

    def residuals(
        self, force: np.ndarray, coordinates: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """All residuals [-]: the readings' under the loss, then the priors'; the slopes of the
        readings' with their own force [1/N]; and the readings' before any loss [-].
        """
        misfits, slopes = self.of(force)
        r, softer = _LOSS[self.loss](misfits)
        prior = (coordinates - self.center) / self.deviation
        return np.concatenate([r.reshape(-1), prior]), (slopes * softer).reshape(-1), misfits


def _linear(r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return r, np.ones_like(r)


def _soft(r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    # of two forms of 2 (sqrt(1 + r²) - 1), the one without cancellation
    root = np.sqrt(1 + r**2)
    factor = np.sqrt(2 / (root + 1))
    return r * factor, 1 / (root * factor)


def _cauchy(r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    square = np.maximum(r**2, 1e-300)
    factor = np.where(r**2 > 1e-12, np.sqrt(np.log1p(square) / square), 1.0)
    return r * factor, 1 / ((1 + r**2) * factor)


_LOSS: dict[str, Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]] = {
    "linear": _linear, "soft_l1": _soft, "cauchy": _cauchy,
}  # fmt: skip
