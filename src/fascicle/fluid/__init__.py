"""Gases and liquids, valves, chambers and supplies.

All are modules whose numbers are fields, so that they are differentiated and batched; laws are
elementwise, of NumPy or JAX. Pressures are gauge pressures save where a name says `absolute`.
"""

from .accumulator import Accumulator as Accumulator
from .accumulator import PumpedAccumulator as PumpedAccumulator
from .chamber import AbstractChamber as AbstractChamber
from .chamber import AdiabaticWall as AdiabaticWall
from .chamber import Isothermal as Isothermal
from .chamber import LiquidChamber as LiquidChamber
from .chamber import StateResidual as StateResidual
from .data_sheets import CatalogValve as CatalogValve
from .data_sheets import catalog_valves as catalog_valves
from .data_sheets import conductance_from_cv as conductance_from_cv
from .data_sheets import conductance_from_kv as conductance_from_kv
from .data_sheets import conductance_from_nominal_flow as conductance_from_nominal_flow
from .flow_elements import Line as Line
from .flow_elements import Orifice as Orifice
from .flow_elements import SonicValve as SonicValve
from .media import AIR as AIR
from .media import NITROGEN as NITROGEN
from .media import OIL as OIL
from .media import WATER as WATER
from .media import Gas as Gas
from .media import Liquid as Liquid
from .pumps import FixedPump as FixedPump
from .spools import AbstractSpool as AbstractSpool
from .spools import Direct as Direct
from .spools import Openings as Openings
from .spools import Servovalve as Servovalve
from .spools import Solenoid as Solenoid
from .spools import validate_commands as validate_commands
from .supply import AbstractSupply as AbstractSupply
from .supply import ConstantSupply as ConstantSupply
from .supply import Tank as Tank
