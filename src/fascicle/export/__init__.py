"""Muscles, bundles and a controller's step for other programs: C without dependencies, from the
laws themselves or as a table of them.
"""

from .c_code import c_code as c_code
from .c_code import write_c as write_c
from .controlling import on_table as on_table
from .fmu import write_fmu as write_fmu
from .table_code import table_code as table_code
from .table_code import tabulated as tabulated
from .table_code import write_table as write_table
