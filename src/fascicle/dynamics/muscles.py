"""The muscles of a plant's motor units, as tables of co-energy or by their exact law.

Both give a `MuscleState`: co-energy, force and conjugate volume with their slopes, each a
derivative of the first. `volume="geometric"` takes the straight braid's volume instead of the
conjugate one, and so makes or loses energy when muscles buckle: an audit reports how much.
"""

import abc
from collections.abc import Sequence
from typing import ClassVar, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from ..bundle.pressurized import stack_muscles
from ..core.array_namespace import absolute, maximum, minimum, where
from ..core.module import Module, static, unique_indices
from ..core.types import Numbers
from ..muscle import Muscle
from ..muscle.braid import Braid
from ..muscle.coenergy import coenergy
from ..muscle.table import PRESSURE_ROUNDING, MuscleState, MuscleTable


class MuscleVolumes(NamedTuple):
    """A volume [m³], its slopes by strain [m³] and pressure [m³/Pa]."""

    volume: Numbers
    by_strain: Numbers
    by_pressure: Numbers


class AbstractMuscles(Module):
    """One muscle of every unit of a plant, units on the last axis, up to `highest_pressure` [Pa]
    between the lowest and highest of its `strains` [-].
    """

    strains: ClassVar[Numbers]
    highest_pressure: ClassVar[Numbers]

    @abc.abstractmethod
    def at(self, pressure: Numbers, strain: Numbers) -> MuscleState:
        """Energy, force, volume and slopes of each at its `pressure` [Pa] and `strain` [-]."""

    def volumes(self, surface: MuscleState, strain: Numbers, rest_length: Numbers) -> MuscleVolumes:
        """Volume of fluid in each, from its `surface` [SI] at a `strain` [-]; `rest_length` [m]."""
        by_strain = rest_length * surface.force_by_pressure
        return MuscleVolumes(surface.volume, by_strain, surface.volume_by_pressure)


class MuscleTables(AbstractMuscles):
    """Muscles by tables, (V3), one for each different muscle.

    `table`: the tables' coefficients stacked, its other numbers one for each unit; `indices`: of
    each unit's coefficients in the stack.
    """

    table: MuscleTable
    indices: np.ndarray

    @classmethod
    def from_muscles(
        cls,
        muscles: Sequence[Muscle],
        highest_pressure: float,
        shape: tuple[int, int],
        strains: Sequence[tuple[float, float] | None] | None = None,
    ) -> "MuscleTables":
        """Tables of each unit's muscle, up to `highest_pressure` [Pa], with `shape` nodes between
        its `strains` [-]; default: those of `Muscle.table`.
        """
        unique, indices = unique_indices(muscles)
        ends = strains or [None] * len(muscles)
        tables = [muscles[i].table(highest_pressure, ends[i], shape) for i in unique]
        columns = [(x.root_step, *x.strains, x.rest_length) for x in tables]
        root_step, low, high, length = np.array([columns[i] for i in indices], float).T
        median, upper, largest = np.max([table.errors for table in tables], axis=0).tolist()
        coefficients = np.stack([x.coefficients for x in tables])
        stack = MuscleTable(coefficients, root_step, (low, high), length, (median, upper, largest))
        return cls(stack, np.array(indices))

    def at(self, pressure: Numbers, strain: Numbers) -> MuscleState:
        return self.table.lookup_at(pressure, strain, self.indices)

    @property
    def strains(self) -> tuple[Numbers, Numbers]:
        return self.table.strains

    @property
    def highest_pressure(self) -> Numbers:
        return self.table.highest_pressure


class ExactMuscles(AbstractMuscles):
    """Muscles by their laws, (V2), integrated each time: exact to rounding, a hundred times slower.

    `groups`: muscles of the same laws stacked, as of a bundle, with the `indices` of their units.
    """

    groups: tuple[Muscle, ...]
    indices: tuple[tuple[int, ...], ...] = static()
    strains: tuple[Numbers, Numbers]
    highest_pressure: Numbers

    @classmethod
    def from_muscles(
        cls, muscles: Sequence[Muscle], highest_pressure: float, strains: tuple[Numbers, Numbers]
    ) -> "ExactMuscles":
        """Exact laws of each unit's muscle up to `highest_pressure` [Pa], within `strains` [-]."""
        indices, groups = zip(*stack_muscles(list(muscles)), strict=True)
        return cls(groups, indices, strains, np.full(len(muscles), highest_pressure))

    def at(self, pressure: Numbers, strain: Numbers) -> MuscleState:
        P = minimum(maximum(pressure, 0.0), self.highest_pressure)
        eps = minimum(maximum(strain, self.strains[0]), self.strains[1])
        surfaces = [
            _exact_surface(muscles, P[..., np.array(index)], eps[..., np.array(index)])
            for index, muscles in zip(self.indices, self.groups, strict=True)
        ]
        order = np.argsort([i for index in self.indices for i in index])
        columns = zip(*surfaces, strict=True)
        surface = MuscleState(*(jnp.concatenate(x, axis=-1)[..., order] for x in columns))
        excess = pressure - P  # past the ends the volume is constant, and the force linear
        inside = absolute(excess) <= PRESSURE_ROUNDING
        return surface._replace(
            coenergy=surface.coenergy + surface.volume * excess,
            force=surface.force + surface.force_by_pressure * excess,
            volume_by_pressure=where(inside, surface.volume_by_pressure, 0.0),
        )


@jax.jit  # operation by operation, a first value takes five times as long
def _exact_surface(muscles: Muscle, pressure: Numbers, strain: Numbers) -> MuscleState:
    """State of `muscles`, each unit at its `pressure` [Pa] and `strain` [-]."""
    one_pascal = jnp.ones_like(pressure)

    def coenergy_and_volume(P: Numbers) -> tuple[Numbers, Numbers]:
        return jax.jvp(lambda P: coenergy(muscles.law.at(P), strain), (P,), (one_pascal,))

    def force_and_slope(P: Numbers) -> tuple[Numbers, Numbers]:
        return muscles.law.at(P).force_and_slope(strain)

    (value, volume), (_, volume_by) = jax.jvp(coenergy_and_volume, (pressure,), (one_pascal,))
    (pull, slope), (by_pressure, _) = jax.jvp(force_and_slope, (pressure,), (one_pascal,))
    return MuscleState(value, pull, volume, slope, by_pressure, volume_by)


class MuscleWrapper(AbstractMuscles):
    """Base of muscles that wrap other `muscles` and have the same limits of strain and pressure."""

    muscles: AbstractMuscles

    @property
    def strains(self) -> tuple[Numbers, Numbers]:
        return self.muscles.strains

    @property
    def highest_pressure(self) -> Numbers:
        return self.muscles.highest_pressure


class GeometricMuscles(MuscleWrapper):
    """Muscles with the force of `muscles`, and the volume of their straight `braid`, (V), whether
    they buckle or not; `walls`: volumes of their bladders [m³].
    """

    braid: Braid
    walls: Numbers

    def at(self, pressure: Numbers, strain: Numbers) -> MuscleState:
        return self.muscles.at(pressure, strain)

    def volumes(self, surface: MuscleState, strain: Numbers, rest_length: Numbers) -> MuscleVolumes:
        swept, _ = self.braid.mesh(1.0, strain)  # dV of a meter's contraction [m²]
        volume = self.braid.volume(strain) - self.walls
        return MuscleVolumes(volume, self.braid.length * swept, 0.0 * surface.volume)
