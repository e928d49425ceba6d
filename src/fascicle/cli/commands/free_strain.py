"""`fascicle free-strain`: the strain at which a muscle's or a bundle's force vanishes."""

from typing import Any

from .. import options
from ..errors import UserError, user_errors
from ..inputs import check_grid, is_bundle, read_list, read_states, read_target
from ..options import option
from ..outputs import Outputs, count_decimals, number, print_table, print_text, status
from .bundle import check_equilibria, print_states


def run(
    file: str = options.TARGET,
    pressure: list[str] | None = option(
        "Gauge pressures: a list or range for a muscle; for a bundle one value or range per motor"
        " unit (344.7kPa,0kPa); repeat for more.",
        "--pressure -p",
        metavar="LIST",
    ),
    no_resistance: bool = options.NO_RESISTANCE,
    as_json: bool = options.JSON,
    as_csv: bool = options.CSV,
    out: str | None = options.OUT,
    plot: str | None = options.PLOT,
    overwrite: bool = options.OVERWRITE,
) -> None:
    """Compute the free strain of a muscle or a bundle.

    The free strain is the contraction without load. The table adds a muscle's blocked force and
    collapse strain, or all equilibria of a bundle.
    """
    outputs = Outputs(as_json, as_csv, out, plot, overwrite)
    target = read_target(file)
    from ...results.tables import bundle_equilibria, muscle_free_strain

    if is_bundle(target):
        pressures = read_states(pressure, target)
        units = len(pressures[0])
        check_grid(len(pressures), units, units)
        with status("finding equilibria"), user_errors():
            variables = bundle_equilibria(target, pressures, not no_resistance)
    elif no_resistance:
        raise UserError("--no-resistance: only a bundle's muscles resist: drop it for a muscle.")
    else:
        text = ",".join(pressure or [options.DEFAULT_PRESSURE])
        pressures = read_list(text, "pressure", "--pressure")
        with status("finding free strains"), user_errors():
            variables = muscle_free_strain(target, pressures)

    def figure() -> Any:
        import numpy as np

        from ...plot.curves import free_strain_states

        strains = variables["free_strain"].values
        return free_strain_states(target, np.array(pressures), strains, not no_resistance)

    table = print_states if is_bundle(target) else _print
    outputs.write(variables, lambda: table(variables), figure, title=f"Free strain of {file}")
    check_equilibria(variables)


def _print(variables: Any) -> None:
    columns = [[f"{pressure / 1e3:.6g}" for pressure in variables["pressure"].values.tolist()]]
    highest = variables["pressure"].values.argmax()
    free, blocked = (variables[x].values[highest] for x in ("free_strain", "blocked_force"))
    print_text(
        f"At {columns[0][highest]} kPa: free strain {free:.4f}, blocked force {blocked:.4g} N."
    )
    for name in [*variables][1:]:
        values = variables[name].values.tolist()
        decimals = 4 if name.endswith("strain") else count_decimals(values)
        columns.append([number(value, decimals) for value in values])
    heads = ["pressure [kPa]", "free strain [-]", "blocked force [N]", "collapse strain [-]",
             "collapse moment [N·m]"]  # fmt: skip
    rows = [*zip(*columns, strict=True)]
    print_table("Free strain, blocked force and collapse", heads, rows)
