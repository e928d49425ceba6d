r"""One design in detail: its load cases, size, mass, fluid and cost.

Forces are those of its muscles at a table of throttled pressures, added up over the states. The
*margin* is the least force to spare; the fluid is what flows in from the supply:

$$V_N = \sum_i n_i \frac{(p_i + p_a) V_i(\varepsilon) - p_a V_i(0)}{p_a} \tag{G3}$$

for air, in normal volume, over the units that are fed, each filled at its own pressure $p_i$ and
vented to the atmosphere $p_a$ at rest; for a liquid $\sum_i n_i (V_i(\varepsilon) - V_i(0))$, since
it stays full. A unit that isn't fed breathes with the atmosphere. Where a load case is one of
a cloud, a *cycle* goes from rest to it and back, and the mean over the task counts by weight; where
the task is given in time, it goes once through all of them and to the first again, and each unit
takes in what its content rises by.

Mass is that given by the products' makers, or that of the bladders alone,
$\rho \sum n_i V_{b,i}$, where a density is given. Of air the cost of a cycle is that of its
normal volume $V_N$, or of the energy
$p_a V_N \ln((P_s + p_a)/p_a)$ that compresses it without losses; of a liquid, that of $P_s V$.

**Reference:** normal volumes at 20 °C and 100 kPa (ISO 8778, "ANR"), the air in the muscle at
20 °C too, the atmosphere at 100 kPa. **Assumes** no dead volume in tubes and valves, and no leaks.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..bundle.states import states_of
from ..core.module import with_fields
from ..core.types import Bool, Float, Int
from ..muscle import Muscle
from .catalog import Catalog, Product
from .cycle import ATMOSPHERE, Cycle, ValveSizing, first_level, size_valves
from .designs import Designs, Sizes, packed_radius
from .evaluation import MIXED, UNIFORM, Resolution, evaluate, every_level_table
from .exhaustive_search import SearchResult
from .outcome import (
    FORCE_TOLERANCE,
    MAX_FED_SETS,
    Demand,
    choose_states,
)
from .task import Task


STANDARD_GRAVITY = 9.80665  # m/s², of ISO 80000-3
_BATCH = 1024  # points computed together: some ten megabytes of forces at all levels

Points = Float[np.ndarray, " point"]


@dataclass(frozen=True, eq=False)
class Cases:
    """Forces, recruitment states and fluid of a bundle at the points of a `task`, its load cases.

    - `length`: of the bundle at rest [m].
    - `largest`: force that it gives at each [N].
    - `spare`: that force less the demanded one [N]; negative where it isn't reached.
    - `state`: that meets it, counted from 0.
    - `pressure`: throttled in that state [Pa]; of independent units, that of the last pressurized.
    - `content`: of each unit [m³]: of air in normal volume, of liquid what flows in.
    """

    task: Task
    length: float
    largest: Points
    spare: Points
    state: Int[np.ndarray, " point"]
    pressure: Points
    content: Float[np.ndarray, "point unit"]

    @property
    def reached(self) -> Bool[np.ndarray, " point"]:
        """Mask of the load cases that are reached."""
        return self.spare >= -FORCE_TOLERANCE

    @property
    def relative(self) -> Points:
        """Relative margin of each load case [-]: force to spare over the demanded force; over the
        task's largest force where none is demanded.
        """
        return self.spare / self.task.reference

    @property
    def tightest(self) -> int:
        """The load case with the least force to spare, counted from 0."""
        return int(np.argmin(self.spare))

    @property
    def worst(self) -> int:
        """The load case with the least force to spare over what is demanded [-], counted from 0."""
        return int(np.argmin(self.relative))

    @cached_property
    def fluid(self) -> Points:
        """Fluid that a cycle to each load case takes from the supply [m³]."""
        return np.maximum(self.content, 0.0).sum(axis=1)

    @property
    def fluid_of_a_cycle(self) -> float:
        """Fluid of a cycle [m³]: the mean of `fluid`, or the sum over a task in time."""
        if self.task.time is None:
            return float(np.average(self.fluid, weights=self.task.weight))
        rise = np.diff(self.content, axis=0, append=self.content[:1])
        return float(np.maximum(rise, 0.0).sum())


def cases(designs: Designs, index: int, task: Task) -> Cases:
    """Compute the load cases of a task for a design.

    **Arguments:**

    - `designs`: with the design among them.
    - `index`: of the design.
    - `task`: what is demanded.

    **Returns:** the load cases.
    """
    drawing, uniform = designs.drawing(index), bool(designs.uniform[index])
    drawing.tuning.warn_extrapolation(task.supply_pressure)
    counts = designs.counts[index][designs.counts[index] > 0]
    sizes = designs.sizes(index).take(slice(0, 1 if uniform else len(counts)))
    resolution, demand = UNIFORM if uniform else MIXED, Demand.from_task(task)
    batches = []
    for start in range(0, len(task), _BATCH):
        cut = slice(start, start + _BATCH)
        portion = with_fields(
            demand, force=demand.force[cut], travel=demand.travel[cut], weight=demand.weight[cut]
        )
        batches.append(_case_fields(drawing, sizes, counts, portion, resolution, task.fluid))
    return Cases(task, float(sizes.length[0]), *map(np.concatenate, zip(*batches, strict=True)))


def _case_fields(
    drawing: Muscle,
    sizes: Sizes,
    counts: Int[np.ndarray, " unit"],
    demand: Demand,
    resolution: Resolution,
    fluid: str,
) -> tuple[np.ndarray, ...]:
    """Fields of `Cases` after the length: largest, spare, state, pressure and content."""
    length, F = sizes.length[0], demand.force
    table, _ = every_level_table(drawing, sizes, demand, (), resolution)
    table = table.take(np.zeros(len(counts), int) if len(sizes.length) == 1 else slice(None))
    sets, state_of = states_of(demand.scheme, len(counts)).sets(max_sets=MAX_FED_SETS)
    choice = choose_states(counts, table, length, demand, sets, np.ones(sets.size, bool), True)
    full, throttled = sets.full[choice.state], sets.throttled[choice.state]
    pressurized, forces = full | throttled, counts * table.levels
    if sets.independent:
        last, levels = _independent_levels(forces, full, throttled, F, resolution.level)
    else:
        force = sets.sums(forces, forces[0], forces[-1])[choice.state, :, np.arange(len(F))]
        last = first_level(force, F, resolution.level)
        levels = np.where(throttled, last[:, None], full)
    # a case that isn't reached is as near as can be with all fed units at full supply
    levels = np.where(choice.reached[:, None], levels, pressurized)
    pressure = np.where(choice.reached, last, 1.0) * demand.supply
    content = table.volume
    if fluid == "air":
        filling = levels * demand.supply / ATMOSPHERE
        content = (1 + filling) * content + filling * sizes.muscle(drawing).volume(0 * sizes.length)
    content = np.where(pressurized, counts * content, 0.0)
    return choice.largest, choice.spare, state_of[choice.state], pressure, content


def _independent_levels(
    forces: Float[np.ndarray, "level point unit"],
    full: Bool[np.ndarray, "point unit"],
    throttled: Bool[np.ndarray, "point unit"],
    demanded: Points,
    level: Float[np.ndarray, " level"],
) -> tuple[Points, Float[np.ndarray, "point unit"]]:
    """Levels of the last throttled unit and of all units [-], if several are throttled
    independently: all of them but the last have the level of most force, or that of least force
    if the demand is below the force of the others.
    """
    vented, supplied = forces[0], forces[-1]
    base = np.where(full, supplied, vented).sum(axis=1)
    extreme = np.where((demanded >= base)[:, None], forces.argmax(axis=0), forces.argmin(axis=0))
    force = np.take_along_axis(forces, extreme[None], axis=0)[0]
    force = np.where(full, supplied, np.where(throttled, force, vented))
    last = throttled.shape[1] - 1 - np.argmax(throttled[:, ::-1], axis=1)
    is_last = np.arange(throttled.shape[1]) == last[:, None]
    remainder = demanded - np.where(is_last, 0.0, force).sum(axis=1)
    last_level = first_level(forces[:, np.arange(len(last)), last].T, remainder, level)
    levels = np.where(full, 1.0, np.where(throttled, level[extreme], 0.0))
    return last_level, np.where(is_last, last_level[:, None], levels)


@dataclass(frozen=True, eq=False)
class Summary:
    """Summary of a design; unknown numbers are `None`.

    - `label`, `muscles`, `valves`: its composition, and numbers of muscles and valves.
    - `cases`: its load cases.
    - `diameter`, `diameter_at_rest`: at the largest contraction, vented units bowed out, and at
      rest [m].
    - `product`: that its muscles are sold as, if any.
    - `bladders`: their volume [m³].
    - `mass`: of whole muscles if the `product` gives it, else of the bladders [kg].
    - `price`, `price_of_muscles`, `cost_of_a_cycle`: of muscles and valves, of muscles alone, and
      of the fluid, in the catalog's currency [-].
    - `sizing`: of valves and hoses for a cycle, if one is demanded.
    - `run`, `run_failure`: words on the run over time with these valves, and on its failure, if
      any.
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
    sizing: ValveSizing | None = None
    run: str = ""
    run_failure: str = ""

    @property
    def margin(self) -> float:
        """The least force to spare [N], negative where a load case isn't reached."""
        return float(self.cases.spare.min())

    @property
    def relative_margin(self) -> float:
        """The least force to spare over what is demanded, of the load cases that are reached
        [-]; NaN where none is.
        """
        relative = self.cases.relative[self.cases.reached]
        return float(relative.min()) if relative.size else np.nan

    @property
    def load_factor(self) -> float:
        """Factor by which all loads could be multiplied together [-]; infinite without a load."""
        loaded = self.cases.task.force > 0
        ratio = self.cases.largest[loaded] / self.cases.task.force[loaded]
        return float(np.min(ratio, initial=np.inf))

    @property
    def flow(self) -> float:
        """Air that the cycles of `sizing` take, in normal volume [m³/s], with that of hoses at
        supply pressure.
        """
        assert self.sizing is not None
        task, hoses = self.cases.task, self.sizing.hose_volume
        pressurized_units = np.average(np.sum(self.cases.content != 0, axis=1), weights=task.weight)
        hose_air = pressurized_units * hoses * task.supply_pressure / ATMOSPHERE
        return (self.cases.fluid_of_a_cycle + hose_air) * self.sizing.cycle.per_minute / 60

    @property
    def supply_power(self) -> float:
        """Power that compresses the air of `flow` without losses [W]."""
        ratio = self.cases.task.supply_pressure / ATMOSPHERE
        return ATMOSPHERE * self.flow * float(np.log1p(ratio))


def summarize_result(result: SearchResult, index: int) -> Summary:
    """Summary of the recorded design with an `index` in a search."""
    envelope = result.values.get("envelope")
    diameter = None if envelope is None else float(envelope[index])
    design = result.all_designs(np.array([index]))
    return summarize(design, 0, result.task, result.catalog, diameter, result.cycle)


def summarize(
    designs: Designs,
    index: int,
    task: Task,
    catalog: Catalog,
    diameter: float | None = None,
    cycle: Cycle | None = None,
) -> Summary:
    """Summarize a design: its load cases, size, mass, price and valves.

    **Arguments:**

    - `designs`: with the design among them.
    - `index`: of the design.
    - `task`: what is demanded.
    - `catalog`: products and prices [-].
    - `diameter`: of the envelope [m], if it has been computed.
    - `cycle`: for which valves are sized, or `None`.

    **Returns:** the summary.
    """
    design = designs.take(np.array([index]))
    if diameter is None:
        diameter = float(evaluate(design, task, ["envelope"])["envelope"][0])
    counts, radius = design.counts[0], design.radius[0]
    section = np.pi * (radius**2 - (radius - design.wall[0]) ** 2)
    bladders = float(np.sum(counts * section) * design.length[0])
    product = catalog.products.get(list(design.drawings)[int(design.kind[0])])
    mass = None if catalog.density is None else catalog.density * bladders
    if product is not None and product.mass is not None:
        mass = product.mass * int(counts.sum())
    load_cases = cases(design, 0, task)
    price, muscle_price = float(catalog.price(design)[0]), float(catalog.muscle_price(design)[0])
    cost, fluid, supply = None, load_cases.fluid_of_a_cycle, task.supply_pressure
    if task.fluid == "air" and catalog.air is not None:
        cost = catalog.air * fluid
    elif catalog.energy is not None:
        work = supply if task.fluid == "liquid" else ATMOSPHERE * np.log1p(supply / ATMOSPHERE)
        cost = float(catalog.energy * work * fluid)
    sizing = None if cycle is None else size_for_cases(design, load_cases, cycle)
    return Summary(
        design.labels[0], int(counts.sum()), int(design.units[0]), load_cases, diameter,
        2 * float(packed_radius(radius, counts)), product, bladders, mass,
        None if np.isnan(price) else price, None if np.isnan(muscle_price) else muscle_price,
        cost, sizing,
    )  # fmt: skip


def size_for_cases(
    design: Designs, load_cases: Cases, cycle: Cycle, time: float | None = None
) -> ValveSizing | None:
    """Valves of a single `design` for its load cases and a `cycle`, as of `size_valves`; `time`: in
    which they do it without the load's inertia [s].
    """
    pressurized, margin = load_cases.content != 0, load_cases.relative
    margin = np.where(load_cases.reached, np.maximum(margin, 0.0), -1.0)
    return size_valves(
        design, 0, load_cases.task, cycle, pressurized, load_cases.fluid, margin, time
    )
