"""Dynamics of a bundle: chambers that fill, a load that moves, and the energy balance.

`Plant` joins a bundle to its chambers, valves, supply and load. `equilibrium_state` is its state at
rest, `simulate` moves it in fixed steps with a controller, `integrate` in adaptive steps, and
`audit` returns the energy balance of a run.

Importing this package imports `fascicle.jax`, which sets an option of XLA: with it fixed steps are
ten times as fast on a CPU. XLA reads it when it first compiles, so import this package before you
compile anything.
"""

from ..jax import jax as _jax  # noqa: F401 64 bits, pytrees and XLA's option
from ..muscle.hysteresis import AbstractHysteresis as AbstractHysteresis
from ..muscle.hysteresis import Coulomb as Coulomb
from ..muscle.hysteresis import Dahl as Dahl
from ..muscle.hysteresis import Damping as Damping
from ..muscle.hysteresis import MaxwellSlip as MaxwellSlip
from .audit import Audit as Audit
from .audit import Balance as Balance
from .audit import Event as Event
from .audit import audit as audit
from .audit import events as events
from .equilibrium import equilibrium_state as equilibrium_state
from .equilibrium import holding_pressures as holding_pressures
from .integrate import integrate as integrate
from .linearize import LinearModel as LinearModel
from .linearize import linearize as linearize
from .loads import AbstractLoad as AbstractLoad
from .loads import AntagonisticJoint as AntagonisticJoint
from .loads import HangingMass as HangingMass
from .loads import InertiaSpringDamper as InertiaSpringDamper
from .loads import PrescribedMotion as PrescribedMotion
from .loads import Stop as Stop
from .motion import State as State
from .outputs import PlantOutputs as PlantOutputs
from .plant import Plant as Plant
from .simulate import Measurement as Measurement
from .simulate import Schedule as Schedule
from .simulate import StepSizeEstimate as StepSizeEstimate
from .simulate import Trajectory as Trajectory
from .simulate import estimate_substeps as estimate_substeps
from .simulate import simulate as simulate
