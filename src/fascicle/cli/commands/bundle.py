"""`fascicle bundle`: a bundle's force, free strain and equilibria at pressures."""

from typing import Any

from ..equilibria import check_zeros, show_states
from ..inputs import check_grid, read_bundle, read_list, read_states
from ..options import (
    DEFAULT_STRAIN,
    AsCsv,
    AsJson,
    NoResistance,
    Out,
    Plot,
    Pressures,
    Replace,
    Strain,
    Target,
)
from ..outputs import Outputs
from ..printed import decimals, number, show
from ..problems import refusing
from ..telling import telling


def run(
    file: Target,
    pressure: Pressures = None,
    strain: Strain = DEFAULT_STRAIN,
    no_resistance: NoResistance = False,
    as_json: AsJson = False,
    as_csv: AsCsv = False,
    out: Out = None,
    plot: Plot = None,
    overwrite: Replace = False,
) -> None:
    """Force and equilibria of a bundle.

    At pressures, one for each motor unit; left out, the end of each recruitment state.
    """
    strains = read_list(strain, "strain", "--strain")
    outputs = Outputs(as_json, as_csv, out, plot, overwrite)
    bundle = read_bundle(file)
    states = read_states(pressure, bundle)
    check_grid(len(states), len(states[0]), len(strains))
    from ...results.tables import bundle_force
    from ..compute import bundle_equilibria

    with telling("finding equilibria and forces"), refusing():
        # the zeros take most memory, and refuse what has none
        zeros = bundle_equilibria(bundle, states, not no_resistance)
        variables = {**bundle_force(bundle, states, strains, not no_resistance), **zeros}
    outputs.give(
        variables,
        lambda: _table(variables),
        lambda: _figure(bundle, states, strains, not no_resistance),
        title=f"Bundle {file}",
    )
    check_zeros(variables)


def _table(variables: Any) -> None:
    show_states(variables)
    forces = variables["force"].values.tolist()
    places = decimals(force for row in forces for force in row)
    rows = [
        [f"{strain:.6g}", *(number(force, places) for force in row)]
        for strain, row in zip(
            variables["strain"].values.tolist(), zip(*forces, strict=True), strict=True
        )
    ]
    heads = ["strain", *(f"state {i + 1}" for i in range(len(forces)))]
    show("Force in N by strain", heads, rows)


def _figure(bundle: Any, states: list[list[float]], strains: list[float], resistance: bool) -> Any:
    from ...plot.curves import bundle_force_strain, smooth

    pressures = states[0] if len(states) == 1 else states
    return bundle_force_strain(bundle, pressures, smooth(strains), resistance)
