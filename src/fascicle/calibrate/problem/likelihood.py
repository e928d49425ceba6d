r"""How likely a record is by a law's forces, at the noise that suits it best.

A measured force has a normal density about the law's, one that was clipped the chance that it
isn't above:

$$-2 \ln L = \sum_{measured} \left[\ln \sigma^2 + n r^2/\sigma^2\right]
  - 2 \sum_{clipped} \ln \Phi(\sqrt n\, (F - \mu)/\sigma), \tag{C13}$$

with $r$ what the law misses and $n$ how many readings are averaged; what is the same for all laws
is left out. $\sigma$ is where that is least. All laws, those without physics too, are so judged on
all readings that there are.

**Source:** Tobin (1958).
"""

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.special import log_ndtr

from ..data.grid import Grid


_FINEST = 1e-9  # of the largest force: below, a noise is rounding
_WIDE = 5.0  # of the noise's logarithm: how far clipped readings may move it


def deviance(data: Grid, force: np.ndarray) -> float:
    """(C13) of `data` [-] by a law's `force` [N], less how many forces were measured [-]: without
    clipped ones that number times the logarithm of the mean square.
    """
    count, used = np.asarray(data.count), np.asarray(data.uncensored)
    measured = np.asarray(data.force)[used]
    n, top = measured.size, float(np.max(np.abs(measured), initial=1e-300))
    squares = float(np.sum(count[used] * (measured - force[used]) ** 2))
    clipped = (np.sqrt(count) * (force - np.asarray(data.force)))[(count > 0) & ~used]
    alone = np.log(max(np.sqrt(squares / max(n, 1)), _FINEST * top))

    def at(log_noise: float) -> float:
        noise = np.exp(log_noise)
        lost = -2 * float(np.sum(log_ndtr(-clipped / noise)))
        return 2 * n * log_noise + squares / noise**2 - n + lost

    if not clipped.size:
        return at(alone)
    ends = (alone - _WIDE, alone + _WIDE)
    found = minimize_scalar(at, bounds=ends, method="bounded", options={"xatol": 1e-10})
    return min(float(found.fun), at(alone))
