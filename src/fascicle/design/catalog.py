"""Products on sale, prices, and the cheapest of many designs.

**Cheapest**, of the designs on the front, is the one with

1. the lowest price of muscles and valves, where the price of every product and of a valve is known;
   else the fewest valves, one for each motor unit, since a pressure valve costs more than a muscle
   does; then the lowest price of its muscles, where every product has one, else the fewest muscles;
2. of those of equal price, the fewest valves, then the fewest muscles;
3. the smallest muscles: the least volume of all of them at rest;
4. the least fluid energy, mean over the task.

The first of these that differs between two designs decides. Missing prices are never guessed.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..core.types import Float, Int
from ..core.validation import distinct_texts
from ..muscle import Muscle
from .designs import Designs
from .objectives import Values
from .task import Task


_ROUNDING = 1e-9  # relative, of a product's limits: 150 mm of 600 mm are a quarter
_DIGITS = 9  # of a size: two splits of the same muscles have the same up to rounding


class Product(NamedTuple):
    """Product: a muscle on sale, of one length: its `name`, `price` for one in the catalog's
    currency, `mass` of one [kg], and the largest pressure [Pa] and contraction [-] that its maker
    allows; each is `None` if unknown. `source` of the figures.
    """

    name: str
    price: float | None = None
    mass: float | None = None
    largest_pressure: float | None = None
    largest_strain: float | None = None
    source: str = ""

    def exclusion_reason(self, task: Task, length: float) -> str:
        """Reason why this product must not be used for a `task` at its `length` [m]; empty if it
        may.
        """
        limit, strain = self.largest_pressure, float(task.strain_of(length).max())
        if limit is not None and task.supply_pressure > limit * (1 + _ROUNDING):
            given, most = distinct_texts(task.supply_pressure / 1e3, limit / 1e3)
            return f"the supply has {given} kPa, its maker allows {most} kPa"
        limit = self.largest_strain
        if limit is not None and strain > limit * (1 + _ROUNDING):
            given, most = distinct_texts(100 * strain, 100 * limit)
            return f"the task demands a contraction of {given} %, its maker allows {most} %"
        return ""


@dataclass(frozen=True)
class Catalog:
    """Catalog of products and prices. `products`, by the name of their drawing; prices in a
    `currency`: of a `valve` and of a `muscle` of products without a price [-], of `air` for each
    normal m³ and of `energy` for each J; `density` of the bladder [kg/m³].
    """

    products: Mapping[str, Product] = field(default_factory=dict)
    currency: str = ""
    valve: float | None = None
    muscle: float | None = None
    air: float | None = None
    energy: float | None = None
    density: float | None = None

    def muscle_price(self, designs: Designs) -> Float[np.ndarray, " design"]:
        """Price of the muscles of each of the `designs` [-]; NaN if unknown."""
        prices = np.array([self._price_of_one(name) for name in designs.drawings])
        return designs.counts.sum(axis=1) * prices[designs.kind]

    def price(self, designs: Designs) -> Float[np.ndarray, " design"]:
        """Price of muscles and valves of each of the `designs` [-]; NaN if unknown."""
        valve = np.nan if self.valve is None else self.valve
        return self.muscle_price(designs) + valve * designs.units

    def excluded(self, drawings: Mapping[str, Muscle], task: Task) -> dict[str, str]:
        """Reasons why products must not be used for a `task`, by the names of their `drawings`."""
        reasons = {
            name: product.exclusion_reason(task, float(drawings[name].length))
            for name, product in self.products.items()
        }
        return {name: reason for name, reason in reasons.items() if reason}

    def known_prices(self, drawings: Mapping[str, Muscle]) -> tuple[bool, bool]:
        """True if all muscle prices are known; true if these and the valve's price are."""
        muscles = not np.any(np.isnan([self._price_of_one(name) for name in drawings]))
        return muscles, muscles and self.valve is not None

    def _price_of_one(self, name: str) -> float:
        """Price of one muscle of the drawing with a `name` [-]; NaN if unknown."""
        product = self.products.get(name)
        price = self.muscle if product is None or product.price is None else product.price
        return np.nan if price is None else price


def cheapest(
    candidates: Int[np.ndarray, " candidate"],
    values: Values,
    designs: Callable[[Int[np.ndarray, " index"]], Designs],
    catalog: Catalog,
) -> int | None:
    """Index of the design with the lowest price of muscles and valves, or the fewest valves if a
    price is unknown; ties as in the module's docstring; `None` without candidates.

    `candidates`: indices of the designs to choose from; `values`: objectives of all designs, by
    name [SI], with `valves` and `mean_energy`; `designs`: gives designs by their
    indices; `catalog`: prices [-].
    """
    if not candidates.size:
        return None
    chosen = designs(candidates)
    muscles_known, all_known = catalog.known_prices(chosen.drawings)
    valves, muscles = values["valves"][candidates], chosen.counts.sum(axis=1)
    price = catalog.muscle_price(chosen) if muscles_known else muscles
    costs = (catalog.price(chosen),) if all_known else (valves, price)
    size = chosen.length * np.sum(chosen.counts * chosen.radius**2, axis=1)
    keys = (*costs, valves, muscles, np.round(size / size.max(), _DIGITS))
    return int(candidates[np.lexsort((values["mean_energy"][candidates], *keys[::-1]))[0]])


def describe_cheapest(catalog: Catalog, drawings: Mapping[str, Muscle]) -> str:
    """Meaning of "cheapest" with the `catalog`'s prices [-] for `drawings`, in words."""
    muscles_known, all_known = catalog.known_prices(drawings)
    if all_known:
        return "lowest price of muscles and valves"
    muscles = "lowest price of muscles" if muscles_known else "fewest muscles"
    missing = "no price of a valve is given" if muscles_known else "no prices are given"
    return f"fewest valves, then {muscles}, then the smallest; {missing}"
