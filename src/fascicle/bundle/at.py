"""A bundle at given pressures: the units' free and collapse strains solved for.

Units whose muscles have the same laws are one row of muscles, evaluated at once.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..core.array_namespace import add_table_axis, array_namespace, min_nodes, stack
from ..core.module import Module, static, tree_map
from ..core.types import Numbers, PerUnit, Whole
from ..core.validation import LARGEST_STRAIN
from ..muscle.piecewise import Pressurized as MusclesAtPressures
from .plates import muscle_strain, plate_strain


class Pressurized(Module):
    """A bundle at given pressures: `groups` of its units' muscles, the `places` of their units,
    units last; how many muscles each unit has [-], and its $L/L_i$ [-] where lengths differ.
    """

    groups: tuple[MusclesAtPressures, ...]
    places: tuple[tuple[int, ...], ...] = static()
    counts: Whole
    ratios: Numbers | None

    @property
    def farthest(self) -> Numbers:
        """The largest strain of the bundle [-] that all of its muscles' laws are made for."""
        if self.ratios is None:
            return LARGEST_STRAIN
        seen = plate_strain(self.ratios, LARGEST_STRAIN)
        return array_namespace(seen).min(seen, axis=-1)

    @property
    def nearest(self) -> Numbers:
        """The strain of the bundle [-] at which the fibers of one of its muscles are straight."""
        straight = self._seen(self.each(_straight))
        return array_namespace(straight).max(straight, axis=-1)

    def of(self, lane: Any) -> "Pressurized":
        """Those of the lanes [-] that are asked for, where lanes are the last axis but two."""
        return tree_map(lambda x: x if np.ndim(x) < 3 else x[..., lane, :, :], self)

    def each(self, function: Callable[[MusclesAtPressures], Any]) -> Any:
        """`function` of one muscle of every unit, units on the last axis."""
        return self._ordered([function(group) for group in self.groups])

    def along(self, function: Callable[..., Any], *strains: Numbers) -> Any:
        """`function` of one muscle of every unit and of its own strains [-] at the bundle's,
        units on the last axis.
        """
        return self._along(function, *(add_table_axis(strain) for strain in strains))

    @property
    def kinks(self) -> Numbers:
        """Strains of the bundle [-] at which its muscles' forces have kinks, units last."""
        return self._seen(self.each(lambda muscle: muscle.kinks))

    @property
    def turns(self) -> list[Numbers]:
        """Those of them that aren't the free strains, one array for onsets and one for collapse."""
        found = [self._seen(self.each(lambda muscle: muscle.collapse))]
        if all(group.onset is group.column.free_strain for group in self.groups):
            return found
        return [self._seen(self.each(lambda muscle: muscle.onset)), *found]

    @property
    def fold(self) -> Numbers:
        """The least strain of the bundle [-] past which a force may jump; inf where none does."""
        folds = self._seen(self.each(_fold))
        return array_namespace(folds).min(folds, axis=-1)

    @property
    def free_strains(self) -> Numbers:
        """Strain of the bundle [-] at which each unit alone neither pulls nor pushes."""
        return self._seen(self.each(lambda muscle: muscle.column.free_strain))

    def unit_forces(self, strain: Numbers) -> tuple[Numbers, Numbers]:
        """Force of each unit [N], its muscles together, at `strain` [-], and its slope [N]."""
        return self.forces_apart(add_table_axis(strain))

    def forces_apart(self, strains: Numbers) -> tuple[Numbers, Numbers]:
        """The same, each unit at one of the `strains` of the bundle [-] on the last axis."""
        force, slope = self._along(lambda muscle, eps: muscle.force(eps), strains)
        if self.ratios is not None:
            slope = slope * self.ratios
        return self.counts * force, self.counts * slope

    def force(self, strain: Numbers) -> tuple[Numbers, Numbers]:
        """Force of all units [N] at `strain` [-], (B1), and its slope in strain [N]."""
        forces, slopes = self.unit_forces(strain)
        total = array_namespace(forces).sum
        return total(forces, axis=-1), total(slopes, axis=-1)

    def _along(self, function: Callable[..., Any], *strains: Numbers) -> Any:
        values = []
        for group, places in zip(self.groups, self.places, strict=True):
            some = np.array(places)
            own = [eps if eps.shape[-1] == 1 else eps[..., some] for eps in strains]
            if self.ratios is not None:
                own = [muscle_strain(self.ratios[..., some], eps) for eps in own]
            values.append(function(group, *own))
        return self._ordered(values)

    def _seen(self, strains: Numbers) -> Numbers:
        return strains if self.ratios is None else plate_strain(self.ratios, strains)

    def _ordered(self, values: list[Any]) -> Any:
        if isinstance(values[0], tuple):
            return tuple(self._ordered(list(rows)) for rows in zip(*values, strict=True))
        if len(values) == 1:
            return values[0]
        order = np.argsort([i for places in self.places for i in places])
        at_work, shapes = array_namespace(*values), {np.shape(value)[:-1] for value in values}
        if len(shapes) > 1:  # some units are rows of muscles, others aren't
            shape = np.broadcast_shapes(*shapes)
            values = [at_work.broadcast_to(x, (*shape, x.shape[-1])) for x in values]
        return at_work.concatenate(values, axis=-1)[..., order]


def pressurized(bundle: Any, pressures: PerUnit) -> Pressurized:
    """`bundle` [-] at `pressures` [Pa], one for each unit on the last axis."""
    groups = tuple(
        muscles.law.at(pressures[..., np.array(places)]) for places, muscles in bundle.rows
    )
    places = tuple(places for places, _ in bundle.rows)
    return Pressurized(groups, places, bundle.counts, bundle.ratios)


def _straight(muscle: MusclesAtPressures) -> Numbers:
    return muscle.law.tension.bladder.braid.straight + 0.0 * muscle.column.free_strain


def _fold(muscle: MusclesAtPressures) -> Numbers:
    none = np.inf + 0.0 * muscle.column.free_strain
    return min_nodes(stack([none, *muscle.law.buckling.folds(muscle.column)]))
