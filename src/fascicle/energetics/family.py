r"""Bundles of equal cross-section: one muscle's section split into motor units.

$N$ motor units of radius $r = R/\sqrt N$ take the section of one muscle of radius $R$, with
$t_0/r_0$, length and braid angle unchanged. $N = 1$ is the single equivalent motor unit
(SEMU) that a bundle is compared with.

**Source:** Kim, Mazzoleni and Bryant (2021), section 4.2.
"""

import numpy as np

from ..bundle import Bundle, MotorUnit
from ..bundle.schemes import AbstractScheme
from ..core.errors import InvalidInputError
from ..core.module import with_fields
from ..core.types import Values
from ..muscle import Muscle


def constant_cross_section(
    muscle: Muscle,
    units: int,
    supply_pressure: Values = None,
    scheme: AbstractScheme | str = "orderly",
) -> Bundle:
    """A muscle's section split evenly into motor units of one muscle each.

    **Arguments:**

    - `muscle`: the single equivalent motor unit's, of radius $R$ [-].
    - `units`: $N$ [-], at least 1.
    - `supply_pressure`: the bundle's [Pa], if it is known.
    - `scheme`: one of `fascicle.schemes`, by name or as an object [-].

    **Returns:** a bundle [-] of $N$ units.

    **Raises:** `ValueError` for less than one unit.
    """
    if units < 1:
        raise InvalidInputError("units", "must be at least 1", units)
    sizes = (muscle.outer_radius / np.sqrt(units), muscle.wall_thickness / np.sqrt(units))
    thin = with_fields(muscle, outer_radius=sizes[0], wall_thickness=sizes[1])
    return Bundle([MotorUnit(thin)] * units, supply_pressure, scheme)
