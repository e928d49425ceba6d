"""Gases and liquids, valves, chambers and supplies: what fills a muscle.

All are modules whose numbers are fields, so that they are differentiated and batched; laws are
elementwise, of NumPy or JAX. Pressures are gauge pressures save where a name says `absolute`.
"""

from .accumulator import Accumulator as Accumulator
from .adiabatic_wall import AdiabaticWall as AdiabaticWall
from .chamber import AbstractChamber as AbstractChamber
from .chamber import Balance as Balance
from .constant_supply import ConstantSupply as ConstantSupply
from .isothermal import Isothermal as Isothermal
from .line import Line as Line
from .liquid_chamber import LiquidChamber as LiquidChamber
from .media import AIR as AIR
from .media import NITROGEN as NITROGEN
from .media import OIL as OIL
from .media import WATER as WATER
from .media import Gas as Gas
from .media import Liquid as Liquid
from .orifice import Orifice as Orifice
from .polytropic import Polytropic as Polytropic
from .pumped import PumpedAccumulator as PumpedAccumulator
from .pumps import FixedPump as FixedPump
from .pumps import PressureBand as PressureBand
from .pumps import Relief as Relief
from .pumps import VariablePump as VariablePump
from .sonic_valve import SonicValve as SonicValve
from .spools import AbstractSpool as AbstractSpool
from .spools import Direct as Direct
from .spools import Openings as Openings
from .spools import OrderlyValve as OrderlyValve
from .spools import Servovalve as Servovalve
from .spools import checked_commands as checked_commands
from .supply import AbstractSupply as AbstractSupply
from .tank import Tank as Tank
