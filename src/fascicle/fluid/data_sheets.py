r"""Sonic conductance from the other figures of a valve's data sheet, and valves on sale.

From a nominal flow $Q_n$, mostly from 6 to 5 bar gauge, and from a flow coefficient $K_v$ of
water,

$$C = \frac{Q_n}{p_1\, \psi(p_2/p_1)}, \tag{F24}$$
$$C = K_v \sqrt{\frac{1 - b}{2}\, \frac{\rho_w}{\rho_0\, p_0\, \Delta p_w}}, \tag{F25}$$

with absolute pressures, $p_0$ = 100 kPa and $\Delta p_w$ = 1 bar. **Assumes** of (F25) that water
and gas meet the same resistance at small differences, and that $b$ holds up to there: a valve with
soft seats or long ducts differs by tens of percent, so that a $C$ of the data sheet is better.

**Source:** ISO 6358 (2013) for (F4); VDI/VDE 2173 and IEC 60534 define $K_v$; (F24) and (F25)
derived here. A test holds (F24) to an example of SMC's data sheets, and (F25) to IEC 60534's choked
flow.

Of the valves on sale, each has $C$ and $b$ of (F4) from the supply to the port and from the port to
the room, as its maker's data sheet has them; valves whose sheet gives one way only, or a nominal
flow without $b$, were left out.
"""

from typing import NamedTuple

from ..core.array_namespace import sqrt
from ..core.types import Batch
from ..core.validation import check_choice, check_interval, check_positive
from .fields import ROOM_PRESSURE
from .flow_elements import REFERENCE_DENSITY, SonicValve, flow_function


_REFERENCE_PRESSURE = 1e5  # Pa, of ISO 8778
_WATER_DENSITY = 998.2  # kg/m³, at 20 °C
_BAR, _PSI = 1e5, 6894.757293168  # Pa; the latter from the exact pound and inch
_GALLON = 3.785411784e-3  # m³, exact
_LITER_PER_SECOND_BAR = 1e-8  # m³/(s·Pa)
_CKD = "CKD, instruction manual SM-P00077-A/3 (2020), flow characteristics of manifolds"
_SMC = "SMC, catalog CAT.ES11-90B (2009), flow-rate characteristics, body ported"
DENSITIES = {"anr": REFERENCE_DENSITY, "din1343": 1.292}  # kg/m³, of air at these references


def conductance_from_nominal_flow(
    flow: Batch,
    b: Batch,
    inlet: Batch = 6e5,
    outlet: Batch = 5e5,
    reference: str = "anr",
    room_pressure: Batch = ROOM_PRESSURE,
) -> Batch:
    """Sonic conductance of a valve from its nominal flow of air, equation (F24).

    **Arguments:**

    - `flow`: $Q_n$, as a volume at the reference [m³/s]; 100 L/min are 1.667e-3.
    - `b`: critical pressure ratio [-].
    - `inlet`, `outlet`: gauge pressures at which it was measured [Pa]; arrays broadcast.
    - `reference`: state of the volume: "anr" (20 °C, 100 kPa) or "din1343" (0 °C, 101 325 Pa).
    - `room_pressure`: absolute [Pa].

    **Returns:** $C$ [m³/(s·Pa)].

    **Raises:** `InvalidInputError` for values off their domains, and an outlet above the inlet.
    """
    flow, inlet = check_positive(flow, "flow", "m³/s"), check_positive(inlet, "inlet", "Pa")
    b = check_interval(b, 0.0, 1.0, "b", "-")
    density = DENSITIES[check_choice(reference, DENSITIES, "reference")]
    room = check_positive(room_pressure, "room_pressure", "Pa")
    outlet = check_interval(outlet, 0.0, inlet, "outlet", "Pa", closed=(True, False))
    high = inlet + room
    fraction = flow_function((outlet + room) / high, b)
    return flow * density / REFERENCE_DENSITY / (high * fraction)


def conductance_from_kv(Kv: Batch, b: Batch) -> Batch:
    """Sonic conductance of a valve for air from its flow coefficient, equation (F25).

    `Kv`: flow of water at 1 bar [m³/s]; 1 m³/h is 2.778e-4. `b`: critical pressure ratio [-].
    Returns $C$ [m³/(s·Pa)]; `InvalidInputError` for values off their domains.
    """
    Kv, b = check_positive(Kv, "Kv", "m³/s"), check_interval(b, 0.0, 1.0, "b", "-")
    air = REFERENCE_DENSITY * _REFERENCE_PRESSURE * _BAR
    return Kv * sqrt((1 - b) / 2 * _WATER_DENSITY / air)


def conductance_from_cv(Cv: Batch, b: Batch) -> Batch:
    """Sonic conductance of a valve for air from its flow coefficient in US units, equation (F25).

    `Cv`: flow of water at 1 psi [US gallons a minute], as data sheets print it; others as of
    `conductance_from_kv`.
    """
    Cv = check_positive(Cv, "Cv", "-")
    return conductance_from_kv(Cv * _GALLON / 60 * (_BAR / _PSI) ** 0.5, b)


class CatalogValve(NamedTuple):
    """On/off valve of the catalog by its `name`, and its `kind`, such as "5/2": `supply` and
    `exhaust`; `source` of the figures.
    """

    name: str
    kind: str
    supply: SonicValve
    exhaust: SonicValve
    source: str


def _valve(
    name: str, kind: str, supply: tuple[float, float], exhaust: tuple[float, float], source: str
) -> CatalogValve:
    """Valve of the catalog from printed figures: C [L/(s·bar)] and b [-] of both ways."""
    filling, venting = (SonicValve(C * _LITER_PER_SECOND_BAR, b) for C, b in (supply, exhaust))
    return CatalogValve(name, kind, filling, venting, source)


def catalog_valves() -> tuple[CatalogValve, ...]:
    """Valves of the catalog, the smallest first."""
    return (
        _valve("CKD M3GA1-R", "3/2", (0.86, 0.31), (1.1, 0.19), _CKD),  # two valves in one
        _valve("CKD M3GA2-R", "3/2", (1.7, 0.40), (2.3, 0.29), _CKD),  # as above
        _valve("SMC 51-SY5120", "5/2", (1.9, 0.35), (2.4, 0.39), _SMC),
        _valve("CKD M4GA3-R", "5/2", (3.2, 0.37), (3.8, 0.13), _CKD),
        _valve("SMC 51-SY7120", "5/2", (4.1, 0.23), (3.3, 0.33), _SMC),
        _valve("SMC 51-SY9120", "5/2", (7.0, 0.33), (7.6, 0.35), _SMC),
    )
