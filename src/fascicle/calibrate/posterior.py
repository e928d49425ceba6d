r"""Posterior of a calibration, sampled by Hamiltonian Monte Carlo.

The likelihood is that of the least-squares fit: normal scatter about the law for measured forces,
its integral up to zero for clipped ones. It is multiplied by the priors of the coordinates, the
uncertainty of the readings' curves, the model's own error where residuals show one (`diagnostics`),
and a flat prior on the logarithm of the noise. Samples are standardized deviations from the fit,
$z = \hat z + \mathrm{chol}(C) u$: without this scaling chains do not mix.

**Source:** Hoffman and Gelman (2014) for the sampler; numpyro.
"""

from dataclasses import dataclass
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax.scipy.special import log_ndtr

from ..core.errors import InvalidInputError, require
from ..jax import jax
from .calibration import Calibration, value_of


_ACCEPT = 0.95  # probability: kinks at collapse, and undetermined constants, need short steps


@dataclass(frozen=True, eq=False)
class Posterior:
    """Draws of a calibration's parameters, and convergence diagnostics of the chains.

    - `values`, `coordinates`: of the parameters [SI], [-]; `curves`: coefficients of the readings'
      curves; `noise`: of a reading [N]; a row for each draw.
    - `r_hat`, `ess`: potential scale reduction, and effective sample size, of each parameter [-].
    - `divergences`: number of divergent steps.
    """

    names: tuple[str, ...]
    values: np.ndarray
    coordinates: np.ndarray
    curves: np.ndarray
    noise: np.ndarray
    r_hat: np.ndarray
    ess: np.ndarray
    divergences: int

    @property
    def agrees(self) -> bool:
        """The chains converged: R-hat below 1.01 and ESS above 400 for all, no divergence."""
        return bool(np.all(self.r_hat < 1.01) and np.all(self.ess > 400) and self.divergences == 0)

    def interval(self, level: float = 0.9) -> np.ndarray:
        """Ends of each parameter's central interval [SI], of probability `level` [-]."""
        tail = 0.5 * (1 - level)
        return np.quantile(self.values, [tail, 1 - tail], axis=0).T


def sample(
    calibration: Calibration, draws: int = 1000, warmup: int = 500, chains: int = 2, seed: int = 0
) -> Posterior:
    """Draw from the posterior of a calibration: each chain `draws`, after `warmup` others.

    **Raises:** `InvalidInputError` for a robust loss; `MissingExtraError` if numpyro is not
    installed.
    """
    if calibration.problem.loss != "linear":
        rule, remedy = "must be linear for a posterior", "a robust loss is no model of noise"
        raise InvalidInputError("loss", rule, None, remedy)
    require("numpyro")
    import numpyro
    from numpyro import distributions as dist
    from numpyro.diagnostics import effective_sample_size, split_gelman_rubin
    from numpyro.infer import MCMC, NUTS, init_to_median

    target = _Target(calibration)

    def model() -> None:
        u = numpyro.sample("u", dist.Normal(jnp.zeros(target.size), 1).to_event(1))
        # the density of the standard normal that samples u is divided out
        numpyro.factor("target", target.log_density(u) + 0.5 * jnp.sum(u**2))

    kernel = NUTS(model, init_strategy=init_to_median(num_samples=5), target_accept_prob=_ACCEPT)
    run = MCMC(
        kernel, num_warmup=warmup, num_samples=draws, num_chains=chains,
        chain_method="vectorized", progress_bar=False,
    )  # fmt: skip
    run.run(jax.random.PRNGKey(seed), extra_fields=("diverging",))
    u = run.get_samples(group_by_chain=True)["u"]
    z, curves, noise = jax.vmap(target.unpack)(u.reshape(-1, u.shape[-1]))
    sampled = np.asarray(jax.vmap(lambda point: value_of(target.problem, point))(z))
    by_chain = sampled.reshape(chains, draws, -1)
    z, curves, noise, r_hat, ess = map(
        np.asarray,
        (z, curves, noise, split_gelman_rubin(by_chain), effective_sample_size(by_chain)),
    )
    divergences = int(np.sum(run.get_extra_fields()["diverging"]))
    return Posterior(calibration.names, sampled, z, curves, noise, r_hat, ess, divergences)


class _Target:
    """Log posterior density over standardized coordinates, curves, discrepancy and noise."""

    def __init__(self, calibration: Calibration):
        self.problem, diagnosis = calibration.problem, calibration.diagnosis
        self.center = jnp.asarray(calibration.coordinates)
        self.scale = jnp.linalg.cholesky(jnp.asarray(calibration.covariance))
        self.curves, self.base = jnp.zeros((0, 0)), jnp.zeros(0)
        readings = calibration.readings
        if readings is not None:
            # from the pull alone: all other readings are in the likelihood
            base, covariance = readings.pulling or (self.problem.curves, readings.covariance)
            spread, basis = jnp.linalg.eigh(jnp.asarray(covariance))
            # unused orders of a polynomial have no spread
            used = np.asarray(spread) > 1e-12 * float(jnp.max(spread))
            self.base = jnp.asarray(base)
            self.curves = (basis * jnp.sqrt(jnp.maximum(spread, 0)))[:, used]
        self.discrepancy = jnp.asarray(diagnosis.discrepancy)
        # the discrepancy's part of the residuals is no noise
        self.noise = diagnosis.noise if diagnosis.significant else self.problem.noise
        self.count = float(np.sum((self.problem.weight > 0) & self.problem.grid.measured))
        sizes = [self.center.size, self.curves.shape[1], self.discrepancy.shape[-1], 1]
        self.ends = np.cumsum(sizes)
        self.size = int(self.ends[-1])

    def unpack(self, u: Any) -> tuple[Any, Any, Any]:
        """Coordinates [-], coefficients of the curves, and the noise [N] at `u`."""
        z, curves, _, log_noise = jnp.split(u, self.ends[:-1])
        noise = self.noise * jnp.exp(log_noise[0] / jnp.sqrt(2 * self.count))
        coefficients = self.base + self.curves @ curves if self.base.size else self.base
        return self.center + self.scale @ z, coefficients, noise

    def log_density(self, u: Any) -> Any:
        """Log density of likelihood and priors, to a constant."""
        z, coefficients, noise = self.unpack(u)
        _, curves, errors, _ = jnp.split(u, self.ends[:-1])
        problem, grid = self.problem, self.problem.grid
        mu = problem.force(jnp.concatenate([z, coefficients])) + self.discrepancy @ errors
        square = problem.weight**2 * grid.count * ((grid.force - mu) / noise) ** 2
        side = 1.0 if grid.at_least is None else jnp.where(grid.at_least, -1.0, 1.0)
        below = side * (grid.force - mu) * jnp.sqrt(grid.count) / noise
        clipped = problem.weight**2 * log_ndtr(below)
        likelihood = jnp.where(grid.censored, clipped, -0.5 * square)
        prior = jnp.sum(((z - problem.center) / problem.deviation) ** 2)
        prior = prior + jnp.sum(curves**2) + jnp.sum(errors**2)
        return jnp.sum(likelihood) - self.count * jnp.log(noise) - 0.5 * prior
