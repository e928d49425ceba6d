"""The muscles of a plant's motor units, as tables of co-energy or by their exact law.

Both give a `Surface`: co-energy, force and conjugate volume with their slopes, each a derivative of
the first. `volume="geometric"` takes the straight braid's volume instead of the conjugate one, and
so makes or loses energy when muscles buckle: an audit reports how much.
"""

import abc
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from ..bundle.pressurized import stack_muscles, unique_indices
from ..core.array_namespace import absolute, maximum, minimum, where
from ..core.module import Module, static
from ..core.types import Numbers
from ..core.validation import is_concrete
from ..muscle import Muscle
from ..muscle.braid import Braid
from ..muscle.coenergy import coenergy_at_rest, contraction_work
from ..muscle.surface import PRESSURE_ROUNDING, Surface, UnitSurface, lookup


class Volumes(NamedTuple):
    """A volume [m³], its slopes by strain [m³] and pressure [m³/Pa]."""

    volume: Numbers
    by_strain: Numbers
    by_pressure: Numbers


class AbstractMuscles(Module):
    """One muscle of every unit, units on the last axis."""

    @abc.abstractmethod
    def at(self, pressure: Numbers, strain: Numbers) -> Surface:
        """Surface of each at its `pressure` [Pa] and `strain` [-]."""

    def force(self, pressure: Numbers, strain: Numbers) -> Numbers:
        """Force of each [N] at its `pressure` [Pa] and `strain` [-]."""
        return self.at(pressure, strain).force

    def volumes(self, surface: Surface, strain: Numbers, rest_length: Numbers) -> Volumes:
        """Volume of fluid in one muscle of each unit, from its `surface` [SI] at a `strain` [-];
        `rest_length` [m].
        """
        del strain
        by_strain = rest_length * surface.force_by_pressure
        return Volumes(surface.volume, by_strain, surface.volume_by_pressure)

    @property
    @abc.abstractmethod
    def strains(self) -> tuple[Numbers, Numbers]:
        """Ends of the tabulated strains [-], of each unit."""

    @property
    @abc.abstractmethod
    def highest_pressure(self) -> Numbers:
        """Highest tabulated pressure [Pa], of each unit."""


class Tables(AbstractMuscles):
    """Tables of several units, one for each kind of muscle: `table`, with numbers for each unit,
    and the `indices` of each unit's coefficients.
    """

    table: UnitSurface
    indices: np.ndarray

    @classmethod
    def from_muscles(
        cls, muscles: Sequence[Muscle], highest_pressure: float, shape: tuple[int, int]
    ) -> "Tables":
        """Tables of each unit's muscle, up to `highest_pressure` [Pa], with `shape` nodes."""
        unique, indices = unique_indices(muscles)
        tables = [UnitSurface.tabulate(muscles[i], highest_pressure, shape=shape) for i in unique]
        per_unit = [tables[i] for i in indices]
        table = UnitSurface(
            np.stack([unit_table.coefficients for unit_table in tables]),
            _of_units(per_unit, lambda unit_table: unit_table.root_step),
            (
                _of_units(per_unit, lambda unit_table: unit_table.strains[0]),
                _of_units(per_unit, lambda unit_table: unit_table.strains[1]),
            ),
            _of_units(per_unit, lambda unit_table: unit_table.rest_length),
            _largest_errors([unit_table.errors for unit_table in tables]),
        )
        return cls(table, np.array(indices))

    def at(self, pressure: Numbers, strain: Numbers) -> Surface:
        """Surface of each at its `pressure` [Pa] and `strain` [-], (V3)."""
        return lookup(self.table, pressure, strain, self.indices)

    @property
    def strains(self) -> tuple[Numbers, Numbers]:
        """The table's ends [-], of each unit."""
        return self.table.strains

    @property
    def highest_pressure(self) -> Numbers:
        """The table's end [Pa], of each unit."""
        return self.table.highest_pressure


def _of_units(tables: Sequence[UnitSurface], get: Callable[[UnitSurface], Any]) -> Numbers:
    return np.array([float(get(unit_table)) for unit_table in tables])


def _largest_errors(errors: Sequence[tuple[float, float, float]]) -> tuple[float, float, float]:
    median, upper, largest = (max(column) for column in zip(*errors, strict=True))
    return median, upper, largest


class Exact(AbstractMuscles):
    """Muscles by their laws, integrated each time: exact to rounding, and a hundred times slower.

    `groups`: muscles of the same laws stacked, as of a bundle, `indices` of their units;
    `ends`: of the strains [-]; `top`: the highest pressure [Pa].
    """

    groups: tuple[Muscle, ...]
    indices: tuple[tuple[int, ...], ...] = static()
    ends: tuple[Numbers, Numbers]
    top: Numbers

    @classmethod
    def from_muscles(
        cls, muscles: Sequence[Muscle], highest_pressure: float, ends: tuple[Numbers, Numbers]
    ) -> "Exact":
        """Exact laws of each unit's muscle, up to `highest_pressure` [Pa], between strains `ends`
        [-].
        """
        indices, groups = zip(*stack_muscles(list(muscles)), strict=True)
        return cls(groups, indices, ends, np.full(len(muscles), highest_pressure))

    def at(self, pressure: Numbers, strain: Numbers) -> Surface:
        """Surface of each at its `pressure` [Pa] and `strain` [-], (V2)."""
        P = minimum(maximum(pressure, 0.0), self.top)
        eps = minimum(maximum(strain, self.ends[0]), self.ends[1])
        surfaces = [
            _exact_surface(muscles, P[..., np.array(index)], eps[..., np.array(index)])
            for index, muscles in zip(self.indices, self.groups, strict=True)
        ]
        order = np.argsort([i for index in self.indices for i in index])
        columns = zip(*surfaces, strict=True)
        surface = Surface(*(jnp.concatenate(x, axis=-1)[..., order] for x in columns))
        excess = pressure - P  # past the ends the volume is constant, and the force linear
        inside = absolute(excess) <= PRESSURE_ROUNDING
        return surface._replace(
            coenergy=surface.coenergy + surface.volume * excess,
            force=surface.force + surface.force_by_pressure * excess,
            volume_by_pressure=where(inside, surface.volume_by_pressure, 0.0),
        )

    def force(self, pressure: Numbers, strain: Numbers) -> Numbers:
        """Force of each [N] at its `pressure` [Pa] and `strain` [-], without the integral for its
        volume, which takes a hundred times as long.
        """
        if not is_concrete(pressure, strain) or np.any((pressure < 0) | (pressure > self.top)):
            return self.at(pressure, strain).force
        P, eps = np.broadcast_arrays(pressure, np.clip(strain, *self.ends))
        force = np.empty(P.shape)
        for indices, muscles in zip(self.indices, self.groups, strict=True):
            index = np.array(indices)
            force[..., index] = muscles.law.at(P[..., index]).force(eps[..., index])[0]
        return force

    @property
    def strains(self) -> tuple[Numbers, Numbers]:
        """Ends [-] of the strains, of each unit."""
        return self.ends

    @property
    def highest_pressure(self) -> Numbers:
        """The domain's end [Pa], of each unit."""
        return self.top


def _exact_surface(muscles: Muscle, pressure: Numbers, strain: Numbers) -> Surface:
    """Surface of `muscles` [SI], one for each unit on the last axis."""
    one_pascal = jnp.ones_like(pressure)
    volume_at_rest = muscles.braid.volume(0.0) - muscles.bladder.volume

    def coenergy(P: Numbers) -> Numbers:
        law = muscles.law.at(P)
        work = (
            P * volume_at_rest
            + muscles.law.tension.rest_coenergy(P)[0]
            + contraction_work(law, strain)
        )
        return work + coenergy_at_rest(law) if muscles.ends.is_compliant else work

    def with_volume(P: Numbers) -> tuple[Numbers, Numbers]:
        return jax.jvp(coenergy, (P,), (one_pascal,))

    def force(P: Numbers) -> tuple[Numbers, Numbers]:
        return muscles.law.at(P).force(strain)

    (value, volume), (_, volume_by) = jax.jvp(with_volume, (pressure,), (one_pascal,))
    (pull, slope), (by_pressure, _) = jax.jvp(force, (pressure,), (one_pascal,))
    return Surface(value, pull, volume, slope, by_pressure, volume_by)


class Geometric(AbstractMuscles):
    """`muscles` with the volume of their straight `braid`, (V), buckled or not; `walls`: volumes of
    their bladders [m³].
    """

    muscles: AbstractMuscles
    braid: Braid
    walls: Numbers

    def at(self, pressure: Numbers, strain: Numbers) -> Surface:
        """Surface of each at its `pressure` [Pa] and `strain` [-], but for the volume."""
        return self.muscles.at(pressure, strain)

    def force(self, pressure: Numbers, strain: Numbers) -> Numbers:
        """Force of each muscle [N] at its `pressure` [Pa] and `strain` [-]."""
        return self.muscles.force(pressure, strain)

    def volumes(self, surface: Surface, strain: Numbers, rest_length: Numbers) -> Volumes:
        """Volume of fluid in one muscle of each unit at its `strain` [-], at any `surface` [SI]
        and `rest_length` [m].
        """
        del rest_length
        swept, _ = self.braid.mesh(1.0, strain)  # dV of a meter's contraction [m²]
        volume = self.braid.volume(strain) - self.walls
        return Volumes(volume, self.braid.length * swept, 0.0 * surface.volume)

    @property
    def strains(self) -> tuple[Numbers, Numbers]:
        """Strains of its muscles [-]."""
        return self.muscles.strains

    @property
    def highest_pressure(self) -> Numbers:
        """Highest pressure of its muscles [Pa]."""
        return self.muscles.highest_pressure
