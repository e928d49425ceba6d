r"""A pump that keeps an accumulator charged, and what that costs.

$$\dot m_{acc} = \dot m_{pump}(P) - \dot m_{relief}(P) - \dot m_{drawn}, \tag{F23}$$

the pump driven, and wasting, as (F20) says, the relief valve as (F22). A fixed pump is switched by
a pressure band, looked at after each step; a variable one swivels by itself. Energies are
integrated beside the mass, so that what the shaft does is what the bundle is given, what is stored,
and what is lost.
"""

from typing import ClassVar

import numpy as np

from ..core.array_namespace import array_namespace
from ..core.errors import InvalidInputError
from ..core.types import Batch, BatchLike, BoolBatch, Numbers
from ..core.validation import is_concrete
from .accumulator import Accumulator
from .chamber import row
from .entry import part
from .pumps import FixedPump, PressureBand, Relief, VariablePump
from .supply import AbstractSupply


class PumpedAccumulator(AbstractSupply):
    """An accumulator with a pump, equation (F23).

    `accumulator`: with the pressure that it begins with [-]. `pump` [-]. `band`: between which
    pressures a fixed pump is switched [-]; left out, it always runs. `relief`: a valve to the
    reservoir [-], or none.
    """

    source: ClassVar[str] = "Merritt (1967)"

    accumulator: Accumulator = part("accumulator", (Accumulator,))
    pump: FixedPump | VariablePump = part("pump", (FixedPump, VariablePump))
    band: PressureBand | None = part("band", (PressureBand,), default=None)
    relief: Relief | None = part("relief", (Relief,), default=None)

    def __check_init__(self):
        if self.band is not None and isinstance(self.pump, VariablePump):
            why = "must be left out with a VariablePump, which swivels by itself"
            raise InvalidInputError("band", why, self.band, shown="one")
        one, other = self.pump.liquid, self.accumulator.liquid
        pairs = ((one.bulk_modulus, other.bulk_modulus),
                 (one.reference_density, other.reference_density))  # fmt: skip
        if any(is_concrete(a, b) and np.any(np.asarray(a) != np.asarray(b)) for a, b in pairs):
            raise InvalidInputError(
                "pump", "must be for the accumulator's liquid", one, shown="another"
            )

    @property
    def names(self) -> tuple[str, ...]:
        """Mass, whether the pump is on, and energies since the beginning [-]."""
        return ("mass", "pump_on", "shaft_work", "pump_lost", "relief_lost")

    @property
    def units(self) -> tuple[str, ...]:
        """Theirs [-]."""
        return ("kg", "1", "J", "J", "J")

    def start(self) -> Numbers:
        """At the accumulator's pressure, the pump as its band has it, nothing spent yet [SI]."""
        P = self.accumulator.pressure
        on = 1.0 if self.band is None else self.band.start(P)
        none = 0.0 * P
        return row(self.accumulator.start()[..., 0], on + none, none, none, none)

    def pressure_at(self, state: Numbers) -> Batch:
        """Gauge pressure [Pa] in a `state` [SI]."""
        return self.accumulator.pressure_at(state)

    def temperature_at(self, state: Numbers) -> Batch:
        """The room's [K], in any `state` [SI]."""
        return self.accumulator.temperature_at(state)

    def rates(self, state: Numbers, mass_in: BatchLike, energy_in: BatchLike) -> Numbers:
        """Equation (F23) [SI] for a `state` [SI] where `mass_in` [kg/s] flows in from the bundle,
        negative where it is drawn; `energy_in` [W] doesn't count.
        """
        del energy_in
        P = self.pressure_at(state)
        known = (P, state[..., 1]) if isinstance(self.pump, FixedPump) else (P,)
        flow, shaft = self.pump.flow(*known), self.pump.shaft_power(*known)
        lost = self.pump.lost_power(*known)
        out = wasted = 0.0 * P
        if self.relief is not None:
            out = self.relief.flow(P)
            wasted = self.relief.lost_power(P, self.accumulator.liquid)
        return row(mass_in + flow - out, 0.0 * P, shaft, lost, wasted)

    def switched(self, state: Numbers) -> Numbers:
        """A `state` [SI] with its pump switched by the band [SI]."""
        if self.band is None:
            return state
        on = self.band.after(state[..., 1], self.pressure_at(state))
        at_work = array_namespace(state, on)
        return at_work.concatenate([state[..., :1], on[..., None], state[..., 2:]], axis=-1)

    def stored(self, state: Numbers) -> Batch:
        """Energy [J] of a `state` [SI] in the accumulator."""
        return self.accumulator.stored(state)

    def spent(self, state: Numbers) -> dict[str, Batch]:
        """Energies [J] since the beginning of a `state` [SI], by name."""
        return dict(zip(self.names[2:], (state[..., k] for k in (2, 3, 4)), strict=True))

    def empty(self, state: Numbers) -> BoolBatch:
        """Whether a `state` [SI] has no liquid left: yes or no [-]."""
        return self.accumulator.empty(state)
