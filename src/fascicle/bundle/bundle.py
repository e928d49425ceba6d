r"""Motor units and bundles: muscles in parallel between rigid plates.

A motor unit is $n$ equal muscles at one pressure; a bundle is motor units that share one
strain. Its force is the sum over them,

$$F(P_1 \dots P_k, \varepsilon) = \sum_i n_i F_i(P_i, \varepsilon), \tag{U1}$$

with $\max(F_i, 0)$ instead of $F_i$ where resistance is neglected, as models before the
paper did. With resistance the force can vanish at several strains. The free strain is the
*smallest* of them [R16], where the force followed from $\varepsilon = 0$ at fixed
pressures first reaches zero; without resistance it is its units' largest.

Muscles of unlike length share the plates' distance, not the strain, (B7): the bundle's `length` is
that distance at rest.

**Sign:** as for a muscle. **Assumes** that the muscles don't touch.
**Source:** Kim, Mazzoleni and Bryant (2021), sections 4 and 6.
"""

from collections.abc import Sequence
from functools import cached_property, partial, reduce

import numpy as np

from ..core.array_namespace import array_namespace, stack, where
from ..core.errors import InvalidInputError
from ..core.module import (
    Module,
    record,
    replace_checked,
    static,
    tree_leaves,
    unique_indices,
    with_fields,
)
from ..core.types import Batch, Int, IntBatch, Numbers, PerUnit, Values, Whole
from ..core.validation import (
    broadcast_shape,
    check_count,
    check_finite,
    check_gauge_pressure,
    check_whole_number,
    match_array_type,
)
from ..muscle import Muscle
from ..muscle.validation import check_strain, lowest_strain
from ..repr_table import with_table_repr
from .energetics import average_efficiency, efficiency_map
from .equilibria import (
    Equilibria,
    attach_derivatives,
    find_equilibria,
    find_first_equilibria,
    usual_count,
)
from .inverse import recruit
from .pressurized import check_plate_strain, plate_distance, pressurize, stack_muscles
from .printing import bundle_line, bundle_table
from .recruitment import workspace
from .reversal import reversal
from .schemes import AbstractScheme, scheme_of


class MotorUnit(Module):
    """Equal muscles at one pressure, the smallest part that is activated: a `muscle` and the
    `count` of them [-], a whole number ≥ 1.
    """

    muscle: Muscle
    count: IntBatch = record(default=1, converter=partial(check_count, name="count"))

    def __check_init__(self):
        if not isinstance(self.muscle, Muscle):
            raise InvalidInputError("muscle", "must be a Muscle", self.muscle)


@with_table_repr(bundle_table, bundle_line)
class Bundle(Module):
    """Motor units between rigid plates, in the order in which they are recruited.

    With batches of muscles, or of counts, it is a batch of bundles, which broadcasts against
    pressures and strains in forces, free strains and equilibria.
    """

    motor_units: tuple[MotorUnit, ...]
    supply_pressure: Batch | None
    scheme: AbstractScheme = static()
    plate_distance: Batch | None

    def __init__(
        self,
        motor_units: Sequence[MotorUnit],
        supply_pressure: Values = None,
        scheme: AbstractScheme | str = "orderly",
        length: Values = None,
    ):
        """`motor_units` in the order of recruitment, the supply's gauge pressure [Pa] if known, and
        one of `fascicle.schemes`, by name or as an object.

        `length`: distance between the plates at rest [m]; by default the muscles' length, which
        must then be the same for all. The field `plate_distance` is `None` if all muscles are as
        long as that. `ValueError` for no units, an unknown scheme, unequal lengths without a
        `length`, and lengths that no plates can hold.
        """
        units, supply = tuple(motor_units), supply_pressure
        if not units:
            rule = "must hold at least one motor unit"
            raise InvalidInputError("motor_units", rule, None, shown="none")
        for unit in units:
            if not isinstance(unit, MotorUnit):
                raise InvalidInputError("motor_units", "must hold MotorUnit objects", unit)
        distance = plate_distance(length, [unit.muscle for unit in units])
        if supply is not None:
            supply = check_gauge_pressure(supply, "supply_pressure")
        self.__attrs_init__(units, supply, scheme_of(scheme), distance)

    @classmethod
    def constant_cross_section(
        cls,
        muscle: Muscle,
        units: int,
        supply_pressure: Values = None,
        scheme: AbstractScheme | str = "orderly",
    ) -> "Bundle":
        r"""A bundle that splits a muscle's section evenly into motor units of one muscle each.

        $N$ `units` of radius $r = R/\sqrt N$ take the section of one `muscle` of radius $R$, with
        $t_0/r_0$, length and braid angle unchanged. $N = 1$ is the single equivalent motor
        unit (SEMU) that a bundle is compared with. `supply_pressure` [Pa] and `scheme` are the
        bundle's. `ValueError` for less than one unit.
        """
        units = check_whole_number(units, "units", 1)
        scale = np.sqrt(units)
        radius, thickness = muscle.outer_radius / scale, muscle.wall_thickness / scale
        thin = with_fields(muscle, outer_radius=radius, wall_thickness=thickness)
        return cls([MotorUnit(thin)] * units, supply_pressure, scheme)

    @property
    def length(self) -> Batch:
        """Length at rest $L$ [m], between the plates."""
        muscle = self.motor_units[0].muscle
        return muscle.length if self.plate_distance is None else self.plate_distance

    @cached_property
    def ratios(self) -> Numbers | None:
        """$L/L_i$ [-] of each motor unit, on the last axis; `None` if all are 1."""
        if self.plate_distance is None:
            return None
        return stack([self.plate_distance / x.muscle.length for x in self.motor_units], axis=-1)

    @cached_property
    def counts(self) -> Whole:
        """Muscles in each motor unit [-], on the last axis."""
        return stack([unit.count for unit in self.motor_units], axis=-1)

    @cached_property
    def groups(self) -> tuple[tuple[tuple[int, ...], Muscle], ...]:
        """Indices of units of the same laws, with their muscles stacked to be evaluated at once."""
        return tuple(stack_muscles([unit.muscle for unit in self.motor_units]))

    def force(self, pressures: Values, strain: Values, resistance: bool = True) -> Batch:
        """Pulling force [N] of all units, equation (U1), at gauge `pressures` [Pa], one for each
        motor unit on the last axis, and the bundle's contraction `strain` [-], which broadcasts.

        Without `resistance` units past their own free strain don't push back. `ValueError` for a
        wrong number of pressures and values off the domain.
        """
        forces = self.unit_forces(pressures, strain, resistance)
        return array_namespace(forces).sum(forces, axis=-1)

    def unit_forces(self, pressures: Values, strain: Values, resistance: bool = True) -> PerUnit:
        """Pulling force [N] of each motor unit, all its muscles, motor units on the last axis;
        arguments are those of `force`: pressures [Pa] and strain [-].
        """
        P, eps = self._check_pressures(pressures), self._check_strain(strain)
        self._check_shapes(P, strain=eps)
        forces = pressurize(self, P).unit_forces_and_slopes(eps)[0]
        return forces if resistance else where(forces > 0, forces, 0.0)

    def free_strain(self, pressures: Values, resistance: bool = True) -> Batch:
        """Smallest strain [-] of no force at `pressures` [Pa], inf if none, which jumps where two
        zeros meet and vanish; without `resistance`, the units' largest free strain. Arguments and
        errors are those of `force`.
        """
        P = self._check_pressures(pressures)
        if not resistance:
            return _largest_free_strain(self, P)
        roots = self._find_equilibria(P)
        return where(roots.count > 0, roots.strain[..., 0], np.inf)[()]

    def equilibria(self, pressures: Values, resistance: bool = True) -> Equilibria:
        """All strains of no force [-] at `pressures` [Pa], and their stability, NaN-padded on a new
        last axis; without `resistance` the bundle is slack beyond its free strain, which alone is
        given. Arguments and errors are those of `force`.
        """
        P = self._check_pressures(pressures)
        if resistance:
            return self._find_equilibria(P)
        strain = _largest_free_strain(self, P)[..., None]
        exists = strain > -np.inf
        return Equilibria(strain, exists, exists.sum(axis=-1))

    def strain_at(self, force: Values, pressures: Values) -> Equilibria:
        """All strains [-] at which the bundle pulls with a `force` [N]: equilibria under a load.

        They lie between straight fibers and the end of the domain, NaN-padded on a new last axis,
        with their stability; a `count` of 0 if none holds the load. A negative force pushes the
        plates together. `pressures` [Pa], which broadcast, and errors are those of `force`.
        """
        F = match_array_type(force, check_finite(force, "force", "N"))
        return self._find_equilibria(self._check_pressures(pressures), force=F)

    # functions of a bundle, whose docstrings and signatures these methods have
    recruit = recruit
    workspace = workspace
    reversal = reversal
    efficiency_map = efficiency_map
    average_efficiency = average_efficiency

    def replace(self, **changes: Values) -> "Bundle":
        """A new bundle with `changes` of its arguments; `ValueError` for bad names and values."""
        return replace_checked(self, changes, length=self.plate_distance)

    def distinct_units(self) -> tuple["Bundle", Int[np.ndarray, " unit"]]:
        """A bundle of the units that differ, without supply pressure and scheme, and the index
        among them of each unit: equal units are evaluated once.
        """
        unique, inverse = unique_indices(self.motor_units)
        units = [self.motor_units[i] for i in unique]
        return Bundle(units, length=self.plate_distance), np.array(inverse)

    def _check_strain(self, strain: Values) -> Batch:
        """The `strain` [-] of the plates as floats, refused off the domain of any muscle."""
        muscles = [unit.muscle for unit in self.motor_units]
        if self.plate_distance is not None:
            return check_plate_strain(strain, self.plate_distance, muscles)
        lowest = [lowest_strain(muscle.law) for muscle in muscles]
        return check_strain(strain, reduce(np.maximum, lowest))

    def _check_pressures(self, pressures: Values, name: str = "pressures") -> PerUnit:
        """The `pressures` [Pa], one for each unit, 0 to 1 MPa; warns of those above a tuning."""
        P, units = check_gauge_pressure(pressures, name), len(self.motor_units)
        if P.ndim == 0 or P.shape[-1] != units:
            rule = f"must hold one pressure for each of the {units} motor units on the last axis"
            count, text = (P.shape[-1], None) if P.ndim else (1, "a single pressure")
            raise InvalidInputError(name, rule, count, shown=text)
        for i, unit in enumerate(self.motor_units):
            unit.muscle.tuning.warn_extrapolation(P[..., i])
        return P

    def _check_shapes(self, pressures: PerUnit, **arrays: Numbers) -> tuple[int, ...]:
        """Shape to which `pressures`, units last, `arrays` and a batch of bundles broadcast."""
        shapes = {name: np.shape(x) for name, x in arrays.items()}
        shape = broadcast_shape(pressures=np.shape(pressures)[:-1], **shapes)
        return broadcast_shape(muscles=self._batch, pressures=shape) if self._batch else shape

    @cached_property
    def _batch(self) -> tuple[int, ...]:
        """Shape of a batch of bundles, `()` of a single one."""
        shapes = {"length": () if self.plate_distance is None else np.shape(self.plate_distance)}
        for i, unit in enumerate(self.motor_units, start=1):
            shapes[f"motor unit {i}"] = unit.muscle.batch_shape
            shapes[f"count {i}"] = np.shape(unit.count)
        return broadcast_shape(**shapes)

    def _find_equilibria(self, pressures: PerUnit, **force: Numbers) -> Equilibria:
        """Equilibria at `pressures` [Pa] under a `force` [N], searched for by NumPy."""
        shape = self._check_shapes(pressures, **force)
        arrays = (self, pressures, *force.values())
        if array_namespace(*tree_leaves(arrays)) is np:
            return find_equilibria(*arrays)
        from ..core import jax_backend as jax

        slots = (*shape, usual_count(len(self.motor_units)))
        kinds = ((float, slots), (bool, slots), (int, shape))
        result = Equilibria(*(jax.array_spec(*kind) for kind in kinds))
        roots = jax.call_numpy(find_first_equilibria, result, *arrays)
        strain = attach_derivatives(self, roots.strain, *arrays[1:])
        return roots._replace(strain=strain)


def _largest_free_strain(bundle: Bundle, pressures: PerUnit) -> Numbers:
    muscles = pressurize(bundle, pressures)
    free_strains = muscles.plate_strains(lambda muscle: muscle.column.free_strain)
    return array_namespace(free_strains).max(free_strains, axis=-1)


def as_bundle(value: Muscle | Bundle, name: str = "bundle") -> Bundle:
    """A bundle, or a muscle as one; `name`: of the argument, in an error."""
    if isinstance(value, Bundle):
        return value
    if not isinstance(value, Muscle):
        rule, kind = "must be a Muscle or a Bundle", type(value).__name__
        raise InvalidInputError(name, rule, value, shown=kind)
    return Bundle([MotorUnit(value)])
