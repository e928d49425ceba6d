r"""Chamber states from which volume work is integrated out, for energy-conserving fixed steps.

A wall that moves works on what is behind it. Where a muscle collapses, the slope of its volume
jumps, and a method of fixed steps that adds up $\dot V$ of its stages misses some of the volume
that it goes: energy is made. A chamber's state $s$, whose rates are affine in $\dot V$ with a slope
$\dot s_{\dot V}$ that is affine in pressure, holds

$$k = s - \dot s_{\dot V}(P)\, V, \qquad
  \dot k = \dot s|_{\dot V = 0} - \frac{\mathrm{d} \dot s_{\dot V}}{\mathrm{d} P} \dot P\, V,
  \tag{T6}$$

which asks for the volume alone: of gas behind a wall, mass and enthalpy. At the end of a substep
the state follows from $k$ and the volume that was reached, so that no volume is lost; where its
pressure is set right, the wall works along.

**Source:** the first law, by parts.
"""

from typing import NamedTuple

from ..core.array_namespace import array_namespace, maximum
from ..core.types import Batch, Numbers
from ..fluid import AbstractChamber
from .chamber_pressure import assemble_chambers, muscle_volumes
from .plant import Plant


class ProjectedChambers(NamedTuple):
    """Chambers whose pressures have been set right: states of the `chambers` [SI], `pressures`
    [Pa], and what setting them right adds by parts [J], $-\\int V\\,\\mathrm{d}P$ of all units, to
    the `work` and to its `mismatch`.
    """

    chambers: Numbers
    pressures: Numbers
    work: Batch
    mismatch: Batch


def conserved_state(
    chamber: AbstractChamber, chambers: Numbers, pressures: Numbers, volumes: Numbers
) -> Numbers:
    """$k$ [SI] of `chambers` [SI] of a kind of `chamber` [-] at `pressures` [Pa], with `volumes`
    [m³] of muscles, equation (T6).
    """
    return chambers - chamber.per_volume_rate(chambers, pressures) * volumes[..., None]


def conserved_rates(
    chamber: AbstractChamber,
    chambers: Numbers,
    fixed_volume_rate: Numbers,
    pressure_rates: Numbers,
    volumes: Numbers,
) -> Numbers:
    """$\\dot k$ [SI], equation (T6), of `chambers` [SI] of a kind of `chamber` that change by
    `fixed_volume_rate` [SI] in constant volumes, at `pressure_rates` [Pa/s] and `volumes` [m³] of
    muscles.
    """
    push, P_dot = chamber.per_volume_rate, pressure_rates
    folded = push(chambers, P_dot) - push(chambers, 0.0 * P_dot)
    return fixed_volume_rate - folded * volumes[..., None]


def project_chambers(
    plant: Plant, holds: Numbers, strains: Numbers, guess: Numbers, steps: int
) -> ProjectedChambers:
    """Chambers of a `plant` [-] that hold $k$, `holds` [SI], at `strains` [-] and led to pressures
    `guess` [Pa], set right in so many `steps` [-] of Newton's method.
    """
    n, chamber = plant.counts, plant.chamber
    push, lowest = chamber.per_volume_rate, chamber.lowest_pressure
    at_0, first = at, chambers_now = muscle_volumes(plant, strains, guess)
    V_0 = first.volume
    s = s_0 = holds + push(holds, guess) * V_0[..., None]
    P = before = guess
    for turn in range(steps):
        if turn:
            at, chambers_now = muscle_volumes(plant, strains, P)
            s = s_0 + push(s_0, (guess + P) / 2) * (chambers_now.volume - V_0)[..., None]
        step = assemble_chambers(plant, s, P, at, chambers_now).working_step
        # half of the way to no fluid at all at most
        P, before = maximum(P + step, (P + lowest) / 2), P
    last = P - before
    V = chambers_now.volume + chambers_now.by_pressure * last
    s = s_0 + push(s_0, (guess + P) / 2) * (V - V_0)[..., None]
    add, change = array_namespace(P).sum, guess - P
    work = (V_0 + V) / 2 * change
    conjugate = n * (at_0.volume + at.volume + at.volume_by_pressure * last) / 2 * change
    return ProjectedChambers(s, P, add(work, axis=-1), add(work - conjugate, axis=-1))
