"""Pareto front of runs by two costs: depth of the dip of force, and energy."""

import numpy as np

from ..core.types import Marks, Values


_SAME = 1e-6  # of the larger one: runs that differ by less are as good as each other


def front(dips: Values, energies: Values) -> Marks:
    """Runs that are on the front of dip against energy.

    **Arguments:**

    - `dips`: of each run, or its drawdown [SI].
    - `energies`: of each run [J].

    **Returns:** whether no other run is better in one of both and as good in the other [-].
    """
    pairs = np.stack([np.asarray(dips, float), np.asarray(energies, float)], axis=-1)
    is_dominated = _SAME * np.maximum(np.max(np.abs(pairs), axis=0), 1e-300)
    point, rival = pairs[:, None, :], pairs[None, :, :]
    as_good = np.all(rival <= point + is_dominated, axis=-1)
    better = np.any(rival < point - is_dominated, axis=-1)
    return ~np.any(as_good & better, axis=1)
