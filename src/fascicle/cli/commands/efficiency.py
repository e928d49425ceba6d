"""`fascicle efficiency`: work over fluid energy, isobaric and isotonic."""

from typing import Any

from .. import options
from ..errors import UserError, exit_incomplete, user_errors
from ..inputs import check_grid, read_bundle, read_list, read_rising_strains, read_supply
from ..options import option
from ..outputs import Outputs, number, print_table, print_text, status


_PATHS = ("isobaric", "isotonic")


def run(
    file: str = options.TARGET,
    supply: str | None = options.SUPPLY,
    path: str | None = option(
        "Path of the work: isobaric or isotonic; default: both.",
        autocompletion=lambda: list(_PATHS),
    ),
    force: str | None = option(
        "Forces of a table: 20N or 10N:100N:10N; default: 80, for the average alone.",
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
    """Compute the average efficiency of isobaric and isotonic work.

    The average is over a bundle's force-strain workspace. With --force, a table gives the
    efficiency of each point, too.
    """
    if path is not None and path not in _PATHS:
        raise UserError(f"--path {path}: choose one of {', '.join(_PATHS)}.")
    pressure, strains = read_supply(supply), read_rising_strains(strain)
    forces = None if force is None else read_list(force, "force", "--force")
    outputs = Outputs(as_json, as_csv, out, plot, overwrite)
    bundle = read_bundle(file, pressure)
    paths = _PATHS if path is None else (path,)
    check_grid(len(bundle.motor_units), len(forces or range(80)), len(strains or range(225)))
    from ...bundle.energetics import efficiency_map
    from ...results import tables

    with status("finding efficiencies"), user_errors():
        maps = [
            efficiency_map(bundle, pressure, path, forces, strains, not no_resistance, scheme)
            for path in paths
        ]
        variables = tables.efficiency(maps)

    def figure() -> Any:
        from ...plot.workspace import efficiency

        return efficiency(*maps)

    def table() -> None:
        _print(variables, forces is not None)

    outputs.write(variables, table, figure, title=f"Efficiency of {file}")
    fractions = variables["reached"].values
    # a map without demanded forces extends past the workspace: only an empty one is incomplete
    if not fractions.all() or (forces is not None and fractions.min() < 1):
        pairs = zip(fractions, paths, strict=True)
        texts = ", ".join(f"{100 * fraction:.3g} % {path}" for fraction, path in pairs)
        exit_incomplete(
            f"the bundle doesn't reach all points ({texts}): the others have no efficiency."
        )


def _print(variables: Any, points: bool) -> None:
    values = {name: variable.values.tolist() for name, variable in variables.items()}
    for path, average, fraction in zip(
        values["path"], values["average"], values["reached"], strict=True
    ):
        coverage = f"{100 * fraction:.0f} % of the grid of forces and strains"
        print_text(
            f"{path}: average efficiency {number(average, 4)} over the points within reach,"
            f" {coverage}"
        )
    if not points:
        return
    forces = [f"{force:.6g}" for force in values["force"]]
    strains = [f"{strain:.4g}" for strain in values["strain"]]
    for path, grid in zip(values["path"], values["efficiency"], strict=True):
        cells = [[number(value, 4) for value in row] for row in grid]
        heads, labels = ["force [N]", *(f"strain {strain}" for strain in strains)], forces
        if len(strains) > len(forces):  # the longer list runs down the page
            heads, labels = ["strain [-]", *(f"{force} N" for force in forces)], strains
            cells = [[*column] for column in zip(*cells, strict=True)]
        rows = [[label, *row] for label, row in zip(labels, cells, strict=True)]
        caption = "-: out of reach" if any("-" in row for row in cells) else ""
        print_table(f"Efficiency [-], {path}", heads, rows, caption)
