r"""Where the fluid comes from: what a supply tells of itself.

A supply has a state, its numbers on the last axis, and a gauge pressure and a temperature that
follow from it. A kilogram of gas at $p_s$, as warm as the room, has the exergy
$R T_a \ln(p_s/p_a)$ (`Gas.flow_exergy`), one of liquid the energy $h(P_s)$ (`Liquid.flow_energy`).
"""

import abc
from typing import Any

import numpy as np

from ..core.errors import InvalidInputError
from ..core.module import Module, record
from ..core.types import Batch, BatchLike, BoolBatch, Numbers, Values
from ..core.validation import Range, check_plausible, check_positive, is_concrete


_PRESSURE = Range("Pa", 1.0, 1e3, 1e8, 1e9)


class AbstractSupply(Module):
    """A supply with a state."""

    @property
    @abc.abstractmethod
    def names(self) -> tuple[str, ...]:
        """Of its state's numbers [-]."""

    @property
    @abc.abstractmethod
    def units(self) -> tuple[str, ...]:
        """Theirs [-]."""

    @property
    def count(self) -> int:
        """How many they are [-]."""
        return len(self.names)

    @abc.abstractmethod
    def start(self) -> Numbers:
        """The state [SI] that it begins with."""

    @abc.abstractmethod
    def pressure_at(self, state: Numbers) -> Batch:
        """Gauge pressure [Pa] in a `state` [SI]."""

    @abc.abstractmethod
    def temperature_at(self, state: Numbers) -> Batch:
        """Temperature [K] in a `state` [SI]."""

    @abc.abstractmethod
    def rates(self, state: Numbers, mass_in: BatchLike, energy_in: BatchLike) -> Numbers:
        """How the state changes [SI], from `state` [SI], where `mass_in` [kg/s] and its enthalpy
        `energy_in` [W] flow in; drawn from, both are negative.
        """

    def switched(self, state: Numbers) -> Numbers:
        """A `state` [SI] with what switches at once in it set [SI]; the same where nothing does."""
        return state

    def spent(self, state: Numbers) -> dict[str, Batch]:
        """What driving it took and lost [J] up to a `state` [SI], by name; nothing where it isn't
        driven.
        """
        del state
        return {}

    @abc.abstractmethod
    def stored(self, state: Numbers) -> Batch:
        """What a `state` [SI] keeps [J]: exergy of a gas, energy of a liquid."""

    @abc.abstractmethod
    def empty(self, state: Numbers) -> BoolBatch:
        """Whether it has nothing left to give in a `state` [SI]: yes or no [-]."""


def supply_pressure() -> Any:
    """The field [-] of a supply's gauge pressure [Pa], above the room's."""

    def checked(value: Values) -> Batch:
        if is_concrete(value):
            p = np.asarray(value)
            if p.dtype.kind in "fiu" and np.any(p <= 0):
                bad = float(np.min(p))
                rule = "must lie above the room's, which is 0 Pa gauge"
                raise InvalidInputError("pressure", rule, bad, "raise it", shown=f"{bad:g} Pa")
        return check_plausible(check_positive(value, "pressure", "Pa"), "pressure", _PRESSURE)

    return record(converter=checked)
