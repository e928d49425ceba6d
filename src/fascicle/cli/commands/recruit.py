"""`fascicle recruit`: the recruitment state and pressures that give a force at a strain."""

from typing import Annotated, Any

import typer

from ..inputs import check_grid, read_bundle, read_list, read_one
from ..options import AsCsv, AsJson, NoResistance, Out, Overwrite, Scheme, Supply, Target
from ..outputs import Outputs
from ..printed import decimals, number, show
from ..problems import fall_short, refusing
from ..telling import telling


Force = Annotated[
    str,
    typer.Option(
        "--force",
        "-f",
        metavar="LIST",
        help="Demanded forces: 40N, a list 20N,40N or a range 0N:100N:10N.",
        show_default=False,
    ),
]
Strain = Annotated[
    str,
    typer.Option(
        "--strain",
        "-s",
        metavar="LIST",
        help="Contractions: 0.12, a list 0,0.1 or a range 0:0.2:0.05.",
        show_default=False,
    ),
]
_UNREACHED = {1: "more than", 2: "less than"}


def run(
    file: Target,
    force: Force,
    strain: Strain,
    supply: Supply = None,
    scheme: Scheme = None,
    no_resistance: NoResistance = False,
    as_json: AsJson = False,
    as_csv: AsCsv = False,
    out: Out = None,
    overwrite: Overwrite = False,
) -> None:
    """State and pressures that give a force at a strain.

    Of several solutions the one that takes least fluid; the others are shown too.
    """
    forces = read_list(force, "force", "--force")
    strains = read_list(strain, "strain", "--strain")
    supply_pressure = None if supply is None else read_one(supply, "pressure", "--supply")
    check_grid(len(forces), len(strains))
    outputs = Outputs(as_json, as_csv, out, None, overwrite, "--overwrite")
    bundle = read_bundle(file, unsupplied=supply_pressure is None)
    from ..compute import bundle_recruit, is_free

    told = f"finding the pressures of {len(forces) * len(strains)} demands"
    with telling(told), refusing():
        variables = bundle_recruit(
            bundle, forces, strains, supply_pressure, scheme, not no_resistance
        )
    outputs.give(
        variables,
        lambda: _table(variables, is_free(bundle, scheme)),
        title=f"Recruitment of {file}",
    )
    status = variables["status"].values
    if missed := int((status != 0).sum()):
        fall_short(
            f"{missed} of {status.size} demands can't be reached: for them the nearest force is"
            " given, with status 1 where more was demanded than can be, 2 where less."
        )


def _table(variables: Any, free: bool) -> None:
    values = {name: variable.values.tolist() for name, variable in variables.items()}
    places = decimals(force for row in values["force"] for force in row)
    rows, unreached = [], []
    for i, demanded in enumerate(values["demand"]):
        for j, strain in enumerate(values["strain"]):
            rows.append(_row(values, i, j, places))
            if status := values["status"][i][j]:
                unreached.append(
                    f"{demanded:.6g} N at a strain of {strain:.6g} is {_UNREACHED[status]} can be"
                    f" reached: the nearest is {number(values['force'][i][j], places)} N."
                )
    units = len(values["pressures"][0][0])
    heads = ["demand N", "strain", "state", *(f"P{unit + 1} kPa" for unit in range(units))]
    caption = "u: unstable, the force rises with strain there"
    show("Recruitment", [*heads, "force N", "other solutions"], rows, caption, keys=2)
    if free:
        print(
            "Of all pressures that give it, those that take least fluid; the others aren't listed."
        )
    for line in unreached:
        print(line)


def _row(values: Any, i: int, j: int, places: int) -> list[str]:
    """A demand's answer; other solutions as state and throttled pressure."""
    own = values["throttled_pressure"][i][j], values["state"][i][j]
    names = ("solution_pressure", "solution_state", "solution_stable")
    others = [
        f"{state}: {pressure / 1e3:.6g} kPa{'' if firm else ' u'}"
        for pressure, state, firm in zip(*(values[name][i][j] for name in names), strict=True)
        if state and (pressure, state) != own
    ]
    return [
        f"{values['demand'][i]:.6g}",
        f"{values['strain'][j]:.6g}",
        f"{values['state'][i][j]}",
        *(f"{pressure / 1e3:.6g}" for pressure in values["pressures"][i][j]),
        number(values["force"][i][j], places) + ("" if values["stable"][i][j] else " u"),
        "\n".join(others) or "-",
    ]
