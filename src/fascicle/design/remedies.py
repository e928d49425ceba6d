"""Remedies: changes by which a design would reach its task, each solved for with the law itself.

One quantity is changed at a time: the supply's pressure, the number of muscles in the last motor
unit, the radius of all muscles with their walls in proportion, and, where the task asks for a
stroke, the muscles' length. The smallest change that reaches is searched on a grid from the present
value to the largest possible one, then between the last value that doesn't reach and the first that
does; the result is checked at every point. Where nothing on the grid reaches, this quantity alone
can't.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..core.types import Float, Int
from ..core.validation import HIGHEST_PRESSURE
from .catalog import Product
from .designs import Designs
from .evaluation import evaluate, outcomes
from .objectives import Limits, other_limits, within_miss_limit
from .task import Task


_LONGEST, _WIDEST = 10.0, 0.25  # m; some three times what has been built
_MOST_MUSCLES = 1000  # of a bundle, some ten times what has been built
_GRID = 33  # values from the present one to the largest
_PRECISION = 1e-6  # of a pressure or a size: finer than any gauge
_FEW = 256  # points solved for at first; the others are checked when it is solved


@dataclass(frozen=True)
class Remedy:
    """Change of one quantity for a design to reach its task: the sufficient value, or if none is
    the largest one tried and the force that is still missing [N].

    - `what`: the changed quantity: "supply_pressure" [Pa], "muscles", "radius" [m] or "length" [m].
    - `now`: its present value; `value`: the sufficient one, `None` if there is none.
    - `most`: the largest that was tried; with it the `worst` point is still `short` by so much [N],
      since the bundle gives `largest` there [N].
    - `free_strain`: the largest of the muscles, at that pressure [-].
    - `breaks`: limits that the changed design breaks, by name, and the value it has then [SI].
    - `measured`: the pressure that the muscles' tuning was measured up to [Pa].
    """

    what: str
    now: float
    value: float | None
    most: float
    worst: int = 0
    short: float = 0.0
    largest: float = 0.0
    free_strain: float = 0.0
    breaks: tuple[tuple[str, float], ...] = ()
    measured: float = np.inf


def remedies(
    designs: Designs,
    index: int,
    task: Task,
    may_miss: float,
    limits: Limits,
    product: Product | None = None,
) -> list[Remedy]:
    """Changes by which a design would reach its task, one for each quantity, enough or not.

    **Arguments:**

    - `designs`: with the design among them.
    - `index`: of the design.
    - `task`: what is demanded.
    - `may_miss`: share of it that may be missed [-].
    - `limits`: on objectives, by name [SI]: the result names those that the changed design breaks.
    - `product`: that its muscles are sold as, if they are: their radius can't be changed then.

    **Returns:** the changes, each by itself.
    """
    design = designs.take(np.array([index]))
    design = design.take(np.array([0]), int(design.units[0]))
    present, drawing = _present_values(design, task), design.drawing(0)
    highest = HIGHEST_PRESSURE
    if product is not None and product.largest_pressure is not None:
        highest = min(highest, product.largest_pressure)
    largest = {"supply_pressure": highest, "muscles": _MOST_MUSCLES}
    if product is None:
        largest["radius"] = _WIDEST
    if task.stroke is not None:
        largest["length"] = _LONGEST
    pressures = np.asarray(drawing.tuning.pressures)
    measured = float(pressures.max()) if pressures.size > 1 else np.inf
    # a change leaves the number of valves as it is
    names = [name for name in other_limits(limits) if name != "valves"]
    changes = []
    for what, end in largest.items():
        spaced = np.linspace if what == "supply_pressure" else np.geomspace
        grid = spaced(present[what], max(end, present[what]), _GRID)
        grid = np.unique(grid.round()) if what == "muscles" else grid
        remedy = _smallest_change(design, task, what, grid, may_miss)
        if remedy.value is None:
            pressure = remedy.most if what == "supply_pressure" else task.supply_pressure
            law = design.sizes(0).muscle(drawing).law
            free = law.tension.free_strain(pressure + 0.0 * design.radius[0])
            remedy = replace(remedy, free_strain=float(free.max()))
        elif names:
            values = evaluate(*_apply_change(design, task, what, remedy.value), names)
            pairs = [(name, float(values[name][0])) for name in names]
            broken = tuple(pair for pair in pairs if not limits[pair[0]].holds(pair[1]))
            remedy = replace(remedy, breaks=broken)
        changes.append(replace(remedy, measured=measured))
    return changes


def _present_values(design: Designs, task: Task) -> dict[str, float]:
    """Present values that a remedy may change [SI]: all muscles' number and largest radius."""
    return {
        "supply_pressure": task.supply_pressure,
        "muscles": float(design.counts.sum()),
        "radius": float(design.radius.max()),
        "length": float(design.length[0]),
    }


def _apply_change(design: Designs, task: Task, what: str, value: float) -> tuple[Designs, Task]:
    """The design and its task with a `value` [SI] of `what`; more muscles join the last unit, radii
    and walls are scaled by the ratio to the largest.
    """
    if what == "supply_pressure":
        return design, replace(task, supply_pressure=value)
    present = _present_values(design, task)[what]
    ratio = value / present
    if what == "length":
        return replace(design, length=design.length * ratio), task
    if what == "radius":
        return replace(design, radius=design.radius * ratio, wall=design.wall * ratio), task
    counts = design.counts.copy()
    counts[0, -1] += round(value - present)
    return replace(design, counts=counts), task


def _smallest_change(
    design: Designs, task: Task, what: str, grid: Float[np.ndarray, " value"], may_miss: float
) -> Remedy:
    """Remedy with the smallest value that reaches the task, on the rising `grid` or between."""

    def spare_forces(
        value: float, points: Int[np.ndarray, " point"]
    ) -> Float[np.ndarray, " point"]:
        ((_, outcome),) = outcomes(*_apply_change(design, task.take(points), what, value))
        return np.reshape(outcome.spare, -1)

    def reaches(value: float, points: Int[np.ndarray, " point"]) -> bool:
        return bool(within_miss_limit(spare_forces(value, points), task.weight[points], may_miss))

    present, highest = float(grid[0]), float(grid[-1])
    all_points = points = np.arange(len(task))
    if may_miss == 0 and len(task) > _FEW:
        # where all must be reached the hardest decide; which they are may change with the value
        points = np.argsort(spare_forces(present, all_points))[:_FEW]
    while True:
        first = next((i for i, value in enumerate(grid) if reaches(float(value), points)), None)
        if first is None:
            excess = spare_forces(highest, all_points)
            worst = int(np.argmin(excess / task.reference))
            largest = float(excess[worst] + task.force[worst])
            return Remedy(what, present, None, highest, worst, float(-excess[worst]), largest)
        low, high = grid[max(first - 1, 0)], grid[first]
        while high - low > (1.0 if what == "muscles" else _PRECISION * high):
            middle = 0.5 * (low + high)
            middle = float(np.floor(middle)) if what == "muscles" else middle
            low, high = (low, middle) if reaches(middle, points) else (middle, high)
        if reaches(float(high), all_points):
            return Remedy(what, present, float(high), highest)
        points = np.union1d(points, np.argsort(spare_forces(float(high), all_points))[:_FEW])
