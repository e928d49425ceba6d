r"""Chambers joined to their muscles: pressure of the fluid, and its rate of change.

A unit's chamber of state $s$ is joined to its muscles by their volume, which depends on strain and
pressure. With $g(s, P, V) = 0$ and $\dot s$ affine in $\dot V$,

$$\dot P = - \frac{g_s \cdot \dot s|_{\dot V = 0}
  + (g_s \cdot \dot s_{\dot V} + g_V)\, V_\varepsilon \dot\varepsilon}
  {g_P + (g_s \cdot \dot s_{\dot V} + g_V)\, V_P}, \qquad
  \dot V = V_\varepsilon \dot\varepsilon + V_P \dot P. \tag{T4}$$

The pressure itself is the root of $g$, by Newton's method from an integrated pressure.

**Fixed steps conserve energy.** When a muscle collapses, the slope of its volume jumps, and a
method of fixed steps that adds up $\dot V$ of its stages misses some of the change of volume: it
creates energy. A chamber's state $s$, whose rates are affine in $\dot V$ with a slope
$\dot s_{\dot V}$ that is affine in pressure, has a conserved state

$$k = s - \dot s_{\dot V}(P)\, V, \qquad
  \dot k = \dot s|_{\dot V = 0} - \frac{\mathrm{d} \dot s_{\dot V}}{\mathrm{d} P} \dot P\, V,
  \tag{T6}$$

which depends on the volume alone: of gas behind a wall, mass and enthalpy. At the end of a substep
the state follows from $k$ and the volume then, so that no volume is lost; the correction of its
pressure includes the wall's work.

**Source** of (T6): the first law, by parts.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from jax import lax

from ..core.array_namespace import absolute, array_namespace, maximum
from ..core.jax_backend import iterate
from ..core.roots import guarded
from ..core.types import Batch, BoolBatch, Numbers
from ..fluid import AbstractChamber
from ..fluid.chamber import StateResidual
from ..muscle.table import MuscleState
from .muscles import MuscleVolumes


if TYPE_CHECKING:
    from .plant import Plant

_FLAT = 1e-2  # of the fluid's own slope: below it a residual says little about the pressure


class ChamberEvaluation(NamedTuple):
    """Evaluation of a plant's chambers at `pressures` [Pa]: volumes, and the residual of the state.

    `muscles` of each unit; the `volume` they fill [m³] with its slopes by strain [m³] and pressure
    [m³/Pa]; the `residual` (F12) [SI]; `volume_sensitivity`, $g_s \\cdot \\dot s_{\\dot V} + g_V$.
    """

    pressures: Numbers
    muscles: MuscleState
    volume: Numbers
    by_strain: Numbers
    by_pressure: Numbers
    residual: StateResidual
    volume_sensitivity: Numbers

    @property
    def slope(self) -> Numbers:
        """Slope of the residual at a constant state, $\\mathrm{d}g/\\mathrm{d}P$ [SI]."""
        return self.residual.by_pressure + self.residual.by_volume * self.by_pressure

    @property
    def is_folded(self) -> BoolBatch:
        """True where the volume falls with pressure by more than fluid and hose expand."""
        return self.slope <= 0

    @property
    def pressure_slope(self) -> Numbers:
        """Denominator of (T4) [SI]: the slope with the walls' work, as volume follows pressure."""
        return self.residual.by_pressure + self.volume_sensitivity * self.by_pressure

    def newton_step(self, slope: Numbers) -> Numbers:
        """Newton's step [Pa] towards the root, by a `slope` of the residual [SI]."""
        return -self.residual.value / self._nonzero_slope(slope)

    @property
    def is_unsolved(self) -> BoolBatch:
        """True where Newton's step is longer than 1 Pa plus 1e-4 of the pressure."""
        # such a step changes the force by a ten-thousandth, less than a load cell shows
        return absolute(self.newton_step(self.slope)) > 1.0 + 1e-4 * absolute(self.pressures)

    def pressure_rate(self, state_rates: Numbers, strain_rate: Batch) -> Numbers:
        """Rate of pressure [Pa/s], (T4): fixed-volume `state_rates` [SI], `strain_rate` [1/s]."""
        xp = array_namespace(state_rates, strain_rate)
        flowing = xp.sum(self.residual.by_state * state_rates, axis=-1)
        push = flowing + self.volume_sensitivity * self.by_strain * strain_rate
        return -push / self._nonzero_slope(self.pressure_slope)

    def _nonzero_slope(self, slope: Numbers) -> Numbers:
        """The `slope` of the residual [SI], replaced by the fluid's own where it vanishes."""
        fluid_slope = self.residual.by_pressure
        return guarded(absolute(slope) > _FLAT * fluid_slope, slope, fluid_slope)


def muscle_volumes(
    plant: "Plant", strains: Numbers, pressures: Numbers
) -> tuple[MuscleState, MuscleVolumes]:
    """One muscle of each unit at `strains` [-] and `pressures` [Pa], and volumes of all [m³]."""
    n, muscles = plant.counts, plant.muscles.at(pressures, strains)
    V, by_strain, by_pressure = plant.muscles.volumes(muscles, strains, plant.lengths)
    result = muscles, MuscleVolumes(n * V, n * by_strain, n * by_pressure)
    # else XLA computes the table anew for each use: a quarter more to compile, a tenth to run
    return result if array_namespace(V) is np else lax.optimization_barrier(result)


def evaluate_chambers(
    plant: "Plant", chambers: Numbers, strains: Numbers, P: Numbers, muscles: tuple | None = None
) -> ChamberEvaluation:
    """Volumes and residual (F12) of `chambers` [SI] of a `plant` at `strains` [-] and given
    pressures `P` [Pa], which aren't solved for; `muscles`: its `muscle_volumes` there, if known.
    """
    state, (V, by_strain, by_pressure) = muscles or muscle_volumes(plant, strains, P)
    g = plant.chamber.state_residual(chambers, P, V)
    per_volume = g.by_state * plant.chamber.per_volume_rate(chambers, P)
    sensitivity = array_namespace(per_volume).sum(per_volume, axis=-1) + g.by_volume
    return ChamberEvaluation(P, state, V, by_strain, by_pressure, g, sensitivity)


def solve_pressures(
    plant: "Plant", chambers: Numbers, strains: Numbers, guess: Numbers, steps: int
) -> Numbers:
    """Pressures [Pa] of `chambers` [SI] of a `plant` at `strains` [-], by `steps` of Newton's
    method from a `guess` [Pa].
    """
    lowest = plant.chamber.lowest_pressure

    def newton(P: Numbers) -> Numbers:
        at = evaluate_chambers(plant, chambers, strains, P)
        return maximum(P + at.newton_step(at.slope), (P + lowest) / 2)  # half-way to no fluid

    return iterate(newton, guess + 0.0 * (chambers[..., 0] + strains), steps)


class ProjectedChambers(NamedTuple):
    """Chambers after a correction of their pressures: states of the `chambers` [SI], `pressures`
    [Pa], the `work` $-\\int V\\,\\mathrm{d}P$ of the correction, of all units [J], and the
    `mismatch`, the part of it that the conjugate volume would not do [J].
    """

    chambers: Numbers
    pressures: Numbers
    work: Batch
    mismatch: Batch


def conserved_state(
    chamber: AbstractChamber, chambers: Numbers, pressures: Numbers, volumes: Numbers
) -> Numbers:
    """Conserved states $k$ [SI], (T6), of states `chambers` [SI] at `pressures` [Pa], with
    `volumes` of muscles [m³]: mass, and $U + p V$ where the state holds an energy.
    """
    return chambers - chamber.per_volume_rate(chambers, pressures) * volumes[..., None]


def conserved_rates(
    chamber: AbstractChamber,
    chambers: Numbers,
    state_rates: Numbers,
    P_dot: Numbers,
    volumes: Numbers,
) -> Numbers:
    """Rates $\\dot k$ of the conserved states [SI], equation (T6), of states `chambers` [SI] with
    `state_rates` at a fixed volume [SI], at rates of pressure `P_dot` [Pa/s] and `volumes` [m³].
    """
    push = chamber.per_volume_rate
    folded = push(chambers, P_dot) - push(chambers, 0.0 * P_dot)
    return state_rates - folded * volumes[..., None]


def project_chambers(
    plant: "Plant", conserved: Numbers, strains: Numbers, guess: Numbers, steps: int
) -> ProjectedChambers:
    """Chambers of a `plant` with the `conserved` states $k$ [SI] at `strains` [-], in `steps` of
    Newton's method from pressures `guess` [Pa].
    """
    n, chamber = plant.counts, plant.chamber
    push, lowest = chamber.per_volume_rate, chamber.lowest_pressure
    start, start_volumes = muscles, volumes = muscle_volumes(plant, strains, guess)
    V_0 = start_volumes.volume
    s = s_0 = conserved + push(conserved, guess) * V_0[..., None]
    P = before = guess
    for i in range(steps):
        if i:
            muscles, volumes = muscle_volumes(plant, strains, P)
            s = s_0 + push(s_0, (guess + P) / 2) * (volumes.volume - V_0)[..., None]
        at = evaluate_chambers(plant, s, strains, P, (muscles, volumes))
        step = at.newton_step(at.pressure_slope)
        P, before = maximum(P + step, (P + lowest) / 2), P  # half-way to no fluid at most
    last = P - before
    V = volumes.volume + volumes.by_pressure * last
    s = s_0 + push(s_0, (guess + P) / 2) * (V - V_0)[..., None]
    add, change = array_namespace(P).sum, guess - P
    work = (V_0 + V) / 2 * change
    conjugate = n * (start.volume + muscles.volume + muscles.volume_by_pressure * last) / 2 * change
    return ProjectedChambers(s, P, add(work, axis=-1), add(work - conjugate, axis=-1))
