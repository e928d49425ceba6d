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

import equinox as eqx
import numpy as np

from ..core.types import Float
from ..core.validation import HIGHEST_PRESSURE
from .cases import Bench
from .catalog import Product
from .designs import Designs
from .evaluation import evaluate
from .limits import Limits, enough, others
from .task import Task


_LONGEST, _WIDEST = 10.0, 0.25  # m; some three times what has been built
_MOST_MUSCLES = 1000  # of a bundle
_GRID = 33
_PRECISION = 1e-6  # of a pressure or a size
_AT_ONCE = 256  # points looked at while solving; the others when it is solved

Points = Float[np.ndarray, " point"]
Forces = Callable[[float], Points]


@dataclass(frozen=True)
class Remedy:
    """A change that would reach the task. `what` is changed: "supply_pressure" [Pa], "muscles"
    [-], "radius" [m] or "length" [m], `now` as it is; its `value`, `None` where this alone can't;
    `most`: the largest that was looked at, which at the `worst` point is still `short` by so much
    [N], so that it gives `largest` there [N]. `contracts`: the largest free strain of the muscles,
    at that pressure [-]. `breaks`: limits that the changed design breaks, by name, and the value
    it has then [SI]; `measured`: the pressure that the muscles' tuning was measured up to [Pa].
    """

    what: str
    now: float
    value: float | None
    most: float
    worst: int = 0
    short: float = 0.0
    largest: float = 0.0
    contracts: float = 0.0
    breaks: tuple[tuple[str, float], ...] = ()
    measured: float = np.inf


def remedies(
    designs: Designs,
    place: int,
    task: Task,
    may_miss: float,
    limits: Limits,
    product: Product | None = None,
) -> list[Remedy]:
    """What would make a design reach its task.

    **Arguments:**

    - `designs`: among which it is [-].
    - `place`: which of them [-].
    - `task`: what is demanded [-].
    - `may_miss`: share of it that may be missed [-].
    - `limits`: on objectives, by name [SI]: which of them the changed design breaks is told.
    - `product`: what its muscles are sold as [-], if they are: their radius can't be changed then.

    **Returns:** the changes [-], each by itself.
    """
    bench, asked = Bench.of(designs, place), _Asked(task, may_miss)
    top, supply = HIGHEST_PRESSURE, task.supply_pressure
    if product is not None and product.largest_pressure is not None:
        top = min(top, product.largest_pressure)

    def by_pressure(value: float) -> Points:
        return bench.largest(value, asked.strain(bench.length), task.scheme)

    held, last = int(bench.counts[:-1].sum()), int(bench.counts[-1])

    def by_number(value: float) -> Points:
        more = replace(bench, counts=np.append(bench.counts[:-1], round(value) - held))
        return more.largest(supply, asked.strain(bench.length), task.scheme)

    radius = max(float(m.outer_radius) for m in bench.muscles)

    def by_radius(value: float) -> Points:
        wider = _scaled(bench, value / radius, 1.0)
        return wider.largest(supply, asked.strain(bench.length), task.scheme)

    def by_length(value: float) -> Points:
        longer = _scaled(bench, 1.0, value / bench.length)
        return longer.largest(supply, asked.strain(value), task.scheme)

    number = np.geomspace(held + last, max(_MOST_MUSCLES, held + last), _GRID).round()
    tried: list[tuple[str, Forces, Float[np.ndarray, " grid"]]] = [
        ("supply_pressure", by_pressure, np.linspace(supply, max(supply, top), _GRID)),
        ("muscles", by_number, np.unique(number)),
    ]
    if product is None:
        tried.append(("radius", by_radius, np.geomspace(radius, max(radius, _WIDEST), _GRID)))
    if task.stroke is not None:
        longest = max(bench.length, _LONGEST)
        tried.append(("length", by_length, np.geomspace(bench.length, longest, _GRID)))
    found = []
    for what, forces, grid in tried:
        one = _solved(what, forces, grid, asked)
        if one.value is None:
            at = one.most if what == "supply_pressure" else supply
            one = replace(one, contracts=bench.contracts(at))
        one = replace(one, measured=bench.measured)
        found.append(_checked(one, designs, place, task, limits))
    return found


class _Asked:
    """The points of a task that are looked at: the hardest first, all when it is solved."""

    def __init__(self, task: Task, may_miss: float):
        self.task, self.may_miss = task, may_miss
        self.rows = np.arange(len(task))

    def strain(self, length: float) -> Points:
        return self.task.strain_of(length)[self.rows]

    def spare(self, largest: Points) -> Points:
        return largest - self.task.force[self.rows]

    def reached(self, largest: Points) -> bool:
        return bool(enough(self.spare(largest), self.task.weight[self.rows], self.may_miss))

    def all(self) -> None:
        self.rows = np.arange(len(self.task))

    def hardest(self, forces: Forces, value: float) -> None:
        """Look at those alone that decide at a value, where all points must be reached."""
        self.all()
        if self.may_miss == 0 and len(self.rows) > _AT_ONCE:
            self.rows = np.sort(np.argsort(self.spare(forces(value)))[:_AT_ONCE])


def _solved(what: str, forces: Forces, grid: Float[np.ndarray, " grid"], asked: _Asked) -> Remedy:
    """The smallest value that reaches, between the grid's ends."""
    now, most = float(grid[0]), float(grid[-1])
    asked.hardest(forces, now)
    while True:
        first = next((i for i, x in enumerate(grid) if asked.reached(forces(float(x)))), None)
        if first is None:
            return _none(what, forces, now, most, asked)
        value = _between(what, forces, float(grid[max(first - 1, 0)]), float(grid[first]), asked)
        looked_at = asked.rows
        asked.all()
        largest = forces(value)
        if asked.reached(largest):
            return Remedy(what, now, value, most)
        # points that were left out decide after all
        missed = np.argsort(asked.spare(largest))[:_AT_ONCE]
        asked.rows = np.union1d(looked_at, missed)


def _between(what: str, forces: Forces, low: float, high: float, asked: _Asked) -> float:
    whole = what == "muscles"
    while high - low > (1.0 if whole else _PRECISION * high):
        middle = 0.5 * (low + high)
        middle = np.floor(middle) if whole else middle
        if asked.reached(forces(middle)):
            high = middle
        else:
            low = middle
    return float(high)


def _none(what: str, forces: Forces, now: float, most: float, asked: _Asked) -> Remedy:
    asked.all()
    largest = forces(most)
    spare = largest - asked.task.force
    worst = int(np.argmin(spare / asked.task.reference))
    return Remedy(what, now, None, most, worst, float(-spare[worst]), float(largest[worst]))


def _scaled(bench: Bench, radius: float, length: float) -> Bench:
    muscles = tuple(
        eqx.tree_at(
            lambda m: (m.outer_radius, m.wall_thickness, m.length),
            muscle,
            (muscle.outer_radius * radius, muscle.wall_thickness * radius, muscle.length * length),
        )
        for muscle in bench.muscles
    )
    return replace(bench, muscles=muscles)


def _checked(one: Remedy, designs: Designs, place: int, task: Task, limits: Limits) -> Remedy:
    """The same with the limits that it breaks; a change leaves the number of valves as it is."""
    names = tuple(name for name in others(limits) if name != "valves")
    if one.value is None or not names:
        return one
    changed, by = designs.take(np.array([place])), one.value / one.now
    if one.what == "supply_pressure":
        task = replace(task, supply_pressure=one.value)
    elif one.what == "muscles":
        counts = changed.counts.copy()
        counts[0, np.count_nonzero(counts[0]) - 1] += round(one.value - one.now)
        changed = replace(changed, counts=counts)
    elif one.what == "radius":
        changed = replace(changed, radius=changed.radius * by, wall=changed.wall * by)
    else:
        changed = replace(changed, length=changed.length * by)
    values = evaluate(changed, task, names)
    told = ((name, float(values[name][0])) for name in names)
    return replace(one, breaks=tuple(x for x in told if not limits[x[0]].holds(x[1])))
