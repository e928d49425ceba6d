"""The oracle, part 9: fluid through valves into chambers, in plain numbers.

Every figure is had another way than the library's: flows by ISO 6358 as printed, pairs of
elements by the pressure between them, hoses by Fanno's equation, fillings in closed form,
exergies and stored energies by quadrature.
"""

import math

from scipy.integrate import quad
from scipy.optimize import brentq


R, GAMMA = 287.05, 1.4  # of dry air
ROOM, WARM = 101325.0, 293.15
RHO_0 = 1.185  # of ISO 6358's reference air
CP, CV = GAMMA * R / (GAMMA - 1), R / (GAMMA - 1)


def sonic(C, b, p1, p2, T1=WARM, m=0.5, laminar=0.999):
    """ISO 6358, with Sanville's laminar end from a ratio on, p1 ≥ p2, absolute."""
    r = p2 / p1
    choked = C * RHO_0 * p1 * math.sqrt(WARM / T1)
    if r <= b:
        return choked
    if r <= laminar:
        return choked * (1 - ((r - b) / (1 - b)) ** 2) ** m
    return choked * (1 - ((laminar - b) / (1 - b)) ** 2) ** m * (1 - r) / (1 - laminar)


def sonic_pair(first, second, p1, p2, laminar=0.999):
    """Two of them, (C, b), one behind the other: the pressure between balances them."""
    end = {"laminar": laminar}

    def surplus(p):
        return sonic(*first, p1, p, **end) - sonic(*second, p, p2, **end)

    # as far down as the first element chokes they needn't meet at p2
    between = brentq(surplus, p2, p1, xtol=1e-9, rtol=1e-15) if surplus(p2) > 0 else p2
    return sonic(*first, p1, between, **end)


def fanno_conductance(length, diameter, friction):
    """Sonic conductance of a hose that chokes at its end, after a loss-free entrance."""

    def surplus(M):
        g = (GAMMA + 1) / 2
        inside = g * M**2 / (1 + (GAMMA - 1) / 2 * M**2)
        needed = (1 - M**2) / (GAMMA * M**2) + g / GAMMA * math.log(inside)
        return needed - friction * length / diameter

    M = brentq(surplus, 1e-4, 1 - 1e-9)
    total = (1 + (GAMMA - 1) / 2 * M**2) ** (-(GAMMA + 1) / (2 * (GAMMA - 1)))
    area = math.pi * diameter**2 / 4
    return area * math.sqrt(GAMMA / (R * WARM)) * M * total / RHO_0


# a rigid volume V at the room's temperature, filled from p_s: pressure [Pa, absolute] in time


def choked_filling(C, supply, V, start, t):
    return start + C * RHO_0 * supply * R * WARM / V * t


def subsonic_filling(C, b, supply, V, start, t):
    """m = ½: dr/dt = k √(1 − y²), y = (r − b)/(1 − b), so that asin y rises evenly."""
    k = C * RHO_0 * R * WARM / V
    y = math.sin(math.asin((start / supply - b) / (1 - b)) + k * t / (1 - b))
    return supply * (b + (1 - b) * y)


def laminar_filling(C, b, supply, V, start, t):
    slope = C * RHO_0 * math.sqrt(1 - ((0.999 - b) / (1 - b)) ** 2) / 0.001
    return supply + (start - supply) * math.exp(-slope * R * WARM / V * t)


def adiabatic_filling(supply_temperature, start, start_temperature, pressure):
    """Temperature of a rigid volume that no heat leaves, filled to a pressure, absolute."""
    share = start / pressure
    # (γ − 1) c_p T_in (m − m0) = V (p − p0), m = p V/(R T)
    mass = start / start_temperature + (pressure - start) / (GAMMA * supply_temperature)
    return start / share / mass


def adiabatic_discharge(start_temperature, start, pressure):
    return start_temperature * (pressure / start) ** ((GAMMA - 1) / GAMMA)


def entropy(p, T):
    """Of a kilogram over the room's, warmed at the room's pressure and then compressed."""
    warmed = quad(lambda t: CP / t, WARM, T, epsabs=0, epsrel=1e-13)[0]
    return warmed - quad(lambda x: R / x, ROOM, p, epsabs=0, epsrel=1e-13)[0]


def flow_exergy(p, T):
    return CP * (T - WARM) - WARM * entropy(p, T)


def stored_exergy(m, p, T):
    v, v_room = R * T / p, R * WARM / ROOM
    return m * (CV * (T - WARM) + ROOM * (v - v_room) - WARM * entropy(p, T))


def liquid_energies(density, modulus, p):
    """∫dp/ρ and ∫p dρ/ρ² from no gauge pressure up to p."""

    def rho(x):
        return density * math.exp(x / modulus)

    flow = quad(lambda x: 1 / rho(x), 0, p, epsabs=0, epsrel=1e-13)[0]
    stored = quad(lambda x: x / (modulus * rho(x)), 0, p, epsabs=0, epsrel=1e-13)[0]
    return flow, stored


def accumulator_pressure(volume, precharge, n, taken):
    """Absolute, of the gas that `taken` m³ of liquid leave."""
    return precharge * (volume / (volume - taken)) ** n


def accumulator_energy(volume, precharge, n, taken):
    """Work against gas less that of the room's pressure."""
    gas = quad(
        lambda V: accumulator_pressure(volume, precharge, n, V), 0, taken, epsabs=0, epsrel=1e-12
    )
    return gas[0] - ROOM * taken


def hose_pressure_drop(length, diameter, viscosity, density, friction, mass_flow):
    """Hagen and Poiseuille's and Darcy and Weisbach's, added."""
    area = math.pi * diameter**2 / 4
    speed = mass_flow / (density * area)
    laminar = 32 * viscosity * length * speed / diameter**2
    return laminar + friction * length / diameter * density / 2 * speed**2


def orifice_pressure_drop(area, discharge, density, mass_flow):
    return (mass_flow / (discharge * area)) ** 2 / (2 * density)
