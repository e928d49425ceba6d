"""`fascicle bundle`: a bundle's force, free strain and equilibria at pressures."""

import math
from typing import Any

from .. import options
from ..errors import exit_incomplete, user_errors
from ..inputs import check_grid, read_bundle, read_list, read_states
from ..outputs import Outputs, decimals, number, print_table, status


def run(
    file: str = options.TARGET,
    pressure: list[str] | None = options.PRESSURES,
    strain: str = options.STRAIN,
    no_resistance: bool = options.NO_RESISTANCE,
    as_json: bool = options.JSON,
    as_csv: bool = options.CSV,
    out: str | None = options.OUT,
    plot: str | None = options.PLOT,
    overwrite: bool = options.OVERWRITE,
) -> None:
    """Force and equilibria of a bundle.

    At pressures, one for each motor unit; default: the end of each recruitment state.
    """
    strains = read_list(strain, "strain", "--strain")
    outputs = Outputs(as_json, as_csv, out, plot, overwrite)
    bundle = read_bundle(file)
    states = read_states(pressure, bundle)
    units = len(states[0])
    check_grid(len(states), units, max(units, len(strains)))
    from ...results.tables import bundle_equilibria, bundle_force

    resistance = not no_resistance
    with status("finding equilibria and forces"), user_errors():
        forces = bundle_force(bundle, states, strains, resistance)
        variables = {**forces, **bundle_equilibria(bundle, states, resistance)}

    def draw() -> Any:
        from ...plot.curves import bundle_force_strain, smooth

        pressures = states[0] if len(states) == 1 else states
        return bundle_force_strain(bundle, pressures, smooth(strains), resistance)

    outputs.write(variables, lambda: _print(variables), draw, title=f"Bundle {file}")
    check_equilibria(variables)


def check_equilibria(variables: Any) -> None:
    """End a command whose states have no strain of zero force; `variables`: its result."""
    free = variables["free_strain"].values.tolist()
    missing = [f"{row}" for row, strain in enumerate(free, start=1) if math.isnan(strain)]
    if missing:
        exit_incomplete(f"no strain of zero force was found in row {', '.join(missing)}.")


def print_states(variables: Any) -> None:
    """Print pressures, free strain and equilibria, a row for each state.

    **Arguments:** `variables`: of a table of `bundle_equilibria`.
    """
    names = ("pressures", "free_strain", "equilibria", "stable")
    states = zip(*(variables[name].values.tolist() for name in names), strict=True)
    rows = [
        [
            f"{state}",
            *(f"{pressure / 1e3:.6g}" for pressure in pressures),
            number(free, 4),
            ", ".join(
                number(strain, 4) + ("" if is_stable else " u")
                for strain, is_stable in zip(equilibria, stable, strict=True)
                if math.isfinite(strain)  # the rest of the row is NaN
            ),
        ]
        for state, (pressures, free, equilibria, stable) in enumerate(states, start=1)
    ]
    units = variables["pressures"].values.shape[1]
    heads = ["state", *(f"P{unit + 1} kPa" for unit in range(units)), "free strain", "equilibria"]
    caption = "u: unstable, the force rises with strain there"
    print_table("Strains of zero force", heads, rows, caption)


def _print(variables: Any) -> None:
    print_states(variables)
    forces = variables["force"].values.tolist()
    places = decimals(force for row in forces for force in row)
    strains = variables["strain"].values.tolist()
    rows = [
        [f"{strain:.6g}", *(number(force, places) for force in row)]
        for strain, row in zip(strains, zip(*forces, strict=True), strict=True)
    ]
    heads = ["strain", *(f"state {state + 1}" for state in range(len(forces)))]
    print_table("Force in N by strain", heads, rows)
