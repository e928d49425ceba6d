r"""Spools: from a command to the openings of a valve.

A command $u$ lies in [-1, 1]: above zero supply and port are joined, below it port and exhaust.
A spool at $x$ uncovers

$$z_{supply} = \frac{(x - o)^+}{1 - o}, \qquad z_{exhaust} = \frac{(-x - o)^+}{1 - o},
  \tag{F9}$$

nothing as long as $|x|$ is within its overlap $o$. Its position is the command (`Direct`), or
follows it,

$$\dot x = \frac{u - x}{\tau}. \tag{F10}$$

The orderly recruitment valve has one spool for $N$ units, whose ports lie in a row. At $x = -1$ all
are vented; on its way to 1 it passes each in turn and leaves it joined to the supply:

$$x_i = N (1 + x) - 2 i - 1, \quad i = 0 \dots N - 1, \tag{F11}$$

is the position of the spool at port $i$, and (F9) of it, up to 1, the port's opening. One unit is
throttled at a time, the units before it are at the supply, those after it at the exhaust.

**Source:** Merritt (1967), Hydraulic Control Systems; the orderly valve after Vemula, Kim,
Mazzoleni and Bryant (2022), Bioinspiration & Biomimetics 17, from what its abstract says: the
ports' even spacing and linear openings are ours.
"""

import abc
from typing import ClassVar, NamedTuple

import numpy as np

from ..core.array_namespace import maximum, minimum
from ..core.errors import InvalidInputError
from ..core.module import Module, static
from ..core.types import Batch, Numbers, Values
from ..core.validation import Range, check_interval
from .fields import interval_field, positive_field


_TIME = Range("s", 1e-6, 1e-4, 1.0, 1e3)  # usual valves take 0.1 ms to 1 s


class Openings(NamedTuple):
    """Openings of each unit's valve [-] to `supply` and `exhaust`, units on the last axis."""

    supply: Batch
    exhaust: Batch


class AbstractSpool(Module):
    """Spools of valves: their motion by commands, and the ports they open; `overlap`: closed share
    of the travel [-], in [0, 1).
    """

    overlap: ClassVar[Batch]

    def command_count(self, units: int) -> int:
        """Number of commands for a number of `units`: one for each."""
        return units

    @abc.abstractmethod
    def state_count(self, units: int) -> int:
        """Number of spools with a state for a number of `units`."""

    @abc.abstractmethod
    def rate(self, command: Numbers, spool: Numbers) -> Numbers:
        """Rate [1/s] of the positions `spool` [-] under a `command` [-]."""

    @abc.abstractmethod
    def openings(self, command: Numbers, spool: Numbers) -> Openings:
        """Openings [-] at a `command` [-] and a position of the `spool` [-]."""

    def _port_openings(self, position: Numbers) -> Openings:
        """Openings [-], (F9), at a `position` of the spool [-]: to the supply if positive, else to
        the exhaust.
        """
        # at the edges a derivative is the mean of both sides', as differences have it
        supply, exhaust = (
            minimum(maximum(side - self.overlap, 0.0) / (1 - self.overlap), 1.0)
            for side in (position, -position)
        )
        return Openings(supply, exhaust)


class Direct(AbstractSpool):
    """A spool for each unit whose position is the command. `overlap`: $o$ [-], in [0, 1)."""

    source: ClassVar[str] = "Merritt (1967)"
    overlap: Batch = interval_field("overlap", 0.0, 1.0, closed=(True, False), default=0.0)

    def state_count(self, units: int) -> int:
        """Zero spools with a state, for any number of `units`."""
        return 0 * units

    def rate(self, command: Numbers, spool: Numbers) -> Numbers:
        """Empty rates [1/s]: the `spool` [-] has no state, at any `command` [-]."""
        return 0.0 * command[..., :0] + spool

    def openings(self, command: Numbers, spool: Numbers) -> Openings:
        """Openings [-], (F9), at the `command` [-]; the `spool` [-] doesn't count."""
        del spool
        return self._port_openings(command)


class Servovalve(AbstractSpool):
    """A spool for each unit that follows its command with a first-order lag, equation (F10).

    `time_constant`: $\\tau$ [s]. `overlap`: $o$ [-], in [0, 1).
    """

    source: ClassVar[str] = "Merritt (1967)"
    time_constant: Batch = positive_field("time_constant", _TIME)
    overlap: Batch = interval_field("overlap", 0.0, 1.0, closed=(True, False), default=0.0)

    def state_count(self, units: int) -> int:
        """One spool with a state for each of the `units`."""
        return units

    def rate(self, command: Numbers, spool: Numbers) -> Numbers:
        """Rate of the `spool` [1/s] towards its `command` [-], equation (F10)."""
        return (command - spool) / self.time_constant

    def openings(self, command: Numbers, spool: Numbers) -> Openings:
        """Openings [-], (F9), at the `spool` [-]; the `command` [-] doesn't count."""
        del command
        return self._port_openings(spool)


class OrderlyValve(AbstractSpool):
    """One spool for all units, equations (F10) and (F11).

    `units`: number of its ports. `time_constant`: $\\tau$ [s]. `overlap`: $o$ at each port
    [-], in [0, 1).
    """

    source: ClassVar[str] = "Vemula, Kim, Mazzoleni and Bryant (2022)"
    units: int = static()
    time_constant: Batch = positive_field("time_constant", _TIME)
    overlap: Batch = interval_field("overlap", 0.0, 1.0, closed=(True, False), default=0.0)

    def __check_init__(self):
        if isinstance(self.units, bool) or not isinstance(self.units, int) or self.units < 1:
            raise InvalidInputError("units", "must be a whole number of at least 1", self.units)

    def command_count(self, units: int) -> int:
        """One command for all of the `units`, whose number must be that of the ports."""
        if units != self.units:
            rule = f"must be the bundle's number of motor units, {units}"
            raise InvalidInputError("units", rule, self.units, "give the valve a port for each")
        return 1

    def state_count(self, units: int) -> int:
        """One spool for all of the `units`, whose number must be that of the ports."""
        return self.command_count(units)

    def rate(self, command: Numbers, spool: Numbers) -> Numbers:
        """Rate of the `spool` [1/s] towards the `command` [-], equation (F10)."""
        return (command - spool) / self.time_constant

    def openings(self, command: Numbers, spool: Numbers) -> Openings:
        """Openings [-] of all units, on the last axis, at the one `spool`'s position [-], (F11) and
        (F9); `command` doesn't count.
        """
        del command
        return self._port_openings(self.units * (1 + spool) - 2 * np.arange(self.units) - 1)

    def closing_command(self, unit: int) -> float:
        """Command [-] at which port `unit`, counted from 0, is shut and all before it are open to
        the supply.
        """
        if not 0 <= unit < self.units:
            raise InvalidInputError("unit", f"must lie in [0, {self.units - 1}]", unit)
        return (2 * unit + 1) / self.units - 1


def validate_commands(command: Values, name: str = "command") -> Numbers:
    """A `command` called `name` as floats [-]; `InvalidInputError` outside [-1, 1]."""
    return check_interval(
        command, -1.0, 1.0, name, "-", "from open exhaust to open supply", closed=(True, True)
    )
