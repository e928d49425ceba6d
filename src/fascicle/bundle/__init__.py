"""Motor units, bundles, their recruitment and the reversal of their free strain."""

from . import recruitment as recruitment
from . import reversal as reversal
from .bundle import Bundle as Bundle
from .bundle import Equilibria as Equilibria
from .bundle import MotorUnit as MotorUnit
