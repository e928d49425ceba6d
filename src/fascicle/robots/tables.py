"""Muscles past the ends of their tables, and the status that says so.

Below the strain at which its table begins, near that of straight fibers, a muscle goes on as a
spring whose stiffness is the table's largest there. The law stiffens further: the force is too low.
"""

import enum

import numpy as np

from ..core.array_namespace import array_namespace, minimum
from ..core.types import Numbers, Whole
from ..dynamics.muscles import AbstractMuscles, MuscleWrapper
from ..muscle.table import MuscleState


class TableWarning(UserWarning):
    """A muscle has left its table: its force there is extrapolated."""


class TableStatus(enum.IntEnum):
    """Place of a muscle in its table."""

    INSIDE = 0
    STRETCHED = 1
    SHORTENED = 2
    PRESSURE = 3


# NumPy's integers: of a Python's number a compiled step makes another type than its input's
_STATUS = tuple(map(np.int64, TableStatus))
_MESSAGES = (
    "lies in its table",
    "is stretched past its table: the force of a spring, too low",
    "is shortened past its table: the force is held",
    "has a pressure above its table: the force goes on linearly",
)


class SoftEnds(MuscleWrapper):
    """`muscles` of given `lengths` at rest [m] that go on as springs of an `edge_stiffness` [N]
    below their lowest strain.
    """

    lengths: Numbers
    edge_stiffness: Numbers

    @classmethod
    def from_muscles(cls, muscles: AbstractMuscles, lengths: Numbers) -> "SoftEnds":
        """Springs as stiff as the `muscles` at their tables' low ends, at the stiffest pressure."""
        low = np.asarray(muscles.strains[0])
        pressures = np.linspace(0.0, np.asarray(muscles.highest_pressure), 51)
        slopes = np.asarray(muscles.at(pressures, low + 0.0 * pressures).force_by_strain)
        return cls(muscles, lengths, np.max(np.maximum(-slopes, 0.0), axis=0))

    def at(self, pressure: Numbers, strain: Numbers) -> MuscleState:
        edge, K = self.muscles.at(pressure, strain), self.edge_stiffness
        past = minimum(strain - self.muscles.strains[0], 0.0)
        return edge._replace(  # beside the table's force, which is constant past its end
            coenergy=edge.coenergy - self.lengths * K * past**2 / 2,
            force=edge.force - K * past,
            force_by_strain=edge.force_by_strain - K * (past < 0),
        )


def table_status(muscles: AbstractMuscles, pressures: Numbers, strains: Numbers) -> Whole:
    """A `TableStatus` of each unit of `muscles` at `pressures` [Pa] and `strains` [-]."""
    xp, (low, high) = array_namespace(pressures, strains), muscles.strains
    inside, stretched, shortened, pressure = _STATUS
    status = xp.where(pressures > muscles.highest_pressure, pressure, inside)
    status = xp.where(strains > high, shortened, status)
    return xp.where(strains < low, stretched, status)


def status_message(muscles: AbstractMuscles, status: Whole, tendons: list[str]) -> str:
    """Words for the first unit of `muscles` whose `status` isn't `INSIDE`, with its tendon's name
    in `tendons`.
    """
    status = np.asarray(status).reshape((-1, len(tendons)))
    row, unit = np.argwhere(status)[0]
    low, high = (float(np.asarray(end)[unit]) for end in muscles.strains)
    top = float(np.asarray(muscles.highest_pressure)[unit]) / 1e3
    table = f"strains {low:.3f} to {high:.3f}, up to {top:.0f} kPa"
    return f"muscle on {tendons[unit]!r} {_MESSAGES[status[row, unit]]} ({table})"
