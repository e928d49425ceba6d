r"""How sure a fit is: covariance, and what the data alone determine.

At the minimum, with the Jacobian $J$ of the residuals by the coordinates, and $S$ by the
readings' curves, whose own covariance is $\Sigma_s$,

$$C = (J^T J)^{-1} + K \Sigma_s K^T, \qquad K = (J^T J)^{-1} J^T S. \tag{C3}$$

The readings come from where the muscle pulls and the factors from where it resists, so the
two parts are independent. Scattering residuals that follow one another along a sweep hold
less than their number says: $C$'s first part is widened by $(1 + \rho)/(1 - \rho)$ with
their correlation $\rho$ from one to the next.

A coordinate is a logarithm or like one. It is called *identifiable* if the data alone, the
prior taken off, know it to a deviation below 1, a factor of e either way.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from .grid import Table
from .problem import Problem, Vector
from .readings import Level


KNOWN = 1.0
NORMAL = 1.6448536269514722  # 95 % quantile: intervals hold 90 %

Matrix = Float[Array, "parameter parameter"]


class Conclusion(eqx.Module):
    """What holds at a minimum, at the noise that the residuals show there.

    - `covariance`: of the coordinates [-], `from_curves` the part that readings cause.
    - `noise`: of one reading [N].
    - `force`, `misfits`: of the model [N], and residuals before any loss [-].
    - `strain`: of the fitted muscle at each reading [-].
    - `free_strain`, `collapse_strain`: of the fitted muscle at each level [-].
    """

    covariance: Matrix
    from_curves: Matrix
    noise: Float[Array, ""]
    force: Table
    misfits: Table
    strain: Table
    free_strain: Level
    collapse_strain: Level


def conclude(
    problem: Problem, z: Vector, curves_covariance: Float[Array, "coefficient coefficient"] | None
) -> Conclusion:
    """What holds at the minimum `z` [-]; the readings' curves have this covariance [-]."""
    curved = problem.curves is not None and curves_covariance is not None
    k, free = z.size, jnp.zeros(0) if problem.curves is None else problem.curves

    # one Jacobian by coordinates and curves together: the law is compiled once
    def residuals(both: Array) -> tuple[Array, Array]:
        at = eqx.tree_at(lambda p: p.curves, problem, both[k:]) if curved else problem
        mu = at.force(both[:k])
        r = at.residuals_of(mu, both[:k])
        return r, mu

    J, mu = jax.jacfwd(residuals, has_aux=True)(jnp.concatenate([z, free]))
    misfits = problem.misfits_of(mu)
    noise = scatter(problem, misfits, k)
    # residuals are in units of the noise, priors are not
    J = J.at[: misfits.size].multiply(problem.noise / noise)
    inverse = jnp.linalg.inv(J[:, :k].T @ J[:, :k])
    caused = jnp.zeros_like(inverse)
    if curved:
        K = inverse @ J[:, :k].T @ J[:, k:]
        caused = K @ curves_covariance @ K.T
    muscle = problem.muscle_at(z)
    at = muscle._law().at(problem.data.pressure[:, 0])
    return Conclusion(
        inverse + caused, caused, noise, mu, misfits * problem.noise / noise,
        problem.strain(muscle), at.column.free_strain, at.collapse,
    )  # fmt: skip


def scatter(problem: Problem, misfits: Table, parameters: int) -> Float[Array, ""]:
    """Deviation of a single reading [N] about a model with so many `parameters` [-]."""
    used = (problem.weight > 0) & problem.data.uncensored
    r = jnp.where(used, misfits * problem.noise, 0.0)
    free = jnp.maximum(jnp.sum(used) - parameters, 1)
    usual = jnp.sqrt(jnp.sum(r**2) / free)
    if problem.loss != "linear":
        # outliers that the loss plays down must not come back as noise
        usual = 1.4826 * jnp.nanmedian(jnp.where(used, jnp.abs(r), jnp.nan))
    return jnp.where(usual > 0, usual, problem.noise)
