"""`fascicle space`: recruitment states in the force-strain space, and where they overlap."""

from typing import Any

from ..inputs import check_grid, read_bundle, read_list, read_one
from ..options import (
    AsCsv,
    AsJson,
    Levels,
    NoResistance,
    Out,
    Plot,
    Replace,
    Scheme,
    SpaceStrain,
    Supply,
    Target,
)
from ..outputs import Outputs
from ..printed import decimals, number, show
from ..problems import refusing
from ..telling import telling


def run(
    file: Target,
    supply: Supply = None,
    levels: Levels = None,
    strain: SpaceStrain = None,
    scheme: Scheme = None,
    no_resistance: NoResistance = False,
    as_json: AsJson = False,
    as_csv: AsCsv = False,
    out: Out = None,
    plot: Plot = None,
    overwrite: Replace = False,
) -> None:
    """Recruitment states and their overlap."""
    supply_pressure = None if supply is None else read_one(supply, "pressure", "--supply")
    pressures = None if levels is None else read_list(levels, "pressure", "--levels")
    strains = None if strain is None else read_list(strain, "strain", "--strain")
    check_grid(len(pressures or ()), len(strains or ()))
    outputs = Outputs(as_json, as_csv, out, plot, overwrite)
    bundle = read_bundle(file, unsupplied=supply_pressure is None)
    from ..compute import bundle_space

    with telling("finding what each state reaches"), refusing():
        variables, space = bundle_space(
            bundle, supply_pressure, pressures, strains, not no_resistance, scheme
        )
    outputs.give(
        variables,
        lambda: _table(variables, len(bundle.motor_units)),
        lambda: _figure(space),
        title=f"Space of {file}",
    )


def _table(variables: Any, units: int) -> None:
    values = {name: variable.values.tolist() for name, variable in variables.items()}
    strains, high, low = values["strain"], values["high"], values["low"]
    places = decimals(force for row in high for force in row)
    step = max(1, round(len(strains) / 12))
    rows = [
        [
            f"{strains[j]:.4g}",
            *(
                f"{number(bottom[j], places)} to {number(top[j], places)}"
                for bottom, top in zip(low, high, strict=True)
            ),
        ]
        for j in range(0, len(strains), step)
    ]
    heads = ["strain", *(f"state {i + 1}" for i in range(len(high)))]
    show(f"Force in N that each state reaches ({values['scheme']} recruitment)", heads, rows)
    if not values["overlap_states"]:
        if units > 1:
            print("One state reaches all of it: nothing overlaps.")
        return
    rows = []
    for pair, area, bottom, top in zip(
        values["overlap_states"],
        values["overlap_area"],
        values["overlap_low"],
        values["overlap_high"],
        strict=True,
    ):
        widths = [t - b if t > b else 0.0 for b, t in zip(bottom, top, strict=True)]
        widest = max(range(len(widths)), key=widths.__getitem__)
        there = widths[widest] > 0
        rows.append(
            [
                f"{pair[0]} and {pair[1]}",
                f"{area:.4g}",
                f"{widths[widest]:.4g}" if there else "-",
                f"{strains[widest]:.4g}" if there else "-",
            ]
        )
    show("Overlap of states", ["states", "area N", "widest N", "at strain"], rows)


def _figure(found: Any) -> Any:
    from ...bundle.space import overlap
    from ...plot.workspace import workspace

    return workspace(found, overlap(found))
