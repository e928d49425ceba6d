r"""Chambers: fluid in a volume that moves.

No motion of the wall changes the state at once, whose numbers are on the last axis: mass, and
energy if heat takes its time. The pressure follows from it and the volume by an equation of state,
of which a chamber gives the residual and its slopes in closed form, so that it can be solved
together with a muscle's volume, which depends on the pressure:

$$g(s, P, V(P)) = 0, \qquad
  \frac{\mathrm{d}g}{\mathrm{d}P} = g_P + g_V \frac{\mathrm{d}V}{\mathrm{d}P} > 0. \tag{F12}$$

The residual rises with pressure and with volume. The rates of the state are affine in that of the
volume, so that a volume that moves with the pressure can be brought to the other side.
"""

import abc
from typing import Any, ClassVar, NamedTuple

from ..core.array_namespace import array_namespace
from ..core.module import Module
from ..core.types import Batch, BatchLike, Numbers
from ..core.validation import Range
from .fields import nonnegative_field, room_pressure_field, temperature_field


_DEAD = Range("m³", 0.0, 0.0, 1e-2, 1e3)  # usual hoses and fittings hold less than 10 L


class StateResidual(NamedTuple):
    """Residual of a chamber's equation of state (F12): its `value`, and its slopes `by_state` (on
    the last axis), `by_pressure` and `by_volume`; in J, or in kg for a liquid [SI].
    """

    value: Batch
    by_state: Numbers
    by_pressure: Batch
    by_volume: Batch


class AbstractChamber(Module):
    """Chamber of fluid in a volume that moves; its fields here are given by keyword.

    - `dead_volume`: of hose and fittings, in addition to the volume of each method [m³].
    - `room_pressure`: absolute [Pa]. `room_temperature`: of room and wall [K].
    - `names`, `units`: of the state variables, and `count`, their number.
    - `gas` of a gas, `liquid` of a liquid.
    """

    names: ClassVar[tuple[str, ...]]
    units: ClassVar[tuple[str, ...]]
    gas: ClassVar[Any]
    liquid: ClassVar[Any]

    dead_volume: Batch = nonnegative_field(
        "dead_volume", _DEAD, "leave it out if there is none", default=0.0, kw_only=True
    )
    room_pressure: Batch = room_pressure_field(kw_only=True)
    room_temperature: Batch = temperature_field(kw_only=True)

    @property
    def count(self) -> int:
        """Number of state variables."""
        return len(self.names)

    @property
    @abc.abstractmethod
    def lowest_pressure(self) -> Batch:
        """Gauge pressure [Pa] at which there is no gas, or a liquid boils."""

    @abc.abstractmethod
    def state_at(self, pressure: BatchLike, volume: BatchLike) -> Numbers:
        """State [SI] at gauge `pressure` [Pa] and `volume` [m³], as warm as the room."""

    @abc.abstractmethod
    def temperature(self, state: Numbers, pressure: BatchLike) -> Batch:
        """Temperature [K] of a `state` [SI] at gauge `pressure` [Pa]."""

    @abc.abstractmethod
    def state_residual(
        self, state: Numbers, pressure: BatchLike, volume: BatchLike
    ) -> StateResidual:
        """Residual of the equation of state (F12) and its slopes [SI] for a `state` [SI] at gauge
        `pressure` [Pa] in a `volume` [m³].
        """

    @abc.abstractmethod
    def static_pressure(self, state: Numbers, volume: BatchLike) -> Batch:
        """Gauge pressure [Pa] of a `state` [SI] in a `volume` [m³] that doesn't move."""

    @abc.abstractmethod
    def rates(
        self, state: Numbers, pressure: Batch, mass_in: Batch, energy_in: Batch, volume_rate: Batch
    ) -> Numbers:
        """Rates of the state variables with an inflow, as the volume changes.

        **Arguments:**

        - `state`: the state [SI].
        - `pressure`: its gauge pressure [Pa].
        - `mass_in`: mass flow into the chamber [kg/s].
        - `energy_in`: its enthalpy flow, a gas's $c_p T$ from upstream [W].
        - `volume_rate`: of the volume [m³/s].

        **Returns:** rates [SI] on the last axis, affine in `volume_rate`.
        """

    @abc.abstractmethod
    def per_volume_rate(self, state: Numbers, pressure: BatchLike) -> Numbers:
        """Slope [SI] of a `state`'s rates [SI] at gauge `pressure` [Pa] by the rate of volume."""

    @abc.abstractmethod
    def heat_flow(
        self, state: Numbers, pressure: Batch, mass_in: Batch, energy_in: Batch, volume_rate: Batch
    ) -> Batch:
        """Heat flow out through the wall [W]; arguments [SI] as of `rates`."""

    @abc.abstractmethod
    def stored_energy(self, state: Numbers, pressure: BatchLike) -> Batch:
        """Stored energy [J] of a `state` [SI] at gauge `pressure` [Pa]: a gas's exergy, a liquid's
        energy with that of its compliance.
        """


class AbstractMassChamber(AbstractChamber):
    """A chamber whose state is the mass in it alone."""

    names: ClassVar[tuple[str, ...]] = ("mass",)
    units: ClassVar[tuple[str, ...]] = ("kg",)

    def rates(
        self, state: Numbers, pressure: Batch, mass_in: Batch, energy_in: Batch, volume_rate: Batch
    ) -> Numbers:
        """Rate of the mass [kg/s] on the last axis: `mass_in` [kg/s]; other arguments [SI], as of
        `AbstractChamber.rates`, don't count.
        """
        del pressure, energy_in, volume_rate
        return stack_last(mass_in + 0.0 * state[..., 0])

    def per_volume_rate(self, state: Numbers, pressure: BatchLike) -> Numbers:
        """Zero [kg/m³] for any `state` [SI] and `pressure` [Pa]."""
        return stack_last(0.0 * (state[..., 0] + pressure))


def stack_last(*numbers: BatchLike) -> Numbers:
    """Several `numbers` [SI], broadcast, on a new last axis [SI]."""
    xp = array_namespace(*numbers)
    return xp.stack(xp.broadcast_arrays(*numbers), axis=-1)
