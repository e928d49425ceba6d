r"""From a command to openings: how a valve's spool moves and what it uncovers.

A command $u$ lies in [-1, 1]: above zero supply and port are joined, below it port and exhaust.
A spool at $x$ uncovers

$$z_{supply} = \frac{(x - o)^+}{1 - o}, \qquad z_{exhaust} = \frac{(-x - o)^+}{1 - o},
  \tag{F9}$$

nothing as long as $|x|$ is within its overlap $o$. It is where the command is (`Direct`), or
follows it,

$$\dot x = \frac{u - x}{\tau}. \tag{F10}$$

The orderly recruitment valve has one spool for $N$ units, whose ports lie in a row. At $x = -1$ all
are vented; on its way to 1 it passes each in turn and leaves it joined to the supply:

$$x_i = N (1 + x) - 2 i - 1, \quad i = 0 \dots N - 1, \tag{F11}$$

is where port $i$ sees the spool, and (F9) of it, up to 1, what of that port is open. One unit is
throttled at a time, those before it are at the supply, those after it at the exhaust.

**Source:** Merritt (1967), Hydraulic Control Systems; the orderly valve after Vemula, Kim,
Mazzoleni and Bryant (2022), Bioinspiration & Biomimetics 17, from what its abstract says: the
ports' even spacing and linear openings are ours.
"""

import abc
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ..core.array_namespace import maximum, minimum
from ..core.errors import InvalidInputError
from ..core.module import Module, static
from ..core.types import Batch, Numbers, Values
from ..core.validation import Range, check_interval
from .fields import interval_field, positive_field


_TIME = Range("s", 1e-6, 1e-4, 1.0, 1e3)


class Openings(NamedTuple):
    """Shares of each unit's valve that are open to the `supply` and to the `exhaust` [-], units on
    the last axis.
    """

    supply: Batch
    exhaust: Batch


class AbstractSpool(Module):
    """Law from commands to openings."""

    @abc.abstractmethod
    def commands(self, units: int) -> int:
        """Number of commands [-] for a number of `units` [-]."""

    @abc.abstractmethod
    def states(self, units: int) -> int:
        """Number of spools with a state [-] for a number of `units` [-]."""

    @abc.abstractmethod
    def rate(self, command: Numbers, spool: Numbers) -> Numbers:
        """Rate of the `spool` [1/s], itself [-], under a `command` [-]."""

    @abc.abstractmethod
    def openings(self, command: Numbers, spool: Numbers) -> Openings:
        """Openings [-] at a `command` [-] and a position of the `spool` [-]."""


class Direct(AbstractSpool):
    """A spool for each unit that is where the command is. `overlap`: $o$ [-], in [0, 1)."""

    source: ClassVar[str] = "Merritt (1967)"
    overlap: Batch = interval_field("overlap", 0.0, 1.0, closed=(True, False), default=0.0)

    def commands(self, units: int) -> int:
        """One [-] for each of the `units` [-]."""
        return units

    def states(self, units: int) -> int:
        """None for any number of `units` [-]."""
        return 0 * units

    def rate(self, command: Numbers, spool: Numbers) -> Numbers:
        """No rates [1/s] at any `command` [-] for no `spool` [-]."""
        return 0.0 * command[..., :0] + spool

    def openings(self, command: Numbers, spool: Numbers) -> Openings:
        """Equation (F9) [-] at the `command` [-], whatever the `spool` [-]."""
        del spool
        return _uncovered(command, self.overlap)


class Servovalve(AbstractSpool):
    """A spool for each unit that follows its command, equation (F10).

    `time_constant`: $\\tau$ [s]. `overlap`: $o$ [-], in [0, 1).
    """

    source: ClassVar[str] = "Merritt (1967)"
    time_constant: Batch = positive_field("time_constant", _TIME)
    overlap: Batch = interval_field("overlap", 0.0, 1.0, closed=(True, False), default=0.0)

    def commands(self, units: int) -> int:
        """One [-] for each of the `units` [-]."""
        return units

    def states(self, units: int) -> int:
        """One [-] for each of the `units` [-]."""
        return units

    def rate(self, command: Numbers, spool: Numbers) -> Numbers:
        """Equation (F10) [1/s] for a `command` [-] and the `spool` there [-]."""
        return (command - spool) / self.time_constant

    def openings(self, command: Numbers, spool: Numbers) -> Openings:
        """Equation (F9) [-] of the `spool` [-], whatever the `command` [-]."""
        del command
        return _uncovered(spool, self.overlap)


class OrderlyValve(AbstractSpool):
    """One spool for all units, equations (F10) and (F11).

    `units`: how many ports it has [-]. `time_constant`: $\\tau$ [s]. `overlap`: $o$ at each port
    [-], in [0, 1).
    """

    source: ClassVar[str] = "Vemula, Kim, Mazzoleni and Bryant (2022)"
    units: int = static()
    time_constant: Batch = positive_field("time_constant", _TIME)
    overlap: Batch = interval_field("overlap", 0.0, 1.0, closed=(True, False), default=0.0)

    def __check_init__(self):
        if isinstance(self.units, bool) or not isinstance(self.units, int) or self.units < 1:
            raise InvalidInputError("units", "must be a whole number of at least 1", self.units)

    def commands(self, units: int) -> int:
        """One [-] for all of the `units` [-], which must be as many as it has ports."""
        self._check(units)
        return 1

    def states(self, units: int) -> int:
        """One [-] for all of the `units` [-], which must be as many as it has ports."""
        self._check(units)
        return 1

    def rate(self, command: Numbers, spool: Numbers) -> Numbers:
        """Equation (F10) [1/s] for the `command` [-] and the `spool` there [-]."""
        return (command - spool) / self.time_constant

    def openings(self, command: Numbers, spool: Numbers) -> Openings:
        """Equations (F11) and (F9) [-] of the `spool` [-], whatever the `command` [-]."""
        del command
        seen = self.units * (1 + spool) - 2 * np.arange(self.units) - 1
        return _uncovered(seen, self.overlap)

    def middle(self, unit: int) -> float:
        """The command [-] at which port `unit`, counted from 0, is shut and all before it are
        open to the supply.
        """
        if not 0 <= unit < self.units:
            raise InvalidInputError("unit", f"must lie in [0, {self.units - 1}]", unit)
        return (2 * unit + 1) / self.units - 1

    def _check(self, units: int) -> None:
        if units != self.units:
            rule = f"must be the bundle's number of motor units, {units}"
            raise InvalidInputError("units", rule, self.units, "give the valve a port for each")


def validate_commands(command: Values, name: str = "command") -> Numbers:
    """A `command` [-] called `name` as floats [-]; `ValueError` outside [-1, 1]."""
    return check_interval(
        command, -1.0, 1.0, name, "-", "from open exhaust to open supply", closed=(True, True)
    )


def _uncovered(x: Any, overlap: Batch) -> Openings:
    # at the edges a derivative is the mean of both sides', as differences have it
    supply, exhaust = (
        minimum(maximum(side - overlap, 0.0) / (1 - overlap), 1.0) for side in (x, -x)
    )
    return Openings(supply, exhaust)
