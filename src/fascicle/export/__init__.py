"""Muscles, bundles and a controller's step for other programs: C without dependencies, from the
laws themselves or as a table of them.
"""

from typing import TYPE_CHECKING, Any

from .c_code import c_code as c_code
from .c_code import write_c as write_c
from .table_code import table_code as table_code
from .table_code import tabulated as tabulated
from .table_code import write_table as write_table


if TYPE_CHECKING:
    from .controlling import on_table as on_table
    from .fmu import write_fmu as write_fmu


def __getattr__(name: str) -> Any:
    # a controller's step needs JAX, which the others do without
    if name == "on_table":
        from .controlling import on_table

        return on_table
    if name == "write_fmu":
        from .fmu import write_fmu

        return write_fmu
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
