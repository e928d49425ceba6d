r"""Muscles between the plates of a bundle, at given pressures.

Units whose muscles have the same laws are one batch of muscles, evaluated together.

**Unlike lengths.** Plates at rest a distance $L$ apart, moved to $L (1 - \varepsilon)$, give a
muscle of length $L_i$ at rest the strain

$$\varepsilon_i = 1 - \frac{L}{L_i} (1 - \varepsilon), \tag{B7}$$

so a longer muscle is slack, or buckled, where a shorter one is still at rest, and a muscle
that is shorter than $L$ is stretched from the start. **Valid** while no muscle's fibers are
straight as long as another one isn't pulled.
"""

from collections.abc import Callable, Hashable, Iterable, Sequence
from functools import reduce
from typing import TYPE_CHECKING

import numpy as np

from ..core.array_namespace import add_table_axis, array_namespace, stack
from ..core.errors import InvalidInputError
from ..core.module import Module, static, tree_leaves, tree_map, tree_structure, with_fields
from ..core.types import Batch, Numbers, PerUnit, PyTree, Values, Whole
from ..core.validation import LARGEST_STRAIN, check_size, is_concrete, traced_floats, warn_user
from ..muscle import Muscle
from ..muscle.muscle import map_numbers
from ..muscle.piecewise import PressurizedMuscle
from ..muscle.validation import check_strain, lowest_strain


if TYPE_CHECKING:
    from .bundle import Bundle


class PressurizedBundle(Module):
    """A bundle at given pressures.

    `groups`: muscles of the same laws, with the `indices` of their units; `counts`: muscles of each
    unit [-], units last; `ratios`: $L/L_i$ [-], if lengths differ.
    """

    groups: tuple[PressurizedMuscle, ...]
    indices: tuple[tuple[int, ...], ...] = static()
    counts: Whole
    ratios: Numbers | None

    def take(self, index: Whole) -> "PressurizedBundle":
        """Bundles of a batch by `index`; the batch is on the last axis but two."""
        return tree_map(lambda x: x if np.ndim(x) < 3 else x[..., index, :, :], self)

    def plate_strains(self, function: Callable[[PressurizedMuscle], Numbers]) -> Numbers:
        """The plates' strain [-] at the strain of a `function` of one muscle of each unit."""
        # also one that is the same for all muscles has a value for each
        values = [function(group) + 0.0 * group.column.free_strain for group in self.groups]
        strains = self._in_order(values)
        return strains if self.ratios is None else plate_strain(self.ratios, strains)

    def map_units_over_strain(self, function: Callable[..., PyTree], *strains: Numbers) -> PyTree:
        """A `function` of one muscle of each unit and its strains at the bundle's `strains` [-]."""
        values = []
        for group, index in zip(self.groups, self.indices, strict=True):
            arguments = [add_table_axis(strain) for strain in strains]
            if self.ratios is not None:
                ratios = self.ratios[..., np.array(index)]
                arguments = [muscle_strain(ratios, x) for x in arguments]
            values.append(function(group, *arguments))
        return self._in_order(values)

    def unit_forces_and_slopes(self, strain: Numbers) -> tuple[Numbers, Numbers]:
        """Force of each unit [N], all its muscles, at `strain` [-], and its slope [N]."""
        force, slope = self.map_units_over_strain(PressurizedMuscle.force_and_slope, strain)
        if self.ratios is not None:
            slope = slope * self.ratios
        return self.counts * force, self.counts * slope

    def force_and_slope(self, strain: Numbers) -> tuple[Numbers, Numbers]:
        """Force of all units [N] at `strain` [-], (U1), and its slope in strain [N]."""
        forces, slopes = self.unit_forces_and_slopes(strain)
        total = array_namespace(forces).sum
        return total(forces, axis=-1), total(slopes, axis=-1)

    def _in_order(self, values: list[Numbers]) -> Numbers:
        """Groups' values in the order of the units, on the last axis."""
        if isinstance(values[0], tuple):
            return tuple(self._in_order(list(entries)) for entries in zip(*values, strict=True))
        if len(values) == 1:
            return values[0]
        order = np.argsort([i for index in self.indices for i in index])
        xp, shapes = array_namespace(*values), {np.shape(value)[:-1] for value in values}
        if len(shapes) > 1:  # some units are batches of muscles, others aren't
            shape = np.broadcast_shapes(*shapes)
            values = [xp.broadcast_to(x, (*shape, x.shape[-1])) for x in values]
        return xp.concatenate(values, axis=-1)[..., order]


def pressurize(bundle: "Bundle", pressures: PerUnit) -> PressurizedBundle:
    """A `bundle` at `pressures` [Pa], one for each unit on the last axis."""
    indices = tuple(index for index, _ in bundle.groups)
    groups = tuple(
        muscles.law.at(pressures[..., np.array(index)]) for index, muscles in bundle.groups
    )
    return PressurizedBundle(groups, indices, bundle.counts, bundle.ratios)


def flatten_batch(
    bundle: "Bundle", pressures: PerUnit, force: Numbers = 0.0
) -> tuple[tuple["Bundle", PerUnit, Numbers], tuple[int, ...]]:
    """A bundle, or a batch of bundles, at `pressures` [Pa], units last, and a `force` [N], which
    broadcast: all with an axis of points ahead of one of length one; and the shape of the points.
    """
    shape = np.broadcast_shapes(bundle._batch, np.shape(pressures)[:-1], np.shape(force))

    def flatten(x: Numbers, *axes: int) -> Numbers:
        return array_namespace(x).broadcast_to(x, (*shape, *axes)).reshape(-1, 1, *axes)

    def flatten_number(x: Numbers) -> Numbers:
        return flatten(x) if np.ndim(x) else x

    def flatten_table(x: Numbers) -> Numbers:
        return flatten(x, np.shape(x)[-1]) if np.ndim(x) > 1 else x

    if bundle._batch:
        units = []
        for unit in bundle.motor_units:
            muscle = map_numbers(flatten_number, flatten_table, unit.muscle)
            units.append(with_fields(unit, muscle=muscle, count=flatten_number(unit.count)))
        distance = tree_map(flatten_number, bundle.plate_distance)
        bundle = with_fields(bundle, motor_units=tuple(units), plate_distance=distance)
    return (bundle, flatten(pressures, np.shape(pressures)[-1]), flatten(force)), shape


def stack_muscles(muscles: Sequence[Muscle]) -> list[tuple[tuple[int, ...], Muscle]]:
    """Groups of muscles of the same laws and shapes, each as its indices among `muscles` and one
    muscle, stacked on the last axis; repetitions of one object stay that object, which broadcasts.
    """
    groups: dict[Hashable, list[int]] = {}
    for i, muscle in enumerate(muscles):
        key = tree_structure(muscle), tuple(map(np.shape, tree_leaves(muscle)))
        groups.setdefault(key, []).append(i)
    return [(tuple(index), _stack([muscles[i] for i in index])) for index in groups.values()]


def _stack(muscles: list[Muscle]) -> Muscle:
    first = muscles[0]
    if all(muscle is first for muscle in muscles) and first.is_single:
        return first
    return map_numbers(lambda *row: stack(row, axis=-1), lambda *row: stack(row, axis=-2), *muscles)


def muscle_strain(ratio: Batch, strain: Batch) -> Batch:
    """A muscle's contraction [-] at the plates' `strain` [-]; `ratio`: $L/L_i$ [-], (B7)."""
    return 1 - ratio * (1 - strain)


def plate_strain(ratio: Batch, strain: Batch) -> Batch:
    """The plates' contraction [-] at a muscle's `strain` [-]; `ratio`: $L/L_i$ [-]."""
    return 1 - (1 - strain) / ratio


def plate_distance(length: Values, muscles: Sequence[Muscle]) -> Batch | None:
    """Distance between the plates at rest [m]: a `length` [m], checked, or `None` where it is every
    muscle's. `ValueError` for unequal lengths without one, and if no plates can hold the muscles.
    """
    lengths = [muscle.length for muscle in muscles]
    if length is None:
        for i, muscle_length in enumerate(lengths[1:] if is_concrete(*lengths) else (), start=2):
            if not np.allclose(muscle_length, lengths[0], rtol=1e-9, atol=0):  # a file's decimals
                first, largest = (float(np.max(x)) for x in (lengths[0], muscle_length))
                rule = "must hold muscles of one length"
                remedy = "or give `length`, the distance between the plates at rest, in m"
                text = f"{first:g} m in unit 1 and {largest:g} m in unit {i}"
                raise InvalidInputError("motor_units", rule, largest, remedy, shown=text)
        return None
    L = check_size(length, "length")
    if not is_concrete(L, *lengths):
        return L
    if all(np.array_equal(np.broadcast_arrays(L, x)[0], x) for x in lengths):
        return None
    if not is_concrete(*(muscle.braid_angle for muscle in muscles)):
        return L
    longest = reduce(np.maximum, map(np.asarray, lengths), np.asarray(L))
    for i, muscle in enumerate(muscles, start=1):
        straight = np.asarray(muscle.length) / np.cos(np.asarray(muscle.braid_angle))
        if np.any(longest >= straight):  # overstretched before another muscle is taut
            end, value = float(np.min(straight)), float(np.max(longest))
            limit = f"{end:g} m, where unit {i}'s fibers are straight"
            rule = f"and the muscles' must stay below {limit}"
            remedy = "take lengths that are nearer to each other"
            raise InvalidInputError("length", rule, value, remedy, shown=f"{value:g} m")
    return L


def check_plate_strain(strain: Values, length: Batch, muscles: Sequence[Muscle]) -> Batch:
    """Plates' `strain` [-], refused off any muscle's domain; `length`: between them at rest [m]."""
    if not is_concrete(length, *((muscle.length, muscle.braid_angle) for muscle in muscles)):
        return traced_floats(strain)
    ratios = [np.asarray(length / muscle.length) for muscle in muscles]
    straight = [lowest_strain(muscle.law) for muscle in muscles]
    low = reduce(np.maximum, map(plate_strain, ratios, straight))
    high = reduce(np.minimum, [plate_strain(ratio, LARGEST_STRAIN) for ratio in ratios])
    return check_strain(strain, low, high, "(every muscle in its domain, seen from the plates)")


def check_volume_by_strain(muscles: Iterable[Muscle]) -> None:
    """Refuse `muscles` whose volume depends on their force, too; warn of braids that swell."""
    for muscle in muscles:
        if muscle.tension.stretches:
            warn_user(
                "fluid is counted in the braid as it is without pressure: the volume by which"
                " fibers that stretch let it swell is not included."
            )
        compliance = muscle.ends.compliance
        if is_concrete(compliance) and np.any(np.asarray(compliance) > 0):
            largest = float(np.max(np.asarray(compliance)))
            rule = "must be 0 for efficiencies, designs and the least fluid: volume is the strain's"
            text = f"{1e6 * largest:g} mm/kN"
            remedy = "leave it out; simulations and `conjugate_volume` count fluid at its pressure"
            raise InvalidInputError("end_compliance", rule, largest, remedy, shown=text)


def unit_volume_change(bundle: "Bundle", strain: Values) -> PerUnit:
    """Fluid $n_i (V_i(\\varepsilon) - V_i(0))$ [m³] that each motor unit of a `bundle` takes in
    from rest length to `strain` [-], units on the last axis; `ValueError` for compliant ends.
    """
    check_volume_by_strain(unit.muscle for unit in bundle.motor_units)
    eps, ratios, volumes = bundle._check_strain(strain), bundle.ratios, []
    for i, unit in enumerate(bundle.motor_units):
        start, end = (x if ratios is None else muscle_strain(ratios[..., i], x) for x in (0.0, eps))
        volume = unit.muscle.braid.volume  # the bladder's own doesn't change
        volumes.append(unit.count * (volume(end) - volume(start)))
    return stack(volumes, axis=-1)
