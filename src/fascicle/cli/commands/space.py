"""`fascicle space`: the workspace of each recruitment state, and its overlaps."""

from typing import Any

from .. import options
from ..errors import user_errors
from ..inputs import check_grid, check_rising, read_bundle, read_list, read_one
from ..options import option
from ..outputs import Outputs, decimals, number, print_table, status


def run(
    file: str = options.TARGET,
    supply: str | None = options.SUPPLY,
    levels: str | None = option(
        "Throttled pressures; default: seven from zero to the supply pressure.", metavar="LIST"
    ),
    strain: str | None = options.SPACE_STRAIN,
    scheme: str | None = options.SCHEME,
    no_resistance: bool = options.NO_RESISTANCE,
    as_json: bool = options.JSON,
    as_csv: bool = options.CSV,
    out: str | None = options.OUT,
    plot: str | None = options.PLOT,
    overwrite: bool = options.OVERWRITE,
) -> None:
    """Recruitment states and their overlap."""
    supply_pressure = None if supply is None else read_one(supply, "pressure", "--supply")
    pressures = None if levels is None else read_list(levels, "pressure", "--levels")
    strains = None if strain is None else read_list(strain, "strain", "--strain")
    check_rising(strains)
    outputs = Outputs(as_json, as_csv, out, plot, overwrite)
    bundle = read_bundle(file, supply_pressure)
    units = len(bundle.motor_units)
    check_grid(max(units, len(pressures or ())), units, len(strains or range(201)))
    from ...bundle import recruitment
    from ...results import tables

    with status("finding the workspace of each state"), user_errors():
        space = recruitment.space(
            bundle,
            supply_pressure,
            pressures or 7,
            strains,
            resistance=not no_resistance,
            scheme=scheme,
        )
        variables = tables.space(space)

    def draw() -> Any:
        from ...plot.workspace import workspace

        return workspace(space, recruitment.overlap(space))

    outputs.write(variables, lambda: _print(variables, units), draw, title=f"Space of {file}")


def _print(variables: Any, units: int) -> None:
    values = {name: variable.values.tolist() for name, variable in variables.items()}
    strains, high, low = values["strain"], values["high"], values["low"]
    places = decimals(force for row in high for force in row)
    rows = [
        [f"{strains[j]:.4g}", *(f"{number(bottom[j], places)} to {number(top[j], places)}"
                                for bottom, top in zip(low, high, strict=True))]
        for j in range(0, len(strains), max(1, round(len(strains) / 12)))
    ]  # fmt: skip
    heads = ["strain", *(f"state {state + 1}" for state in range(len(high)))]
    print_table(f"Force in N that each state reaches ({values['scheme']} recruitment)", heads, rows)
    if not values["overlap_states"]:
        if units > 1:
            print("One state reaches all of it: nothing overlaps.")
        return
    names = ("overlap_states", "overlap_area", "overlap_low", "overlap_high")
    rows = []
    for pair, area, bottom, top in zip(*(values[name] for name in names), strict=True):
        widths = [t - b if t > b else 0.0 for b, t in zip(bottom, top, strict=True)]
        width = max(widths)
        widest = [f"{width:.4g}", f"{strains[widths.index(width)]:.4g}"] if width else ["-", "-"]
        rows.append([f"{pair[0]} and {pair[1]}", f"{area:.4g}", *widest])
    print_table("Overlap of states", ["states", "area N", "widest N", "at strain"], rows)
