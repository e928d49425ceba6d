r"""Spools: from a command to the openings of a valve.

A command $u$ lies in [-1, 1]: above zero supply and port are joined, below it port and exhaust.
A spool at $x$ uncovers

$$z_{supply} = \frac{(x - o)^+}{1 - o}, \qquad z_{exhaust} = \frac{(-x - o)^+}{1 - o},
  \tag{F9}$$

nothing as long as $|x|$ is within its overlap $o$. Its position is the command (`Direct`), or
follows it,

$$\dot x = \frac{u - x}{\tau}. \tag{F10}$$

On/off valves (`Solenoid`), one to the supply and one to the exhaust, are energized for a share
$|u|$ of each pulse of a period $T$. With delays $t_o$ and $t_c$ to half open and to half closed,
the one that $u$ asks for is open at a time $t$ of the pulse by

$$z = \min\left(\frac{t}{2 t_o},\ 1 - \frac{t - |u| T}{2 t_c}\right), \qquad 0 \le z \le 1,
  \tag{F11}$$

also in the next pulse, if it hasn't closed. In the mean that is $|u| + (t_c - t_o)/T$, if the pulse
is long enough to open the valve and the pause to close it. A pulse begins with its period, so that
$u$ moves its end alone, once a period and $t_c$ later: in a loop that is a delay of
$T/2 + t_c$ in the mean, of which half a period is that of any loop that is sampled with $T$.

**Source:** Merritt (1967), Hydraulic Control Systems.
"""

import abc
from typing import ClassVar, NamedTuple

from ..core.array_namespace import absolute, array_namespace, maximum, minimum, where
from ..core.module import Module, record
from ..core.types import Batch, Numbers, Values
from ..core.validation import Range, check_interval
from .fields import interval_field, positive_field


_TIME = Range("s", 1e-6, 1e-4, 1.0, 1e3)  # usual valves take 0.1 ms to 1 s


class Openings(NamedTuple):
    """Openings of each unit's valve [-] to `supply` and `exhaust`, units on the last axis."""

    supply: Batch
    exhaust: Batch


def _check_dead_time(value: Values) -> float:
    """A dead time [s], refused unless it lies in [0, 10] s."""
    return float(check_interval(value, 0.0, 10.0, "dead_time", "s", closed=(True, True)))


class AbstractSpool(Module):
    """Spools of valves: their motion by commands, and the ports they open; `overlap`: closed share
    of the travel [-], in [0, 1). `dead_time`: from a command to its effect [s], by keyword; a run
    takes it in whole steps, and begins with shut valves.
    """

    overlap: ClassVar[Batch]
    dead_time: float = record(
        default=0.0, converter=_check_dead_time, kw_only=True, static=True, unit="s"
    )

    @property
    def pulse_delay(self) -> Batch:
        """Mean delay of commands by pulses [s], besides the `dead_time`."""
        return 0.0

    def state_count(self, units: int) -> int:
        """Number of spools with a state for a number of `units`: one each, if not overridden."""
        return units

    @abc.abstractmethod
    def rate(self, command: Numbers, spool: Numbers) -> Numbers:
        """Rate [1/s] of the positions `spool` [-] under a `command` [-]."""

    @abc.abstractmethod
    def openings(self, command: Numbers, spool: Numbers) -> Openings:
        """Openings [-] at a `command` [-] and a position of the `spool` [-]."""

    def command_at(self, opening: Numbers) -> Numbers:
        """Command [-] for a mean `opening` [-]: positive to the supply, negative to the exhaust."""
        return opening

    def _port_openings(self, position: Numbers) -> Openings:
        """Openings [-], (F9), at a `position` of the spool [-]."""
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
        return 0 * units

    def rate(self, command: Numbers, spool: Numbers) -> Numbers:
        return 0.0 * command[..., :0] + spool

    def openings(self, command: Numbers, spool: Numbers) -> Openings:
        """Openings [-], (F9), at the `command` [-]."""
        return self._port_openings(command)


class Servovalve(AbstractSpool):
    """A spool for each unit that follows its command with a first-order lag, equation (F10).

    `time_constant`: $\\tau$ [s]. `overlap`: $o$ [-], in [0, 1).
    """

    source: ClassVar[str] = "Merritt (1967)"
    time_constant: Batch = positive_field("time_constant", _TIME)
    overlap: Batch = interval_field("overlap", 0.0, 1.0, closed=(True, False), default=0.0)

    def rate(self, command: Numbers, spool: Numbers) -> Numbers:
        """Rate of the `spool` [1/s] towards its `command` [-], equation (F10)."""
        return (command - spool) / self.time_constant

    def openings(self, command: Numbers, spool: Numbers) -> Openings:
        return self._port_openings(spool)


class Solenoid(AbstractSpool):
    """Two on/off valves for each unit, driven by the width of pulses, equation (F11).

    `period`: $T$ of the pulses [s]. `opening_delay`, `closing_delay`: $t_o$, $t_c$ [s].
    """

    source: ClassVar[str] = "derived here"
    overlap: ClassVar[Batch] = 0.0
    period: Batch = positive_field("period", _TIME)
    opening_delay: Batch = positive_field("opening_delay", _TIME)
    closing_delay: Batch = positive_field("closing_delay", _TIME)

    @property
    def pulse_delay(self) -> Batch:
        return self.period / 2 + self.closing_delay

    def rate(self, command: Numbers, spool: Numbers) -> Numbers:
        """Rate of each unit's pulse clock `spool` [1/s], $1/T$ at any `command` [-]."""
        return 1 / self.period + 0.0 * (command + spool)

    def openings(self, command: Numbers, spool: Numbers) -> Openings:
        """Openings [-], (F11), at a `command` [-] and clocks `spool` [-]."""
        duty_cycle, T = absolute(command), self.period
        time = (spool - array_namespace(spool).floor(spool)) * T

        def opening(time: Numbers) -> Numbers:
            rise, fall = time / (2 * self.opening_delay), (time - duty_cycle * T)
            return maximum(minimum(minimum(rise, 1 - fall / (2 * self.closing_delay)), 1.0), 0.0)

        z = where(duty_cycle >= 1, 1.0, maximum(opening(time), opening(time + T)))
        return Openings(where(command > 0, z, 0.0), where(command < 0, z, 0.0))

    def command_at(self, opening: Numbers) -> Numbers:
        correction = (self.opening_delay - self.closing_delay) / self.period
        duty_cycle = minimum(maximum(absolute(opening) + correction, 0.0), 1.0)
        return where(opening > 0, duty_cycle, where(opening < 0, -duty_cycle, 0.0))


def validate_commands(command: Values, name: str = "command") -> Numbers:
    """A `command` called `name` as floats [-]; `InvalidInputError` outside [-1, 1]."""
    why = "from open exhaust to open supply"
    return check_interval(command, -1.0, 1.0, name, "-", why, closed=(True, True))
