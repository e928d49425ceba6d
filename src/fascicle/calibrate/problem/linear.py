"""Residuals, forces and their exact Jacobians at a place, from one function of the law.

Searching, covariances, profiles, trends and left-out errors all ask for the same: a whole fit
needs the law compiled once, whichever of a problem's constants are free. All else is NumPy.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from .misfit import Misfit
from .parameters import put
from .residuals import Problem


@dataclass(frozen=True, eq=False)
class Linear:
    """A problem at a place. Columns are all of the problem's parameters, then its curves'.

    - `residuals` [-], readings row by row, then priors; `slopes`: their Jacobian [-].
    - `force`: of the model at the readings' places [N]; `force_slopes`: its Jacobian [N],
      columns on the last axis.
    - `strain`: of the muscle there [-]; `misfits`: residuals before any loss [-]; both at the
      readings' places.
    """

    residuals: np.ndarray
    slopes: np.ndarray
    force: np.ndarray
    force_slopes: np.ndarray
    strain: np.ndarray
    misfits: np.ndarray


class Linearized:
    """A problem that is about to be evaluated at many places: what is asked of it at each is only
    the law and some sums. A search's steps take less time than finding their way through modules.
    """

    def __init__(self, problem: Problem):
        """**Arguments:** `problem` [-]."""
        arrays, static = eqx.partition(problem, eqx.is_array)
        paths, tree = jax.tree_util.tree_flatten_with_path(arrays)
        leaves = [leaf for _, leaf in paths]
        names = [getattr(path[0], "name", "") for path, _ in paths]
        self._curves = names.index("curves") if "curves" in names else None
        # a number that was written down is of a weaker kind, for which all is compiled once more
        self._leaves = jax.device_put([np.asarray(leaf) for leaf in leaves])
        self._forces = _compiled(tree, static)
        self._misfit = problem.misfit

    def __call__(self, coordinates: np.ndarray) -> Linear:
        """The problem at `coordinates` [-] of all its parameters."""
        z = np.asarray(coordinates, dtype=float)
        return self.by(self._misfit, z, None, every=z)

    def by(
        self, misfit: Misfit, coordinates: np.ndarray, curves: np.ndarray | None, every: np.ndarray
    ) -> Linear:
        """The same as a `misfit` [-] has it, with other `curves` [-], [N] where these are given;
        its priors are on `every` of the numbers [-], which begin with the coordinates.
        """
        leaves = self._leaves
        if curves is not None and self._curves is not None:
            leaves = list(leaves)
            leaves[self._curves] = jax.device_put(np.asarray(curves))
        z = np.asarray(coordinates, dtype=float)
        mu, force_slopes, strain = (np.asarray(x) for x in self._forces(leaves, z))
        r, by_force, misfits = misfit.residuals(mu, every)
        n, k = by_force.size, every.size
        slopes = np.zeros((n + k, force_slopes.shape[-1]))
        slopes[:n] = by_force[:, None] * force_slopes.reshape(n, -1)
        slopes[np.arange(n, n + k), np.arange(k)] = 1 / misfit.deviation
        return Linear(r, slopes, mu, force_slopes, strain, misfits)


def linear(problem: Problem, coordinates: np.ndarray) -> Linear:
    """A `problem` [-] at `coordinates` [-] of all its parameters."""
    return Linearized(problem)(coordinates)


@cache
def _compiled(tree: Any, static: Problem) -> Callable[..., tuple[Array, Array, Array]]:
    """Forces, their Jacobian and strains, of the problems of this structure."""

    @jax.jit
    def forces(leaves: list[Array], coordinates: Array) -> tuple[Array, Array, Array]:
        return _forces(eqx.combine(jax.tree.unflatten(tree, leaves), static), coordinates)

    return forces


def _forces(problem: Problem, coordinates: Array) -> tuple[Array, Array, Array]:
    k = coordinates.size
    curves = jnp.zeros(0) if problem.curves is None else problem.curves

    # one Jacobian by coordinates and curves together: the law is compiled once
    def at(both: Array) -> tuple[Array, Array]:
        here = problem
        if problem.curves is not None:
            here = eqx.tree_at(lambda p: p.curves, problem, both[k:])
        mu = here.force(both[:k])
        return mu, mu

    slopes, mu = jax.jacfwd(at, has_aux=True)(jnp.concatenate([coordinates, curves]))
    strain = problem.strain(put(problem.parameters, problem.muscle, coordinates, problem.free))
    return mu, slopes, strain
