r"""A muscle or a bundle as C: one header and one source without dependencies, C99.

The laws are evaluated on symbols, and CasADi writes the resulting expressions: the force with its
slopes, free strain, onset and collapse strain, all roots included, as straight code of known
length. No memory is allocated. The templates in `c` add the names, the checks of the domain, the
sum over motor units, and the searches: of a bundle's free strain between its kinks, and of the
pressures for a force.
"""

import os
from pathlib import Path
from typing import Any

from .. import __version__
from ..bundle import Bundle
from ..bundle.force_curves import ROOT_TOLERANCE, pressure_grid
from ..bundle.pressurized import plate_strain
from ..core.errors import InvalidInputError
from ..core.module import unique_indices
from ..core.validation import HIGHEST_PRESSURE, LARGEST_STRAIN
from ..muscle import Muscle
from ..muscle.validation import lowest_strain
from .c_files import (
    as_bundle,
    c_array,
    check_c_name,
    length_ratios,
    render_template,
    write_c_files,
)
from .inverse import inverse_code


_AGREEMENT = "Both search with the same nodes of pressure, kinks and extrema."
_KINKS = 24  # for which C has room: over pressure a kind of muscle has four or so
_LOCALS = 224  # doubles on the stack besides CasADi's work, of all functions that call one another
_LIMITS = 10  # doubles on the stack for each unit and kind of muscle: least and largest forces


def c_code(target: Muscle | Bundle, name: str = "muscle") -> tuple[str, str]:
    """Header and source of a muscle or bundle in C.

    **Arguments:**

    - `target`: the muscle or bundle, with numbers, not arrays.
    - `name`: prefix of all names in C.

    **Returns:** the text of the header, and that of the source.

    **Raises:** `ValueError` for a name that C doesn't allow, and for anything but one muscle or
    bundle; `ModuleNotFoundError` if CasADi is missing.
    """
    check_c_name(name)
    bundle = as_bundle(target)
    muscles = [unit.muscle for unit in bundle.motor_units]
    for muscle in muscles:
        if not muscle.buckling.symbolic:
            rule = "can't be written in C"
            remedy = "write its table (--table, `table_code`), or take elastica or kim2021"
            raise InvalidInputError("buckling", rule, muscle.buckling.name, remedy)
    terms, kinds = unique_indices(muscles)
    laws, work = _law_values([muscles[i] for i in terms], name)
    ratios = length_ratios(bundle)
    lowest = max(
        plate_strain(ratio, float(lowest_strain(muscle.law)))
        for muscle, ratio in zip(muscles, ratios, strict=True)
    )
    largest = min(plate_strain(ratio, LARGEST_STRAIN) for ratio in ratios)
    case = "    case {0}: {1}_law{0}(arg, res, NULL, NULL, 0); break;"
    values = {
        "title": "A bundle of muscles" if isinstance(target, Bundle) else "A muscle",
        "version": __version__,
        "name": name,
        "guard": name.upper(),
        "units": len(muscles),
        "unit_kinds": c_array(kinds),
        "kind_count": len(terms),
        "counts": c_array(int(unit.count) for unit in bundle.motor_units),
        "ratios": c_array(ratios),
        "cases": "\n".join(case.format(i, name) for i in range(len(terms))),
        "lowest": repr(lowest),
        "low": f"{lowest:.6f}",
        "largest": repr(largest),
        "high": f"{largest:.6f}",
        "highest": repr(HIGHEST_PRESSURE),
        "top": f"{HIGHEST_PRESSURE:g}",
        "laws": laws,
    }
    kind = "bundle" if isinstance(target, Bundle) else "muscle"
    pressure_argument = "pressure" if kind == "bundle" else "pressure[0]"
    values |= _inverse_values(bundle, [muscles[i] for i in terms], name, pressure_argument)
    doubles = work + 4 * len(muscles) + len(terms) * (2 * values["nodes"] + 2 * _KINKS)
    doubles += _LOCALS + _LIMITS * (len(terms) + len(muscles))
    values["stack"] = f"{doubles * 8 / 1024:.1f}"
    values["curves"] = render_template("law_curves.c", values)
    values["declarations"] = render_template(f"{kind}_law.h", values)
    values["functions"] = render_template(f"{kind}_law.c", values)
    return render_template("law.h", values), render_template("law.c", values)


def write_c(
    target: Muscle | Bundle, folder: str | os.PathLike[str], name: str = "muscle"
) -> tuple[Path, Path]:
    """Write `NAME.h` and `NAME.c` into a folder.

    **Arguments:**

    - `target`: the muscle or bundle.
    - `folder`: the folder; it is created if it is missing.
    - `name`: prefix of files and of names in C.

    **Returns:** the paths of header and source.

    **Raises:** as `c_code`.
    """
    return write_c_files(c_code(target, name), folder, name)


def _inverse_values(
    bundle: Bundle, muscles: list[Muscle], name: str, pressure_argument: str
) -> dict[str, Any]:
    """Values of the templates for the inverse of a bundle with these different `muscles`."""
    supply = bundle.supply_pressure
    top = HIGHEST_PRESSURE if supply is None else float(supply)
    pressures = (pressure_grid(muscles, top) * top).tolist()
    values = inverse_code(
        bundle, name, top, ROOT_TOLERANCE, _AGREEMENT, pressure_argument=pressure_argument
    )
    return values | {
        "nodes": len(pressures),
        "node_pressures": c_array(pressures),
        "kinks": _KINKS,
    }


def _law_values(muscles: list[Muscle], name: str) -> tuple[str, int]:
    """Laws of different muscles as C, and the number of doubles that they need on the stack."""
    try:
        import casadi as ca
    except ModuleNotFoundError:
        raise ModuleNotFoundError(
            "C code needs CasADi: `pip install 'fascicle[export]'`."
        ) from None
    from .symbols import symbols

    code, work = ca.CodeGenerator(f"{name}.c", {"with_header": False}), 0
    for i, muscle in enumerate(muscles):
        functions: Any = symbols()
        P, eps = ca.SX.sym("P"), ca.SX.sym("eps")
        law = muscle.law.at(P)
        force, by_strain = law.force(eps)
        kinks = (law.column.free_strain, law.law.buckling.onset(law.column), law.collapse_strain)
        expressions = functions.resolve(force, ca.jacobian(force, P), by_strain, *map(ca.SX, kinks))
        function = ca.Function(f"{name}_law{i}", [P, eps], expressions)
        code.add(function)
        work = max(work, int(function.sz_w()))
    return code.dump(), work
