"""`fascicle efficiency`: work over fluid energy, isobaric and isotonic."""

from typing import Any

from ..inputs import check_grid, read_bundle, read_list, read_one
from ..options import (
    Along,
    AsCsv,
    AsJson,
    Forces,
    NoResistance,
    Out,
    Overwrite,
    Plot,
    Scheme,
    SpaceStrain,
    Supply,
    Target,
)
from ..outputs import Outputs
from ..printed import number, show
from ..problems import UserError, fall_short, refusing
from ..telling import telling


_PATHS = ("isobaric", "isotonic")


def run(
    file: Target,
    supply: Supply = None,
    path: Along = None,
    force: Forces = None,
    strain: SpaceStrain = None,
    scheme: Scheme = None,
    no_resistance: NoResistance = False,
    as_json: AsJson = False,
    as_csv: AsCsv = False,
    out: Out = None,
    plot: Plot = None,
    overwrite: Overwrite = False,
) -> None:
    """Efficiency, isobaric and isotonic.

    Averages over a bundle's force-strain space, or points of it at forces and strains.
    """
    if path is not None and path not in _PATHS:
        raise UserError(f"--path {path}: choose one of {', '.join(_PATHS)}.")
    supply_pressure = None if supply is None else read_one(supply, "pressure", "--supply")
    forces = None if force is None else read_list(force, "force", "--force")
    strains = None if strain is None else read_list(strain, "strain", "--strain")
    check_grid(len(forces or ()), len(strains or ()))
    outputs = Outputs(as_json, as_csv, out, plot, overwrite, "--overwrite")
    bundle = read_bundle(file, unsupplied=supply_pressure is None)
    paths = _PATHS if path is None else (path,)
    from ..compute import bundle_efficiency

    with telling("finding efficiencies"), refusing():
        variables, maps = bundle_efficiency(
            bundle,
            supply_pressure,
            paths,
            forces,
            strains,
            not no_resistance,
            scheme,
        )
    outputs.give(
        variables,
        lambda: _table(variables, points=force is not None),
        lambda: _figure(maps),
        title=f"Efficiency of {file}",
    )
    share = variables["reached"].values
    # by itself the map is of all points that are reached; points that were asked for are another
    # matter, and so is a map of none
    if not share.all() or (force is not None and share.min() < 1):
        told = ", ".join(f"{100 * x:.3g} % {path}" for path, x in zip(paths, share, strict=True))
        fall_short(f"not all points are reached ({told}): the others have no efficiency.")


def _table(variables: Any, points: bool) -> None:
    values = {name: variable.values.tolist() for name, variable in variables.items()}
    if points:
        for path, grid in zip(values["path"], values["efficiency"], strict=True):
            _show_points(path, values["force"], values["strain"], grid)
    rows = [
        [path, number(average, 4), f"{100 * share:.0f} %"]
        for path, average, share in zip(
            values["path"], values["average"], values["reached"], strict=True
        )
    ]
    show("Average over the points reached", ["path", "efficiency", "reached"], rows)


def _show_points(
    path: str, forces: list[float], strains: list[float], grid: list[list[float]]
) -> None:
    """The longer of forces and strains runs down the page, where there is room for it."""
    cells = [[number(x, 4) for x in row] for row in grid]
    if len(strains) > len(forces):
        heads = ["strain", *(f"{force:.6g} N" for force in forces)]
        columns = [[f"{strain:.4g}" for strain in strains], *cells]
        rows = [list(row) for row in zip(*columns, strict=True)]
    else:
        heads = ["force N", *(f"{strain:.4g}" for strain in strains)]
        rows = [[f"{force:.6g}", *row] for force, row in zip(forces, cells, strict=True)]
    show(f"Efficiency, {path}, by strain", heads, rows, "-: not reached")


def _figure(maps: Any) -> Any:
    from ...plot.workspace import efficiency

    return efficiency(*maps)
