"""`fascicle force`: a muscle's force over pressures and strains."""

from typing import Any

from .. import options
from ..errors import user_errors
from ..inputs import check_grid, read_list, read_muscle
from ..outputs import Outputs, decimals, number, print_table, status


_MARKS = (" ", "b", "c", "s")
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
        [title, *(number(strain, 4) for strain in values[name])]
        for title, name in (("free", "free_strain"), ("collapse", "collapse_strain"))
    ]
    print_table("Free strain and strain of collapse", ["", *heads], rows)
    places = decimals(force for row in values["force"] for force in row)
    # transposed: strains run down the page, pressures across
    columns = [
        [f"{number(force, places)}{_MARKS[region]}" for force, region in zip(*pair, strict=True)]
        for pair in zip(values["force"], values["region"], strict=True)
    ]
    rows = [
        [f"{strain:.6g}", *row]
        for strain, row in zip(values["strain"], zip(*columns, strict=True), strict=True)
    ]
    print_table("Force in N by strain", ["strain", *heads], rows, _CAPTION)
