"""The oracle, part 11: what the next motor unit takes before it gives, in plain numbers.

Two units, n1 and n2 of one muscle, at one strain: grids and SciPy's root finder over the oracle's
own force, volumes by differences of its own work. It never imports the library.
"""

import math
from dataclasses import dataclass

import numpy as np
import oracle_energy
import oracle_force
from oracle_muscle import RTOL
from scipy.optimize import brentq, minimize_scalar


ATMOSPHERE = 101325.0
GRID = 401


@dataclass(frozen=True)
class Pair:
    """n1 + n2 muscles at a supply's pressure [Pa]."""

    muscle: object
    n1: int
    n2: int
    supply: float = 413.7e3


def gain(pair, pressure, strain):
    """g(p) [N]: what unit 2 adds to its own resistance."""
    one = oracle_force.force(pair.muscle, float(pressure), float(strain))
    return pair.n2 * (one - oracle_force.force(pair.muscle, 0.0, float(strain)))


def largest_force(pair, strain):
    """F1max [N]: unit 1 at the supply's pressure, unit 2 empty."""
    full, empty = (oracle_force.force(pair.muscle, P, strain) for P in (pair.supply, 0.0))
    return pair.n1 * full + pair.n2 * empty


def dip(pair, strain):
    """D [N] and p_d [Pa]."""
    grid = np.linspace(0.0, pair.supply, GRID)
    values = [gain(pair, P, strain) for P in grid]
    k = int(np.argmin(values))
    if values[k] >= 0:
        return 0.0, 0.0
    bounds = grid[max(k - 1, 0)], grid[min(k + 1, GRID - 1)]
    found = minimize_scalar(
        lambda P: gain(pair, P, strain), bounds=bounds, method="bounded", options={"xatol": 1e-3}
    )
    return -found.fun, found.x


def onset(pair, strain):
    """p_on [Pa]: the last root of g; 0 where g never falls, inf where it doesn't come back."""
    grid = np.linspace(0.0, pair.supply, GRID)
    values = np.array([gain(pair, P, strain) for P in grid])
    if values[-1] <= 0:
        return math.inf
    last = int(np.flatnonzero(values <= 0)[-1])
    if last == 0:
        return 0.0
    return brentq(lambda P: gain(pair, P, strain), grid[last], grid[last + 1], rtol=RTOL)


def gas_time(pair, strain, mass_flow, gas_constant=287.05, temperature=293.15, strain_before=None):
    """t_c [s] for a gas that flows in at a mass flow [kg/s], as warm as the room."""
    before = strain if strain_before is None else strain_before
    p = onset(pair, strain)
    filled = (p + ATMOSPHERE) * oracle_energy.conjugate_volume(pair.muscle, p, strain)
    empty = ATMOSPHERE * oracle_energy.conjugate_volume(pair.muscle, 0.0, before)
    return pair.n2 * (filled - empty) / (gas_constant * temperature * mass_flow)


def oil_time(pair, strain, flow):
    """t_c [s] for a liquid that flows in at a volume a second [m3/s]."""
    p = onset(pair, strain)
    volumes = [oracle_energy.conjugate_volume(pair.muscle, P, strain) for P in (p, 0.0)]
    return pair.n2 * (volumes[0] - volumes[1]) / flow


def needed_reserve(pair, strain, demand_rate, time):
    """max over p <= p_on of -g(p) + F' t_c p/p_on [N]."""
    p_on = onset(pair, strain)
    if p_on == 0:
        return max(demand_rate * time, 0.0)
    return max(
        -gain(pair, P, strain) + demand_rate * time * P / p_on
        for P in [*np.linspace(0, p_on, 401), dip(pair, strain)[1]]
    )


def last_start(pair, strain, begin, demand_rate, mass_flow, points=41):
    """Of a ramp from a force [N] at t = 0 that rises by demand_rate [N/s]: the last moment [s] at
    which a gas may begin to flow into unit 2 at a mass flow [kg/s], its pressure as the gas in it
    makes it, if unit 1 is as fast as is needed.
    """
    pressures = np.r_[np.linspace(0, onset(pair, strain), points), dip(pair, strain)[1]]
    content = [
        (p + ATMOSPHERE) * oracle_energy.conjugate_volume(pair.muscle, p, strain) for p in pressures
    ]
    per_time = pair.n2 / (287.05 * 293.15 * mass_flow)
    need = max(
        -gain(pair, p, strain) + demand_rate * per_time * (m - content[0])
        for p, m in zip(pressures, content, strict=True)
    )
    return (largest_force(pair, strain) - need - begin) / demand_rate
