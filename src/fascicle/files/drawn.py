"""Muscles as uncertain as their calibration left them, drawn from the covariance in the file."""

import os

import numpy as np

from ..calibrate.problem.parameters import named, put
from ..muscle import Muscle
from .reading import load, provenance


def drawn(path: str | os.PathLike[str], draws: int = 1000, seed: int = 0) -> Muscle:
    """Draws of a calibrated muscle's constants, normal in the coordinates that were fitted.

    **Arguments:**

    - `path`: the muscle file that `fascicle calibrate` wrote [-].
    - `draws`: how many [-].
    - `seed`: of chance [-].

    **Returns:** the muscle, draws on the first axis of all its numbers [-].

    **Raises:** `ValueError` for a file without a calibration; `OSError` where it can't be read.
    """
    muscle, told = load(path), provenance(path)
    if not isinstance(muscle, Muscle) or "covariance" not in told:
        raise ValueError(f"{os.fspath(path)}: has no [calibration] with a covariance to draw from.")
    parameters = named(list(told["coordinate_names"]), muscle)
    center, covariance = np.array(told["coordinates"]), np.array(told["covariance"])
    # put in their own order, which needn't be that of the names in the file
    order = [list(told["coordinate_names"]).index(one.name) for one in parameters]
    z = np.random.default_rng(seed).multivariate_normal(center, covariance, draws)[:, order]
    import jax

    return jax.vmap(lambda row: put(parameters, muscle, row))(jax.numpy.asarray(z))
