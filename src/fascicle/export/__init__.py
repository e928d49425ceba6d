"""Muscles and bundles as C: headers and sources without dependencies, from the laws themselves."""

from .c_code import c_code as c_code
from .c_code import write_c as write_c
