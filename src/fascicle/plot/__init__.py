"""Figures in one style; functions take arrays and laws, and return matplotlib figures."""

from .curves import bundle_force_strain as bundle_force_strain
from .curves import force_strain as force_strain
from .curves import free_strain as free_strain
from .shapes import shapes as shapes
from .theme import to_bytes as to_bytes
