"""Forces of a bundle's units at every throttled level, equal units computed once."""

import numpy as np

from ..core.types import Float, Int
from .alike import unlike
from .bundle import Bundle


def unit_tables(
    bundle: Bundle,
    supply_pressure: float,
    levels: Float[np.ndarray, " level"],
    strain: Float[np.ndarray, " strain"],
    resistance: bool,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Force of every unit at every level, and at no and at full pressure, as `States` takes them.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `supply_pressure`: the supply's [Pa].
    - `levels`: throttled pressures [Pa].
    - `strain`: contractions [-].
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** forces [N], with level, strain and unit axes, the last two without levels.
    """
    few, places = distinct(bundle)
    pressures = np.r_[levels, 0.0, supply_pressure][:, None, None] * np.ones(len(few.motor_units))
    table = np.asarray(few.unit_forces(pressures, strain, resistance))[..., places]
    return table[:-2], table[-2], table[-1]


def distinct(bundle: Bundle) -> tuple[Bundle, Int[np.ndarray, " unit"]]:
    """The unlike units of a bundle, so that equal ones needn't be evaluated twice.

    **Arguments:** `bundle`: the bundle [-].

    **Returns:** a bundle of its unlike units alone, and which of them each unit is [-].
    """
    kept, places = unlike(bundle.motor_units)
    different = [bundle.motor_units[i] for i in kept]
    return Bundle(different, length=bundle.plate_distance), np.array(places)
