r"""One design as whoever buys and builds it looks at it: margin, size, mass, fluid, cost.

Mass is what the products' makers say, or that of the bladders alone, $\rho \sum n_i V_{b,i}$, where
a density is given. Of air the cost of a cycle is that of its normal volume $V_N$, or of the energy
$p_a V_N \ln((P_s + p_a)/p_a)$ that compresses it without losses; of a liquid, that of $P_s V$.
"""

from dataclasses import dataclass

import numpy as np

from .cases import ATMOSPHERE, Cases, cases
from .catalog import Catalog, Product
from .designs import Designs, packed_radius
from .evaluation import evaluate
from .exhaustive_search import Found
from .task import Task


STANDARD_GRAVITY = 9.80665  # m/s²


@dataclass(frozen=True, eq=False)
class Summary:
    """A design's `label` [-], how many `muscles` and `valves` it has [-], what it does at its
    `cases` [-]; its `diameter` with unfed units bowed out at the largest contraction, and
    `diameter_at_rest` [m]; the `product` that its muscles are, if they are one; its `bladders`'
    volume [m³]; `mass` [kg], which is that of whole muscles where the `product` gives it; `price`
    of muscles and valves, `price_of_muscles`, and `cost_of_a_cycle` [-] in the catalog's currency:
    what isn't known is `None`.
    """

    label: str
    muscles: int
    valves: int
    cases: Cases
    diameter: float
    diameter_at_rest: float
    product: Product | None
    bladders: float
    mass: float | None
    price: float | None
    price_of_muscles: float | None
    cost_of_a_cycle: float | None

    @property
    def margin(self) -> float:
        """The least force to spare [N], negative where a load case isn't reached."""
        return float(self.cases.spare.min())

    @property
    def relative_margin(self) -> float:
        """The least force to spare over what is demanded, of the load cases that are reached [-];
        NaN where none is.
        """
        reached = self.cases.relative[self.cases.reached]
        return float(reached.min()) if reached.size else np.nan

    @property
    def load_factor(self) -> float:
        """By how much all loads could be multiplied at once [-]; infinite where there is none."""
        loaded = self.cases.task.force > 0
        return float(
            np.min(self.cases.largest[loaded] / self.cases.task.force[loaded], initial=np.inf)
        )


def summarized(found: Found, place: int) -> Summary:
    """A design of a search, summarized.

    **Arguments:**

    - `found`: by the search [-].
    - `place`: of the design among those that were kept [-].

    **Returns:** the summary [-].
    """
    one = found.all_designs(np.array([place]))
    envelope = found.values.get("envelope")
    diameter = None if envelope is None else float(envelope[place])
    return summary_of(one, 0, found.task, found.catalog, diameter)


def summary_of(
    designs: Designs, place: int, task: Task, catalog: Catalog, diameter: float | None = None
) -> Summary:
    """A design, summarized.

    **Arguments:**

    - `designs`: among which it is [-].
    - `place`: which of them [-].
    - `task`: what is demanded [-].
    - `catalog`: products and prices [-].
    - `diameter`: of the envelope [m], if it has been computed.

    **Returns:** the summary [-].
    """
    one = designs.take(np.array([place]))
    if diameter is None:
        diameter = float(evaluate(one, task, ["envelope"])["envelope"][0])
    counts, radius = one.counts[0], one.radius[0]
    inner = radius - one.wall[0]
    bladders = float(np.sum(counts * np.pi * (radius**2 - inner**2)) * one.length[0])
    name = list(one.drawings)[int(one.kind[0])]
    product = catalog.products.get(name)
    mass = None if catalog.density is None else catalog.density * bladders
    if product is not None and product.mass is not None:
        mass = product.mass * int(counts.sum())
    found = cases(one, 0, task)
    return Summary(
        label=one.labels[0],
        muscles=int(counts.sum()),
        valves=int(one.units[0]),
        cases=found,
        diameter=diameter,
        diameter_at_rest=2 * float(packed_radius(radius, counts)),
        product=product,
        bladders=bladders,
        mass=mass,
        price=_known(catalog.price(one)[0]),
        price_of_muscles=_known(catalog.muscle_price(one)[0]),
        cost_of_a_cycle=_cost(catalog, task, found.fluid_of_a_cycle),
    )


def _cost(catalog: Catalog, task: Task, fluid: float) -> float | None:
    """Of a cycle's `fluid` [m³]."""
    if task.fluid == "air" and catalog.air is not None:
        return catalog.air * fluid
    if catalog.energy is None:
        return None
    if task.fluid == "liquid":
        return catalog.energy * task.supply_pressure * fluid
    ratio = (task.supply_pressure + ATMOSPHERE) / ATMOSPHERE
    return float(catalog.energy * ATMOSPHERE * fluid * np.log(ratio))


def _known(value: float) -> float | None:
    return None if np.isnan(value) else float(value)
