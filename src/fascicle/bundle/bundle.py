r"""Motor units and bundles: muscles in parallel between rigid plates.

A motor unit is $n$ equal muscles at one pressure; a bundle is motor units that share one
strain. Its force is the sum over them,

$$F(P_1 \dots P_k, \varepsilon) = \sum_i n_i F_i(P_i, \varepsilon), \tag{B1}$$

with $\max(F_i, 0)$ instead of $F_i$ where resistance is neglected, as models before the
paper did. With resistance the force can vanish at several strains. The free strain is the
*smallest* of them [R16], where the force followed from $\varepsilon = 0$ at fixed
pressures first reaches zero; without resistance it is its units' largest.

Muscles of unlike length share the plates' distance, not the strain: `plates` says what
each one's is, and the bundle is told the distance at rest.

**Sign:** as for a muscle. **Assumes** that the muscles don't touch.
**Source:** Kim, Mazzoleni and Bryant (2021), sections 4 and 6.
"""

from collections.abc import Callable, Sequence
from functools import cached_property, partial, reduce
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..core.array_namespace import array_namespace, where
from ..core.errors import InvalidInputError, require
from ..core.lazy import import_late
from ..core.module import Module, evaluate, primal_numpy, replace_checked, static
from ..core.types import (
    AnyArray,
    Batch,
    Bool,
    Float,
    Int,
    IntBatch,
    Numbers,
    PerUnit,
    Values,
    Whole,
)
from ..core.validation import (
    HIGHEST_PRESSURE,
    LARGEST_STRAIN,
    broadcast_shape,
    check_choice,
    check_count,
    check_finite,
    check_interval,
    check_plausible,
    has_units,
    is_concrete,
    match_array_type,
    warn_pressure_units,
)
from ..muscle import Muscle
from ..muscle.muscle import BACKENDS
from ..muscle.validation import check_strain, lowest_strain, strain_domain
from ..repr_table import with_table_repr
from .equilibria import attach_derivatives, equilibria, first_equilibrium
from .pressurized import (
    bundle_shape,
    flatten_batch,
    plate_distance,
    plate_strain_in_domain,
    pressurized,
    stack_muscles,
    unique_indices,
)
from .printing import equilibria_sheet, line, sheet, unit_line, unit_sheet
from .schemes import AbstractScheme, scheme_of


if TYPE_CHECKING:
    from .inverse import Recruited


@with_table_repr(unit_sheet, unit_line)
class MotorUnit(Module):
    """`count` equal muscles at one pressure, the smallest part that is activated."""

    muscle: Muscle
    count: IntBatch

    def __init__(self, muscle: Muscle, count: Values = 1):
        """**Arguments:** `muscle` [-]; `count`: how many of it [-], a whole number ≥ 1."""
        if not isinstance(muscle, Muscle):
            raise InvalidInputError("muscle", "must be a Muscle", muscle)
        check_count(count, "count")
        self.muscle, self.count = muscle, np.asarray(count)[()] if is_concrete(count) else count


@with_table_repr(equilibria_sheet)
class Equilibria(NamedTuple):
    """Strains of zero force, rising along the last axis, which ends in NaN where there
    are fewer. `stable`: the force falls with strain there. `count`: how many there are.
    """

    strain: Float[AnyArray, "*#points zero"]
    stable: Bool[AnyArray, "*#points zero"]
    count: Int[AnyArray, "*#points"]


@with_table_repr(sheet, line)
class Bundle(Module):
    """Motor units between rigid plates, in the order in which they are recruited.

    With rows of muscles, or of counts, it is a row of bundles, which broadcasts against pressures
    and strains in forces, free strains and equilibria.
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
        """**Arguments:**

        - `motor_units`: in the order of recruitment [-], at least one.
        - `supply_pressure`: the supply's gauge pressure [Pa], if it is known.
        - `scheme`: one of `fascicle.schemes`, by name or as an object [-].
        - `length`: the distance between the plates at rest [m]; left out, the muscles' length,
          which must then be the same for all. It is `None` in the field of that distance
          wherever all muscles are as long.

        **Raises:** `ValueError` for no units, an unknown scheme, unlike lengths without a
        distance between the plates, and lengths that can't go together.
        """
        units = tuple(motor_units)
        if not units:
            raise InvalidInputError(
                "motor_units", "must hold at least one motor unit", None, shown="none"
            )
        for unit in units:
            if not isinstance(unit, MotorUnit):
                raise InvalidInputError("motor_units", "must hold MotorUnit objects", unit)
        self.motor_units = units
        self.plate_distance = plate_distance(length, [unit.muscle for unit in units])
        known = supply_pressure is not None
        self.supply_pressure = _pressure(supply_pressure, "supply_pressure") if known else None
        self.scheme = scheme_of(scheme)

    @property
    def length(self) -> Batch:
        """Length at rest $L$ [m], between the plates."""
        broadcast_shape = self.motor_units[0].muscle.length
        return broadcast_shape if self.plate_distance is None else self.plate_distance

    @cached_property
    def ratios(self) -> Numbers | None:
        """$L/L_i$ [-] of each motor unit, on the last axis; `None` where all are 1."""
        if self.plate_distance is None:
            return None
        L = self.plate_distance
        return _joined([L / unit.muscle.length for unit in self.motor_units])

    @cached_property
    def counts(self) -> Whole:
        """Muscles in each motor unit [-], on the last axis."""
        return _joined([unit.count for unit in self.motor_units])

    @cached_property
    def groups(self) -> tuple[tuple[tuple[int, ...], Muscle], ...]:
        """Units of the same laws, with their muscles as one, evaluated together."""
        return tuple(stack_muscles([unit.muscle for unit in self.motor_units]))

    def force(self, pressures: Values, strain: Values, resistance: bool = True) -> Batch:
        """Pulling force of all units together, equation (B1).

        **Arguments:**

        - `pressures`: gauge pressures [Pa], one for each motor unit on the last axis.
        - `strain`: the bundle's contraction $\\varepsilon$ [-]; broadcasts against the rest.
        - `resistance`: whether units past their own free strain push back [-].

        **Returns:** force [N].

        **Raises:** `ValueError` for a wrong number of pressures and values off the domain.
        """
        forces = self.unit_forces(pressures, strain, resistance)
        return array_namespace(forces).sum(forces, axis=-1)

    def unit_forces(self, pressures: Values, strain: Values, resistance: bool = True) -> PerUnit:
        """Pulling force of each motor unit, its muscles together.

        **Arguments:**

        - `pressures`: gauge pressures [Pa], one for each motor unit on the last axis.
        - `strain`: the bundle's contraction $\\varepsilon$ [-]; broadcasts against the rest.
        - `resistance`: whether units past their own free strain push back [-].

        **Returns:** forces [N], motor units on the last axis.

        **Raises:** `ValueError` for a wrong number of pressures and values off the domain.
        """
        P, eps = self._pressures(pressures), self._strain(strain)
        self._shape(pressures=P, strain=eps)
        forces = evaluate(_unit_forces, self, P, eps)
        # outside what is compiled, so that one compilation serves both
        return forces if resistance else where(forces > 0, forces, 0.0)

    def free_strain(self, pressures: Values, resistance: bool = True) -> Batch:
        """Smallest strain at which the force vanishes; without resistance, the largest.

        **Arguments:**

        - `pressures`: gauge pressures [Pa], one for each motor unit on the last axis.
        - `resistance`: whether units past their own free strain push back [-].

        **Returns:** strain [-]. It jumps with pressure where two zeros meet and vanish.

        **Raises:** `ValueError` for a wrong number of pressures and values off the domain.
        """
        P = self._pressures(pressures)
        if not resistance:
            return evaluate(_free_strain, self, P, static=(False,))
        return self._search(_free_strain, P, static=(True,))

    def equilibria(self, pressures: Values, resistance: bool = True) -> Equilibria:
        """All strains at which the force vanishes, and whether they are stable.

        **Arguments:**

        - `pressures`: gauge pressures [Pa], one for each motor unit on the last axis.
        - `resistance`: whether units past their own free strain push back [-]. Without it
          the bundle is slack beyond its free strain, which alone is given.

        **Returns:** `Equilibria`: strains [-] and stability, NaN-padded on a new last axis.

        **Raises:** `ValueError` for a wrong number of pressures and values off the domain.
        """
        P = self._pressures(pressures)
        if not resistance:
            return evaluate(_equilibria, self, P, static=(False,))
        return self._search(_equilibria, P, static=(True,))

    def strain_at(self, force: Values, pressures: Values) -> Equilibria:
        """All strains at which the bundle pulls with a force: where a hanging load may rest.

        **Arguments:**

        - `force`: $F$ [N] between the plates, negative where they are pushed together.
        - `pressures`: gauge pressures [Pa], one for each motor unit on the last axis; the rest
          broadcasts against `force`.

        **Returns:** `Equilibria`: strains [-] from straight fibers to the end of the domain, and
        stability, NaN-padded on a new last axis; a `count` of 0 where none holds it.

        **Raises:** `ValueError` for a wrong number of pressures and values off the domain.
        """
        F, P = (
            match_array_type(force, check_finite(force, "force", "N")),
            self._pressures(pressures),
        )
        return self._search(_strain_at, P, F)

    def recruit(
        self,
        force: Values,
        strain: Values,
        supply: Values = None,
        scheme: AbstractScheme | str | None = None,
        prefer: str = "efficiency",
        *,
        present: Values = None,
        resistance: bool = True,
    ) -> "Recruited":
        """State and pressures that give a force at a strain, equation (B9).

        **Arguments:**

        - `force`: the demanded pulling force [N].
        - `strain`: the bundle's contraction [-]; broadcasts against `force`.
        - `supply`: the supply's pressure [Pa], one for all; left out, the bundle's own.
        - `scheme`: one of `fascicle.schemes`, by name or as an object; left out, the bundle's own.
        - `prefer`: of several solutions, "efficiency" for the one that takes least fluid, or
          "nearest" for the one whose pressures are nearest to `present`.
        - `present`: the pressures now [Pa], units on the last axis; the rest broadcasts.
        - `resistance`: whether units past their own free strain push back.

        **Returns:** `Recruited`: pressures [Pa], state, force [N], status and all solutions.

        **Raises:** `ValueError` for values off the domain, and for no supply pressure.
        """
        solve = import_late("bundle.recruitment.recruit")
        options = {"present": present, "resistance": resistance}
        return solve(self, force, strain, supply, scheme, prefer, **options)

    def workspace(
        self,
        supply_pressure: Values = None,
        levels: Values = 7,
        strain: Values = None,
        resistance: bool = True,
        scheme: AbstractScheme | str | None = None,
    ) -> Any:
        """The force-strain region of every recruitment state.

        **Arguments:**

        - `supply_pressure`: [Pa]; left out, the bundle's own.
        - `levels`: throttled pressures of the curves [Pa], or how many of them.
        - `strain`: rising strains [-]; left out, 201 from zero to the largest free strain.
        - `resistance`: whether units past their own free strain push back.
        - `scheme`: one of `fascicle.schemes`, by name or as an object; left out, the bundle's own.

        **Returns:** a `Space`: forces [N], strains [-], pressures [Pa].

        **Raises:** `ValueError` where no supply pressure is known or a value is off.
        """
        space = import_late("bundle.workspace.space")
        return space(self, supply_pressure, levels, strain, resistance, scheme)

    def reversal(
        self, unit: int = 2, supply_pressure: Values = None, resistance: bool = True
    ) -> Any:
        """Turn of the free strain as a unit's pressure rises from zero to the supply's.

        **Arguments:**

        - `unit`: whose pressure rises, counted from 1.
        - `supply_pressure`: of the units before it [Pa]; left out, the bundle's own.
        - `resistance`: whether units past their own free strain push back.

        **Returns:** a `Reversal`: pressure [Pa], strains and depth [-].

        **Raises:** `ValueError` for a unit that doesn't exist, and for no supply pressure.
        """
        return import_late("bundle.reversal.reversal")(self, unit, supply_pressure, resistance)

    def efficiency_map(
        self,
        supply_pressure: Values = None,
        path: str = "isobaric",
        force: Values = None,
        strain: Values = None,
        resistance: bool = True,
        scheme: AbstractScheme | str | None = None,
    ) -> Any:
        """Efficiency over the force-strain space.

        **Arguments:**

        - `supply_pressure`: $P_s$ [Pa]; left out, the bundle's own.
        - `path`: "isobaric" or "isotonic".
        - `force`: forces [N]; left out, 80 even ones up to the blocked force of all units.
        - `strain`: positive strains [-]; left out, multiples of 1/375 to the free strain.
        - `resistance`: whether units past their own free strain push back.
        - `scheme`: one of `fascicle.schemes`, by name or as an object; left out, the bundle's own.

        **Returns:** an `EfficiencyMap`: forces [N], strains and efficiencies [-].

        **Raises:** `ValueError` for values off the domain, and for no supply pressure.
        """
        efficiency_map = import_late("bundle.efficiency.efficiency_map")
        return efficiency_map(self, supply_pressure, path, force, strain, resistance, scheme)

    def average_efficiency(
        self,
        supply_pressure: Values = None,
        path: str = "isobaric",
        resistance: bool = True,
        scheme: AbstractScheme | str | None = None,
    ) -> float:
        """Average efficiency over the force-strain space; arguments as of `efficiency_map`.

        **Arguments:**

        - `supply_pressure`: $P_s$ [Pa]; left out, the bundle's own.
        - `path`: "isobaric" or "isotonic".
        - `resistance`: whether units past their own free strain push back.
        - `scheme`: one of `fascicle.schemes`, by name or as an object; left out, the bundle's own.

        **Returns:** efficiency [-].

        **Raises:** `ValueError` for values off the domain, and for no supply pressure.
        """
        average = import_late("bundle.efficiency.average_efficiency")
        return average(self, supply_pressure, path, resistance, scheme)

    def plot(
        self, pressures: Values = None, strains: Values = None, resistance: bool = True
    ) -> Any:
        """Its force-strain space, state by state; or at given pressures its force, unit by unit.

        **Arguments:**

        - `pressures`: one for each motor unit [Pa]; left out, the space up to the supply's.
        - `strains`: contractions [-], rising; left out, to the largest free strain or past it.
        - `resistance`: whether units past their own free strain push back [-].

        **Returns:** a figure of matplotlib's [-].

        **Raises:** `ValueError` where there are neither pressures nor a supply's.
        """
        return import_late("plot.objects.of_bundle")(self, pressures, strains, resistance)

    def compile(self, backend: str = "jax") -> Callable[[Values, Values], Any]:
        """The force alone as a bare function, with this bundle held constant and nothing checked.

        **Arguments:** `backend`: "jax" for arrays, batches and gradients, or "casadi" for single
        points and their slopes (`with_slopes`) [-].

        **Returns:** a function of the units' pressures [Pa] and the strain [-] that gives the
        force [N].

        **Raises:** `ValueError` for an unknown backend, `ImportError` where it is not installed.
        """
        if check_choice(backend, BACKENDS, "backend") == "casadi":
            return import_late("export.point_function.bundle_function")(self)
        require("jax")
        from ..core.jax_backend import jit

        return jit(partial(_force, self))

    def replace(self, **changes: Any) -> "Bundle":
        """The same bundle, but for some of its arguments.

        **Arguments:** `changes`: arguments of the class, such as `scheme="batch"` [-].

        **Returns:** a new bundle [-]; this one stays as it is.

        **Raises:** `ValueError`, one line, for unknown names and for what a bundle can't be.
        """
        return replace_checked(self, changes, length=self.plate_distance)

    def _strain(self, strain: Values) -> Batch:
        single = isinstance(strain, float) and self.plate_distance is None
        if single and 0.0 <= strain <= LARGEST_STRAIN:
            return np.float64(strain)  # a check of each muscle would take as long as their law
        muscles = [unit.muscle for unit in self.motor_units]
        if self.plate_distance is not None:
            return plate_strain_in_domain(strain, self.plate_distance, muscles)
        # a muscle that stands for several units needn't be asked again
        once = {id(muscle): muscle for muscle in muscles}.values()
        return check_strain(
            strain, reduce(np.maximum, [lowest_strain(*strain_domain(m)) for m in once])
        )

    def _pressures(self, pressures: Values) -> PerUnit:
        P, n = _pressure(pressures), len(self.motor_units)
        if P.ndim == 0 or P.shape[-1] != n:
            got = "a single pressure" if P.ndim == 0 else f"{P.shape[-1]}"
            raise InvalidInputError(
                "pressures",
                f"must hold one pressure for each of the {n} motor units on the last axis",
                P.shape[-1] if P.ndim else 1,
                shown=got,
            )
        for i, unit in enumerate(self.motor_units):
            unit.muscle.tuning.warn_extrapolation(P[..., i])
        return P

    def _shape(self, pressures: PerUnit, **others: Numbers) -> tuple[int, ...]:
        """The shape that these have together [-], less the units' axis and rows of bundles."""
        shapes = {name: np.shape(x) for name, x in others.items()}
        shape = broadcast_shape(pressures=np.shape(pressures)[:-1], **shapes)
        if self._batch:
            broadcast_shape(muscles=self._batch, pressures=shape)
        return shape

    @cached_property
    def _batch(self) -> tuple[int, ...]:
        """The shape of a row of bundles [-]."""
        return bundle_shape(self)

    def _search(self, law: Any, *arrays: Numbers, static: tuple = ()) -> Any:
        """The result of a `law` that searches. Where JAX traces for derivatives alone, NumPy
        searches, and the strains get their derivatives afterwards.
        """
        self._shape(**dict(zip(("pressures", "force"), arrays, strict=False)))
        primal = primal_numpy(self, *arrays)
        if primal is None:
            return evaluate(law, self, *arrays, static=static)
        bundle, *numbers = primal
        result = bundle._search(law, *numbers, static=static)
        if isinstance(result, Equilibria):
            return result._replace(strain=evaluate(_with_derivatives, self, result.strain, *arrays))
        return evaluate(_with_derivatives, self, result[..., None], *arrays)[..., 0]


def _force(bundle: Bundle, pressures: PerUnit, strain: Numbers) -> Numbers:
    return pressurized(bundle, pressures).force(strain)[0]


def _unit_forces(bundle: Bundle, pressures: PerUnit, strain: Numbers) -> Numbers:
    return pressurized(bundle, pressures).unit_forces(strain)[0]


def _free_strain(bundle: Bundle, pressures: PerUnit, resistance: bool) -> Numbers:
    if not resistance:
        free = pressurized(bundle, pressures).free_strains
        return array_namespace(free).max(free, axis=-1)
    batch, shape = flatten_batch(bundle, pressures)
    return first_equilibrium(batch).reshape(shape)


def _equilibria(bundle: Bundle, pressures: PerUnit, resistance: bool) -> Equilibria:
    if not resistance:
        strain = _free_strain(bundle, pressures, False)[..., None]
        exists = strain > -np.inf
        return Equilibria(strain, exists, array_namespace(exists).sum(exists, axis=-1))
    batch, shape = flatten_batch(bundle, pressures)
    return Equilibria(*(x.reshape((*shape, *x.shape[1:])) for x in equilibria(batch)))


def _strain_at(bundle: Bundle, pressures: PerUnit, force: Numbers) -> Equilibria:
    batch, shape = flatten_batch(bundle, pressures, force)
    load = array_namespace(force).broadcast_to(force, shape).reshape(-1)
    return Equilibria(*(x.reshape((*shape, *x.shape[1:])) for x in equilibria(batch, load)))


def _with_derivatives(
    bundle: Bundle, strain: Numbers, pressures: PerUnit, force: Numbers = 0.0
) -> Numbers:
    """Equilibria [-] that were found without derivatives, with them."""
    batch, shape = flatten_batch(bundle, pressures, force)
    load = array_namespace(force).broadcast_to(force, shape).reshape(-1, 1)
    roots = attach_derivatives(batch.pressurized(), load, strain.reshape(*load.shape[:1], -1))
    return roots.reshape(strain.shape)


def _joined(values: list[Any]) -> Any:
    """One for each unit, on the last axis."""
    at_work = array_namespace(*values)
    return at_work.stack(at_work.broadcast_arrays(*values), axis=-1)


def _pressure(value: Values, name: str = "pressures") -> Batch:
    checked = check_interval(value, 0.0, HIGHEST_PRESSURE, name, "Pa", "(gauge)", (True, True))
    if not has_units(value):
        warn_pressure_units(checked)
    return match_array_type(value, checked)


def resolve_scheme(bundle: Bundle, scheme: AbstractScheme | str | None) -> AbstractScheme:
    """The scheme that is asked for, or the bundle's own.

    **Arguments:** `bundle` [-]; `scheme`: by name or as an object [-], or `None`.

    **Returns:** the scheme [-].

    **Raises:** `ValueError` for an unknown name, and for a row of bundles.
    """
    check_single(bundle)
    return bundle.scheme if scheme is None else scheme_of(scheme)


def resolve_supply_pressure(bundle: Bundle, supply_pressure: Values = None) -> float:
    """The supply pressure that holds: the one given, else the bundle's own.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `supply_pressure`: the one given [Pa], or None.

    **Returns:** supply pressure [Pa].

    **Raises:** `ValueError` where there is neither, and for a row of bundles.
    """
    check_single(bundle)
    supply = bundle.supply_pressure if supply_pressure is None else supply_pressure
    if supply is None:
        raise InvalidInputError(
            "supply_pressure", "must be given in Pa", None, "the bundle has none of its own"
        )
    P = check_interval(
        supply, 0.0, HIGHEST_PRESSURE, "supply_pressure", "Pa", "(gauge)", (False, True)
    )
    return float(check_plausible(P, "supply_pressure"))


def check_single(bundle: Any) -> None:
    """Refuse what is no `Bundle`, and batches of them."""
    if not isinstance(bundle, Bundle):
        remedy = "make one of it: fs.Bundle([fs.MotorUnit(muscle)])"
        raise InvalidInputError(
            "bundle", "must be a Bundle", bundle, remedy, shown=type(bundle).__name__
        )
    if shape := bundle._batch:
        raise InvalidInputError(
            "bundle",
            "must be a single one here",
            None,
            "make a bundle of each row of its muscles",
            shown=f"rows of the shape {shape}",
        )


def distinct_units(bundle: Bundle) -> tuple[Bundle, Int[np.ndarray, " unit"]]:
    """The unlike units of a bundle, so that equal ones needn't be evaluated twice.

    **Arguments:** `bundle`: the bundle [-].

    **Returns:** a bundle of its unlike units alone, and which of them each unit is [-].
    """
    unique, inverse = unique_indices(bundle.motor_units)
    units = [bundle.motor_units[i] for i in unique]
    return Bundle(units, length=bundle.plate_distance), np.array(inverse)
