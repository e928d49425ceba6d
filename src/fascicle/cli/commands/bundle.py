"""`fascicle bundle`: a bundle's force, free strain and equilibria at pressures."""

import math
from typing import Any

from .. import options
from ..errors import exit_incomplete, user_errors
from ..inputs import check_grid, read_bundle, read_list, read_states
from ..outputs import Outputs, count_decimals, number, print_table, print_text, status


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
    """Compute a bundle's force and equilibria over contraction.

    An equilibrium is a strain at which the bundle without load can rest.
    """
    strains = read_list(strain, "strain", "--strain")
    outputs = Outputs(as_json, as_csv, out, plot, overwrite)
    bundle = read_bundle(file)
    states = read_states(pressure, bundle)
    units = len(states[0])
    check_grid(len(states), units, max(units, len(strains)))
    from ...results.tables import bundle_equilibria, bundle_force

    resistance = not no_resistance
    with status("computing equilibria and forces"), user_errors():
        forces = bundle_force(bundle, states, strains, resistance)
        variables = {**forces, **bundle_equilibria(bundle, states, resistance)}

    def figure() -> Any:
        from ...plot.curves import bundle_force_strain, smooth

        pressures = states[0] if len(states) == 1 else states
        return bundle_force_strain(bundle, pressures, smooth(strains), resistance)

    outputs.write(variables, lambda: _print_forces(variables), figure, title=f"Bundle {file}")
    check_equilibria(variables)


def check_equilibria(variables: Any) -> None:
    """End a command with states that have no strain of zero force; `variables`: its result."""
    free = variables["free_strain"].values.tolist()
    missing = [f"{row}" for row, strain in enumerate(free, start=1) if math.isnan(strain)]
    if missing:
        exit_incomplete(
            f"no strain of zero force in state {', '.join(missing)}: the bundle pulls at every"
            " strain; lower its pressures."
        )


def print_states(variables: Any) -> None:
    """Print pressures, free strain and equilibria of states; `variables`: `bundle_equilibria`."""
    names = ("pressures", "free_strain", "equilibria", "stable")
    columns, rows = [variables[name].values.tolist() for name in names], []
    finite = [strain for strain in columns[1] if math.isfinite(strain)]
    if finite:
        limits = sorted({number(strain, 4) for strain in (min(finite), max(finite))})
        count = len(columns[1])
        states = "the state" if count == 1 else f"{count} states"
        print_text(f"Free strain of {states}: {' to '.join(limits)}.")
    for pressures, free, *equilibria in zip(*columns, strict=True):
        strains = [
            number(strain, 4) + ("" if is_stable else " u")
            for strain, is_stable in zip(*equilibria, strict=True)
            if math.isfinite(strain)  # a row with fewer equilibria is filled with NaN
        ]
        kilopascals = [f"{pressure / 1e3:.6g}" for pressure in pressures]
        rows.append([f"{len(rows) + 1}", *kilopascals, number(free, 4), ", ".join(strains)])
    units = [f"P{unit + 1} [kPa]" for unit in range(variables["pressures"].values.shape[1])]
    heads = ["state", *units, "free strain [-]", "equilibria [-]"]
    print_table("Free strain and equilibria without load", heads, rows, unstable_caption(rows))


def unstable_caption(rows: list[list[str]]) -> str:
    """Caption that explains the mark "u", if the table has one."""
    marked = any(cell.endswith(" u") or " u," in cell for row in rows for cell in row)
    return (
        "u: unstable, the force rises with strain there and the bundle leaves it" if marked else ""
    )


def _print_forces(variables: Any) -> None:
    """Print the free strains, and a table of force over strain by recruitment state."""
    print_states(variables)
    force = variables["force"].values
    decimals = count_decimals(force.ravel())
    rows = [
        [f"{strain:.6g}", *(number(value, decimals) for value in values)]
        for strain, values in zip(variables["strain"].values, force.T, strict=True)
    ]
    heads = ["strain [-]", *(f"state {state + 1} [N]" for state in range(len(force)))]
    print_table("Force by strain", heads, rows)
