"""A muscle's table as a function block in Structured Text, IEC 61131-3, for a PLC.

Its numbers are those of the table in C, and its force is the same polynomial. Its inverse looks
between the table's lines for the first change of sign, where C also has the extrema within a cell.
"""

from functools import partial
from textwrap import fill

import numpy as np

from .. import __version__
from ..core.errors import InvalidInputError
from ..core.types import Values
from ..muscle import Muscle
from .c_files import check_c_name, render_template
from .c_table import EDGE, nodes, tabulate


# type of numbers, and halvings of a cell until its ends differ by a rounding
_TYPES = {"double": ("LREAL", np.float64, 53), "float": ("REAL", np.float32, 24)}


def function_block(
    muscle: Muscle,
    name: str = "muscle",
    precision: str = "double",
    highest_pressure: Values = None,
    shape: tuple[int, int] | None = None,
) -> str:
    """Text of a `FUNCTION_BLOCK` called `FB_` and the `name`, with the table of a `muscle`.

    Its type of numbers is LREAL for the `precision` "double" and REAL for "float". Other arguments,
    `highest_pressure` [Pa] among them, and errors: as `table_code`.
    """
    if not isinstance(muscle, Muscle):
        kind, remedy = type(muscle).__name__, "write each muscle of a bundle by itself"
        raise InvalidInputError("muscle", "must be a Muscle", None, remedy, shown=kind)
    check_c_name(name)
    tables = tabulate(muscle, precision, highest_pressure, shape)
    (surface,), (real, kind, halvings) = tables.surfaces, _TYPES[precision]
    number = partial(np.format_float_scientific, trim="0")
    lines, columns = surface.coefficients.shape[:2]
    low, high = map(float, surface.strains)
    cell = (high - low) / columns
    lowest, top = tables.pressures
    numbers = {
        "line": float(surface.root_step) ** 2,
        "top": top,
        "lowest_pressure_real": lowest,
        "highest_real": top * (1 + EDGE[precision]),
        "low_real": low,
        "high_real": high,
        "cell": cell,
        "cell_length": cell * float(surface.rest_length),
        "meets": tables.meets,
    }
    values = {
        **tables.limits_as_text,
        **{key: number(kind(value)) for key, value in numbers.items()},
        "version": __version__,
        "name": name,
        "real": real,
        "errors": tables.errors.replace("\n", "\n * "),
        "lines": lines,
        "columns": columns,
        "halvings": halvings,
        "nodes": fill(", ".join(map(number, kind(nodes(surface)).ravel())), 100),
    }
    return render_template("function_block.st", values)
