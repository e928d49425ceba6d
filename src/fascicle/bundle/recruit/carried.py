r"""What was found without derivatives, with them.

The pressure found is a root of (B9): it moves with the demand, the strain, the bundle and the
supply as

$$\mathrm{d}p = (\mathrm{d}F_d - \mathrm{d}F|_p)/(\partial F/\partial p), \tag{B12}$$

where $p$ is what the throttled units share. The others stay at their share of the supply, which
also holds of those throttled where the demand wasn't reached.
"""

from typing import Any

from ...core.arrays import library, where
from ...core.derived import along
from ...core.roots import guarded, still
from ...core.types import Marks, Numbers
from ..at import pressurized
from ..bundle import Bundle
from .inverse import REACHED, Recruited


def carried(
    bundle: Bundle,
    force: Numbers,
    strain: Numbers,
    supply: Numbers,
    found: Recruited,
    throttled: Marks,
    resistance: bool,
) -> Recruited:
    """Equation (B12) by one step of Newton's, which is of no length.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `force`: demanded [N], broadcast as `strain`.
    - `strain`: the bundle's contractions [-].
    - `supply`: $P_s$ [Pa].
    - `found`: for them, without derivatives [-].
    - `throttled`: which units share the pressure that was found, units last [-].
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** the same [-].
    """
    P = found.pressures / still(supply) * supply
    given = _force(bundle, P, strain, resistance)
    fixed, eps = still((bundle, strain))
    slope = along(lambda p: _force(fixed, p, eps, resistance), still(P), 1.0 * throttled)
    reached = found.status == REACHED
    moves = reached & (slope != 0)
    short = where(moves, force - given, 0.0)
    step = (short - still(short)) / guarded(moves, slope)
    return found._replace(
        pressures=P + where(throttled, step[..., None], 0.0),
        force=where(reached, force + still(found.force - force), given),
    )


def _force(bundle: Bundle, pressures: Numbers, strain: Numbers, resistance: bool) -> Any:
    forces, _ = pressurized(bundle, pressures).unit_forces(strain)
    kept = forces if resistance else where(forces > 0, forces, 0.0)
    return library(kept).sum(kept, axis=-1)
