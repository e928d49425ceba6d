"""`fascicle free-strain`: where a muscle's or a bundle's force vanishes."""

from typing import Any

from ..equilibria import check_zeros, show_states
from ..inputs import check_grid, is_bundle, read_list, read_states, read_target
from ..options import (
    DEFAULT_PRESSURE,
    AsCsv,
    AsJson,
    NoResistance,
    Out,
    Plot,
    Pressures,
    Replace,
    Target,
)
from ..outputs import Outputs
from ..printed import decimals, number, show
from ..problems import UserError, refusing
from ..telling import telling


def run(
    file: Target,
    pressure: Pressures = None,
    no_resistance: NoResistance = False,
    as_json: AsJson = False,
    as_csv: AsCsv = False,
    out: Out = None,
    plot: Plot = None,
    overwrite: Replace = False,
) -> None:
    """Free strain of a muscle or a bundle.

    With a muscle's blocked force and collapse, or all of a bundle's equilibria.
    """
    outputs = Outputs(as_json, as_csv, out, plot, overwrite)
    found = read_target(file)
    from ...results.tables import muscle_free_strain
    from ..compute import bundle_equilibria

    if is_bundle(found):
        states = read_states(pressure, found)
        check_grid(len(states), len(states[0]))
        with telling("finding equilibria"), refusing():
            variables = bundle_equilibria(found, states, not no_resistance)
        table = show_states
    else:
        if no_resistance:
            raise UserError("--no-resistance: it is for bundles; a muscle's free strain has none.")
        text = ",".join(pressure or [DEFAULT_PRESSURE])
        pressures = read_list(text, "pressure", "--pressure")
        with telling("finding free strains"), refusing():
            variables = muscle_free_strain(found, pressures)
        table = _table
    outputs.give(
        variables,
        lambda: table(variables),
        lambda: _figure(found, variables, not no_resistance),
        title=f"Free strain of {file}",
    )
    check_zeros(variables)


def _table(variables: Any) -> None:
    columns = [variable.values.tolist() for variable in variables.values()]
    places = [
        4 if name.endswith("strain") else decimals(column)
        for name, column in zip(variables, columns, strict=True)
    ]
    rows = [
        [f"{row[0] / 1e3:.6g}", *(number(x, n) for x, n in zip(row[1:], places[1:], strict=True))]
        for row in zip(*columns, strict=True)
    ]
    heads = ["pressure kPa", "free strain", "blocked force N", "collapse strain", "at N m"]
    show("Free strain, blocked force and collapse", heads, rows)


def _figure(found: Any, variables: Any, resistance: bool) -> Any:
    from ...plot.curves import free_strain_states

    pressures = variables["pressures" if is_bundle(found) else "pressure"].values
    return free_strain_states(found, pressures, variables["free_strain"].values, resistance)
