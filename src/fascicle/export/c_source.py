r"""A muscle or a bundle as C: one header and one source without dependencies, C99.

The laws are evaluated on symbols, and CasADi writes what they come to: the force with its
slopes, free strain, onset and collapse strain, all roots included, as straight code of known
length. No memory is allocated. What is added here are the names, the checks of the domain, the
sum over motor units, and the search for a bundle's free strain between its kinks.
"""

from pathlib import Path
from typing import Any

from ..bundle import Bundle
from ..bundle.pressurized import unique_indices
from ..core.errors import InvalidInputError
from ..core.types import Values
from ..core.validation import HIGHEST_PRESSURE, LARGEST_STRAIN
from ..muscle import Muscle
from ..muscle.validation import lowest_strain, strain_domain
from .c_files import checked_bundle, checked_name, write_c_files
from .template import header, source


def c_code(target: Muscle | Bundle, name: str = "muscle") -> tuple[str, str]:
    """Header and source of a muscle or bundle in C.

    **Arguments:**

    - `target`: the muscle or bundle [-], with numbers, not arrays.
    - `name`: with which all names in C begin [-].

    **Returns:** the header's text and the source's [-].

    **Raises:** `ValueError` for a name that C can't have and for what isn't one muscle or bundle;
    `ModuleNotFoundError` where CasADi is missing.
    """
    checked_name(name)
    bundle = checked_bundle(target)
    units = bundle.motor_units
    muscles = [unit.muscle for unit in units]
    for muscle in muscles:
        if not muscle.buckling.symbolic:
            rule = "can't be written in C"
            remedy = "write its table (--table, `table_code`), or take elastica or kim2021"
            raise InvalidInputError("buckling", rule, muscle.buckling.name, remedy)
    terms, kinds = unique_indices(muscles)
    written, room = _laws([muscles[i] for i in terms], name)
    ratios = [1.0] * len(muscles)
    if bundle.ratios is not None:
        ratios = [float(ratio) for ratio in bundle.ratios]
    numbers = {
        "name": name,
        "guard": name.upper(),
        "units": len(muscles),
        "kinds": kinds,
        "counts": [int(unit.count) for unit in units],
        "ratios": ratios,
        "lowest": max(
            1 - (1 - float(lowest_strain(*strain_domain(muscle)))) / ratio
            for muscle, ratio in zip(muscles, ratios, strict=True)
        ),
        "largest": min(1 - (1 - LARGEST_STRAIN) / r for r in ratios),
        "highest": HIGHEST_PRESSURE,
        "room": room,
        "laws": written,
        "bundle": isinstance(target, Bundle),
    }  # fmt: skip
    return header(numbers), source(numbers)


def write_c(target: Muscle | Bundle, folder: Values, name: str = "muscle") -> tuple[Path, Path]:
    """Write `NAME.h` and `NAME.c` into a folder.

    **Arguments:**

    - `target`: the muscle or bundle [-].
    - `folder`: where to [-]; made where it isn't.
    - `name`: with which files and names in C begin [-].

    **Returns:** the paths of header and source [-].

    **Raises:** as `c_code`.
    """
    return write_c_files(c_code(target, name), folder, name)


def _laws(muscles: list[Muscle], name: str) -> tuple[str, int]:
    """The laws of unlike muscles as C, and how many doubles of stack they need [-]."""
    try:
        import casadi as ca
    except ModuleNotFoundError:
        raise ModuleNotFoundError(
            "C code needs CasADi: `pip install 'fascicle[export]'`."
        ) from None
    from .symbols import symbols

    code = ca.CodeGenerator(f"{name}.c", {"with_header": False})
    functions = [_law(ca, symbols(), muscle, f"{name}_law{i}") for i, muscle in enumerate(muscles)]
    for function in functions:
        code.add(function)
    return code.dump(), max(int(function.sz_w()) for function in functions)


def _law(ca: Any, functions: Any, muscle: Muscle, name: str) -> Any:
    """Force, its slopes and the kinks as a function of pressure and strain."""
    P, eps = ca.SX.sym("P"), ca.SX.sym("eps")
    at = muscle.law.at(P)
    F, by_strain = at.force(eps)
    kinks = (at.column.free_strain, at.law.buckling.onset(at.column), at.collapse)
    expressions = functions.resolved(F, ca.jacobian(F, P), by_strain, *map(ca.SX, kinks))
    return ca.Function(name, [P, eps], expressions)
