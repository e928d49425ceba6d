"""`fascicle recruit`: the recruitment state and pressures that give a force at a strain."""

from typing import Any

from .. import options
from ..errors import exit_incomplete, user_errors
from ..inputs import check_grid, read_bundle, read_list, read_one
from ..options import option
from ..outputs import Outputs, decimals, number, print_table, status


_UNREACHED = {1: "more than", 2: "less than"}


def run(
    file: str = options.TARGET,
    force: str = option(
        "Demanded forces: 40N, a list 20N,40N or a range 0N:100N:10N.",
        "--force -f",
        metavar="LIST",
        default=...,
    ),
    strain: str = option(
        "Contractions: 0.12, a list 0,0.1 or a range 0:0.2:0.05.",
        "--strain -s",
        metavar="LIST",
        default=...,
    ),
    supply: str | None = options.SUPPLY,
    scheme: str | None = options.SCHEME,
    no_resistance: bool = options.NO_RESISTANCE,
    as_json: bool = options.JSON,
    as_csv: bool = options.CSV,
    out: str | None = options.OUT,
    overwrite: bool = options.OVERWRITE_ONLY,
) -> None:
    """State and pressures that give a force at a strain.

    The solution that takes least fluid; other solutions are listed beside it.
    """
    forces = read_list(force, "force", "--force")
    strains = read_list(strain, "strain", "--strain")
    supply_pressure = None if supply is None else read_one(supply, "pressure", "--supply")
    outputs = Outputs(as_json, as_csv, out, None, overwrite)
    bundle = read_bundle(file, supply_pressure)
    units = len(bundle.motor_units)
    check_grid(len(forces), len(strains), units, units)
    import numpy as np

    from ...bundle import recruitment
    from ...bundle.bundle import resolve_scheme
    from ...results.tables import recruited

    with status(f"finding the pressures of {len(forces) * len(strains)} demands"), user_errors():
        result = recruitment.recruit(
            bundle,
            np.array(forces)[:, None],
            strains,
            supply_pressure,
            scheme,
            resistance=not no_resistance,
        )
        variables = recruited(result, np.array(forces), np.array(strains))
    is_free = resolve_scheme(bundle, scheme).independent
    outputs.write(variables, lambda: _print(variables, is_free), title=f"Recruitment of {file}")
    unreached = variables["status"].values
    if count := int((unreached != 0).sum()):
        exit_incomplete(
            f"{count} of {unreached.size} demands can't be reached: their nearest force is given,"
            " with status 1 where the demand is too large, 2 where it is too small."
        )


def _print(variables: Any, is_free: bool) -> None:
    values = {name: variable.values.tolist() for name, variable in variables.items()}
    places = decimals(force for row in values["force"] for force in row)
    rows, unreached = [], []
    for i, demand in enumerate(values["demand"]):
        for j, strain in enumerate(values["strain"]):
            rows.append(_row(values, i, j, places))
            if code := values["status"][i][j]:
                unreached.append(
                    f"{demand:.6g} N at a strain of {strain:.6g} is {_UNREACHED[code]} can be"
                    f" reached: the nearest is {number(values['force'][i][j], places)} N."
                )
    units = len(values["pressures"][0][0])
    heads = ["demand N", "strain", "state", *(f"P{unit + 1} kPa" for unit in range(units))]
    caption = "u: unstable, the force rises with strain there"
    print_table("Recruitment", [*heads, "force N", "other solutions"], rows, caption, keys=2)
    if is_free:
        print("Of all pressures that give it, those that take least fluid; others aren't listed.")
    for line in unreached:
        print(line)


def _row(values: Any, i: int, j: int, places: int) -> list[str]:
    """Solution of a demand; other solutions as state and throttled pressure."""
    solution = values["throttled_pressure"][i][j], values["state"][i][j]
    names = ("solution_pressure", "solution_state", "solution_stable")
    others = [
        f"{state}: {pressure / 1e3:.6g} kPa{'' if is_stable else ' u'}"
        for pressure, state, is_stable in zip(*(values[name][i][j] for name in names), strict=True)
        if state and (pressure, state) != solution
    ]
    return [
        f"{values['demand'][i]:.6g}",
        f"{values['strain'][j]:.6g}",
        f"{values['state'][i][j]}",
        *(f"{pressure / 1e3:.6g}" for pressure in values["pressures"][i][j]),
        number(values["force"][i][j], places) + ("" if values["stable"][i][j] else " u"),
        "\n".join(others) or "-",
    ]
