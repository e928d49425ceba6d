r"""Chambers joined to their muscles: pressure of the fluid, and its rate of change.

A unit's chamber of state $s$ is joined to its muscles by their volume, which depends on strain and
pressure. With $g(s, P, V) = 0$ and $\dot s$ affine in $\dot V$,

$$\dot P = - \frac{g_s \cdot \dot s|_{\dot V = 0}
  + (g_s \cdot \dot s_{\dot V} + g_V)\, V_\varepsilon \dot\varepsilon}
  {g_P + (g_s \cdot \dot s_{\dot V} + g_V)\, V_P}, \qquad
  \dot V = V_\varepsilon \dot\varepsilon + V_P \dot P. \tag{T4}$$

The pressure itself is the root of $g$, by Newton's method from an integrated pressure.
"""

from typing import NamedTuple

import numpy as np
from jax import lax

from ..core.array_namespace import absolute, array_namespace, maximum
from ..core.roots import guarded
from ..core.types import Batch, BoolBatch, Numbers
from ..fluid.chamber import Balance
from ..muscle.surface import Surface
from .muscles import Volumes
from .plant import Plant


_FLAT = 1e-2  # of the fluid's own slope, below which the residual hardly tells pressures apart


class ChamberEvaluation(NamedTuple):
    """Chambers at `pressures` [Pa]: the `muscles` of each unit, the volume they fill [m³] with its
    slopes by strain [m³] and pressure [m³/Pa], the residual (F12) as a `balance` [SI], and
    `volume_sensitivity`: $g_s \\cdot \\dot s_{\\dot V} + g_V$ [SI].
    """

    pressures: Numbers
    muscles: Surface
    volume: Numbers
    by_strain: Numbers
    by_pressure: Numbers
    balance: Balance
    volume_sensitivity: Numbers

    @property
    def slope(self) -> Numbers:
        """$\\mathrm{d}g/\\mathrm{d}P$ [SI] of a constant state."""
        return self.balance.by_pressure + self.balance.by_volume * self.by_pressure

    @property
    def is_folded(self) -> BoolBatch:
        """True where the volume falls with pressure by more than fluid and hose expand."""
        return self.slope <= 0

    @property
    def rise(self) -> Numbers:
        """$g_P + (g_s \\cdot \\dot s_{\\dot V} + g_V)\\,V_P$ [SI], the denominator of (T4)."""
        return self.balance.by_pressure + self.volume_sensitivity * self.by_pressure

    @property
    def step(self) -> Numbers:
        """Newton's step [Pa] towards the root."""
        return -self.balance.value / self._steep(self.slope)

    @property
    def working_step(self) -> Numbers:
        """Newton's step [Pa] towards the root, with the work of the walls."""
        return -self.balance.value / self._steep(self.rise)

    @property
    def is_unsolved(self) -> BoolBatch:
        """True where the root is farther away than 1 Pa and 1e-4 of the pressure."""
        return absolute(self.step) > 1.0 + 1e-4 * absolute(self.pressures)

    def pressure_rate(self, fixed_volume_rate: Numbers, strain_rate: Batch) -> Numbers:
        """$\\dot P$ [Pa/s], equation (T4), of chambers with a `fixed_volume_rate` [SI], at a
        `strain_rate` [1/s].
        """
        xp = array_namespace(fixed_volume_rate, strain_rate)
        flowing = xp.sum(self.balance.by_state * fixed_volume_rate, axis=-1)
        push = flowing + self.volume_sensitivity * self.by_strain * strain_rate
        return -push / self._steep(self.rise)

    def _steep(self, slope: Numbers) -> Numbers:
        """A `slope` of the residual [SI], or the fluid's own where that vanishes."""
        fluid_slope = self.balance.by_pressure
        return guarded(absolute(slope) > _FLAT * fluid_slope, slope, fluid_slope)


def evaluate_chambers(
    plant: Plant, chambers: Numbers, strains: Numbers, pressures: Numbers
) -> ChamberEvaluation:
    """`chambers` [SI] of a `plant` at `strains` [-], evaluated at `pressures` [Pa]."""
    return assemble_chambers(plant, chambers, pressures, *muscle_volumes(plant, strains, pressures))


def muscle_volumes(plant: Plant, strains: Numbers, pressures: Numbers) -> tuple[Surface, Volumes]:
    """Muscles of a `plant` at `strains` [-] and `pressures` [Pa], one of each unit, and the
    volumes of all of them [m³].
    """
    n, muscles = plant.counts, plant.muscles.at(pressures, strains)
    V, by_strain, by_pressure = plant.muscles.volumes(muscles, strains, plant.lengths)
    return muscles, Volumes(n * V, n * by_strain, n * by_pressure)


def assemble_chambers(
    plant: Plant, chambers: Numbers, pressures: Numbers, muscles: Surface, volumes: Volumes
) -> ChamberEvaluation:
    """`chambers` [SI] of a `plant` evaluated at `pressures` [Pa], from `muscles` [SI] and their
    `volumes` [m³] there.
    """
    V, by_strain, by_pressure = volumes
    g = plant.chamber.balance(chambers, pressures, V)
    per_volume = g.by_state * plant.chamber.per_volume_rate(chambers, pressures)
    sensitivity = array_namespace(per_volume).sum(per_volume, axis=-1) + g.by_volume
    return ChamberEvaluation(pressures, muscles, V, by_strain, by_pressure, g, sensitivity)


def solve_pressures(
    plant: Plant, chambers: Numbers, strains: Numbers, guess: Numbers, steps: int
) -> Numbers:
    """Pressures [Pa] of `chambers` [SI] of a `plant` at `strains` [-], by `steps` of Newton's
    method from a `guess` [Pa].
    """
    lowest = plant.chamber.lowest_pressure

    def newton(P: Numbers, _: None) -> tuple[Numbers, None]:
        step = evaluate_chambers(plant, chambers, strains, P).step
        return maximum(P + step, (P + lowest) / 2), None  # half-way to no fluid at most

    if array_namespace(chambers, strains, guess) is np:
        for _ in range(steps):
            guess, _ = newton(guess, None)
        return guess
    # a loop, which is compiled once
    return lax.scan(newton, guess, length=steps)[0]
