"""`fascicle force`: a muscle's force over pressures and contractions."""

from typing import Any

from .. import options
from ..errors import user_errors
from ..inputs import check_grid, read_list, read_muscle
from ..outputs import Outputs, count_decimals, number, print_table, print_text, status


# marks in the table of the result's regions 0 to 3, and what they mean
_MARKS = (" ", "b", "c", "s")
_MEANINGS = {
    "b": "buckled, past the free strain", "c": "collapsed: folded at a hinge",
    "s": "straight, and compressed",
}  # fmt: skip


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
    """Compute a muscle's force over pressure and contraction."""
    pressures = read_list(pressure, "pressure", "--pressure")
    strains = read_list(strain, "strain", "--strain")
    check_grid(len(pressures), len(strains))
    outputs = Outputs(as_json, as_csv, out, plot, overwrite)
    muscle = read_muscle(file, "use `fascicle bundle`")
    from ...results.tables import muscle_force

    with status("computing forces"), user_errors():
        variables = muscle_force(muscle, pressures, strains)
        blocked = float(muscle.blocked_force(max(pressures)))

    def figure() -> Any:
        from ...plot.curves import force_strain, smooth

        return force_strain(muscle, sorted(set(pressures)), smooth(strains))

    outputs.write(variables, lambda: _print(variables, blocked), figure, title=f"Force of {file}")


def _print(variables: Any, blocked: float) -> None:
    values = {name: variable.values.tolist() for name, variable in variables.items()}
    pressures, force = values["pressure"], variables["force"].values
    labels = [f"{pressure / 1e3:.6g} kPa" for pressure in pressures]
    highest = pressures.index(max(pressures))
    free, collapse = (number(values[f"{x}_strain"][highest], 4) for x in ("free", "collapse"))
    print_text(
        f"At {labels[highest]}: blocked force {blocked:.4g} N, free strain {free}, "
        + ("no collapse." if collapse == "-" else f"collapse strain {collapse}.")
    )
    print_text(
        "Positive forces pull. Past the free strain the muscle pushes: its force is negative."
    )
    decimals = count_decimals(force.ravel())
    cells = [
        [f"{number(x, decimals)}{_MARKS[region]}" for x, region in zip(*column, strict=True)]
        for column in zip(values["force"], values["region"], strict=True)
    ]
    rows = [[f"{strain:.6g}", *row] for strain, *row in zip(values["strain"], *cells, strict=True)]
    marks = {_MARKS[region] for regions in values["region"] for region in regions}
    caption = "; ".join(f"{mark}: {text}" for mark, text in _MEANINGS.items() if mark in marks)
    print_table("Force [N]", ["strain [-]", *labels], rows, caption)
    rows = [
        [label, *(number(strain, 4) for strain in values[name])]
        for label, name in (("free", "free_strain"), ("collapse", "collapse_strain"))
    ]
    print_table("Free strain and collapse strain [-]", ["", *labels], rows)
