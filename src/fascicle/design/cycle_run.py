"""A run in time of a design with the valves of its sizing: a mass that hangs on the bundle.

The units that the load case feeds are joined to the supply until the mass is lifted by the demanded
stroke, then to the room. The mass weighs the demanded force and rests on a stop at no contraction.
Air stays at 20 °C, as in the sizing; the inertia of the mass is new, and may lift it a little
earlier or later. Needs JAX.
"""

from typing import Any, NamedTuple

import numpy as np

from ..bundle import Bundle
from ..core.array_namespace import maximum, where
from ..core.module import Module
from ..core.types import Batch, Numbers
from ..dynamics import HangingMass, Measurement, Plant, Stop, simulate
from ..dynamics.loads import GRAVITY
from ..fluid import ConstantSupply, Isothermal, SonicValve
from .cycle import ATMOSPHERE, ValveSizing


_STEPS = 1000  # of the cycle's time
_LONGER = 2  # times the cycle's time that is run: a slower design then has a number, too
_SAG = 0.01  # of the stroke, by which the load at rest presses the stop in
_DAMPER_DEPTH = 1e-3  # m, of (T2)
_LEFT = 0.05  # of the stroke, when the load counts as released: as in the sizing


class CycleRun(NamedTuple):
    """A run: times from the start at which the load is lifted by the demanded stroke, and from
    which on it is released [s], NaN if it never is; the `highest` position [m], and the demanded
    `stroke` [m].
    """

    lifted: float
    released: float
    highest: float
    stroke: float

    def passes(self, time: float) -> bool:
        """True if it was lifted and released within a `time` [s]."""
        return self.released <= time  # NaN isn't


class _LiftAndRelease(Module):
    """Controller: supply to the `filled` units until the stroke is reached, then the room."""

    stroke: Batch
    filled: Numbers

    @property
    def memory(self) -> Batch:
        """0 before the stroke is reached, 1 from then on."""
        return np.float64(0.0)

    def __call__(
        self, memory: Batch, measurement: Measurement, reference: Any
    ) -> tuple[Batch, Numbers]:
        """Next memory and a command for each unit [-]."""
        del reference
        memory = maximum(memory, where(measurement.position >= self.stroke, 1.0, 0.0))
        return memory, where(memory > 0, -1.0, self.filled)


def run_cycle(bundle: Bundle, force: float, stroke: float, sizing: ValveSizing) -> CycleRun:
    """Times at which a bundle has lifted and released a hanging mass [s], and its highest position
    [m], from a simulation of one contraction and release.

    **Arguments:**

    - `bundle`: with its supply pressure.
    - `force`: weight of the mass [N], positive.
    - `stroke`: contraction at which the release begins [m], positive.
    - `sizing`: valves and hoses, which must be feasible.

    **Returns:** the times and positions; NaN for a time that isn't reached.

    **Raises:** `ValueError` for a load that the bundle can't hold at rest.
    """
    C = np.where(sizing.conductance > 0, sizing.conductance, sizing.conductance.max())
    mass, stiffness = force / GRAVITY, force / (_SAG * stroke)
    # critical where the load sags to, so that it doesn't bounce: the damper acts by depth, (T2)
    damping = 2 * np.sqrt(stiffness * mass) * (1 + _DAMPER_DEPTH / (_SAG * stroke))
    stop = Stop(low=0.0, stiffness=stiffness, damping=damping)
    plant = Plant(
        bundle,
        HangingMass(mass, stop=stop),
        ConstantSupply(bundle.supply_pressure, room_pressure=ATMOSPHERE),
        Isothermal(dead_volume=sizing.hose_volume, room_pressure=ATMOSPHERE),
        SonicValve(C, sizing.cycle.b, line=sizing.line),
    )
    controller = _LiftAndRelease(np.float64(stroke), np.where(sizing.filled, 1.0, -1.0))
    reference = np.zeros((_LONGER * _STEPS, 1))
    run = simulate(plant, controller, reference, dt=sizing.cycle.time / _STEPS)
    position = np.asarray(run.outputs.position)
    arrivals = np.flatnonzero(position >= stroke)
    if not arrivals.size:
        return CycleRun(np.nan, np.nan, float(position.max()), stroke)
    first = int(arrivals[0])
    # a load that swings up again isn't released yet
    down = int(np.flatnonzero(position > _LEFT * stroke)[-1]) + 1
    released = float(run.time[down]) if down < len(position) else np.nan
    return CycleRun(float(run.time[first]), released, float(position.max()), stroke)
