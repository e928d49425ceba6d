r"""The posterior of a calibration, drawn by Hamiltonian Monte Carlo.

The likelihood is the one that least squares maximizes: normal scatter about the law for
measured forces, its integral up to zero for clipped ones; with it the coordinates' priors,
the readings' curves as uncertain as they were read, the model's own error where residuals
show one (`discrepancy`), and the noise with a flat prior on its logarithm. Drawn are
standardized deviations from the fit, $z = \hat z + \mathrm{chol}(C) u$: without that chains
stick.

**Source:** Hoffman and Gelman (2014) for the sampler; numpyro.
"""

from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.scipy.special import log_ndtr

from ..core.errors import InvalidInputError
from .calibration import Calibration
from .parameters import put, values


INSTALL = "`--posterior` needs the package numpyro: pip install 'fascicle[posterior]'."

_ACCEPT = 0.95


@dataclass(frozen=True, eq=False)
class Posterior:
    """Draws of a calibration's parameters, and whether the chains agree.

    - `names`: of the parameters.
    - `values`: a row for each draw [SI unit of each parameter].
    - `coordinates`: the same draws as coordinates [-].
    - `curves`: coefficients of the readings' curves for each draw.
    - `noise`: of a reading [N], for each draw.
    - `r_hat`: near 1 where chains agree [-]. `ess`: how many independent draws they are
      worth; both for each parameter.
    - `divergences`: number of failed steps.
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
        """Whether R-hat is below 1.01 and ESS above 400 for all, and no step failed."""
        return bool(np.all(self.r_hat < 1.01) and np.all(self.ess > 400) and self.divergences == 0)

    def interval(self, level: float = 0.9) -> np.ndarray:
        """Ends of each parameter's central interval [SI], of probability `level` [-]."""
        tail = 0.5 * (1 - level)
        return np.quantile(self.values, [tail, 1 - tail], axis=0).T


def sample(
    calibration: Calibration, draws: int = 1000, warmup: int = 500, chains: int = 2, seed: int = 0
) -> Posterior:
    """Draw from the posterior of a calibration.

    **Arguments:**

    - `calibration`: the calibration; its noise must be normal, so its loss linear.
    - `draws`: kept for each chain.
    - `warmup`: draws for each chain that are not kept.
    - `chains`: how many.
    - `seed`: random seed.

    **Raises:** `ValueError` for a robust loss, and where numpyro is missing.
    """
    if calibration.problem.loss != "linear":
        raise InvalidInputError(
            "loss", "must be linear for a posterior", None, "a robust one is no model"
        )
    try:
        import numpyro
        from numpyro import distributions as dist
        from numpyro.diagnostics import effective_sample_size, split_gelman_rubin
        from numpyro.infer import MCMC, NUTS, init_to_median
    except ImportError:
        raise ValueError(INSTALL) from None
    target = _Target(calibration)

    def model() -> None:
        u = numpyro.sample("u", dist.Normal(jnp.zeros(target.size), 1).to_event(1))
        # the standard normal draws it by is taken off again: the target alone counts
        numpyro.factor("target", target.log_density(u) + 0.5 * jnp.sum(u**2))

    # short steps: a kink at each collapse, and what the data don't determine, need them
    kernel = NUTS(model, init_strategy=init_to_median(num_samples=5), target_accept_prob=_ACCEPT)
    run = MCMC(
        kernel, num_warmup=warmup, num_samples=draws, num_chains=chains,
        chain_method="vectorized", progress_bar=False,
    )  # fmt: skip
    run.run(jax.random.PRNGKey(seed), extra_fields=("diverging",))
    u = run.get_samples(group_by_chain=True)["u"]
    z, curves, noise = jax.vmap(target.unpack)(u.reshape(-1, u.shape[-1]))
    drawn = np.asarray(jax.vmap(target.values)(z))
    by_chain = drawn.reshape(chains, draws, -1)
    return Posterior(
        names=calibration.names,
        values=drawn,
        coordinates=np.asarray(z),
        curves=np.asarray(curves),
        noise=np.asarray(noise),
        r_hat=np.asarray(split_gelman_rubin(by_chain)),
        ess=np.asarray(effective_sample_size(by_chain)),
        divergences=int(np.sum(run.get_extra_fields()["diverging"])),
    )


class _Target:
    """The log posterior density over standardized coordinates, curves, discrepancy and noise."""

    def __init__(self, calibration: Calibration):
        self.problem, diagnosis = calibration.problem, calibration.diagnosis
        self.center = jnp.asarray(calibration.coordinates)
        self.scale = jnp.linalg.cholesky(jnp.asarray(calibration.covariance))
        self.curves, self.base = jnp.zeros((0, 0)), jnp.zeros(0)
        readings = calibration.readings
        if readings is not None:
            # what the pull alone says of them: the rest is in the likelihood
            base, covariance = readings.pulling or (self.problem.curves, readings.covariance)
            spread, basis = jnp.linalg.eigh(jnp.asarray(covariance))
            own = np.asarray(spread) > 1e-12 * float(jnp.max(spread))
            self.base = jnp.asarray(base)
            self.curves = (basis * jnp.sqrt(jnp.maximum(spread, 0)))[:, own]
        self.discrepancy = jnp.asarray(diagnosis.discrepancy)
        # what the discrepancy explains is no noise
        self.noise = diagnosis.noise if diagnosis.significant else self.problem.noise
        self.count = float(np.sum((self.problem.weight > 0) & self.problem.grid.measured))
        sizes = [self.center.size, self.curves.shape[1], self.discrepancy.shape[-1], 1]
        self.ends = np.cumsum(sizes)
        self.size = int(self.ends[-1])

    def unpack(self, u: Any) -> tuple[Any, Any, Any]:
        """Coordinates [-], coefficients of the curves, and the noise [N] at `u`."""
        z, curves, _, away = jnp.split(u, self.ends[:-1])
        noise = self.noise * jnp.exp(away[0] / jnp.sqrt(2 * self.count))
        moved = self.base + self.curves @ curves if self.base.size else self.base
        return self.center + self.scale @ z, moved, noise

    def log_density(self, u: Any) -> Any:
        """Log density of likelihood and priors, to a constant."""
        z, moved, noise = self.unpack(u)
        _, curves, errors, _ = jnp.split(u, self.ends[:-1])
        problem, grid = self.problem, self.problem.grid
        mu = problem.force(jnp.concatenate([z, moved])) + self.discrepancy @ errors
        square = problem.weight**2 * grid.count * ((grid.force - mu) / noise) ** 2
        clipped = problem.weight**2 * log_ndtr((grid.force - mu) * jnp.sqrt(grid.count) / noise)
        likelihood = jnp.where(grid.censored, clipped, -0.5 * square)
        prior = jnp.sum(((z - problem.center) / problem.deviation) ** 2)
        known = jnp.sum(curves**2) + jnp.sum(errors**2)
        return jnp.sum(likelihood) - self.count * jnp.log(noise) - 0.5 * (prior + known)

    def values(self, z: Any) -> Any:
        """The fitted parameters [SI units] at coordinates `z`."""
        return values(self.problem.parameters, put(self.problem.parameters, self.problem.muscle, z))
