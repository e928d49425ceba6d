"""`fascicle force`: a muscle's force over pressures and strains."""

from typing import Any

from .. import options
from ..errors import user_errors
from ..inputs import check_grid, read_list, read_muscle
from ..outputs import Outputs, count_decimals, number, print_table, status


_REGIONS = (" ", "b", "c", "s")  # marks of the result's regions 0 to 3
_CAPTION = "b: past the free strain, buckled; c: collapsed; s: compressed straight"


def run(
    file: str = options.TARGET,
    pressure: str = options.PRESSURE,
    strain: str = options.STRAIN,
    as_json: bool = options.JSON,
    as_csv: bool = options.CSV,
    out: str | None = options.OUT,
    plot: str | None = options.PLOT,
    overwrite: bool = options.OVERWRITE,
) -> None:
    """Force of a muscle over strain."""
    pressures = read_list(pressure, "pressure", "--pressure")
    strains = read_list(strain, "strain", "--strain")
    check_grid(len(pressures), len(strains))
    outputs = Outputs(as_json, as_csv, out, plot, overwrite)
    muscle = read_muscle(file, "use `fascicle bundle`")
    from ...results.tables import muscle_force

    with status("finding forces"), user_errors():
        variables = muscle_force(muscle, pressures, strains)

    def draw() -> Any:
        from ...plot.curves import force_strain, smooth

        return force_strain(muscle, sorted(set(pressures)), smooth(strains))

    outputs.write(variables, lambda: _print(variables), draw, title=f"Force of {file}")


def _print(variables: Any) -> None:
    values = {name: variable.values.tolist() for name, variable in variables.items()}
    heads = [f"{pressure / 1e3:.6g} kPa" for pressure in values["pressure"]]
    rows = [
        [label, *(number(strain, 4) for strain in values[name])]
        for label, name in (("free", "free_strain"), ("collapse", "collapse_strain"))
    ]
    print_table("Free strain and collapse strain", ["strain [-]", *heads], rows)
    decimals = count_decimals(variables["force"].values.ravel())
    columns = zip(values["force"], values["region"], strict=True)
    cells = [
        [
            f"{number(force, decimals)}{_REGIONS[region]}"
            for force, region in zip(*column, strict=True)
        ]
        for column in columns
    ]
    rows = [[f"{strain:.6g}", *row] for strain, *row in zip(values["strain"], *cells, strict=True)]
    print_table("Force [N] by strain and pressure", ["strain [-]", *heads], rows, _CAPTION)
