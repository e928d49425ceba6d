r"""Free-strain gradient reversal: pressurizing a unit shortens the free strain at first.

With units $1 \dots k-1$ at supply pressure, the bundle's free strain as a function of unit
$k$'s pressure falls at first, since a muscle at low pressure resists more than an empty
one, then turns and rises. The turn is the reversal point, its depth the fall up to there.
The free strain is the smallest zero of the force, so with rising pressure it jumps down when a
dip of the force first touches zero ahead of it, and up when such a dip lifts off again: then the
jump is the reversal point, and its lower side counts.

**Source:** Kim, Mazzoleni and Bryant (2021), section 6, Figs. 13 and 14.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..core.types import Float, Values
from ..core.validation import check_finite, check_gauge_pressure, check_scalar, check_whole_number
from .pressurized import muscle_strain
from .recruitment import pressures_of
from .states import resolve_supply_pressure


if TYPE_CHECKING:
    from .bundle import Bundle


_GRID = 129  # pressures of each bracket: fine enough for a fall or an onset not to slip through
_ZOOMS = 6  # each narrows the bracket 64 times: to the last bits of a pressure
_NO_FALL = 1e-12  # of strain: rounding of two roots
_JUMP = 1e-6  # of strain: a bracket of 1e-9 of the supply is too narrow for a smooth curve to rise


@dataclass(frozen=True)
class Reversal:
    """Turn of a bundle's free strain as a unit's pressure rises.

    `pressure` [Pa] and `free_strain` [-] at the turn; `initial`: free strain at no pressure [-];
    `depth`: fall between the two [-]; `jump`: the free strain jumps at the turn.
    """

    pressure: float
    free_strain: float
    initial: float
    depth: float
    jump: bool


def free_strain_curve(
    bundle: "Bundle",
    unit: int,
    pressures: Values,
    supply_pressure: Values = None,
    resistance: bool = True,
) -> Float[np.ndarray, " pressure"]:
    """Free strains [-] of the bundle over the `pressures` [Pa] of one `unit`, counted from 1, with
    earlier units at `supply_pressure` [Pa]; other arguments and errors are those of `reversal`.
    """
    supply = resolve_supply_pressure(bundle, supply_pressure)
    unit = check_whole_number(unit, "unit", 1, len(bundle.motor_units))
    pressures = check_gauge_pressure(pressures, "pressures")
    all_pressures = pressures_of(unit, pressures, supply, len(bundle.motor_units))
    return np.asarray(bundle.free_strain(all_pressures, resistance))


def reversal(
    bundle: "Bundle", unit: int = 2, supply_pressure: Values = None, resistance: bool = True
) -> Reversal:
    """Turn of the free strain [-] as the pressure [Pa] of a `unit` of a `bundle`, counted from 1,
    rises from zero to the supply's, with earlier units at `supply_pressure` [Pa], by default the
    bundle's own; without `resistance` units past their own free strain don't push back.

    A depth of zero if the free strain never falls. `ValueError` for a unit that doesn't exist or a
    pressure off the domain.
    """
    supply = resolve_supply_pressure(bundle, supply_pressure)
    pressures = np.linspace(0.0, supply, _GRID)
    strains = free_strain_curve(bundle, unit, pressures, supply, resistance)
    lowest, initial = int(np.argmin(strains)), float(strains[0])
    for _ in range(_ZOOMS):
        ends = pressures[max(lowest - 1, 0)], pressures[min(lowest + 1, _GRID - 1)]
        pressures = np.linspace(*ends, _GRID)
        strains = free_strain_curve(bundle, unit, pressures, supply, resistance)
        lowest = int(np.argmin(strains))
    turn = float(strains[lowest])
    if initial - turn < _NO_FALL:
        return Reversal(0.0, initial, initial, 0.0, jump=False)
    jump = bool(np.ptp(strains) > _JUMP)
    return Reversal(float(pressures[lowest]), turn, initial, initial - turn, jump)


def onset_pressure(
    bundle: "Bundle", strain: Values, unit: int = 2, supply_pressure: Values = None
) -> float:
    """Pressure [Pa] above which, at a `strain` [-] of a `bundle`, a `unit`, counted from 1, only
    adds force: 0 if always, inf if never up to `supply_pressure` [Pa], by default the bundle's own.
    `ValueError` for a unit that doesn't exist or a strain off the domain.
    """
    supply = resolve_supply_pressure(bundle, supply_pressure)
    unit = check_whole_number(unit, "unit", 1, len(bundle.motor_units))
    muscle = bundle.motor_units[unit - 1].muscle
    eps = check_scalar(check_finite(strain, "strain", "-"), "strain")
    if bundle.ratios is not None:
        eps = float(muscle_strain(bundle.ratios[..., unit - 1], bundle._check_strain(eps)))
    low, high = 0.0, supply
    for _ in range(_ZOOMS):
        pressures = np.linspace(low, high, _GRID)
        force = np.asarray(muscle.force(np.r_[0.0, pressures], eps))
        helps = force[1:] > force[0]
        if not helps[-1]:
            return float("inf")
        last = int(np.flatnonzero(~helps)[-1])  # exists: no pressure gains nothing
        low, high = float(pressures[last]), float(pressures[last + 1])
    return high if low > 0 else 0.0
