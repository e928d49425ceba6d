"""A bundle's states as a table: pressures, free strain, equilibria."""

import math
from typing import Any

from .printed import number, show
from .problems import fall_short


def check_zeros(variables: Any) -> None:
    """End a command whose states have no strain of zero force; `variables` as `show_states`."""
    free = variables["free_strain"].values.tolist()
    missing = [f"{row}" for row, strain in enumerate(free, start=1) if math.isnan(strain)]
    if missing:
        fall_short(f"no strain of zero force was found in row {', '.join(missing)}.")


def show_states(variables: Any) -> None:
    """Print pressures, free strain and equilibria, a row for each state.

    **Arguments:** `variables`: of `bundle_equilibria` [-].
    """
    pressures, free, equilibria, stable = (
        variables[name].values.tolist()
        for name in ("pressures", "free_strain", "equilibria", "stable")
    )
    rows = [
        [
            f"{index + 1}",
            *(f"{pressure / 1e3:.6g}" for pressure in pressures[index]),
            number(free[index], 4),
            ", ".join(
                number(strain, 4) + ("" if firm else " u")
                for strain, firm in zip(equilibria[index], stable[index], strict=True)
                if math.isfinite(strain)  # the rest of the row is NaN
            ),
        ]
        for index in range(len(pressures))
    ]
    heads = [
        "state",
        *(f"P{unit + 1} kPa" for unit in range(len(pressures[0]))),
        "free strain",
        "equilibria",
    ]
    show("Strains of zero force", heads, rows, "u: unstable, the force rises with strain there")
