"""Valves on sale whose conductance could be read in their maker's data sheet.

Each has $C$ and $b$ of (F4) from the supply to the port and from the port to the room. Other valves
were left out where a sheet gives one way only, or a nominal flow without $b$.
"""

from typing import NamedTuple

from .flow_elements import SonicValve


_LITER_PER_SECOND_BAR = 1e-8  # m³/(s·Pa)
_CKD = "CKD, instruction manual SM-P00077-A/3 (2020), flow characteristics of manifolds"
_SMC = "SMC, catalog CAT.ES11-90B (2009), flow-rate characteristics, body ported"


class CatalogValve(NamedTuple):
    """Valve of the catalog by its `name`: `supply` and `exhaust` with their $C$ and $b$; `source`
    of the figures.
    """

    name: str
    supply: SonicValve
    exhaust: SonicValve
    source: str


def _valve(
    name: str, supply: tuple[float, float], exhaust: tuple[float, float], source: str
) -> CatalogValve:
    """Valve of the catalog from printed figures: C [L/(s·bar)] and b [-] of both ways."""
    supply_valve, exhaust_valve = (
        SonicValve(C * _LITER_PER_SECOND_BAR, b) for C, b in (supply, exhaust)
    )
    return CatalogValve(name, supply_valve, exhaust_valve, source)


def catalog_valves() -> tuple[CatalogValve, ...]:
    """Valves of the catalog, the smallest first."""
    return (
        _valve("CKD M3GA1-R", (0.86, 0.31), (1.1, 0.19), _CKD),  # two 3-port valves in one
        _valve("CKD M3GA2-R", (1.7, 0.40), (2.3, 0.29), _CKD),  # as above
        _valve("SMC 51-SY5120", (1.9, 0.35), (2.4, 0.39), _SMC),
        _valve("CKD M4GA3-R", (3.2, 0.37), (3.8, 0.13), _CKD),  # two positions
        _valve("SMC 51-SY7120", (4.1, 0.23), (3.3, 0.33), _SMC),
        _valve("SMC 51-SY9120", (7.0, 0.33), (7.6, 0.35), _SMC),
    )
