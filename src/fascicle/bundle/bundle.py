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
from functools import partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from .._checks import one_of, within
from .._limits import whole
from .._methods import compilable
from .._types import Batch, IntBatch, PerUnit, Values
from ..muscle import Muscle
from ..muscle.entry import HIGHEST_PRESSURE
from ..muscle.piecewise import Pressurized as MusclesAtPressures
from .alike import stacked
from .plates import muscle_strain, plate_distance, plate_strain, within_reach
from .zeros import crossings, first_zero


SCHEMES = ("orderly", "batch")


class MotorUnit(eqx.Module):
    """`count` equal muscles at one pressure, the smallest part that is activated."""

    muscle: Muscle
    count: IntBatch

    def __init__(self, muscle: Muscle, count: Values = 1):
        """**Arguments:** `muscle` [-]; `count`: how many of it [-], a whole number ≥ 1."""
        if not isinstance(muscle, Muscle):
            raise ValueError(f"`muscle` must be a Muscle, got {muscle!r}.")
        whole(count, "count")
        self.muscle, self.count = muscle, jnp.asarray(count)


class Equilibria(eqx.Module):
    """Strains of zero force, rising along the last axis, which ends in NaN where there
    are fewer. `stable`: the force falls with strain there. `count`: how many there are.
    """

    strain: Float[Array, "*#points zero"]
    stable: Bool[Array, "*#points zero"]
    count: Int[Array, "*#points"]


class Bundle(eqx.Module):
    """Motor units between rigid plates, in the order in which they are recruited."""

    motor_units: tuple[MotorUnit, ...]
    supply_pressure: Batch | None
    scheme: str = eqx.field(static=True)
    plate_distance: Batch | None

    def __init__(
        self,
        motor_units: Sequence[MotorUnit],
        supply_pressure: Values = None,
        scheme: str = "orderly",
        length: Values = None,
    ):
        """**Arguments:**

        - `motor_units`: in the order of recruitment [-], at least one.
        - `supply_pressure`: the supply's gauge pressure [Pa], if it is known.
        - `scheme`: "orderly" or "batch" [-].
        - `length`: the distance between the plates at rest [m]; left out, the muscles' length,
          which must then be the same for all. It is `None` in the field of that distance
          wherever all muscles are as long.

        **Raises:** `ValueError` for no units, an unknown scheme, unlike lengths without a
        distance between the plates, and lengths that can't go together.
        """
        units = tuple(motor_units)
        if not units:
            raise ValueError("`motor_units` must hold at least one motor unit, got none.")
        for unit in units:
            if not isinstance(unit, MotorUnit):
                raise ValueError(f"`motor_units` must hold MotorUnit objects, got {unit!r}.")
        self.motor_units = units
        self.plate_distance = plate_distance(length, [unit.muscle for unit in units])
        self.supply_pressure = None
        if supply_pressure is not None:
            self.supply_pressure = _pressure(supply_pressure, "supply_pressure")
        self.scheme = one_of(scheme, SCHEMES, "scheme")

    @property
    def length(self) -> Batch:
        """Length at rest $L$ [m], between the plates."""
        common = self.motor_units[0].muscle.length
        return common if self.plate_distance is None else self.plate_distance

    @property
    def ratios(self) -> Batch | None:
        """$L/L_i$ [-] of each motor unit, on the last axis; `None` where all are 1."""
        if self.plate_distance is None:
            return None
        L = self.plate_distance
        return jnp.stack([L / unit.muscle.length for unit in self.motor_units], axis=-1)

    @property
    def counts(self) -> IntBatch:
        """Muscles in each motor unit [-], on the last axis."""
        return jnp.stack([unit.count for unit in self.motor_units], axis=-1)

    @compilable
    def force(self, pressures: Values, strain: Values, resistance: bool = True) -> Batch:
        """Pulling force of all units together, equation (B1).

        **Arguments:**

        - `pressures`: gauge pressures [Pa], one for each motor unit on the last axis.
        - `strain`: the bundle's contraction $\\varepsilon$ [-]; broadcasts against the rest.
        - `resistance`: whether units past their own free strain push back [-].

        **Returns:** force [N].

        **Raises:** `ValueError` for a wrong number of pressures and values off the domain.
        """
        return jnp.sum(self.unit_forces(pressures, strain, resistance), axis=-1)

    @compilable
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
        forces = _unit_forces(self, P, eps)
        # outside what is compiled, so that one compilation serves both
        return forces if resistance else jnp.where(forces > 0, forces, 0.0)

    @compilable
    def free_strain(self, pressures: Values, resistance: bool = True) -> Batch:
        """Smallest strain at which the force vanishes; without resistance, the largest.

        **Arguments:**

        - `pressures`: gauge pressures [Pa], one for each motor unit on the last axis.
        - `resistance`: whether units past their own free strain push back [-].

        **Returns:** strain [-]. It jumps with pressure where two zeros meet and vanish.

        **Raises:** `ValueError` for a wrong number of pressures and values off the domain.
        """
        return _free_strain(self, self._pressures(pressures), bool(resistance))

    @compilable
    def equilibria(self, pressures: Values, resistance: bool = True) -> Equilibria:
        """All strains at which the force vanishes, and whether they are stable.

        **Arguments:**

        - `pressures`: gauge pressures [Pa], one for each motor unit on the last axis.
        - `resistance`: whether units past their own free strain push back [-]. Without it
          the bundle is slack beyond its free strain, which alone is given.

        **Returns:** `Equilibria`: strains [-] and stability, NaN-padded on a new last axis.

        **Raises:** `ValueError` for a wrong number of pressures and values off the domain.
        """
        return _equilibria(self, self._pressures(pressures), bool(resistance))

    def _strain(self, strain: Values) -> Batch:
        muscles = [unit.muscle for unit in self.motor_units]
        if self.plate_distance is not None:
            return within_reach(strain, self.plate_distance, muscles)
        # a muscle that stands for several units needn't be asked again
        once = {id(muscle): muscle for muscle in muscles}.values()
        checked = [muscle._checked(0.0, strain)[1] for muscle in once]
        return checked[0]

    def _pressures(self, pressures: Values) -> PerUnit:
        P, n = _pressure(pressures), len(self.motor_units)
        if P.ndim == 0 or P.shape[-1] != n:
            got = "a single pressure" if P.ndim == 0 else f"{P.shape[-1]}"
            raise ValueError(
                f"`pressures` must hold one pressure for each of the {n} motor units"
                f" on the last axis, got {got}."
            )
        for i, unit in enumerate(self.motor_units):
            unit.muscle.tuning.warn_beyond(P[..., i])
        return P


class Pressurized(eqx.Module):
    """A bundle at given pressures, each unit's free and collapse strain solved for.

    Units whose muscles have the same laws are evaluated as one batched muscle, so that a
    bundle compiles no longer than its unlike muscles do.
    """

    groups: tuple[MusclesAtPressures, ...]
    places: tuple[tuple[int, ...], ...] = eqx.field(static=True)
    counts: IntBatch
    ratios: Batch | None

    def each(self, function: Callable[[MusclesAtPressures], Batch]) -> PerUnit:
        """`function` of one muscle of every unit, units on a new last axis."""
        return self._ordered([jax.vmap(function, out_axes=-1)(group) for group in self.groups])

    def along(self, function: Callable[..., Batch], *strains: Batch) -> PerUnit:
        """`function` of one muscle of every unit and of its strains [-] at the bundle's."""
        if self.ratios is None:
            return self.each(lambda muscle: function(muscle, *strains))

        def one(muscle: MusclesAtPressures, ratio: Batch) -> Batch:
            return function(muscle, *(muscle_strain(ratio, strain) for strain in strains))

        return self._ordered(
            [
                jax.vmap(one, in_axes=(0, -1), out_axes=-1)(
                    group, self.ratios[..., np.array(places)]
                )
                for group, places in zip(self.groups, self.places, strict=True)
            ]
        )

    @property
    def kinks(self) -> PerUnit:
        """Strains of the bundle [-] at which its muscles' forces have kinks, units last."""
        kinks = self.each(lambda muscle: muscle.kinks)
        return kinks if self.ratios is None else plate_strain(self.ratios, kinks)

    @property
    def free_strains(self) -> PerUnit:
        """Strain of the bundle [-] at which each unit alone neither pulls nor pushes."""
        strains = self.each(lambda muscle: muscle.column.free_strain)
        return strains if self.ratios is None else plate_strain(self.ratios, strains)

    def unit_forces(self, strain: Batch) -> PerUnit:
        """Force of each unit [N], its muscles together, at `strain` [-]."""
        return self.counts * self.along(lambda muscle, eps: muscle.response(eps).force, strain)

    def force(self, strain: Batch) -> Batch:
        """Force of all units [N] at `strain` [-], (B1)."""
        return jnp.sum(self.unit_forces(strain), axis=-1)

    def _ordered(self, values: list[Batch]) -> PerUnit:
        order = np.argsort([i for places in self.places for i in places])
        return jnp.concatenate(values, axis=-1)[..., order]


def pressurized(bundle: Bundle, pressures: PerUnit) -> Pressurized:
    """`bundle` at `pressures` [Pa], one for each unit on the last axis."""
    at = jax.vmap(lambda muscle, pressure: muscle._law().at(pressure), in_axes=(0, -1))
    stacks = stacked([unit.muscle for unit in bundle.motor_units])
    groups = tuple(at(muscles, pressures[..., np.array(row)]) for row, muscles in stacks)
    return Pressurized(groups, tuple(row for row, _ in stacks), bundle.counts, bundle.ratios)


@jax.jit
def _unit_forces(bundle: Bundle, pressures: PerUnit, strain: Batch) -> PerUnit:
    return pressurized(bundle, pressures).unit_forces(strain)


@partial(jax.jit, static_argnums=2)
def _free_strain(bundle: Bundle, pressures: PerUnit, resistance: bool) -> Batch:
    def one(pressures: PerUnit) -> Batch:
        at = pressurized(bundle, pressures)
        if not resistance:
            return jnp.max(at.free_strains)
        return first_zero(at.force, at.kinks)

    return _batched(one, pressures)


@partial(jax.jit, static_argnums=2)
def _equilibria(bundle: Bundle, pressures: PerUnit, resistance: bool) -> Equilibria:
    # a unit adds one dip of the force, before it collapses, so two zeros at most
    most = 2 * len(bundle.motor_units) + 1

    def one(pressures: PerUnit) -> tuple[Array, Array, Array]:
        at = pressurized(bundle, pressures)
        return crossings(at.force, at.kinks, most)

    if resistance:
        return Equilibria(*_batched(one, pressures))
    strain = _free_strain(bundle, pressures, False)[..., None]
    return Equilibria(strain, jnp.ones(strain.shape, bool), jnp.ones(strain.shape[:-1], int))


def _batched(function: Callable, pressures: PerUnit) -> Any:
    """`function` of one pressure vector, over all the axes before the last."""
    for _ in range(pressures.ndim - 1):
        function = jax.vmap(function)
    return function(pressures)


def _pressure(value: Values, name: str = "pressures") -> Batch:
    return within(value, 0.0, HIGHEST_PRESSURE, name, "Pa", "(gauge)", (True, True))
