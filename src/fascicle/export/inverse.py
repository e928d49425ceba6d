"""The inverse of a bundle in C: pressures for a force and a strain, as `Bundle.recruit` chooses.

The recruitment states are written as masks. `c/inverse_states.c` takes the first state that gives
the force, or of states that aren't nested that of least fluid; `c/inverse_sets.c` has (B11), for
units that have a pressure each. Both search force curves at one strain.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..bundle import Bundle
from ..bundle.energetics import unit_volume_change
from ..bundle.force_curves import TIE
from ..bundle.inverse import CLOSE
from ..bundle.states import states_of
from ..core.module import unique_indices
from .c_files import render_template


_STRAINS = np.array([0.05, 0.1, 0.2])  # any three: the volume is a cubic of strain, zero at rest


def inverse_code(
    bundle: Bundle,
    name: str,
    highest: float,
    meets: float,
    agreement: str,
    real: str = "double",
    number: Callable[[float], str] = repr,
) -> dict[str, Any]:
    """Values of the templates for the inverse of a bundle in C.

    **Arguments:**

    - `bundle`: the bundle, with its scheme.
    - `name`: prefix of all names in C.
    - `highest`: highest supply pressure [Pa].
    - `meets`: a force this near to the demand meets it [N].
    - `agreement`: how near it is to `Bundle.recruit`, as a comment in C.
    - `real`: type of numbers in C.
    - `number`: formats a number in C.

    **Returns:** `inverse`, the declarations; `inverse_source`, the choice of state; and the
    constants of the search.
    """
    kinds = unique_indices([unit.muscle for unit in bundle.motor_units])[1]
    states = states_of(bundle.scheme, len(kinds))
    sets, owners = states.sets(unique_indices(bundle.motor_units)[1])
    needs_fluid = states.independent or not states.nested
    values: dict[str, Any] = {
        "name": name,
        "guard": name.upper(),
        "real": real,
        "scheme": bundle.scheme.name,
        "agreement": agreement.replace("\n", "\n * "),
        "inverse_highest": f"{highest:.0f}",
        "inverse_top": number(highest),
        "meets": number(meets),
        "meets_text": f"{meets:.1g}",
        "tie": number(max(TIE, meets / 2)),
        "close": number(CLOSE),
        "first_units": ", ".join(str(kinds.index(kind)) for kind in range(max(kinds) + 1)),
        "states": sets.size,
        "full": _mask_rows(sets.full),
        "throttled": _mask_rows(sets.throttled),
        "owners": ", ".join(str(owner + 1) for owner in owners),
        "is_nested": int(not needs_fluid),
        "fluid": "0",
        "fluid_code": "",
    }
    if needs_fluid:
        values["fluid"] = "fluid_of(is_full[k], strain) + fluid_of(is_throttled[k], strain)"
        change = np.asarray(unit_volume_change(bundle, _STRAINS)) / _STRAINS[:, None]
        coefficients = np.linalg.solve(np.vander(_STRAINS, increasing=True), change).T
        rows = ("{" + ", ".join(map(number, row)) + "}" for row in coefficients.tolist())
        values["volumes"] = ",\n".join(rows)
        values["fluid_code"] = "\n" + render_template("inverse_fluid.c", values)
    files = "inverse_begin.c", "inverse_sets.c" if states.independent else "inverse_states.c"
    return values | {
        "inverse": render_template("inverse.h", values),
        "inverse_source": "".join(render_template(file, values) for file in files),
    }


def _mask_rows(mask: np.ndarray) -> str:
    """Initializers of a mask in C, a row each of its states."""
    return ", ".join("{" + ", ".join(str(int(x)) for x in row) + "}" for row in mask)
