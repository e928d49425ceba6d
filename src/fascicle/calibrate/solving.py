"""Levenberg-Marquardt from several starts, and in words how each of them ended.

Jacobians are exact, by forward differentiation of the laws. All starts run as one batch.
"""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jaxtyping import Array, Float, Int

from .problem import Problem, Vector


STEPS = 200
_SAME = 0.02  # of the cost, a fifth of a standard deviation
_FAR = 1.0  # coordinates that the data don't determine are not sent further
_TOLERANCE = 1e-8  # of coordinates and cost: far below any parameter's uncertainty
_SETTLED = 5e-5  # of the cost yet to win, a hundredth of a standard deviation

CONVERGED, STOPPED, BROKE = 0, 1, 2
_WORDS = {
    CONVERGED: "converged",
    STOPPED: f"stopped after {STEPS} steps, before it settled",
    BROKE: "stopped where the solver could not go on",
}


class Solutions(eqx.Module):
    """Where each start ended: coordinates, half the sum of squares, status, steps [-]."""

    coordinates: Float[Array, "start parameter"]
    cost: Float[Array, "start"]
    status: Int[Array, "start"]
    steps: Int[Array, "start"]

    @property
    def best(self) -> Int[Array, ""]:
        """Which start ended lowest [-]."""
        return jnp.argmin(jnp.where(jnp.isfinite(self.cost), self.cost, jnp.inf))


def solve(problem: Problem, starts: Float[Array, "start parameter"]) -> Solutions:
    """Minimize `problem` [-] from each of `starts` [-]."""
    solver = optx.LevenbergMarquardt(rtol=_TOLERANCE, atol=_TOLERANCE)

    # residuals and Jacobian in one pass: the solver would trace and compile the law thrice
    @jax.custom_jvp
    def residuals(z: Vector) -> Array:
        return problem.residuals(z)

    @residuals.defjvp
    def _(primals: tuple[Vector], tangents: tuple[Vector]) -> tuple[Array, Array]:
        def twice(z: Vector) -> tuple[Array, Array]:
            r = problem.residuals(z)
            return r, r

        jacobian, r = jax.jacfwd(twice, has_aux=True)(primals[0])
        return r, jacobian @ tangents[0]

    def one(start: Float[Array, "parameter"]) -> tuple[Any, ...]:
        found = optx.least_squares(
            lambda z, _: residuals(z), solver, start, max_steps=STEPS, throw=False
        )
        z = found.value
        cost = 0.5 * jnp.sum(problem.residuals(z) ** 2)
        good = found.result == optx.RESULTS.successful
        full = found.result == optx.RESULTS.nonlinear_max_steps_reached
        last = found.state.f_info
        settled = full & (_to_win(last.residual, last.jac.as_matrix()) < _SETTLED)
        status = jnp.where(good | settled, CONVERGED, jnp.where(full, STOPPED, BROKE))
        status = jnp.where(jnp.isfinite(cost), status, BROKE)
        return z, cost, status, found.stats["num_steps"]

    return Solutions(*jax.vmap(one)(starts))


def _to_win(r: Float[Array, "residual"], jacobian: Float[Array, "residual parameter"]) -> Array:
    """What a whole Gauss-Newton step would take off the cost [-].

    Along a direction that the data hardly determine, coordinates creep long after the fit has
    settled.
    """
    basis, size, _ = jnp.linalg.svd(jacobian, full_matrices=False)
    part = jnp.where(size > 1e-12 * size[0], basis.T @ r, 0)
    return 0.5 * part @ part


def scattered(center: np.ndarray, count: int, seed: int = 0) -> np.ndarray:
    """`count` starts [-]: the `center` [-], then others about it within a factor of 2."""
    rng = np.random.default_rng(seed)
    others = center + np.log(2) * rng.uniform(-1, 1, (count - 1, center.size))
    return np.concatenate([center[None], others])


def around(best: np.ndarray, covariance: np.ndarray, count: int, seed: int = 0) -> np.ndarray:
    """`count` starts [-]: the `best` [-], then others twice its deviations about it."""
    spread, basis = np.linalg.eigh(np.nan_to_num(covariance))
    normal = np.random.default_rng(seed).normal(size=(count - 1, best.size))
    away = 2 * normal @ (basis * np.sqrt(np.clip(spread, 0, _FAR**2))).T
    return np.concatenate([best[None], best + away])


def joined(first: Solutions, second: Solutions) -> Solutions:
    """The ends [-] of two searches, one after the other."""
    return jax.tree.map(lambda a, b: jnp.concatenate([a, b]), first, second)


def least(solutions: Solutions) -> float:
    """The lowest cost [-]; infinite where all broke."""
    return float(jnp.min(jnp.where(jnp.isfinite(solutions.cost), solutions.cost, jnp.inf)))


def in_words(solutions: Solutions) -> list[str]:
    """How each start ended [-], a line each."""
    best = least(solutions)
    lines = []
    for i, (cost, status, steps) in enumerate(
        zip(solutions.cost.tolist(), solutions.status.tolist(), solutions.steps.tolist(),
            strict=True), start=1
    ):  # fmt: skip
        how = f"start {i}: {_WORDS[status]} ({steps} steps)"
        if status != BROKE:
            # two ends are one minimum if no data could tell them apart
            same = cost - best < _SAME
            how += ", at the best minimum" if same else f", at a worse one (cost {cost:.6g})"
        lines.append(how)
    return lines
