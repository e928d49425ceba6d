"""The bundle in time: chambers that fill, a load that moves, and where every joule went.

`Plant` joins a bundle to its chambers, valves, supply and load; `rest` is where it stands still,
`simulate` moves it in fixed steps with a controller, `integrate` with adaptive ones, and `audit`
says where the energy went.

Importing it sets an option of XLA's in `XLA_FLAGS`, unless you have set it, with which fixed steps
are ten times as fast on a CPU. XLA reads that when it first compiles: import this before.
"""

# ruff: noqa: E402, I001 the option comes before all that imports JAX
from ..core.jax_settings import enable_whole_loops

enable_whole_loops()

from .audit import Audit as Audit
from .audit import Balance as Balance
from .audit import Event as Event
from .audit import audit as audit
from .audit import events as events
from .hysteresis import AbstractHysteresis as AbstractHysteresis
from .hysteresis import Coulomb as Coulomb
from .hysteresis import Dahl as Dahl
from .hysteresis import MaxwellSlip as MaxwellSlip
from .integrate import integrate as integrate
from .loads import AbstractLoad as AbstractLoad
from .loads import AntagonisticJoint as AntagonisticJoint
from .loads import HangingMass as HangingMass
from .loads import InertiaSpringDamper as InertiaSpringDamper
from .loads import PrescribedMotion as PrescribedMotion
from .loads import Stop as Stop
from .pace import Pace as Pace
from .pace import pace as pace
from .plant import Plant as Plant
from .rest import rest as rest
from .schedule import Measurement as Measurement
from .schedule import Schedule as Schedule
from .seen import Seen as Seen
from .simulate import Trajectory as Trajectory
from .simulate import simulate as simulate
from .state import State as State
