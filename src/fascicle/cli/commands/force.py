"""`fascicle force`: a muscle's force over pressures and strains."""

from typing import Any

from ..inputs import check_grid, read_list, read_muscle
from ..options import (
    DEFAULT_PRESSURE,
    DEFAULT_STRAIN,
    AsCsv,
    AsJson,
    Out,
    Plot,
    Pressure,
    Replace,
    Strain,
    Target,
)
from ..outputs import Outputs
from ..printed import decimals, number, show
from ..problems import refusing
from ..telling import telling


_MARKS = ("", "b", "c", "s")
_CAPTION = "b: past the free strain, buckled; c: collapsed; s: compressed straight"


def run(
    file: Target,
    pressure: Pressure = DEFAULT_PRESSURE,
    strain: Strain = DEFAULT_STRAIN,
    as_json: AsJson = False,
    as_csv: AsCsv = False,
    out: Out = None,
    plot: Plot = None,
    overwrite: Replace = False,
) -> None:
    """Force of a muscle over strain."""
    pressures = read_list(pressure, "pressure", "--pressure")
    strains = read_list(strain, "strain", "--strain")
    check_grid(len(pressures), len(strains))
    outputs = Outputs(as_json, as_csv, out, plot, overwrite)
    muscle = read_muscle(file, "use `fascicle bundle`")
    from ...results.tables import muscle_force

    with telling("finding forces"), refusing():
        variables = muscle_force(muscle, pressures, strains)
    outputs.give(
        variables,
        lambda: _table(variables),
        lambda: _figure(muscle, pressures, strains),
        title=f"Force of {file}",
    )


def _table(variables: Any) -> None:
    values = {name: variable.values.tolist() for name, variable in variables.items()}
    heads = [f"{pressure / 1e3:.6g} kPa" for pressure in values["pressure"]]
    rows = [
        [title, *(number(strain, 4) for strain in values[name])]
        for title, name in (("free", "free_strain"), ("collapse", "collapse_strain"))
    ]
    show("Free strain and strain of collapse", ["", *heads], rows)
    places = decimals(force for row in values["force"] for force in row)
    # transposed: strains run down the page, pressures across
    columns = [
        [f"{number(force, places)} {_MARKS[region]:1}" for force, region in zip(*pair, strict=True)]
        for pair in zip(values["force"], values["region"], strict=True)
    ]
    rows = [
        [f"{strain:.6g}", *row]
        for strain, row in zip(values["strain"], zip(*columns, strict=True), strict=True)
    ]
    show("Force in N by strain", ["strain", *(f"{head}  " for head in heads)], rows, _CAPTION)


def _figure(muscle: Any, pressures: list[float], strains: list[float]) -> Any:
    import numpy as np

    from ...plot.curves import force_strain, smooth

    return force_strain(muscle, np.unique(pressures), smooth(strains))
