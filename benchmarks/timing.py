"""Times of calls in turn, and rows of the table of results.

A shared machine is slower in some minutes than in others. So calls that are compared take turns,
A B A B …, after a first call that compiles. A ratio is that of their medians; its quartiles are
those of the ratios within each round. A call returns only when its result is there.

A benchmark is a module with a docstring, a function `rows(small)`, and `run(rows, __doc__)` at
its end, so that it runs alone:

    python benchmarks/bundles.py --small
"""

import argparse
import json
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np


FEWEST = 3  # rounds, also over budget
SHORT = 0.15  # s; of a longer call the first 15 ms, see `take_turns`, make no difference

Call = Callable[[], object]


@dataclass(frozen=True)
class Quartiles:
    """Median and quartiles of a quantity."""

    median: float
    low: float
    high: float

    @classmethod
    def of(cls, values: Iterable[float]) -> "Quartiles":
        low, median, high = np.percentile(list(values), [25, 50, 75])
        return cls(float(median), float(low), float(high))


@dataclass(frozen=True)
class Row:
    """One line of the table: a quantity, what it is compared with, its value, and its goal."""

    name: str
    figure: Quartiles | None  # None if it was not measured, and `note` says why
    unit: str  # "×" if the figure is a ratio
    floor: str = ""  # what it is a ratio to, or the time that no call can beat
    at_least: float | None = None
    at_most: float | None = None
    note: str = ""

    @property
    def shortfall(self) -> float | None:
        """The factor by which the goal is missed, at most 1 if it is met."""
        if self.figure is None:
            return None
        if self.at_least is not None:
            return self.at_least / self.figure.median
        return None if self.at_most is None else self.figure.median / self.at_most

    @property
    def met(self) -> bool | None:
        """True if the goal is met; `None` without a goal."""
        return None if self.shortfall is None else self.shortfall <= 1

    def cells(self) -> list[str]:
        """Cells of the table."""
        measured = goal = ""
        if self.figure is not None:
            median, low, high = map(three_digits, asdict(self.figure).values())
            measured = f"{median} {self.unit} ({low} to {high})"
        for sign, bound in (("≥", self.at_least), ("≤", self.at_most)):
            if bound is not None:
                goal = f"{sign} {f'{bound:,.3f}'.rstrip('0').rstrip('.')} {self.unit}"
        met = {True: "yes", False: "no", None: ""}[self.met]
        return [self.name, self.floor, measured, goal, met, self.note]


@dataclass(frozen=True)
class Times:
    """Seconds of each call, round by round."""

    seconds: Mapping[str, np.ndarray]

    def median(self, name: str) -> float:
        """Median [s] of a call."""
        return float(np.median(self.seconds[name]))

    def of(self, name: str, per_second: float = 1.0) -> Quartiles:
        """Time of a call, in a unit of which a second has `per_second`."""
        return Quartiles.of(per_second * self.seconds[name])

    def rate(self, name: str, count: float) -> Quartiles:
        """Items a second of a call that handles `count` of them."""
        return Quartiles.of(count / self.seconds[name])

    def ratio(self, over: str, under: str, factor: float = 1.0) -> Quartiles:
        """`factor` times the time of `over` divided by that of `under`."""
        rounds = Quartiles.of(factor * self.seconds[over] / self.seconds[under])
        median = factor * self.median(over) / self.median(under)
        return Quartiles(median, min(rounds.low, median), max(rounds.high, median))

    def difference(self, longer: str, shorter: str) -> Quartiles:
        """Seconds by which one call takes longer than another."""
        rounds = Quartiles.of(self.seconds[longer] - self.seconds[shorter])
        median = self.median(longer) - self.median(shorter)
        return Quartiles(median, min(rounds.low, median), max(rounds.high, median))


def take_turns(
    calls: Mapping[str, Call], rounds: int = 15, budget: float = 20.0, loops: int = 1,
    clock: Callable[[], float] = time.perf_counter,
) -> Times:  # fmt: skip
    """Times of calls in turn, mean of `loops` of them, for `rounds` or as many as `budget` [s] has.

    A short call is made once more right before it is timed: after a call with one thread a virtual
    machine may keep the threads of the next on one of its processors for some 15 ms.
    """
    for call in calls.values():
        call()  # compiles
    seconds: dict[str, list[float]] = {name: [] for name in calls}
    start = time.perf_counter()
    for index in range(rounds):
        if index >= FEWEST and time.perf_counter() - start > budget:
            break
        for name, call in calls.items():
            if not seconds[name] or seconds[name][-1] < SHORT:
                call()
            begin = clock()
            for _ in range(loops):
                call()
            seconds[name].append((clock() - begin) / loops)
    return Times({name: np.array(values) for name, values in seconds.items()})


def table(rows: Iterable[Row]) -> str:
    """Measured rows as a Markdown table, and a sentence with the others."""
    rows = list(rows)
    heads = ["measurement", "floor", "median (quartiles)", "goal", "met", "note"]
    lines = [heads, ["---"] * len(heads), *(row.cells() for row in rows if row.figure)]
    text = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    missing = [f"{row.name} ({row.note})" for row in rows if row.figure is None]
    return text + (f"\n\nNot measured: {'; '.join(missing)}." if missing else "")


def three_digits(value: float) -> str:
    """Number with three digits, without an exponent."""
    digits = max(0, 2 - int(np.floor(np.log10(abs(value))))) if value else 0
    return f"{value:,.{min(digits, 6)}f}"


def parse_options(description: str | None, modules: Sequence[str] = ()) -> argparse.Namespace:
    """Options of a benchmark's command line, or of one that runs `modules`."""
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--small", action="store_true", help="does it run? its times mean nothing")
    parser.add_argument("--json", type=Path, default=None, help="file for the rows")
    if modules:
        parser.add_argument("--only", choices=modules, nargs="+", help="these benchmarks")
    return parser.parse_args()


def run(rows: Callable[[bool], list[Row]], description: str | None) -> None:
    """Print the rows of a benchmark, and write them to the file of `--json`."""
    options = parse_options(description)
    measured = rows(options.small)
    print(table(measured))
    if options.json is not None:
        options.json.write_text(json.dumps([asdict(row) for row in measured], indent=1) + "\n")


def load_rows(path: Path) -> list[Row]:
    """Rows from a file of `--json`."""
    rows = []
    for row in json.loads(path.read_text()):
        figure = row.pop("figure")
        rows.append(Row(figure=None if figure is None else Quartiles(**figure), **row))
    return rows
