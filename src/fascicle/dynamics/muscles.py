"""The muscles of a plant's motor units, as tables of co-energy or by their exact law.

Both give a `Surface`: co-energy, force and conjugate volume with their slopes, of which each is a
derivative of the first. `volume="geometric"` puts the straight braid's volume in the place of the
conjugate one, which makes or loses energy where muscles buckle: an audit names how much.
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

    def volumes(self, at: Surface, strain: Numbers, rest_length: Numbers) -> Volumes:
        """Volume that fluid fills in one muscle of each unit, which is `at` work [SI] at its
        `strain` [-]; `rest_length` [m].
        """
        del strain
        return Volumes(at.volume, rest_length * at.force_by_pressure, at.volume_by_pressure)

    @property
    @abc.abstractmethod
    def strains(self) -> tuple[Numbers, Numbers]:
        """Ends [-] of the strains that it knows, of each unit."""

    @property
    @abc.abstractmethod
    def highest_pressure(self) -> Numbers:
        """The highest pressure [Pa] that it knows, of each unit."""


class Tables(AbstractMuscles):
    """Of several units, each muscle's table once: `table`, its numbers one for each unit, `indices`
    the place of each unit's coefficients [-].
    """

    table: UnitSurface
    which: np.ndarray

    @classmethod
    def of(
        cls, muscles: Sequence[Muscle], highest_pressure: float, shape: tuple[int, int]
    ) -> "Tables":
        """Of `muscles` [-], one for each unit, up to `highest_pressure` [Pa], with `shape` [-]
        nodes.
        """
        unique, indices = unique_indices(muscles)
        tables = [UnitSurface.tabulate(muscles[i], highest_pressure, shape=shape) for i in unique]
        per_unit = [tables[i] for i in indices]
        table = UnitSurface(
            np.stack([unit_table.coefficients for unit_table in tables]),
            _row(per_unit, lambda unit_table: unit_table.root_step),
            (
                _row(per_unit, lambda unit_table: unit_table.strains[0]),
                _row(per_unit, lambda unit_table: unit_table.strains[1]),
            ),
            _row(per_unit, lambda unit_table: unit_table.rest_length),
            _largest_errors([unit_table.errors for unit_table in tables]),
        )
        return cls(table, np.array(indices))

    def at(self, pressure: Numbers, strain: Numbers) -> Surface:
        """Surface of each at its `pressure` [Pa] and `strain` [-], (V3)."""
        return lookup(self.table, pressure, strain, self.which)

    @property
    def strains(self) -> tuple[Numbers, Numbers]:
        """The table's ends [-], of each unit."""
        return self.table.strains

    @property
    def highest_pressure(self) -> Numbers:
        """The table's end [Pa], of each unit."""
        return self.table.highest_pressure


def _row(tables: Sequence[UnitSurface], number: Callable[[UnitSurface], Any]) -> Numbers:
    return np.array([float(number(unit_table)) for unit_table in tables])


def _largest_errors(errors: Sequence[tuple[float, float, float]]) -> tuple[float, float, float]:
    median, upper, largest = (max(column) for column in zip(*errors, strict=True))
    return median, upper, largest


class Exact(AbstractMuscles):
    """By the law itself, integrated anew each time: right to rounding, and a hundred times slower.

    `groups`: muscles of the same laws in a row, as of a bundle, `indices` of their units;
    `ends`: of the strains that are known [-]; `top`: the highest pressure [Pa].
    """

    groups: tuple[Muscle, ...]
    places: tuple[tuple[int, ...], ...] = static()
    ends: tuple[Numbers, Numbers]
    top: Numbers

    @classmethod
    def of(
        cls, muscles: Sequence[Muscle], highest_pressure: float, ends: tuple[Numbers, Numbers]
    ) -> "Exact":
        """Of `muscles` [-], one for each unit, up to `highest_pressure` [Pa], between strains
        `ends` [-].
        """
        top = np.full(len(muscles), highest_pressure)
        rows = stack_muscles(list(muscles))
        return cls(tuple(m for _, m in rows), tuple(indices for indices, _ in rows), ends, top)

    def at(self, pressure: Numbers, strain: Numbers) -> Surface:
        """Surface of each at its `pressure` [Pa] and `strain` [-], (V2)."""
        P = minimum(maximum(pressure, 0.0), self.top)
        eps = minimum(maximum(strain, self.ends[0]), self.ends[1])
        surfaces = [
            _exact_surface(muscles, P[..., np.array(indices)], eps[..., np.array(indices)])
            for indices, muscles in zip(self.places, self.groups, strict=True)
        ]
        order = np.argsort([i for indices in self.places for i in indices])
        at = Surface(
            *(jnp.concatenate(parts, axis=-1)[..., order] for parts in zip(*surfaces, strict=True))
        )
        past = pressure - P  # the volume stays there, and the force is linear
        inside = absolute(past) <= PRESSURE_ROUNDING
        return at._replace(
            coenergy=at.coenergy + at.volume * past,
            force=at.force + at.force_by_pressure * past,
            volume_by_pressure=where(inside, at.volume_by_pressure, 0.0),
        )

    def force(self, pressure: Numbers, strain: Numbers) -> Numbers:
        """Force of each [N] at its `pressure` [Pa] and `strain` [-], without the integral for its
        volume, which takes a hundred times as long.
        """
        if not is_concrete(pressure, strain) or np.any((pressure < 0) | (pressure > self.top)):
            return self.at(pressure, strain).force
        P, eps = np.broadcast_arrays(pressure, np.clip(strain, *self.ends))
        force = np.empty(P.shape)
        for indices, muscles in zip(self.places, self.groups, strict=True):
            of = np.array(indices)
            force[..., of] = muscles.law.at(P[..., of]).force(eps[..., of])[0]
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
    """Of `muscles` [-], one for each unit on the last axis."""
    unit_table, empty = jnp.ones_like(pressure), muscles.braid.volume(0.0) - muscles.bladder.volume

    def coenergy(P: Numbers) -> Numbers:
        at = muscles.law.at(P)
        done = P * empty + muscles.law.tension.rest_coenergy(P)[0] + contraction_work(at, strain)
        return done + coenergy_at_rest(at) if muscles.ends.is_compliant else done

    def with_volume(P: Numbers) -> tuple[Numbers, Numbers]:
        return jax.jvp(coenergy, (P,), (unit_table,))

    def force(P: Numbers) -> tuple[Numbers, Numbers]:
        return muscles.law.at(P).force(strain)

    (value, volume), (_, volume_by) = jax.jvp(with_volume, (pressure,), (unit_table,))
    (pull, slope), (by_pressure, _) = jax.jvp(force, (pressure,), (unit_table,))
    return Surface(value, pull, volume, slope, by_pressure, volume_by)


class Geometric(AbstractMuscles):
    """`muscles` whose volume is the straight braid's, (V), buckled or not; `braid`: of each unit's,
    `walls`: volumes of their bladders [m³].
    """

    muscles: AbstractMuscles
    braid: Braid
    walls: Numbers

    def at(self, pressure: Numbers, strain: Numbers) -> Surface:
        """Surface of each at its `pressure` [Pa] and `strain` [-], but for the volume."""
        return self.muscles.at(pressure, strain)

    def force(self, pressure: Numbers, strain: Numbers) -> Numbers:
        """Force of each [N] at its `pressure` [Pa] and `strain` [-], as of its muscles."""
        return self.muscles.force(pressure, strain)

    def volumes(self, at: Surface, strain: Numbers, rest_length: Numbers) -> Volumes:
        """Volume that fluid fills in one muscle of each unit at its `strain` [-], whatever it is
        `at` [SI] and its `rest_length` [m].
        """
        del rest_length
        swept, _ = self.braid.mesh(1.0, strain)  # dV of a meter's contraction [m²]
        volume = self.braid.volume(strain) - self.walls
        return Volumes(volume, self.braid.length * swept, 0.0 * at.volume)

    @property
    def strains(self) -> tuple[Numbers, Numbers]:
        """Of its muscles [-]."""
        return self.muscles.strains

    @property
    def highest_pressure(self) -> Numbers:
        """Of its muscles [Pa]."""
        return self.muscles.highest_pressure
