r"""The error of the model itself, and what it makes unsure.

Where residuals follow strain or pressure, the model errs there, and the error that a fit has taken
up into its constants can't be seen. It is taken to be as large as what can be: a smooth
discrepancy is added to the model,

$$F = \mu(z) + B b + e, \qquad b \sim N(0, \tau^2), \tag{C10}$$

with the polynomials $B$ of each trend that was found, and its size from what they explain,
the expectation of the explained squares (Henderson's method III)

$$E \lVert Q^T y \rVert^2 = \tau^2 \lVert (1 - T T^T) B \rVert^2 + \sigma^2 \operatorname{rank} Q,
  \tag{C11}$$

$T$ the span of all that was fitted before. The constants' covariance grows by what such errors
would move them,

$$C_d = \tau^2 (t/1.645)^2\, G B B^T G^T, \qquad G = (J^T J)^{-1} J^T, \tag{C12}$$

$t$ Student's quantile, since $\tau$ is known from a few orders only.

**Assumes** that the discrepancy is smooth, and no larger where the fit took it up than beside.
**Source:** Kennedy and O'Hagan (2001) for the term; Henderson (1953) for its size.
"""

import numpy as np
from scipy.special import stdtrit

from ..problem.residuals import Problem
from ..problem.uncertainty import NORMAL, Conclusion
from .remainder import Remainder, beside, span
from .trends import Looked


_LEVEL = 0.95  # both ends of a 90 % interval


def from_trends(
    problem: Problem, conclusion: Conclusion, left: Remainder, seen: Looked
) -> np.ndarray:
    """What the trends that were found add to the covariance of the free coordinates [-], (C12).

    **Arguments:**

    - `problem`, `conclusion`: of the fit [-].
    - `left`: what it left [-].
    - `seen`: what was found in it [-].

    **Returns:** the covariance [-].
    """
    free = problem.chosen
    total = np.zeros((free.size, free.size))
    if not seen.found:
        return total
    J = conclusion.linear.slopes[:, free]
    used = np.asarray(problem.data.uncensored).reshape(-1)
    rows = np.concatenate([used, np.zeros(J.shape[0] - used.size, dtype=bool)])
    count = int(np.sum(used))
    # residuals fall by this much for each newton that the model errs
    scale = np.asarray(problem.weight).reshape(-1)[used] / float(problem.noise)
    influence = np.linalg.solve(J.T @ J, J[rows].T * scale)
    for trend, (variance, orders) in zip(seen.found, sizes(left, seen), strict=True):
        moved = influence @ trend.columns[:count]
        wide = float(stdtrit(orders, _LEVEL)) / NORMAL
        total += variance * wide**2 * moved @ moved.T
    return total


def sizes(left: Remainder, seen: Looked) -> list[tuple[float, int]]:
    """Of each trend that was `seen` [-] in what a fit `left` [-]: $\\tau^2$ [N²] by (C11), and
    from how many orders it is known [-].
    """
    taken, out = left.taken, []
    for trend in seen.found:
        away, Q = beside(taken, trend.columns), left.beyond(taken, trend.columns)
        explained = float(np.sum((Q.T @ left.residual) ** 2))
        more = explained - seen.noise**2 * Q.shape[1]
        out.append((max(more / float(np.sum(away**2)), 0.0), Q.shape[1]))
        taken = span(np.hstack([taken, trend.columns]))
    return out


def table(problem: Problem, left: Remainder, seen: Looked) -> np.ndarray:
    """The discrepancy's columns at the places of a `problem`'s tables [-], each times its $\\tau$
    [N]; 0 where nothing was measured. `left`: by the fit [-]; `seen`: what was found in it [-].
    """
    used = problem.data.uncensored
    count = int(np.sum(used))
    out = np.zeros((*used.shape, sum(trend.columns.shape[1] for trend in seen.found)))
    if seen.found:
        columns = [
            np.sqrt(variance) * trend.columns[:count] / left.weight[:count, None]
            for trend, (variance, _) in zip(seen.found, sizes(left, seen), strict=True)
        ]
        out[used] = np.hstack(columns)
    return out


def widening(left: Remainder, seen: Looked) -> float:
    """How much wider residuals that follow one another along a sweep make a variance [-].

    Of what is left beside the trends that were found: $(1 + \\rho)/(1 - \\rho)$ with the
    correlation $\\rho$ from one to the next; 1 unless that is more than chance allows.
    """
    read = left.read
    known = span(np.hstack([trend.columns for trend in seen.found])) if seen.found else None
    r = left.residual if known is None else beside(known, left.residual)
    r = r[read]
    order = np.lexsort((left.strain[read], left.branch[read], left.level[read]))
    level, branch = left.level[read][order], left.branch[read][order]
    r = r[order]
    pairs = (np.diff(level) == 0) & (np.diff(branch) == 0)
    total = float(r @ r)
    rho = float(np.sum((r[1:] * r[:-1])[pairs])) / total if total > 0 else 0.0
    rho = min(max(rho, 0.0), 0.99)
    return (1 + rho) / (1 - rho) if rho > 3 / np.sqrt(max(r.size, 1)) else 1.0
