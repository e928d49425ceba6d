r"""One design in detail: its load cases, size, mass, fluid and cost.

The fluid is what flows in from the supply:

$$V_N = \sum_i n_i \frac{(p_i + p_a) V_i(\varepsilon) - p_a V_i(0)}{p_a} \tag{G3}$$

for air, in normal volume, over the units that are fed, each filled at its own pressure $p_i$ and
vented to the atmosphere $p_a$ at rest; for a liquid $\sum_i n_i (V_i(\varepsilon) - V_i(0))$, since
it stays full. In a cloud of load cases a *cycle* goes from rest to one and back, and the mean over
the task counts by weight; where the task is given in time, it goes once through all of them and to
the first again, and each unit takes in what its content rises by.

Mass is the makers', or that of the bladders alone, $\rho \sum n_i V_{b,i}$. Of air the cost of a
cycle is that of its normal volume $V_N$, or of the energy $p_a V_N \ln((P_s + p_a)/p_a)$ that
compresses it without losses; of a liquid, that of $P_s V$.

**Reference:** normal volumes at 20 °C and 100 kPa (ISO 8778, "ANR"), the air in the muscle at
20 °C too, the atmosphere at 100 kPa. **Assumes** no dead volume in tubes and valves, and no leaks.
"""

from dataclasses import dataclass

import numpy as np

from ..bundle import Bundle
from ..core.types import Bool, Float, Int
from ..core.validation import LARGEST_STRAIN
from .cycle import ATMOSPHERE, Cycle, ValveSizing, hose_volume, size_valves
from .designs import Designs, packed_radius
from .evaluation import evaluate, outcomes
from .exhaustive_search import SearchResult
from .outcome import FORCE_TOLERANCE
from .space import Catalog, Product, compositions, number_of_splits
from .task import Task


STANDARD_GRAVITY = 9.80665  # m/s², of ISO 80000-3
_MOST_SPLITS = 5000  # of the same muscles: some seconds

Points = Float[np.ndarray, " point"]


@dataclass(frozen=True, eq=False)
class Cases:
    """A bundle of a `length` [m] at the points of a `task`, its load cases.

    - `largest`: force that it gives at each [N]; `spare`: less the demanded one [N].
    - `state`: that meets it, counted from 1; 0 if it isn't reached.
    - `pressures`: of the units in it, as `recruit` gives them [Pa].
    - `content`: of each unit [m³]: of air in normal volume, of liquid what flows in.
    """

    task: Task
    length: float
    largest: Points
    spare: Points
    state: Int[np.ndarray, " point"]
    pressures: Float[np.ndarray, "point unit"]
    content: Float[np.ndarray, "point unit"]

    @property
    def reached(self) -> Bool[np.ndarray, " point"]:
        """Mask of the load cases that are reached."""
        return self.spare >= -FORCE_TOLERANCE

    @property
    def relative(self) -> Points:
        """Force to spare over `Task.reference` of each load case [-]."""
        return self.spare / self.task.reference

    @property
    def fluid(self) -> Points:
        """Fluid that a cycle to each load case takes from the supply [m³]."""
        return np.maximum(self.content, 0.0).sum(axis=1)

    @property
    def fluid_of_a_cycle(self) -> float:
        """Mean of `fluid` [m³]; of a task in time, what a cycle through it takes."""
        if self.task.time is None:
            return float(np.average(self.fluid, weights=self.task.weight))
        rise = np.diff(self.content, axis=0, append=self.content[:1])
        return float(np.maximum(rise, 0.0).sum())


def cases(designs: Designs, index: int, task: Task) -> Cases:
    """Load cases of a `task` for the design with an `index`."""
    designs.drawing(index).tuning.warn_extrapolation(task.supply_pressure)
    design, bundle = designs.take(np.array([index])), designs.bundle(index, task)
    length = float(design.length[0])
    ((_, outcome),) = outcomes(design, task)
    spare, strain = outcome.spare[:, 0], np.minimum(task.strain_of(length), LARGEST_STRAIN)
    solved = bundle.recruit(task.force, strain)
    pressures = np.asarray(solved.pressures)
    content = np.zeros(pressures.shape)
    for unit, (motor_unit, P) in enumerate(zip(bundle.motor_units, pressures.T, strict=True)):
        volume = np.asarray(motor_unit.muscle.volume(strain))
        taken = volume - float(motor_unit.muscle.volume(0.0))
        if task.fluid == "air":
            taken += P / ATMOSPHERE * volume
        content[:, unit] = np.where(P > 0, motor_unit.count * taken, 0.0)
    state = np.where(spare >= -FORCE_TOLERANCE, np.asarray(solved.state), 0)
    return Cases(task, length, spare + task.force, spare, state, pressures, content)


@dataclass(frozen=True, eq=False)
class Summary:
    """Summary of a design; unknown numbers are `None`.

    - `label`, `muscles`, `valves`: its composition, and numbers of muscles and valves.
    - `diameter`, `diameter_at_rest`: at the largest contraction, vented units bowed out, and at
      rest [m].
    - `product`: that its muscles are sold as; `mass`: as it gives, else of the bladders [kg].
    - `price`, `cost_of_a_cycle`: of muscles and valves, and of the fluid, in the catalog's
      currency [-].
    - `sizing`: of valves and hoses for a cycle, if one is demanded.
    - `held_open`: contraction to which each load case goes if its units stay joined to the supply,
      as by a 3/2 valve [m]; NaN without a rest there.
    - `stretch`: by which the largest load stretches the vented bundle [m]; NaN if it can't.
    """

    label: str
    muscles: int
    valves: int
    cases: Cases
    diameter: float
    diameter_at_rest: float
    product: Product | None
    mass: float | None
    price: float | None
    cost_of_a_cycle: float | None
    sizing: ValveSizing | None
    held_open: Points
    stretch: float

    @property
    def relative_margin(self) -> float:
        """The least `relative` margin of the load cases that are reached [-]; NaN where none is."""
        relative = self.cases.relative[self.cases.reached]
        return float(relative.min()) if relative.size else np.nan

    @property
    def flow(self) -> float:
        """Air that the cycles of `sizing` take, with that of hoses, in normal volume [m³/s]."""
        assert self.sizing is not None
        task, hoses = self.cases.task, hose_volume(self.sizing.line)
        pressurized = np.average(np.sum(self.cases.pressures > 0, axis=1), weights=task.weight)
        hose_air = pressurized * hoses * task.supply_pressure / ATMOSPHERE
        return (self.cases.fluid_of_a_cycle + hose_air) * self.sizing.cycle.per_minute / 60

    @property
    def supply_power(self) -> float:
        """Power that compresses the air of `flow` without losses [W]."""
        ratio = self.cases.task.supply_pressure / ATMOSPHERE
        return ATMOSPHERE * self.flow * float(np.log1p(ratio))


def summarize(
    designs: Designs,
    index: int,
    task: Task,
    catalog: Catalog,
    cycle: Cycle | None = None,
) -> Summary:
    """Summary of the design with an `index`: its load cases, size, mass, price, by a `catalog` [-],
    and valves, if there is a `cycle` to size them for.
    """
    design = designs.take(np.array([index]))
    diameter = float(evaluate(design, task, ["envelope"])["envelope"][0])
    counts, radius = design.counts[0], design.radius[0]
    muscles, valves = int(counts.sum()), int(design.units[0])
    product = catalog.products.get(list(design.drawings)[int(design.kind[0])])
    mass, price = None, float(catalog.price(design)[0])
    if product is not None and product.mass is not None:
        mass = product.mass * muscles
    elif catalog.density is not None:
        section = np.pi * (radius**2 - (radius - design.wall[0]) ** 2)
        mass = catalog.density * float(np.sum(counts * section) * design.length[0])
    load_cases, bundle = cases(design, 0, task), design.bundle(0, task)
    cost, fluid, supply = None, load_cases.fluid_of_a_cycle, task.supply_pressure
    if task.fluid == "air" and catalog.air is not None:
        cost = catalog.air * fluid
    elif catalog.energy is not None:
        work = supply if task.fluid == "liquid" else ATMOSPHERE * np.log1p(supply / ATMOSPHERE)
        cost = float(catalog.energy * work * fluid)
    sizing = None
    if cycle is not None:
        margin = np.where(load_cases.reached, np.maximum(load_cases.relative, 0.0), -1.0)
        sizing = size_valves(design, task, cycle, load_cases.pressures, load_cases.fluid, margin)
    open_pressures = np.where(load_cases.pressures > 0, supply, 0.0)
    vented = _rest(bundle, task.force.max(keepdims=True), np.zeros((1, valves)))
    return Summary(
        *(design.labels[0], muscles, valves, load_cases, diameter),
        *(2 * float(packed_radius(radius, counts)), product, mass),
        *(None if np.isnan(price) else price, cost, sizing),
        held_open=load_cases.length * _rest(bundle, task.force, open_pressures),
        stretch=-load_cases.length * float(vented[0]),
    )


def _rest(bundle: Bundle, force: Points, pressures: Float[np.ndarray, "point unit"]) -> Points:
    """Strain at which a bundle holds loads [N] at rest, the largest stable one [-]; NaN if none."""
    rest = bundle.strain_at(force, pressures)
    strain = np.where(rest.stable, rest.strain, -np.inf).max(axis=-1)
    return np.where(np.isfinite(strain), strain, np.nan)


@dataclass(frozen=True, eq=False)
class Splits:
    """The muscles of a design in 1, 2, 3 … motor units, each time in the split that takes least
    fluid energy: `designs`, and their `values` [SI] by objective.
    """

    designs: Designs
    values: dict[str, Float[np.ndarray, " design"]]


def best_splits(result: SearchResult, index: int) -> Splits | None:
    """Gain and cost of more motor units at the task for the muscles of the recorded design with an
    `index`; `None` for unlike muscles, and for too many of them.
    """
    design, most = result.all_designs(np.array([index])), result.space.most_units
    number = int(design.counts.sum())
    units = min(number, max(most or 5, int(design.units[0])))
    if not design.uniform[0] or number_of_splits(number, "all", units) > _MOST_SPLITS:
        return None
    name = list(design.drawings)[int(design.kind[0])]
    splits = Designs.of(design.muscle(0), compositions(number, units), name)
    names = ["mean_energy", "mean_efficiency", "force_resolution", "relative_margin"]
    if not result.task.scheme.independent:
        names.append("reversal_depth")
    values = evaluate(splits, result.task, names)
    reached = values["relative_margin"] >= result.values["relative_margin"][index] * (1 - 1e-6)
    energy = np.where(reached, values["mean_energy"], np.inf)
    # of each number of units the split with the least energy, if one reaches as much
    order = np.lexsort((energy, splits.units))
    best = order[np.unique(splits.units[order], return_index=True)[1]]
    best = best[np.isfinite(energy[best])]
    if not best.size:
        return None
    return Splits(splits.take(best), {name: row[best] for name, row in values.items()})
