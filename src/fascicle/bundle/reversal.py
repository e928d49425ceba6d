r"""Free-strain gradient reversal: how activating a unit first shortens the reach.

With units $1 \dots k-1$ at supply pressure, the bundle's free strain as a function of unit
$k$'s pressure falls at first, since a muscle at low pressure resists more than an empty
one, then turns and rises. The turn is the reversal point, its depth the fall up to there.
The free strain is the smallest zero of the force, so it jumps down where, with rising
pressure, a dip of the force first touches zero ahead of it, and up where such a dip lifts
off again: then the jump is the reversal point, and its lower side counts.

**Source:** Kim, Mazzoleni and Bryant (2021), section 6, Figs. 13 and 14.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Float, Values
from ..core.validation import check_interval
from ..repr_table import with_table_repr
from .bundle import Bundle, resolve_supply_pressure
from .pressurized import muscle_strain
from .printing import reversal_sheet
from .recruitment import pressures_of


_GRID = 129  # pressures at which the fall and the onset are looked for, again and again
_ZOOMS = 6  # each narrows the bracket 64 times: to the last bits of a pressure


@with_table_repr(reversal_sheet)
@dataclass(frozen=True)
class Reversal:
    """`pressure` [Pa] at the turn, `free_strain` [-] there and at no pressure (`initial`),
    `depth` [-] between them; `jump`: whether the free strain jumps at the turn.
    """

    pressure: float
    free_strain: float
    initial: float
    depth: float
    jump: bool


def free_strain_curve(
    bundle: Bundle,
    unit: int,
    pressures: Values,
    supply_pressure: Values = None,
    resistance: bool = True,
) -> Float[np.ndarray, " pressure"]:
    """Free strain of the bundle against one unit's pressure, earlier units at supply.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `unit`: which unit's pressure is varied [-], counted from 1.
    - `pressures`: its pressures [Pa].
    - `supply_pressure`: of the units before it [Pa]; left out, the bundle's own.
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** free strains [-].

    **Raises:** `ValueError` for a unit that doesn't exist or a pressure off the domain.
    """
    supply, unit = resolve_supply_pressure(bundle, supply_pressure), _counted(bundle, unit)
    all_pressures = pressures_of(unit, pressures, supply, len(bundle.motor_units))
    return np.asarray(bundle.free_strain(all_pressures, resistance))


def reversal(
    bundle: Bundle, unit: int = 2, supply_pressure: Values = None, resistance: bool = True
) -> Reversal:
    """Where the free strain turns as a unit's pressure rises from zero to the supply's.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `unit`: which unit's pressure rises [-], counted from 1.
    - `supply_pressure`: of the units before it [Pa]; left out, the bundle's own.
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** a `Reversal`: pressure [Pa], strains and depth [-]; a depth of zero where
    the free strain never falls.
    """
    supply = resolve_supply_pressure(bundle, supply_pressure)

    def curve(pressures: Values) -> Float[np.ndarray, " pressure"]:
        return free_strain_curve(bundle, unit, pressures, supply, resistance)

    grid = np.linspace(0.0, supply, _GRID)
    strains = curve(grid)
    at, initial = int(np.argmin(strains)), float(strains[0])
    for _ in range(_ZOOMS):
        grid = np.linspace(grid[max(at - 1, 0)], grid[min(at + 1, _GRID - 1)], _GRID)
        strains = curve(grid)
        at = int(np.argmin(strains))
    turn = float(strains[at])
    # equal up to the roots' precision is no fall
    if initial - turn < 1e-12:
        return Reversal(0.0, initial, initial, 0.0, jump=False)
    # the bracket is narrower than 1e-9 of the supply: a smooth curve can't rise in it
    jump = bool(np.ptp(strains) > 1e-6)
    return Reversal(float(grid[at]), turn, initial, initial - turn, jump)


def onset_pressure(
    bundle: Bundle, strain: Values, unit: int = 2, supply_pressure: Values = None
) -> float:
    """Pressure from which a unit makes the bundle's force larger than it is without it.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `strain`: the bundle's contraction [-].
    - `unit`: which unit [-], counted from 1.
    - `supply_pressure`: the largest pressure looked at [Pa]; left out, the bundle's own.

    **Returns:** pressure [Pa]: zero where any pressure helps, inf where none up to the
    supply's does.

    **Raises:** `ValueError` for a unit that doesn't exist or a strain off the domain.
    """
    supply, unit = resolve_supply_pressure(bundle, supply_pressure), _counted(bundle, unit)
    muscle = bundle.motor_units[unit - 1].muscle
    eps = float(check_interval(strain, -np.inf, np.inf, "strain", "-"))
    if bundle.ratios is not None:
        eps = float(muscle_strain(bundle.ratios[..., unit - 1], bundle._strain(eps)))

    def gain(pressures: Values) -> Float[np.ndarray, " pressure"]:
        force = np.asarray(muscle.force(np.r_[0.0, pressures], eps))
        return force[1:] - force[0]

    low, high = 0.0, supply
    for _ in range(_ZOOMS):
        grid = np.linspace(low, high, _GRID)
        helps = gain(grid) > 0
        if not helps[-1]:
            return float("inf")
        # no pressure gains nothing, so it is never counted as helping
        last = int(np.flatnonzero(~helps)[-1])
        low, high = float(grid[last]), float(grid[last + 1])
    return high if low > 0 else 0.0


def _counted(bundle: Bundle, unit: Any) -> int:
    """Which unit of the bundle it is [-], counted from 1."""
    units = len(bundle.motor_units)
    if not isinstance(unit, int | np.integer):
        raise InvalidInputError(
            "unit", "must be a whole number, counted from 1", unit, shown=repr(unit)
        )
    if not 1 <= unit <= units:
        raise InvalidInputError("unit", f"must lie in [1, {units}]", unit)
    return int(unit)
