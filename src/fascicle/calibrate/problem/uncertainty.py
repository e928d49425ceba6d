r"""How sure a fit is: covariance, and what the data alone determine.

At the minimum, with the Jacobian $J$ of the residuals by the coordinates, and $S$ by the
readings' curves, whose own covariance is $\Sigma_s$,

$$C = (J^T J)^{-1} + K \Sigma_s K^T, \qquad K = (J^T J)^{-1} J^T S. \tag{C3}$$

The readings come from where the muscle pulls and the factors from where it resists, so the
two parts are independent. This is what noise alone makes unsure; what the residuals show
beside noise comes on top of it (`discrepancy`).

A coordinate is a logarithm or like one. It is called *identifiable* if the data alone, the
prior taken off, know it to a deviation below 1, a factor of e either way.
"""

from dataclasses import dataclass

import numpy as np

from .linear import Linear, linear
from .residuals import Problem


KNOWN = 1.0
NORMAL = 1.6448536269514722  # 95 % quantile: intervals hold 90 %


@dataclass(frozen=True, eq=False)
class Conclusion:
    """What holds at a minimum, at the noise that the residuals show there.

    - `covariance`: of the free coordinates [-], `from_curves` the part that readings cause.
    - `noise`: of one reading [N].
    - `linear`: the problem there, its residuals over the noise that it was solved with [-].
    - `misfits`: residuals before any loss, over the noise [-].
    """

    covariance: np.ndarray
    from_curves: np.ndarray
    noise: float
    linear: Linear
    misfits: np.ndarray


def conclude(
    problem: Problem, coordinates: np.ndarray, curves_covariance: np.ndarray | None
) -> Conclusion:
    """What holds at the minimum [-], at `coordinates` [-] of all of a `problem`'s parameters [-];
    the readings' curves have this covariance [-].
    """
    found, free = linear(problem, coordinates), problem.chosen
    misfits = found.misfits
    noise = scatter(problem, misfits, free.size)
    # residuals are in units of the noise, priors are not
    J = found.slopes.copy()
    J[: misfits.size] *= float(problem.noise) / noise
    own, curves = J[:, free], J[:, len(problem.parameters) :]
    inverse = np.linalg.inv(own.T @ own)
    caused = np.zeros_like(inverse)
    if curves.size and curves_covariance is not None:
        K = inverse @ own.T @ curves
        caused = K @ curves_covariance @ K.T
    return Conclusion(
        inverse + caused, caused, noise, found, misfits * float(problem.noise) / noise
    )


def scatter(problem: Problem, misfits: np.ndarray, parameters: int) -> float:
    """Deviation of a single reading [N] about a model with so many `parameters` [-], from
    `misfits` [-] over the problem's noise.
    """
    used = np.asarray((problem.weight > 0) & problem.data.uncensored)
    r = misfits[used] * float(problem.noise)
    if problem.loss != "linear":
        # outliers that the loss plays down must not come back as noise
        usual = 1.4826 * float(np.median(np.abs(r))) if r.size else 0.0
    else:
        usual = float(np.sqrt(np.sum(r**2) / max(r.size - parameters, 1)))
    return usual if usual > 0 else float(problem.noise)
