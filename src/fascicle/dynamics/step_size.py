r"""Number of fixed steps that a plant needs.

Between two actions of a controller there are as many equal substeps as the stiffest part needs: the
method is stable while $h |\lambda| \le 2.78$, and is used up to 2. For balanced energies, a gas has
two at least, a liquid more.
"""

import math
from typing import NamedTuple

import numpy as np

from ..core.types import Numbers
from .chamber_pressure import ChamberEvaluation, evaluate_chambers
from .plant import Plant


MAX_SUBSTEPS = 64  # more cost more than a smaller `dt`
# a volume of oil changes most about P = 0, where a table has a line every few pascals and a bend at
# zero: passed within a substep, it leaves an error of work, as the substep squared. In 80 random
# cycles, two substeps left up to 3e-3 of it, sixteen 5e-5, and in two of them more than 1e-5
_LIQUID = 16
_GAS = 2  # with one, crossing the cells of a table leaves 1e-5 of the work; with two 1e-6
_STABLE = 2.0  # largest h|λ|; the method's own limit is 2.78


class StepSizeEstimate(NamedTuple):
    """Substeps that a plant needs: its fastest `rate` [1/s], the `part` that has it, the `substeps`
    to take in a step, at most `MAX_SUBSTEPS`, and `stiff`: true if it needs more.
    """

    rate: float
    part: str
    substeps: int
    stiff: bool


def estimate_substeps(plant: Plant, dt: float) -> StepSizeEstimate:
    """Estimate the substeps that a step of `dt` [s] of a `plant` needs."""
    rates = {**_chamber_rates(plant), **_load_rates(plant)}
    fastest = max(rates, key=lambda name: rates[name])
    need = max(_LIQUID if plant.liquid else _GAS, math.ceil(dt * rates[fastest] / _STABLE))
    return StepSizeEstimate(rates[fastest], fastest, min(need, MAX_SUBSTEPS), need > MAX_SUBSTEPS)


def _chamber_rates(plant: Plant) -> dict[str, float]:
    """Fastest filling of chambers through open valves, and fastest motion of spools [1/s]."""
    top, chamber = plant.supply_pressure, plant.chamber
    # flow is steepest where pressures are nearly equal
    guess = top * np.logspace(-6, 0, 61)
    P = np.concatenate([[0.0], guess, (top - guess)[:-1]])[:, None, None]
    room, T_a = chamber.room_pressure, chamber.room_temperature
    T_s = plant.supply.temperature_at(plant.supply.initial_state())
    c_p = 0.0 if plant.liquid else chamber.gas.c_p
    with np.errstate(all="ignore"):  # of branches that aren't taken
        s, fluid = _rest_evaluations(plant, P, position_count=7)
        rate, no_flow = (chamber.rates(s, P, m, m * c_p * T_a, 0.0) for m in (1.0, 0.0))
        rise = fluid.pressure_rate(rate - no_flow, np.zeros(1))  # of pressure with mass [Pa/kg]
        # small beside each pressure, and never zero
        step = 1e-4 * np.maximum(P, 1e-6 * top)
        filling, venting = (
            np.abs(flow(P + room + step) - flow(P + room - step)) / (2 * step)
            for flow in (
                lambda p: plant.valve.flow(top + room, p, T_s, T_a),
                lambda p: plant.exhaust_valve.flow(p, room, T_a, T_a),
            )
        )
        fastest = np.max(
            np.where(fluid.pressure_slope > 0, np.maximum(filling, venting) * rise, 0.0)
        )
    spool = getattr(plant.spool, "time_constant", None)
    return {
        "a chamber and its valve": float(fastest),
        "a spool": 0.0 if spool is None else float(np.max(1 / np.asarray(spool))),
    }


def _load_rates(plant: Plant) -> dict[str, float]:
    """Fastest swing of a load on its muscles with valves shut, and on its stop, and fastest decay
    by its dampers [1/s].
    """
    load, n, L, g = plant.load, plant.counts, plant.lengths, plant.gains
    if load.prescribed:
        return {}
    M = float(load.inertia)
    P = np.linspace(0.0, plant.supply_pressure, 31)[:, None, None]
    with np.errstate(all="ignore"):  # of branches that aren't taken
        s, fluid = _rest_evaluations(plant, P, position_count=41)
        muscles, rise = fluid.muscles, fluid.pressure_rate(np.zeros_like(s), np.ones(1))
        spring = -n * L * g**2 * (muscles.force_by_strain + muscles.force_by_pressure * rise)
        stiff = np.abs(np.sum(spring, axis=-1, keepdims=True))
        stiff = float(np.nanmax(np.where(fluid.pressure_slope > 0, stiff, 0.0)))
    if plant.hysteresis is not None and hasattr(plant.hysteresis, "stiffness"):
        stiff += float(np.sum(n * (L * g) ** 2) * np.sum(np.asarray(plant.hysteresis.stiffness)))
    rates = {
        "the load on its muscles": math.sqrt((stiff + float(load.stiffness)) / M),
        "the load's damper": float(load.damper) / M,
    }
    if load.stop:
        rates["the stop"] = math.sqrt(float(load.stop.stiffness) / M) + float(load.stop.damping) / M
    return rates


def _rest_evaluations(
    plant: Plant, pressures: Numbers, position_count: int
) -> tuple[Numbers, ChamberEvaluation]:
    """States of chambers [SI] at rest, and their evaluation, at `pressures` [Pa] and
    `position_count` even positions along the stroke.
    """
    q = np.linspace(*plant.stroke, position_count)
    P, eps = np.broadcast_arrays(pressures, plant.strains(q[:, None]))
    s = plant.chambers_at(P, q)
    return s, evaluate_chambers(plant, s, eps, P)
