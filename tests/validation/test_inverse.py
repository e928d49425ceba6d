"""The inverse against dense sampling of the bundle's force: aimed demands, none missed or wrong.

Half of the demands lie beside an extremum or a kink of a state's force over pressure, where a
search on a grid misses what lies between two nodes. Only `Bundle.force` is asked here.
"""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

import fascicle as fs
from fascicle.bundle.recruitment import pressures_of, recruit


SUPPLY_LEVELS = np.unique(np.concatenate([np.linspace(0, 1, 1201), np.linspace(0, 1, 601) ** 3]))
CLOSE = 1e-6  # N, and of the force: forces that a sampled root gives
TENSION = ("klute_hannaford", "klute_hannaford", "kothera2009", "meller2014", "tondu_lopez")
COLLAPSE = ("kim2021", "wood1958", "brazier1927", "stein_hedgepeth1961")
pytestmark = [
    pytest.mark.filterwarnings("ignore:the tuning was measured up to"),
    pytest.mark.filterwarnings("ignore:fluid is counted in the braid"),
]


def muscle(random: np.random.Generator, length: float, **laws: str) -> fs.Muscle:
    """A muscle of random sizes and laws; a third of them are tuned."""
    radius = random.uniform(4e-3, 14e-3)
    tuning = None
    if random.random() < 0.3:
        table = np.sort(random.uniform(20e3, 420e3, 3))
        tuning = fs.Tuning(
            table, random.uniform(0.01, 0.06, 3) * table * 3e-5, random.uniform(0.7, 1.3, 3),
            dead_band=random.choice([0.0, 8e3]), collapse_moment_factor=random.uniform(0.6, 1.2),
        )  # fmt: skip
    chosen = {
        "tension": str(random.choice(TENSION)), "collapse": str(random.choice(COLLAPSE)), **laws
    }  # fmt: skip
    material = str(random.choice(["latex", "silicone_kim2021"]))
    return fs.Muscle(
        length, radius, radius * random.uniform(0.12, 0.3), math.radians(random.uniform(22, 43)),
        material, tuning=tuning, transition_rate=random.uniform(5, 150), **chosen,
    )  # fmt: skip


def bundle(random: np.random.Generator, units: int | None = None, **laws: str) -> fs.Bundle:
    """A bundle of up to three unlike units, a third of them with plates of their own distance."""
    units = units or int(random.integers(1, 4))
    length = random.uniform(0.12, 0.3)
    own = random.random() < 0.3
    lengths = length * (random.uniform(0.99, 1.01, units) if own else np.ones(units))
    members = [fs.MotorUnit(muscle(random, L, **laws), int(random.integers(1, 5))) for L in lengths]
    return fs.Bundle(members, random.uniform(2e5, 9e5), length=length if own else None)


class Sampled:
    """A state's force [N] over the level of its throttled pressure at a strain, with its extrema
    and kinks zoomed in on.
    """

    def __init__(self, made, strain, state, scheme, resistance):
        def force(level):
            P = pressures_of(
                state, np.asarray(level) * made.supply_pressure, made.supply_pressure,
                len(made.motor_units), scheme,
            )  # fmt: skip
            return made.force(P, strain, resistance)

        self.force, self.state = force, state
        level = SUPPLY_LEVELS
        aims = []
        for _ in range(9):  # four more points in each cell beside a bend, again and again
            values = np.asarray(force(level))
            slope = np.diff(values) / np.diff(level)
            bend = np.abs(np.diff(slope)) * np.minimum(np.diff(level)[1:], np.diff(level)[:-1])
            size = 1e-12 * (1 + np.abs(values).max())
            sharp = 1 + np.argsort(bend)[::-1][:40]
            turns = 1 + np.flatnonzero(slope[1:] * slope[:-1] < 0)
            some = np.union1d(sharp[bend[sharp - 1] > size], turns)
            cells = np.unique(np.concatenate([some - 1, some]).astype(int))
            more = np.linspace(level[cells], level[cells + 1], 6)[1:-1].ravel()
            level = np.unique(np.concatenate([level, more]))
        values = np.asarray(force(level))
        turns = 1 + np.flatnonzero(np.diff(values)[1:] * np.diff(values)[:-1] < 0)
        for i in turns[:: max(1, len(turns) // 8)]:
            sense = 1.0 if values[i] < values[i - 1] else -1.0
            best = minimize_scalar(
                lambda u, sense=sense: sense * float(force(u)),
                bounds=(level[i - 1], level[i + 1]), method="bounded", options={"xatol": 1e-13},
            )  # fmt: skip
            level, aims = np.append(level, best.x), [*aims, float(force(best.x))]
        self.level = np.unique(level)
        self.values = np.asarray(force(self.level))
        slope = np.abs(np.diff(np.diff(self.values) / np.diff(self.level)))
        kinks = self.values[1:-1][np.argsort(slope)[::-1][:20]]
        self.aims = np.concatenate([aims, kinks, self.values[[0, -1]]])

    def roots(self, target):
        """Cells [-] in which the force crosses a target [N]."""
        over = self.values > target
        return [(self.level[i], self.level[i + 1]) for i in np.flatnonzero(over[1:] != over[:-1])]

    def jumps(self, low, high, target):
        """Whether the force only jumps past the target [N] there."""
        ends = [float(self.force(u)) - target for u in (low, high)]
        if ends[0] * ends[1] >= 0:
            return False
        root = brentq(lambda u: float(self.force(u)) - target, low, high, xtol=1e-16, rtol=1e-15)
        return abs(float(self.force(root)) - target) > CLOSE * (1 + abs(target))


def aimed(random, curves, count):
    """Demands [N], half of them beside extrema and kinks, the others anywhere and out of reach."""
    values = np.concatenate([curve.values for curve in curves])
    span = np.ptp(values) + 1e-3
    beside = random.choice(np.concatenate([curve.aims for curve in curves]), count)
    beside += random.choice([-1, 1], count) * span * 10 ** random.uniform(-7, -1.5, count)
    anywhere = random.uniform(values.min() - 0.05 * span, values.max() + 0.05 * span, count)
    return np.where(np.arange(count) % 2, beside, anywhere)


def check(random, made, scheme, resistance, strain, count):
    """How many demands were compared; each fault fails."""
    states = range(1, len(made.motor_units) + 1)
    curves = [Sampled(made, strain, state, scheme, resistance) for state in states]
    demand = aimed(random, curves, count)
    options = {}
    if random.random() < 0.4:
        present = made.supply_pressure * random.random((count, len(made.motor_units)))
        options = {"prefer": "nearest", "present": present}
    found = recruit(made, demand, strain, scheme=scheme, resistance=resistance, **options)
    forward = made.force(found.pressures, strain, resistance)
    np.testing.assert_allclose(found.force, forward, rtol=1e-9, atol=1e-7)
    samples = np.concatenate([curve.values for curve in curves])
    for i, target in enumerate(demand):
        told = (made, scheme, resistance, strain, target)
        small = CLOSE * (1 + abs(target))
        pressure, state = (x[i][: found.count[i]] for x in found.solutions[:2])
        reached = found.status[i] == 0
        assert reached == (found.count[i] > 0), told
        assert not reached or abs(found.force[i] - target) < small, told
        assert abs(found.force[i] - target) <= np.abs(samples - target).min() + small, told
        for k, P in zip(state, pressure, strict=True):
            level = P / made.supply_pressure
            assert abs(float(curves[k - 1].force(level)) - target) < small, told
        for curve in curves:
            own = pressure[state == curve.state] / made.supply_pressure
            for low, high in curve.roots(target):
                if np.any((own >= low - 1e-9) & (own <= high + 1e-9)):
                    continue
                ends = [float(curve.force(u)) for u in (low, high)]
                if min(abs(x - target) for x in ends) < 1e-9 * (1 + abs(target)):
                    continue  # it only touches, to rounding
                assert curve.jumps(low, high, target), (*told, curve.state, low, high)
        if options and reached:
            every = np.stack([
                pressures_of(int(k), P, made.supply_pressure, len(made.motor_units), scheme)
                for k, P in zip(state, pressure, strict=True)
            ])  # fmt: skip
            away = np.linalg.norm(every - present[i], axis=1).min()
            chosen = np.linalg.norm(found.pressures[i] - present[i])
            assert chosen <= away * (1 + 1e-9) + 1e-3, told
    return count


@pytest.mark.parametrize(
    ("seed", "trials", "count"), [(0, 5, 120), pytest.param(1, 120, 200, marks=pytest.mark.slow)]
)
def test_no_aimed_demand_is_missed_or_wrong(seed, trials, count):
    random, total = np.random.default_rng(seed), 0
    for _ in range(trials):
        scheme = str(random.choice(["orderly", "batch"]))
        resistance = bool(random.random() < 0.8)
        total += check(
            random, bundle(random), scheme, resistance, random.uniform(0.0, 0.35), count
        )  # fmt: skip
    assert total >= trials * count


def test_forces_beside_the_least_are_reached():
    """Collapse makes a kink there, between two nodes of any fixed grid of pressures."""
    one = fs.Muscle(
        0.2396, 17.85e-3, 2.465e-3, math.radians(40.58), "latex",
        tension="kothera2009", collapse="brazier1927",
    )  # fmt: skip
    made, strain = fs.Bundle([fs.MotorUnit(one)], 932e3, length=0.2365), 0.2396
    curve = Sampled(made, strain, 1, "orderly", True)
    least = curve.values.min()
    demand = least + np.ptp(curve.values) * np.geomspace(1e-9, 1e-1, 400)
    found = recruit(made, demand, strain)
    assert np.all(found.status == 0)
    assert np.abs(made.force(found.pressures, strain) - demand).max() < CLOSE
    assert abs(recruit(made, least - 1.0, strain).force - least) < CLOSE * (1 + abs(least))


@pytest.mark.parametrize(
    ("seed", "trials", "count"), [(2, 3, 60), pytest.param(3, 40, 100, marks=pytest.mark.slow)]
)
def test_free_recruitment_reaches_what_units_can(seed, trials, count):
    random = np.random.default_rng(seed)
    for _ in range(trials):
        made, strain = bundle(random, units=3), random.uniform(0.0, 0.3)
        alone = [
            Sampled(
                fs.Bundle([unit], made.supply_pressure, length=made.length), strain, 1, "orderly",
                True,
            ).values
            for unit in made.motor_units
        ]  # fmt: skip
        least, most = (sum(pick(x) for x in alone) for pick in (np.min, np.max))
        span = most - least
        inside = np.concatenate([
            random.uniform(least, most, count), least + span * np.geomspace(1e-7, 1e-2, count)
        ])  # fmt: skip
        demand = np.concatenate([inside, [least - 0.1 * span, most + 0.1 * span]])
        found = recruit(made, demand, strain, scheme="free")
        forward = made.force(found.pressures, strain)
        small = CLOSE * (1 + abs(most))
        np.testing.assert_allclose(found.force, forward, rtol=1e-9, atol=1e-7)
        jump = max(max(abs(b - a) for a, b in pairwise(x)) for x in alone)
        reached = found.status[:-2] == 0
        # a force of one unit that jumps may leave a gap in what all together give
        assert np.all(reached) or jump > 0.02 * span, (made, strain)
        assert np.abs(found.force[:-2] - inside)[reached].max() < small
        assert found.status[-2:].tolist() == [2, 1]
        assert abs(found.force[-2] - least) < small and abs(found.force[-1] - most) < small
