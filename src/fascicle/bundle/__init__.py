"""Motor units, bundles, their recruitment and the reversal of their free strain.

Names are imported on first use, so that the command line's help loads no NumPy.
"""

from typing import TYPE_CHECKING

from ..core.lazy import attach_lazy


if TYPE_CHECKING:
    from . import energetics as energetics
    from . import recruitment as recruitment
    from . import reversal as reversal
    from . import schemes as schemes
    from .bundle import Bundle as Bundle
    from .bundle import MotorUnit as MotorUnit
    from .equilibria import Equilibria as Equilibria

__all__ = ["Bundle", "Equilibria", "MotorUnit", "energetics", "recruitment", "reversal", "schemes"]

_HOMES = {"Bundle": "bundle", "Equilibria": "equilibria", "MotorUnit": "bundle"}
_HOMES |= dict.fromkeys(("energetics", "recruitment", "reversal", "schemes"), "")

__getattr__, __dir__ = attach_lazy(__name__, _HOMES)
