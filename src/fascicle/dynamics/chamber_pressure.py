r"""Chambers joined to their muscles: what pressure fluid has, and how fast that changes.

A unit's chamber of state $s$ is joined to its muscles by their volume, which depends on strain and
pressure. With $g(s, P, V) = 0$ and $\dot s$ affine in $\dot V$,

$$\dot P = - \frac{g_s \cdot \dot s|_{\dot V = 0}
  + (g_s \cdot \dot s_{\dot V} + g_V)\, V_\varepsilon \dot\varepsilon}
  {g_P + (g_s \cdot \dot s_{\dot V} + g_V)\, V_P}, \qquad
  \dot V = V_\varepsilon \dot\varepsilon + V_P \dot P. \tag{T4}$$

The pressure itself is the root of $g$, which Newton's method takes from where the rates led.
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


_TURNS = 1e-2  # of the fluid's own slope, below which a pressure is as good as any near it


class ChamberEvaluation(NamedTuple):
    """Chambers at `pressures` [Pa]: what muscles do there, the volume they fill [m³] with its
    slopes by strain [m³] and pressure [m³/Pa], the residual (F12) there as a `balance` [SI], and
    `moved`: $g_s \\cdot \\dot s_{\\dot V} + g_V$ [SI].
    """

    pressures: Numbers
    at: Surface
    volume: Numbers
    by_strain: Numbers
    by_pressure: Numbers
    balance: Balance
    volume_sensitivity: Numbers

    @property
    def slope(self) -> Numbers:
        """$\\mathrm{d}g/\\mathrm{d}P$ [SI] of a state that stays."""
        return self.balance.by_pressure + self.balance.by_volume * self.by_pressure

    @property
    def is_folded(self) -> BoolBatch:
        """True where the volume falls with pressure by more than fluid and hose give way."""
        return self.slope <= 0

    @property
    def rise(self) -> Numbers:
        """$g_P + (g_s \\cdot \\dot s_{\\dot V} + g_V)\\,V_P$ [SI], below the line of (T4)."""
        return self.balance.by_pressure + self.volume_sensitivity * self.by_pressure

    @property
    def step(self) -> Numbers:
        """Newton's step [Pa] towards the root."""
        return -self.balance.value / self._steep(self.slope)

    @property
    def working_step(self) -> Numbers:
        """Newton's step [Pa] towards the root, the walls working along."""
        return -self.balance.value / self._steep(self.rise)

    @property
    def is_unsolved(self) -> BoolBatch:
        """True where the root is farther away than a pascal and a ten thousandth."""
        return absolute(self.step) > 1.0 + 1e-4 * absolute(self.pressures)

    def pressure_rate(self, fixed_volume_rate: Numbers, strain_rate: Batch) -> Numbers:
        """$\\dot P$ [Pa/s], equation (T4), of chambers that change by
        `fixed_volume_rate` [SI] in a constant volume, at a `strain_rate` [1/s].
        """
        xp = array_namespace(fixed_volume_rate, strain_rate)
        flowing = xp.sum(self.balance.by_state * fixed_volume_rate, axis=-1)
        push = flowing + self.volume_sensitivity * self.by_strain * strain_rate
        return -push / self._steep(self.rise)

    def _steep(self, slope: Numbers) -> Numbers:
        """A `slope` of the residual [SI]; where it turns, the fluid's own, so that nothing is
        divided by zero.
        """
        fluid_slope = self.balance.by_pressure
        return guarded(absolute(slope) > _TURNS * fluid_slope, slope, fluid_slope)


def evaluate_chambers(
    plant: Plant, chambers: Numbers, strains: Numbers, pressures: Numbers
) -> ChamberEvaluation:
    """`chambers` [SI] of a `plant` [-] at `strains` [-], taken to be at `pressures` [Pa]."""
    return assemble_chambers(plant, chambers, pressures, *muscle_volumes(plant, strains, pressures))


def muscle_volumes(plant: Plant, strains: Numbers, pressures: Numbers) -> tuple[Surface, Volumes]:
    """Muscles of a `plant` [-] at `strains` [-] and `pressures` [Pa], one of each unit, and the
    volumes of all of them [m³].
    """
    n, at = plant.counts, plant.muscles.at(pressures, strains)
    V, by_strain, by_pressure = plant.muscles.volumes(at, strains, plant.lengths)
    return at, Volumes(n * V, n * by_strain, n * by_pressure)


def assemble_chambers(
    plant: Plant, chambers: Numbers, pressures: Numbers, at: Surface, volumes: Volumes
) -> ChamberEvaluation:
    """`chambers` [SI] of a `plant` [-] taken to be at `pressures` [Pa], where muscles are `at` work
    [SI] and span `volumes` [m³].
    """
    V, by_strain, by_pressure = volumes
    g = plant.chamber.balance(chambers, pressures, V)
    along = array_namespace(g.by_state).sum(
        g.by_state * plant.chamber.per_volume_rate(chambers, pressures), axis=-1
    )
    return ChamberEvaluation(pressures, at, V, by_strain, by_pressure, g, along + g.by_volume)


def solve_pressures(
    plant: Plant, chambers: Numbers, strains: Numbers, guess: Numbers, steps: int
) -> Numbers:
    """Pressures [Pa] of `chambers` [SI] of a `plant` at `strains` [-].

    Takes `steps` of Newton's method from `guess` [Pa].
    """
    lowest = plant.chamber.lowest_pressure

    def stepped(P: Numbers, _: None) -> tuple[Numbers, None]:
        # half of the way to no fluid at all at most
        return maximum(
            P + evaluate_chambers(plant, chambers, strains, P).step, (P + lowest) / 2
        ), None

    if array_namespace(chambers, strains, guess) is np:
        for _ in range(steps):
            guess, _ = stepped(guess, None)
        return guess
    # a loop, which is compiled once
    return lax.scan(stepped, guess, length=steps)[0]
