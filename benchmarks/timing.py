"""Times of warm calls, taken in turns, and the rows of the table that they become.

A machine that is shared is slower in some minutes than in others. So calls that are compared
take turns, A B A B ..., and what is told is the ratio of their medians; its spread is the
quartiles of the ratios within each round. Nothing is timed that hasn't been compiled and run
once before, and a short call runs once more right before it is timed: after a call that had one
thread only, a virtual machine may keep the next call's threads on one of its processors for some
15 ms. Each call must return only when its result is there.

A benchmark is a module with a docstring that says what is counted, `rows(small)`, and
`run(rows, __doc__)` at its end, so that it can be run alone:

    python benchmarks/force_field.py --small
"""

import argparse
import gc
import json
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

import numpy as np


FEWEST, PATIENCE = 3, 2.0  # rounds over budget, and by how much
SHORT = 0.15  # s; to a longer call it makes no difference how its first 15 ms went

Call = Callable[[], object]


@dataclass(frozen=True)
class Measured:
    """A median and the quartiles beside it."""

    value: float
    low: float
    high: float

    @classmethod
    def of(cls, values: Iterable[float]) -> "Measured":
        low, value, high = np.percentile(list(values), [25, 50, 75])
        return cls(float(value), float(low), float(high))


@dataclass(frozen=True)
class Row:
    """One line of the table: what was asked, what came out, and what was hoped for."""

    question: str
    figure: Measured | None  # None where it couldn't be measured, and `limit` says why
    unit: str  # "×" where the figure is a ratio
    floor: str = ""  # what it is a ratio to
    reach: float | None = None
    side: Literal["≥", "≤"] = "≥"
    limit: str = ""  # from measured figures alone; empty where unknown

    @property
    def shortfall(self) -> float | None:
        """The factor by which the reach is missed, below 1 where it is met."""
        if self.figure is None or self.reach is None:
            return None
        ratio = self.reach / self.figure.value
        return ratio if self.side == "≥" else 1 / ratio

    @property
    def met(self) -> bool | None:
        return None if self.shortfall is None else self.shortfall <= 1

    def cells(self) -> list[str]:
        """Its cells in the table."""
        measured = "–"
        if self.figure is not None:
            one = self.figure
            middle, low, high = (short(x) for x in (one.value, one.low, one.high))
            measured = f"{middle} {self.unit} ({low} to {high})"
        reach = "" if self.reach is None else f"{self.side} {self.reach:.3g} {self.unit}"
        met = {True: "yes", False: "no", None: ""}[self.met]
        return [self.question, self.floor, measured, reach, met, self.limit]


@dataclass(frozen=True)
class Times:
    """Seconds that each call took, round by round."""

    seconds: Mapping[str, np.ndarray]

    def median(self, name: str) -> float:
        return float(np.median(self.seconds[name]))

    def each(self, name: str, scale: float = 1.0) -> Measured:
        """Time of one call, in units of which a second has `scale`."""
        return Measured.of(scale * self.seconds[name])

    def ratio(self, over: str, under: str, factor: float = 1.0) -> Measured:
        """`factor` times the median of `over` through that of `under`."""
        rounds = Measured.of(factor * self.seconds[over] / self.seconds[under])
        value = factor * self.median(over) / self.median(under)
        return Measured(value, min(rounds.low, value), max(rounds.high, value))


def interleaved(
    calls: Mapping[str, Call], repeats: int = 15, budget: float = 20.0, least: float = 0.0
) -> Times:
    """Times of `calls` that take turns, `repeats` rounds or as many as `budget` [s] allows.

    A call shorter than `least` [s] is made several times in a row, and the mean is kept.
    """
    loops, quick = {}, set()
    for name, call in calls.items():
        call()  # compiles
        start = time.perf_counter()
        call()
        alone = time.perf_counter() - start
        loops[name] = max(1, round(least / alone))
        if alone < SHORT:
            quick.add(name)
    taken: dict[str, list[float]] = {name: [] for name in calls}
    begun = time.perf_counter()
    gc.collect()
    gc.disable()
    try:
        for turn in range(repeats):
            spent = time.perf_counter() - begun
            if spent > budget and (turn >= FEWEST or spent > PATIENCE * budget):
                break
            for name, call in calls.items():
                if name in quick:
                    call()
                start = time.perf_counter()
                for _ in range(loops[name]):
                    call()
                taken[name].append((time.perf_counter() - start) / loops[name])
    finally:
        gc.enable()
    return Times({name: np.array(values) for name, values in taken.items()})


def table(rows: Iterable[Row]) -> str:
    """Rows as a Markdown table."""
    heads = ["question", "floor", "measured (quartiles)", "reach", "met?", "what limits it"]
    lines = [heads, ["---"] * len(heads), *(row.cells() for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def options(about: str | None) -> argparse.Namespace:
    """What every benchmark understands on its command line."""
    parser = argparse.ArgumentParser(
        description=about, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--small", action="store_true", help="does it run? its times mean nothing")
    parser.add_argument("--json", type=Path, default=None, help="file for the rows")
    return parser.parse_args()


def run(rows: Callable[[bool], list[Row]], about: str | None) -> None:
    """Print a benchmark's rows, and keep them where asked."""
    given = options(about)
    save(rows(given.small), given.json)


def save(rows: list[Row], path: Path | None) -> None:
    print(table(rows))
    if path is not None:
        path.write_text(json.dumps([asdict(row) for row in rows], indent=1) + "\n")


def load(path: Path) -> list[Row]:
    """Rows as `save` has written them."""
    made = []
    for one in json.loads(path.read_text()):
        figure = one.pop("figure")
        made.append(Row(figure=None if figure is None else Measured(**figure), **one))
    return made


def short(value: float) -> str:
    """Three digits, and no exponent where a person would write none."""
    digits = max(0, 2 - int(np.floor(np.log10(abs(value))))) if value else 0
    return f"{value:.{min(digits, 6)}f}"
