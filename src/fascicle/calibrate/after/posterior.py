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

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.scipy.special import log_ndtr

from ...core.errors import InvalidInputError
from ..problem.misfit import LOSSES
from ..problem.parameters import put, values
from ..problem.residuals import Problem
from .calibration import Calibration


INSTALL = "`--posterior` needs the package numpyro: pip install 'fascicle[posterior]'."

_ACCEPT = 0.95


@dataclass(frozen=True, eq=False)
class Posterior:
    """Draws of a calibration's parameters, and whether the chains agree.

    - `names`: of the parameters [-].
    - `values`: a row for each draw [SI unit of each parameter].
    - `coordinates`: the same draws as coordinates [-].
    - `curves`: coefficients of the readings' curves [-], [N], for each draw.
    - `noise`: of a reading [N], for each draw.
    - `r_hat`: near 1 where chains agree [-]. `ess`: how many independent draws they are
      worth [-]; both for each parameter.
    - `divergences`: how many steps failed [-].
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
        """Whether R-hat is below 1.01 and ESS above 400 for all, and no step failed [-]."""
        return bool(np.all(self.r_hat < 1.01) and np.all(self.ess > 400) and self.divergences == 0)

    def interval(self, level: float = 0.9) -> np.ndarray:
        """Ends of each parameter's central interval [SI], of probability `level` [-]."""
        tail = 0.5 * (1 - level)
        return np.quantile(self.values, [tail, 1 - tail], axis=0).T


def sample(
    made: Calibration, draws: int = 1000, warmup: int = 500, chains: int = 2, seed: int = 0
) -> Posterior:
    """Draw from the posterior of a calibration.

    **Arguments:**

    - `made`: the calibration [-]; its noise must be normal, so its loss linear.
    - `draws`: kept for each chain [-].
    - `warmup`: not kept [-].
    - `chains`: how many [-].
    - `seed`: of the random numbers [-].

    **Returns:** the draws [-].

    **Raises:** `ValueError` for a robust loss, and where numpyro is missing.
    """
    if made.problem.loss != "linear":
        raise InvalidInputError(
            "loss", f"must be {LOSSES[0]} for a posterior", None, "a robust one is no model"
        )
    try:
        import numpyro
        from numpyro import distributions as dist
        from numpyro.diagnostics import effective_sample_size, split_gelman_rubin
        from numpyro.infer import MCMC, NUTS, init_to_median
    except ImportError:
        raise ValueError(INSTALL) from None
    target = _Target(made)

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
    z, problems, noise = jax.vmap(target.unpacked)(u.reshape(-1, u.shape[-1]))
    found = jax.vmap(target.values)(z)
    curves = problems.curves
    by_chain = np.asarray(found).reshape(chains, draws, -1)
    return Posterior(
        names=made.names,
        values=np.asarray(found),
        coordinates=np.asarray(z),
        curves=np.zeros((len(z), 0)) if curves is None else np.asarray(curves),
        noise=np.asarray(noise),
        r_hat=np.asarray(split_gelman_rubin(by_chain)),
        ess=np.asarray(effective_sample_size(by_chain)),
        divergences=int(np.sum(run.get_extra_fields()["diverging"])),
    )


class _Target:
    """The log posterior density over standardized coordinates, curves, discrepancy and noise."""

    def __init__(self, made: Calibration):
        self.problem: Problem = made.problem
        self.chosen = made.problem.chosen
        self.center = jnp.asarray(made.coordinates)
        self.scale = jnp.linalg.cholesky(jnp.asarray(made.covariance))
        self.curves, self.base = jnp.zeros((0, 0)), jnp.zeros(0)
        if made.readings is not None:
            # what the pull alone says of them: the rest is in the likelihood
            known = made.readings.alone or (self.problem.curves, made.readings.covariance)
            self.base = jnp.asarray(known[0])
            spread, basis = jnp.linalg.eigh(jnp.asarray(known[1]))
            own = np.asarray(spread) > 1e-12 * float(jnp.max(spread))
            self.curves = (basis * jnp.sqrt(jnp.maximum(spread, 0)))[:, own]
        self.discrepancy = jnp.asarray(made.discrepancy)
        # what the discrepancy explains is no noise
        self.noise = made.seen.noise if made.seen.found else float(made.problem.noise)
        used = (np.asarray(made.problem.weight) > 0) & made.problem.data.uncensored
        self.count = float(np.sum(used))
        self.ends = np.cumsum([
            self.center.size, self.curves.shape[1], self.discrepancy.shape[-1], 1
        ])  # fmt: skip
        self.size = int(self.ends[-1])

    def unpacked(self, u: Any) -> tuple[Any, Any, Any]:
        """Coordinates [-], the problem, and the noise [N] at `u` [-]."""
        z, curves, _, away = jnp.split(u, self.ends[:-1])
        noise = self.noise * jnp.exp(away[0] / jnp.sqrt(2 * self.count))
        problem = eqx.tree_at(lambda p: p.noise, self.problem, noise)
        if curves.size:
            moved = self.base + self.curves @ curves
            problem = eqx.tree_at(lambda p: p.curves, problem, moved)
        return self.center + self.scale @ z, problem, noise

    def log_density(self, u: Any) -> Any:
        """Of likelihood and priors [-], to a constant."""
        z, problem, noise = self.unpacked(u)
        _, curves, errs, _ = jnp.split(u, self.ends[:-1])
        data, every = problem.data, jnp.asarray(problem.center).at[self.chosen].set(z)
        mu = problem.force(every) + self.discrepancy @ errs
        square = problem.weight**2 * data.count * ((data.force - mu) / noise) ** 2
        clipped = problem.weight**2 * log_ndtr((data.force - mu) * jnp.sqrt(data.count) / noise)
        likelihood = jnp.where(data.censored, clipped, -0.5 * square)
        prior = jnp.sum(((every - problem.center) / problem.deviation) ** 2)
        known = jnp.sum(curves**2) + jnp.sum(errs**2)
        return jnp.sum(likelihood) - self.count * jnp.log(noise) - 0.5 * (prior + known)

    def values(self, z: Any) -> Any:
        """The fitted parameters [SI units] at coordinates `z` [-]."""
        fitted = self.problem.fitted
        return values(fitted, put(fitted, self.problem.muscle, z))
