"""Hyperelastic bladder materials, and named ones."""

from .material_law import AbstractMaterial as AbstractMaterial
from .material_law import Slopes as Slopes
from .mooney_rivlin import MooneyRivlin as MooneyRivlin
from .rubbers import LATEX as LATEX
from .rubbers import MATERIALS as MATERIALS
from .rubbers import SILICONE_KIM2021 as SILICONE_KIM2021
