"""`fascicle space`: the workspace of each recruitment state, and its overlaps."""

from typing import Any

from .. import options
from ..errors import user_errors
from ..inputs import check_grid, read_bundle, read_list, read_rising_strains, read_supply
from ..options import option
from ..outputs import Outputs, count_decimals, number, print_table, print_text, status


_ROWS = 12  # strains that are printed, about: as many as fit on a screen


def run(
    file: str = options.TARGET,
    supply: str | None = options.SUPPLY,
    levels: str | None = option(
        "Pressures of the throttled motor unit; default: seven from zero to the supply pressure.",
        metavar="LIST",
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
    """Compute the workspaces of recruitment states.

    A state's workspace is the range of forces that it reaches at each contraction; those of two
    states may overlap.
    """
    pressure, strains = read_supply(supply), read_rising_strains(strain)
    throttled = None if levels is None else read_list(levels, "pressure", "--levels")
    outputs = Outputs(as_json, as_csv, out, plot, overwrite)
    bundle = read_bundle(file, pressure)
    units = len(bundle.motor_units)
    check_grid(max(units, len(throttled or ())), units, len(strains or range(201)))
    from ...bundle import recruitment
    from ...results import tables

    with status("computing the workspace of each state"), user_errors():
        space = recruitment.workspace(
            bundle, pressure, throttled or 7, strains, resistance=not no_resistance, scheme=scheme
        )
        variables = tables.space(space)

    def figure() -> Any:
        from ...plot.workspace import workspace

        return workspace(space, recruitment.overlap(space))

    outputs.write(variables, lambda: _print(variables, units), figure, title=f"Space of {file}")


def _print(variables: Any, units: int) -> None:
    values = {name: variable.values for name, variable in variables.items()}
    strains, high, low = values["strain"], values["high"], values["low"]
    decimals = count_decimals(high.ravel())
    print_text(
        f"{units} motor unit{'s' * (units > 1)}, {values['scheme']} recruitment, supply pressure"
        f" {values['supply_pressure'] / 1e3:.6g} kPa: forces up to {number(high.max(), decimals)} N"
        f" at a strain of {strains[high.max(axis=0).argmax()]:.4g}."
    )
    rows = []
    names = ("overlap_states", "overlap_area", "overlap_low", "overlap_high")
    for states, area, bottom, top in zip(*(values[name] for name in names), strict=True):
        widths = (top - bottom).tolist()
        width = max((width for width in widths if width > 0), default=None)  # NaN: no overlap
        widest = ["-", "-"]
        if width is not None:
            widest = [f"{width:.4g}", f"{strains[widths.index(width)]:.4g}"]
        rows.append([f"{states[0]} and {states[1]}", f"{area:.4g}", *widest])
    if rows:
        print_text("Where states overlap, each of them reaches the force; the one with fewer motor"
              " units takes less fluid.")  # fmt: skip
        heads = ["states", "overlap area [N]", "largest width [N]", "at strain [-]"]
        print_table("Overlap of states", heads, rows)
    elif units > 1:
        print_text("One state reaches the whole workspace: there is no overlap.")
    rows = [
        [f"{strains[j]:.4g}", *(f"{number(bottom[j], decimals)} to {number(top[j], decimals)}"
                                for bottom, top in zip(low, high, strict=True))]
        for j in range(0, len(strains), max(1, round(len(strains) / _ROWS)))
    ]  # fmt: skip
    heads = ["strain [-]", *(f"state {state + 1} [N]" for state in range(len(high)))]
    print_table("Range of force of each state", heads, rows)
