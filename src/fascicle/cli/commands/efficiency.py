"""`fascicle efficiency`: work over fluid energy, isobaric and isotonic."""

from typing import Any

from .. import options
from ..errors import UserError, exit_incomplete, user_errors
from ..inputs import check_grid, check_rising, read_bundle, read_list, read_one
from ..options import option
from ..outputs import Outputs, number, print_table, status


_PATHS = ("isobaric", "isotonic")


def run(
    file: str = options.TARGET,
    supply: str | None = options.SUPPLY,
    path: str | None = option(
        "Path of the work: isobaric or isotonic; default: both.",
        autocompletion=lambda: list(_PATHS),
    ),
    force: str | None = option(
        "Forces: 20N or 10N:100N:10N; default: 80 up to the blocked force.", metavar="LIST"
    ),
    strain: str | None = options.SPACE_STRAIN,
    scheme: str | None = options.SCHEME,
    no_resistance: bool = options.NO_RESISTANCE,
    as_json: bool = options.JSON,
    as_csv: bool = options.CSV,
    out: str | None = options.OUT,
    plot: str | None = options.PLOT,
    overwrite: bool = options.OVERWRITE_ONLY,
) -> None:
    """Efficiency, isobaric and isotonic.

    Averages over a bundle's force-strain workspace, or points of it at forces and strains.
    """
    if path is not None and path not in _PATHS:
        raise UserError(f"--path {path}: choose one of {', '.join(_PATHS)}.")
    supply_pressure = None if supply is None else read_one(supply, "pressure", "--supply")
    forces = None if force is None else read_list(force, "force", "--force")
    strains = None if strain is None else read_list(strain, "strain", "--strain")
    check_rising(strains)
    outputs = Outputs(as_json, as_csv, out, plot, overwrite)
    bundle = read_bundle(file, supply_pressure)
    units, paths = len(bundle.motor_units), _PATHS if path is None else (path,)
    check_grid(units, len(forces or range(80)), len(strains or range(225)))
    from ...bundle.efficiency import efficiency_map
    from ...results import tables

    with status("finding efficiencies"), user_errors():
        maps = [
            efficiency_map(
                bundle, supply_pressure, path, forces, strains, not no_resistance, scheme
            )
            for path in paths
        ]
        variables = tables.efficiency(maps)

    def draw() -> Any:
        from ...plot.workspace import efficiency

        return efficiency(*maps)

    outputs.write(
        variables, lambda: _print(variables, force is not None), draw, title=f"Efficiency of {file}"
    )
    share = variables["reached"].values
    # by itself the map is of all points that are reached; points that were asked for are another
    # matter, and so is a map of none
    if not share.all() or (force is not None and share.min() < 1):
        shares = ", ".join(f"{100 * x:.3g} % {path}" for path, x in zip(paths, share, strict=True))
        exit_incomplete(f"not all points are reached ({shares}): the others have no efficiency.")


def _print(variables: Any, points: bool) -> None:
    values = {name: variable.values.tolist() for name, variable in variables.items()}
    if points:
        for path, grid in zip(values["path"], values["efficiency"], strict=True):
            _print_points(path, values["force"], values["strain"], grid)
    rows = [
        [path, number(average, 4), f"{100 * share:.0f} %"]
        for path, average, share in zip(
            values["path"], values["average"], values["reached"], strict=True
        )
    ]
    print_table("Average over the points reached", ["path", "efficiency", "reached"], rows)


def _print_points(
    path: str, forces: list[float], strains: list[float], grid: list[list[float]]
) -> None:
    """Print efficiencies; the longer of forces and strains runs down the page."""
    cells = [[number(x, 4) for x in row] for row in grid]
    down, across = [f"{force:.6g}" for force in forces], [f"{strain:.4g}" for strain in strains]
    heads = ["force N", *across]
    if len(strains) > len(forces):
        heads, down = ["strain", *(f"{force} N" for force in down)], across
        cells = list(zip(*cells, strict=True))
    rows = [[name, *row] for name, row in zip(down, cells, strict=True)]
    print_table(f"Efficiency, {path}, by strain", heads, rows, "-: not reached")
