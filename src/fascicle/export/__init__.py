"""Muscles, bundles and controllers for other programs: their table as C without dependencies or in
Structured Text, units for co-simulation, and a web page.
"""

from typing import TYPE_CHECKING

from ..core.lazy import attach_lazy


if TYPE_CHECKING:
    from .c_table import table_code as table_code
    from .c_table import tabulate as tabulate
    from .c_table import write_table as write_table
    from .controller import tabulate_controller as tabulate_controller
    from .fmu import write_fmu as write_fmu
    from .opensim import opensim_element as opensim_element
    from .page import page_text as page_text
    from .page import write_page as write_page
    from .plant import write_plant_fmu as write_plant_fmu
    from .structured_text import function_block as function_block


_HOMES = dict.fromkeys(("table_code", "tabulate", "write_table"), "c_table")
_HOMES |= {"opensim_element": "opensim", "page_text": "page", "write_page": "page"}
_HOMES |= {"tabulate_controller": "controller", "write_fmu": "fmu"}
_HOMES |= {"write_plant_fmu": "plant", "function_block": "structured_text"}

__getattr__, __dir__ = attach_lazy(__name__, _HOMES)
