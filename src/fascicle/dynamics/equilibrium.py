r"""Equilibrium of a plant: a state at rest.

At given pressures the load rests at the position of

$$\sum_i n_i F_i(P_i, \varepsilon_i)\, L_i g_i - \frac{\mathrm{d} U}{\mathrm{d} q} - F_{stop}(q)
  = 0; \tag{T5}$$

of several the first stable one from the least contraction. Chambers hold fluid at those pressures
in the volume of that strain, as warm as the room; friction is relaxed.
"""

import numpy as np
from scipy.optimize import root_scalar

from ..core.errors import InvalidInputError
from ..core.types import Numbers, PerUnit, Values
from ..core.validation import HIGHEST_PRESSURE, check_interval
from ..fluid import validate_commands
from .motion import State
from .plant import Plant


_POSITIONS = 801  # that bracket an equilibrium: four in each of a table's 200 cells


def equilibrium_state(
    plant: Plant, pressures: Values = 0.0, position: Values = None, command: Values = None
) -> State:
    """Initial state [SI] of a `plant`: at its `position`, else where its forces balance, (T5).

    `pressures`: gauge, of each unit or one for all [Pa]; `position` of the load [SI], fixed until
    the run begins, by default that of balance or of a prescribed motion; `command`: position of the
    valves' spools [-], by default the middle. `ValueError` for pressures off the domain, a position
    outside the muscles' tables, and a load that the bundle can't hold at rest at these pressures.
    """
    closed = (True, True)
    P = check_interval(pressures, 0.0, HIGHEST_PRESSURE, "pressures", "Pa", "(gauge)", closed)
    if np.ndim(P) and np.shape(P) != (plant.units,):
        rule = f"must be one for each of the {plant.units} units"
        raise InvalidInputError("pressures", rule, np.size(P))
    P = np.broadcast_to(P, (plant.units,)) + 0.0
    load, v = plant.load, 0.0
    low, high = plant.stroke
    if not low < high:
        rule = "must leave a stroke on which all muscles are within their tables"
        remedy = "take other lengths, or another contraction at the start"
        raise InvalidInputError("load", rule, low, remedy, shown="none")

    limits = low, high, "position", load.unit, "where the muscles' tables end", closed
    if load.prescribed:
        if position is not None:
            rule, remedy = "must be left out with a prescribed motion", "the load gives its own"
            raise InvalidInputError("position", rule, position, remedy)
        q, v = load.motion_at(0.0, 0.0, 0.0)
        check_interval(q + np.max(getattr(load, "amplitude", 0.0)) * np.array([-1, 1]), *limits)
    elif position is not None:
        q = check_interval(position, *limits)
    else:
        q = _find_equilibrium(plant, P, low, high)
    spools = plant.spool.state_count(plant.units)
    spool = np.zeros(spools) if command is None else validate_commands(command) + np.zeros(spools)
    supply = np.asarray(plant.supply.initial_state(), float)
    q, v = np.float64(q), np.float64(v)
    return State(q, v, spool, plant.chambers_at(P, q), P, supply)


def holding_pressures(
    plant: Plant, position: float | None = None, force: float | None = None
) -> PerUnit:
    """Pressures [Pa] at which the one bundle of a `plant` holds its load at rest at a `position`
    [m], or pulls with a `force` [N] at the prescribed position; the nearest if none do.
    """
    (bundle,), load = plant.bundles, plant.load
    q = load.motion_at(0.0, 0.0, 0.0)[0] if position is None else position
    if force is None:
        stop_force = load.stop.force(q, 0.0)[0] if load.stop else 0.0
        force = float(stop_force - load.force(q))
    return bundle.recruit(force, q / bundle.length, plant.supply_pressure).pressures


def _find_equilibrium(plant: Plant, pressures: Numbers, low: float, high: float) -> float:
    """First position [SI] from `low` to `high` at which the net force falls through zero."""

    def net_force(q: Numbers) -> Numbers:
        with np.errstate(all="ignore"):  # of branches that aren't taken
            eps = plant.strains(np.asarray(q)[..., None])
            pull = np.asarray(plant.muscles.at(pressures + 0.0 * eps, eps).force)
        outside = load.force(q) - (load.stop.force(q, 0.0 * q)[0] if load.stop else 0.0)
        return np.sum(plant.counts * plant.lengths * plant.gains * pull, axis=-1) + outside

    load, positions = plant.load, np.linspace(low, high, _POSITIONS)
    residuals = np.asarray(net_force(positions))
    falls = np.flatnonzero((residuals[:-1] > 0) & (residuals[1:] <= 0))
    if not falls.size:
        side, end, far = ("weak", 0, low) if residuals[0] <= 0 else ("strong", -1, high)
        worst, unit = float(residuals[end]), "N" if load.unit == "m" else "N·m"
        rule = "must be one that the bundle can hold at rest"
        remedy = (
            f"at these pressures it is too {side} by {abs(worst):.4g} {unit} even at {far:.4g}"
            f" {load.unit}: begin at other pressures, or give `position`, from which it then starts"
        )
        raise InvalidInputError("load", rule, worst, remedy, shown="")
    k = falls[0]
    if residuals[k + 1] == 0:
        return float(positions[k + 1])
    bracket = (positions[k], positions[k + 1])
    return float(root_scalar(net_force, bracket=bracket, xtol=1e-16, rtol=1e-14).root)  # rounding
