"""Scheduled commands, and the interface of a controller.

A controller is a function of its memory, a measurement and a reference; it returns its next memory
and commands. A `Schedule` measures nothing.
"""

from typing import Any, NamedTuple, Protocol

import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Batch, Numbers, Values
from ..core.validation import check_finite
from ..fluid import validate_commands


class Measurement(NamedTuple):
    """Input of a controller: `time` [s]; `position` and `velocity` of the load [SI]; `pressures`
    of the units [Pa]; `force` of all muscles on the load [N or N·m]; `supply_pressure` [Pa].
    """

    time: Batch
    position: Batch
    velocity: Batch
    pressures: Numbers
    force: Batch
    supply_pressure: Batch


class Controller(Protocol):
    """Interface of a controller in `simulate`: `memory` at the start; a call takes memory,
    measurement and reference, and returns the next memory and commands.
    """

    @property
    def memory(self) -> Any:
        """Memory at the start."""
        ...

    def __call__(
        self, memory: Any, measurement: Measurement, reference: Any
    ) -> tuple[Any, Numbers]:
        """Next memory and the commands [-], from the `memory`, a `measurement` [SI] and the present
        `reference` [any unit].
        """
        ...


class Schedule:
    """Schedule of valve commands, each constant until the next of its times.

    `times` [s], rising, the first at 0; `commands` [-] in [-1, 1], one row for each of them, one
    column for each command.
    """

    def __init__(self, times: Values, commands: Values):
        """**Arguments:**

        - `times`: rising, the first at 0 [s].
        - `commands`: one row for each of them [-], in [-1, 1].

        **Raises:** `ValueError` for times that don't rise, and commands outside [-1, 1].
        """
        self.times = np.atleast_1d(check_finite(times, "times", "s"))
        if self.times[0] != 0:
            raise InvalidInputError("times", "must begin at 0 s", float(self.times[0]))
        steps = np.diff(self.times)
        if np.any(steps <= 0):
            k = int(np.argmax(steps <= 0))
            raise InvalidInputError(
                "times",
                "must rise",
                self.times[k + 1],
                shown=f"{self.times[k + 1]:g} s after {self.times[k]:g} s",
            )
        rows = np.asarray(validate_commands(commands, "commands"))
        self.commands = rows[:, None] if rows.ndim == 1 else np.atleast_2d(rows)
        if len(self.commands) != len(self.times):
            raise InvalidInputError(
                "commands", "must have one row for each time", len(self.commands)
            )

    def delayed(self, dead_time: float) -> "Schedule":
        """Schedule whose commands come a `dead_time` [s] later, with all valves shut before."""
        if dead_time == 0:
            return self
        times = np.concatenate([[0.0], self.times + dead_time])
        return Schedule(times, np.concatenate([0.0 * self.commands[:1], self.commands]))

    def at(self, time: Values) -> Numbers:
        """Commands [-] in force at each `time` [s]; a column for each command on the last axis."""
        # 1e-9 s: a step that misses a time by rounding has its command
        index = np.searchsorted(self.times, np.asarray(time) + 1e-9, side="right") - 1
        return self.commands[np.maximum(index, 0)]
