"""Muscles, bundles and a controller's step for other programs: C without dependencies, from the
laws themselves or as a table of them.
"""

from typing import TYPE_CHECKING

from ..core.lazy import attach_lazy


if TYPE_CHECKING:
    from .c_source import c_code as c_code
    from .c_source import write_c as write_c
    from .c_table import table_code as table_code
    from .c_table import tabulated as tabulated
    from .c_table import write_table as write_table
    from .controlling import on_table as on_table
    from .fmu import write_fmu as write_fmu


# a controller's step and tables need JAX, which the law as C does without
_HOMES = {
    "c_code": "c_source",
    "on_table": "controlling",
    "table_code": "c_table",
    "tabulated": "c_table",
    "write_c": "c_source",
    "write_fmu": "fmu",
    "write_table": "c_table",
}

__getattr__, __dir__ = attach_lazy(__name__, _HOMES)
