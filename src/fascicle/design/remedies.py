"""What would make a design reach its task: each solved for with the law itself.

One thing is changed at a time, the rest stays: the supply's pressure, the number of muscles in
the last motor unit, the radius of all muscles with their walls in proportion, and, where the task
asks for a stroke, the muscles' length. The smallest change that reaches is looked for on a grid
from what there is to the largest that may be, then between the last value that doesn't reach and
the first that does; what is found is checked at every point. Where nothing on the grid reaches,
this alone can't.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..core.types import Float, Int
from ..core.validation import HIGHEST_PRESSURE
from .catalog import Product
from .designs import Designs
from .evaluation import evaluate, outcomes
from .objectives import Limits, is_enough, other_limits
from .task import Task


_LONGEST, _WIDEST = 10.0, 0.25  # m; some three times what has been built
_MOST_MUSCLES = 1000  # of a bundle
_GRID = 33
_PRECISION = 1e-6  # of a pressure or a size
_AT_ONCE = 256  # points looked at while solving; the others when it is solved


@dataclass(frozen=True)
class Remedy:
    """A change that would reach the task. `what` is changed: "supply_pressure" [Pa], "muscles",
    "radius" [m] or "length" [m], `now` as it is; its `value`, `None` where this alone can't;
    `most`: the largest that was looked at, which at the `worst` point is still `short` by so much
    [N], so that it gives `largest` there [N]. `free_strain`: the largest of the muscles, at that
    pressure. `breaks`: limits that the changed design breaks, by name, and the value
    it has then [SI]; `measured`: the pressure that the muscles' tuning was measured up to [Pa].
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
    """What would make a design reach its task.

    **Arguments:**

    - `designs`: among which it is.
    - `index`: which of them.
    - `task`: what is demanded.
    - `may_miss`: share of it that may be missed [-].
    - `limits`: on objectives, by name [SI]: the result names those that the changed design breaks.
    - `product`: what its muscles are sold as, if they are: their radius can't be changed then.

    **Returns:** the changes, each by itself.
    """
    design = designs.take(np.array([index]))
    design = design.take(np.array([0]), int(design.units[0]))
    drawing, now = design.drawing(0), _current(design, task)
    top = HIGHEST_PRESSURE
    if product is not None and product.largest_pressure is not None:
        top = min(top, product.largest_pressure)
    number = np.geomspace(now["muscles"], max(_MOST_MUSCLES, now["muscles"]), _GRID).round()
    grids = {
        "supply_pressure": np.linspace(
            now["supply_pressure"], max(task.supply_pressure, top), _GRID
        ),
        "muscles": np.unique(number),
    }
    if product is None:
        grids["radius"] = np.geomspace(now["radius"], max(now["radius"], _WIDEST), _GRID)
    if task.stroke is not None:
        grids["length"] = np.geomspace(now["length"], max(now["length"], _LONGEST), _GRID)
    pressures = np.asarray(drawing.tuning.pressures)
    measured = float(pressures.max()) if pressures.size > 1 else np.inf
    found = []
    for what, grid in grids.items():
        remedy = _solve(design, task, what, grid, may_miss)
        if remedy.value is None:
            pressure = remedy.most if what == "supply_pressure" else task.supply_pressure
            law = design.sizes(0).muscle(drawing).law
            free = law.tension.free_strain(pressure + 0.0 * design.radius[0])
            remedy = replace(remedy, free_strain=float(free.max()))
        remedy = replace(remedy, measured=measured)
        found.append(replace(remedy, breaks=_broken_limits(remedy, design, task, limits)))
    return found


def _current(design: Designs, task: Task) -> dict[str, float]:
    """The quantities that a remedy may change, as they are [SI]."""
    return {
        "supply_pressure": task.supply_pressure,
        "muscles": float(design.counts.sum()),
        "radius": float(design.radius.max()),
        "length": float(design.length[0]),
    }


def _change(design: Designs, task: Task, what: str, value: float) -> tuple[Designs, Task]:
    """The design and its task with a remedy's `value` [SI] of `what`."""
    now = _current(design, task)[what]
    ratio = value / now
    if what == "supply_pressure":
        return design, replace(task, supply_pressure=value)
    if what == "length":
        return replace(design, length=design.length * ratio), task
    if what == "radius":
        return replace(design, radius=design.radius * ratio, wall=design.wall * ratio), task
    counts = design.counts.copy()
    counts[0, -1] += round(value - now)
    return replace(design, counts=counts), task


def _solve(
    design: Designs, task: Task, what: str, grid: Float[np.ndarray, " value"], may_miss: float
) -> Remedy:
    """The smallest value that reaches the task, between the grid's ends."""
    now, most = float(grid[0]), float(grid[-1])

    def spare(value: float, points: Int[np.ndarray, " point"]) -> Float[np.ndarray, " point"]:
        changed, asked = _change(design, task.take(points), what, value)
        ((_, found),) = outcomes(changed, asked)
        return np.reshape(found.spare, -1)

    def reaches(value: float, points: Int[np.ndarray, " point"]) -> bool:
        return bool(is_enough(spare(value, points), task.weight[points], may_miss))

    every = points = np.arange(len(task))
    if may_miss == 0 and len(task) > _AT_ONCE:
        # where all must be reached the hardest decide; which they are may change with the value
        points = np.argsort(spare(now, every))[:_AT_ONCE]
    while True:
        first = next((i for i, value in enumerate(grid) if reaches(float(value), points)), None)
        if first is None:
            left = spare(most, every)
            worst = int(np.argmin(left / task.reference))
            largest = float(left[worst] + task.force[worst])
            return Remedy(what, now, None, most, worst, float(-left[worst]), largest)
        low, high = grid[max(first - 1, 0)], grid[first]
        value = _bisect(lambda value: reaches(value, points), low, high, what == "muscles")  # noqa: B023
        if reaches(value, every):
            return Remedy(what, now, value, most)
        points = np.union1d(points, np.argsort(spare(value, every))[:_AT_ONCE])


def _bisect(reaches: Callable[[float], bool], low: float, high: float, whole: bool) -> float:
    """The smallest value that reaches, `whole` numbers alone or to the relative precision."""
    while high - low > (1.0 if whole else _PRECISION * high):
        middle = 0.5 * (low + high)
        middle = float(np.floor(middle)) if whole else middle
        low, high = (low, middle) if reaches(middle) else (middle, high)
    return float(high)


def _broken_limits(
    remedy: Remedy, design: Designs, task: Task, limits: Limits
) -> tuple[tuple[str, float], ...]:
    """Limits that the changed design breaks, and its values [SI]."""
    # a change leaves the number of valves as it is
    names = tuple(name for name in other_limits(limits) if name != "valves")
    if remedy.value is None or not names:
        return ()
    values = evaluate(*_change(design, task, remedy.what, remedy.value), names)
    pairs = ((name, float(values[name][0])) for name in names)
    return tuple(pair for pair in pairs if not limits[pair[0]].holds(pair[1]))
