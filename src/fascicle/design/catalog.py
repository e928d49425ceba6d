"""What can be bought: named products, and prices; and by these which design is the cheapest.

**Cheapest**, of the designs that reach the task and keep all limits, is the one with

1. the lowest price of muscles and valves, where the price of every product and of a valve is known;
   else the fewest valves, one for each motor unit, since a pressure valve costs more than a muscle
   does; then the lowest price of its muscles, where every product has one, else the fewest muscles;
2. of those of equal price, the largest margin: the least force to spare over what is demanded;
3. the fewest valves, then the fewest muscles;
4. the least fluid energy, mean over the task.

The first of these that tells two designs apart decides. A price that isn't given is never guessed.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..core.types import Float, Int
from ..muscle import Muscle
from .designs import Designs
from .objectives import Values
from .task import Task


_BLOCK = 2**16
_ROUNDING = 1e-9  # of a product's limits: 150 mm of 600 mm are a quarter
_DIGITS = 9  # of a margin: two splits of the same muscles have the same up to rounding


class Product(NamedTuple):
    """A muscle that is sold, of one length: its `name`, `price` for one in the catalog's currency,
    `mass` for one [kg], and the largest pressure [Pa] and contraction [-] that its maker
    allows; each of them `None` if it isn't known. `source`: where the figures come from.
    """

    name: str
    price: float | None = None
    mass: float | None = None
    largest_pressure: float | None = None
    largest_strain: float | None = None
    source: str = ""

    def exclusion_reason(self, task: Task, length: float) -> str:
        """Why it must not be used for a `task` at its `length` [m]; empty if it may."""
        most, strain = self.largest_pressure, float(task.strain_of(length).max())
        if most is not None and task.supply_pressure > most * (1 + _ROUNDING):
            return f"{task.supply_pressure / 1e3:g} kPa, it is made for {most / 1e3:g} kPa"
        most = self.largest_strain
        if most is not None and strain > most * (1 + _ROUNDING):
            return f"contracts by up to {100 * most:g} %, the task asks for {100 * strain:.3g} %"
        return ""


@dataclass(frozen=True)
class Catalog:
    """What can be bought, and for how much. `products`, by the name of their drawing; prices in
    a `currency`: of a `valve` and of a `muscle` that no product gives the price of [-], of `air`
    for each normal m³ and of `energy` for each J; `density` of the bladder [kg/m³].
    """

    products: Mapping[str, Product] = field(default_factory=dict)
    currency: str = ""
    valve: float | None = None
    muscle: float | None = None
    air: float | None = None
    energy: float | None = None
    density: float | None = None

    def muscle_price(self, designs: Designs) -> Float[np.ndarray, " design"]:
        """Price of each design's muscles [-]; NaN where it isn't known. `designs`."""
        each = np.array([self._each(name) for name in designs.drawings])
        return designs.counts.sum(axis=1) * each[designs.kind]

    def price(self, designs: Designs) -> Float[np.ndarray, " design"]:
        """Price of each design's muscles and valves [-], NaN if not known. `designs`."""
        valve = np.nan if self.valve is None else self.valve
        return self.muscle_price(designs) + valve * designs.units

    def excluded(self, drawings: Mapping[str, Muscle], task: Task) -> dict[str, str]:
        """Products that must not be used.

        **Arguments:**

        - `drawings`: muscles by name.
        - `task`: what is demanded.

        **Returns:** why not, by the drawing's name.
        """
        why = {
            name: product.exclusion_reason(task, float(drawings[name].length))
            for name, product in self.products.items()
        }
        return {name: text for name, text in why.items() if text}

    def known_prices(self, drawings: Mapping[str, Muscle]) -> tuple[bool, bool]:
        """Whether the price of every one of the `drawings` [-] is known, and of a valve."""
        muscles = not np.any(np.isnan([self._each(name) for name in drawings]))
        return muscles, muscles and self.valve is not None

    def _each(self, name: str) -> float:
        product = self.products.get(name)
        own = None if product is None else product.price
        price = self.muscle if own is None else own
        return np.nan if price is None else price


def cheapest(
    places: Int[np.ndarray, " place"],
    values: Values,
    designs: Callable[[Int[np.ndarray, " place"]], Designs],
    catalog: Catalog,
    drawings: Mapping[str, Muscle],
) -> int | None:
    """The cheapest design, as the module says.

    **Arguments:**

    - `places`: of the designs that may be taken.
    - `values`: objectives of all designs, by name [SI]; with `valves`, `relative_margin` and
      `mean_energy`.
    - `designs`: gives designs by their places.
    - `catalog`: prices [-].
    - `drawings`: of all designs, by name.

    **Returns:** its place; `None` where there is none to be taken.
    """
    if not places.size:
        return None
    muscles_known, all_known = catalog.known_prices(drawings)
    if not all_known:
        # no other count matters before this one
        valves = values["valves"][places]
        places = places[valves == valves.min()]
    best: tuple[float, ...] | None = None
    found = None
    for start in range(0, len(places), _BLOCK):
        block = places[start : start + _BLOCK]
        made = designs(block)
        valves, muscles = values["valves"][block], made.counts.sum(axis=1)
        muscle_price = catalog.muscle_price(made) if muscles_known else muscles
        price = (catalog.price(made),) if all_known else (valves, muscle_price)
        margin = np.round(values["relative_margin"][block], _DIGITS)
        keys = (*price, -margin, valves, muscles, values["mean_energy"][block])
        first = int(np.lexsort(keys[::-1])[0])
        own = tuple(float(key[first]) for key in keys)
        if best is None or own < best:
            best, found = own, int(block[first])
    return found


def describe_cheapest(catalog: Catalog, drawings: Mapping[str, Muscle]) -> str:
    """What "cheapest" means where these prices are known, in words.

    **Arguments:**

    - `catalog`: prices [-].
    - `drawings`: of all designs, by name.

    **Returns:** the words.
    """
    muscles_known, all_known = catalog.known_prices(drawings)
    if all_known:
        return "lowest price of muscles and valves, then largest margin"
    if muscles_known:
        return (
            "fewest valves, then lowest price of muscles, then largest margin;"
            " no price of a valve is given"
        )
    return "fewest valves, then fewest muscles, then largest margin; prices aren't given"
