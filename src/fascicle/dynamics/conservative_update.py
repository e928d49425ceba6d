r"""Conserved states of chambers, for fixed steps that conserve energy.

A moving wall does work on the fluid behind it. When a muscle collapses, the slope of its volume
jumps, and a method of fixed steps that adds up $\dot V$ of its stages misses some of the change of
volume: it creates energy. A chamber's state $s$, whose rates are affine in $\dot V$ with a slope
$\dot s_{\dot V}$ that is affine in pressure, has a conserved state

$$k = s - \dot s_{\dot V}(P)\, V, \qquad
  \dot k = \dot s|_{\dot V = 0} - \frac{\mathrm{d} \dot s_{\dot V}}{\mathrm{d} P} \dot P\, V,
  \tag{T6}$$

which depends on the volume alone: of gas behind a wall, mass and enthalpy. At the end of a substep
the state follows from $k$ and the volume then, so that no volume is lost; the correction of its
pressure includes the wall's work.

**Source:** the first law, by parts.
"""

from typing import NamedTuple

from ..core.array_namespace import array_namespace, maximum
from ..core.types import Batch, Numbers
from ..fluid import AbstractChamber
from .chamber_pressure import assemble_chambers, muscle_volumes
from .plant import Plant


class ProjectedChambers(NamedTuple):
    """Chambers with corrected pressures: states of the `chambers` [SI], `pressures` [Pa], and what
    the correction adds by parts [J], $-\\int V\\,\\mathrm{d}P$ of all units, to the `work` and to
    its `mismatch`.
    """

    chambers: Numbers
    pressures: Numbers
    work: Batch
    mismatch: Batch


def conserved_state(
    chamber: AbstractChamber, chambers: Numbers, pressures: Numbers, volumes: Numbers
) -> Numbers:
    """$k$ [SI], equation (T6), of states `chambers` [SI] of a `chamber` at `pressures` [Pa], with
    `volumes` of muscles [m³].
    """
    return chambers - chamber.per_volume_rate(chambers, pressures) * volumes[..., None]


def conserved_rates(
    chamber: AbstractChamber,
    chambers: Numbers,
    fixed_volume_rate: Numbers,
    pressure_rates: Numbers,
    volumes: Numbers,
) -> Numbers:
    """$\\dot k$ [SI], equation (T6), of states `chambers` [SI] of a `chamber` with a
    `fixed_volume_rate` [SI], at `pressure_rates` [Pa/s] and `volumes` of muscles [m³].
    """
    push, P_dot = chamber.per_volume_rate, pressure_rates
    folded = push(chambers, P_dot) - push(chambers, 0.0 * P_dot)
    return fixed_volume_rate - folded * volumes[..., None]


def project_chambers(
    plant: Plant, conserved: Numbers, strains: Numbers, guess: Numbers, steps: int
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
        step = assemble_chambers(plant, s, P, muscles, volumes).working_step
        P, before = maximum(P + step, (P + lowest) / 2), P  # half-way to no fluid at most
    last = P - before
    V = volumes.volume + volumes.by_pressure * last
    s = s_0 + push(s_0, (guess + P) / 2) * (V - V_0)[..., None]
    add, change = array_namespace(P).sum, guess - P
    work = (V_0 + V) / 2 * change
    conjugate = n * (start.volume + muscles.volume + muscles.volume_by_pressure * last) / 2 * change
    return ProjectedChambers(s, P, add(work, axis=-1), add(work - conjugate, axis=-1))
