r"""What one design does at each load case, for whoever builds it.

Forces are those of its muscles at a table of throttled pressures, added up over the states. The
*margin* is the least force to spare; the fluid is what flows in from the supply:

$$V_N = \sum_i n_i \frac{(p_i + p_a) V_i(\varepsilon) - p_a V_i(0)}{p_a} \tag{G3}$$

for air, in normal volume, over the units that are fed, each filled at its own pressure $p_i$ and
vented to the atmosphere $p_a$ at rest; for a liquid $\sum_i n_i (V_i(\varepsilon) - V_i(0))$, since
it stays full. A unit that isn't fed breathes with the atmosphere. Where a load case is one of
a cloud, a *cycle* goes from rest to it and back, and the mean over the task counts by weight; where
the task is given in time, it goes once through all of them and to the first again, and each unit
takes in what its content rises by.

**Reference:** normal volumes at 20 °C and 100 kPa (ISO 8778, "ANR"), the air in the muscle at
20 °C too, the atmosphere at 100 kPa. **Assumes** no dead volume in tubes and valves, and no leaks.
"""

import warnings
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..bundle.schemes import AbstractScheme
from ..bundle.states import states_of
from ..core.types import Bool, Float, Int
from ..core.validation import LARGEST_STRAIN
from ..muscle import Muscle
from .designs import Designs, Rows
from .kernel import Unlike, highest
from .outcome import MET, MOST_SETS, Demand
from .tables import SHARED, UNLIKE, tabulated
from .task import Task


ATMOSPHERE = 100e3  # Pa, of ISO 8778
_BLOCK = 4096  # strains looked at together: what all levels give there is some ten megabytes

Points = Float[np.ndarray, " point"]


@dataclass(frozen=True, eq=False)
class Cases:
    """Load cases of a `task` for a bundle of `length` [m]: the `largest` force that it gives at
    each [N]; the `state` that meets it, counted from 0, and its throttled `pressure` [Pa], of free
    units that of the last one fed; the
    `content` [m³] of each unit there: of air in normal volume, of liquid what flows in.
    """

    task: Task
    length: float
    largest: Points
    state: Int[np.ndarray, " point"]
    pressure: Points
    content: Float[np.ndarray, "point unit"]

    @property
    def spare(self) -> Points:
        """Force to spare at each load case [N], negative where it isn't reached."""
        return self.largest - self.task.force

    @property
    def reached(self) -> Bool[np.ndarray, " point"]:
        """Which load cases are reached [-]."""
        return self.spare >= -MET

    @property
    def tightest(self) -> int:
        """The load case with the least force to spare [-], counted from 0."""
        return int(np.argmin(self.spare))

    @property
    def worst(self) -> int:
        """The load case of which the largest share is missed [-], counted from 0."""
        return int(np.argmin(self.spare / self.task.reference))

    @property
    def relative(self) -> Points:
        """Force to spare over what is demanded [-]; over the largest demand, where nothing is."""
        return self.spare / self.task.reference

    @cached_property
    def fluid(self) -> Points:
        """What a cycle to each load case takes from the supply [m³]."""
        return np.maximum(self.content, 0.0).sum(axis=1)

    @property
    def fluid_of_a_cycle(self) -> float:
        """What a cycle takes [m³]: the mean of `fluid`, or all that a task in time takes once."""
        if self.task.time is None:
            return float(np.average(self.fluid, weights=self.task.weight))
        rise = np.diff(self.content, axis=0, append=self.content[:1])
        return float(np.maximum(rise, 0.0).sum())


def cases(designs: Designs, place: int, task: Task) -> Cases:
    """What a design does at each load case.

    **Arguments:**

    - `designs`: among which it is [-].
    - `place`: which of them [-].
    - `task`: what is demanded [-].

    **Returns:** the load cases [-].
    """
    bench = Bench.of(designs, place)
    for muscle in bench.muscles:
        muscle.tuning.warn_extrapolation(task.supply_pressure)
    strain, supply = task.strain_of(bench.length), task.supply_pressure
    parts = [
        _used(bench, supply, strain[rows], task.force[rows], task.scheme)
        for rows in _blocks(len(task))
    ]
    largest, state, fed, own, share = (np.concatenate(x) for x in zip(*parts, strict=True))
    content = np.where(fed, bench.counts * bench.content(own * supply, strain, task.fluid), 0.0)
    return Cases(task, bench.length, largest, state, share * supply, content)


def _used(
    bench: "Bench", supply: float, strain: Points, demanded: Points, scheme: AbstractScheme
) -> tuple[np.ndarray, ...]:
    """The largest force at each strain [N], the state used, which units it feeds, their pressures
    over the supply's and the throttled one's [-].
    """
    eps, units = np.minimum(strain, LARGEST_STRAIN), len(bench.counts)
    table = bench.table(supply, eps)
    sets, owner = states_of(scheme, units).sets(most=MOST_SETS)
    low, high = sets.edges(*table)
    largest = _bounded(high.max(axis=0), strain)
    covers = (low - MET <= demanded) & (demanded <= high + MET)
    met = np.any(covers, axis=0) & (largest - demanded >= -MET)
    cost = np.arange(sets.size, dtype=float)[:, None]  # the lowest state
    if not sets.nested:
        taken = np.maximum(
            bench.counts * bench.content(np.zeros((len(eps), units)), eps, "liquid"), 0.0
        )
        cost = sets.fed.astype(float) @ taken.T
    taken_set = np.where(met, np.argmin(np.where(covers, cost, np.inf), axis=0), sets.size - 1)
    held, throttled = sets.full[taken_set], sets.throttled[taken_set]
    fed = held | throttled
    if sets.independent:
        share, own = _shares(bench, table, held, throttled, demanded)
    else:
        force = sets.sums(*table)[taken_set, :, np.arange(len(strain))]
        share = _first_level(force, demanded, bench.level)
        own = np.where(throttled, share[:, None], held)
    # what isn't reached is as near as can be with all that it feeds at full supply
    own = np.where(met[:, None], own, fed)
    return largest, owner[taken_set], fed, own, np.where(met, share, 1.0)


def _shares(
    bench: "Bench",
    table: tuple[np.ndarray, ...],
    held: np.ndarray,
    fed: np.ndarray,
    demanded: Points,
) -> tuple[Points, Float[np.ndarray, "point unit"]]:
    """The last fed unit's level [-] and all units', as `bundle.free` has them."""
    each, none, full = table
    base = np.where(held, full, none).sum(axis=1)
    more = (demanded >= base)[:, None]
    place = np.where(more, each.argmax(axis=0), each.argmin(axis=0))
    extreme = np.take_along_axis(each, place[None], axis=0)[0]
    last = fed.shape[1] - 1 - np.argmax(fed[:, ::-1], axis=1)
    throttled = np.arange(fed.shape[1]) == last[:, None]
    others = np.where(held, full, np.where(fed, extreme, none))
    rest = demanded - np.where(throttled, 0.0, others).sum(axis=1)
    share = _first_level(each[:, np.arange(len(last)), last].T, rest, bench.level)
    own = np.where(held, 1.0, np.where(fed, bench.level[place], 0.0))
    return share, np.where(throttled, share[:, None], own)


@dataclass(frozen=True, eq=False)
class Bench:
    """A design whose forces are looked at: its unlike `muscles`, which of them is each unit's
    (`which`), the units' `counts`, and the throttled pressures over the supply's, `level` [-].
    Pressures beyond what a muscle's tuning was measured at are tried without a word.
    """

    muscles: tuple[Muscle, ...]
    which: Int[np.ndarray, " unit"]
    counts: Int[np.ndarray, " unit"]
    level: Float[np.ndarray, " level"]

    @classmethod
    def of(cls, designs: Designs, place: int) -> "Bench":
        """The bench of a design; `designs` [-], `place` among them [-]."""
        counts = designs.counts[place][designs.counts[place] > 0]
        if designs.alike[place]:
            same = np.zeros(len(counts), int)
            return cls((designs.muscle(place),), same, counts, SHARED.level)
        muscles = tuple(designs.muscle(place, unit) for unit in range(len(counts)))
        return cls(muscles, np.arange(len(counts)), counts, UNLIKE.level)

    @property
    def length(self) -> float:
        """Length at rest [m]."""
        return float(self.muscles[0].length)

    def units(self, supply: float, strain: Points) -> Float[np.ndarray, "level point unit"]:
        """Force of a muscle of every unit [N] at each level.

        **Arguments:**

        - `supply`: its pressure [Pa].
        - `strain`: contractions [-], none above 0.6.

        **Returns:** forces [N].
        """
        pressure = np.minimum(self.level * supply, supply)[:, None]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            each = [m.force(pressure, strain) for m in self.muscles]
        return np.stack(each, axis=-1)[..., self.which]

    def contracts(self, supply: float) -> float:
        """The largest free strain of its muscles [-] at the `supply` [Pa]."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            return max(float(m.free_strain(supply)) for m in self.muscles)

    @property
    def measured(self) -> float:
        """The pressure that all its muscles' tuning was measured up to [Pa]; infinite without."""
        rows = [np.asarray(m.tuning.pressures) for m in self.muscles if m.tuning.pressures.size > 1]
        return min((float(row.max()) for row in rows), default=np.inf)

    def table(self, supply: float, strain: Points) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Force of each unit, its muscles together, as a bundle's states add them up.

        **Arguments:**

        - `supply`: its pressure [Pa].
        - `strain`: contractions [-], none above 0.6.

        **Returns:** forces [N], with level, point and unit axes; at no and at full pressure.
        """
        each = self.counts * self.units(supply, strain)
        return each, each[0], each[-1]

    def largest(self, supply: float, strain: Points, scheme: AbstractScheme) -> Points:
        """Largest force that any state gives [N].

        **Arguments:**

        - `supply`: its pressure [Pa].
        - `strain`: contractions [-], any number, and of any size.
        - `scheme`: of recruitment [-].

        **Returns:** forces [N]; none that pulls, where the laws don't reach so far.
        """
        reached, states = np.minimum(strain, LARGEST_STRAIN), states_of(scheme, len(self.counts))
        if states.apart or len(self.muscles) == 1:
            none = np.zeros(strain.shape)
            demand = Demand(none, reached, none, np.float64(supply), scheme, by_stroke=False)
            table = tabulated(self._rows, demand, (), self.level).take(self.which)
            return _bounded(np.max(highest(Unlike(self.counts), table, states), axis=0), strain)
        parts = [
            states.edges(*self.table(supply, reached[rows]))[1].max(axis=0)
            for rows in _blocks(len(strain))
        ]
        return _bounded(np.concatenate(parts), strain)

    @property
    def _rows(self) -> Rows:
        sizes = ((m.length, m.outer_radius, m.wall_thickness, m.braid_angle) for m in self.muscles)
        return Rows(self.muscles[0], *np.array(list(sizes), float).T)

    def content(
        self, pressure: Float[np.ndarray, "point unit"], strain: Points, fluid: str
    ) -> Float[np.ndarray, "point unit"]:
        """What a muscle of each unit holds beyond what it does at rest, vented [m³], (G3).

        **Arguments:**

        - `pressure`: in each unit [Pa].
        - `strain`: contractions [-].
        - `fluid`: "air" or "liquid" [-].

        **Returns:** of air the normal volume [m³], of liquid the volume [m³].
        """
        asked = np.append(np.minimum(strain, LARGEST_STRAIN), 0.0)
        volumes = np.stack([m.volume(asked) for m in self.muscles], axis=-1)
        now, rest = volumes[:-1, self.which], volumes[-1, self.which]
        if fluid == "liquid":
            return now - rest
        return ((pressure + ATMOSPHERE) * now - ATMOSPHERE * rest) / ATMOSPHERE


def _bounded(largest: Points, strain: Points) -> Points:
    """Beyond what the laws know nothing pulls."""
    return np.where(strain > LARGEST_STRAIN, np.minimum(largest, -2 * MET), largest)


def _first_level(
    force: Float[np.ndarray, "point level"], demanded: Points, level: Float[np.ndarray, " level"]
) -> Points:
    """The lowest level [-] at which a force is the demanded one, linear between two."""
    over = force - demanded[:, None]
    # from below or from above: a state that resists may fall before it rises
    crosses = (over[:, :-1] * over[:, 1:] <= 0) & (over[:, 1:] != over[:, :-1])
    first = np.argmax(crosses, axis=1)
    every = np.arange(len(force))
    before, after = over[every, first], over[every, first + 1]
    drop = np.where(after == before, 1.0, after - before)
    share = np.clip(-before / drop, 0.0, 1.0)
    found = level[first] + share * (level[first + 1] - level[first])
    # within the tolerance of a state's end, and so at it
    return np.where(np.any(crosses, axis=1), found, 1.0)


def _blocks(count: int) -> list[slice]:
    return [slice(start, start + _BLOCK) for start in range(0, count, _BLOCK)]
