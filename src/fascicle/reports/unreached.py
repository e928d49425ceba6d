"""Where no design does the task: which comes nearest, what it misses, and what would reach it."""

import math

import numpy as np

from ..design.exhaustive_search import SearchResult
from ..design.objectives import allowed_miss_fraction, other_limits
from ..design.remedies import Remedy, remedies
from ..design.summary import Summary, summarize_result
from ..units import DIMENSIONS, pretty
from .engineering import called, demand, shown, sizes, words


_DIMENSIONS = {"supply_pressure": "pressure", "radius": "length", "length": "length"}


class Unreached:
    """What is told of a search that found no design: the `summary` of the nearest and what would
    make it reach the task, `ways`, none where it does.
    """

    def __init__(self, found: SearchResult):
        """**Arguments:** `found`: by a search that judged at least one design [-]."""
        assert found.nearest is not None
        self.found, self.place = found, found.nearest
        self.summary: Summary = summarize_result(found, found.nearest)
        self.design = found.all_designs(np.array([found.nearest]))
        self.reaches = bool(found.reaches_task[found.nearest])
        self.ways: list[Remedy] = []
        if not self.reaches:
            share = allowed_miss_fraction(found.limits)
            self.ways = remedies(
                self.design, 0, found.task, share, found.limits, self.summary.product
            )

    @property
    def keeps(self) -> bool:
        """Whether the nearest keeps all other limits [-]."""
        return not self._broken_limits()

    def lines(self) -> list[str]:
        """All of it in sentences [-]."""
        told = [self.verdict(), *self.left(), self.nearest()]
        if self.ways:
            told += ["What would reach it, each by itself:", *self.remedies()]
        return told

    def verdict(self) -> str:
        """That there is none, in a sentence."""
        found, all_kept = self.found, self.found.judged == len(self.found.index)
        reach = int(found.reaches_task.sum())
        if reach and all_kept:
            return (
                f"{reach} of {found.judged} designs {demand(found)}, but none of them keeps all"
                " other limits: none is recommended."
            )
        rest = "" if all_kept or not other_limits(found.limits) else " within the other limits"
        return (
            f"No design is recommended: none of the {found.judged} that were judged can"
            f" {demand(found)}{rest}."
        )

    def left(self) -> list[str]:
        """Which limit leaves how many designs, in sentences [-]."""
        return [*nothing_left(self.found), *(f"{name}: {why}." for name, why in self._barred())]

    def nearest(self) -> str:
        """Which design comes nearest, and by how much it misses what, in a sentence."""
        cases, broken = self.summary.cases, self._broken_limits()
        which = f"{called(self.summary)}, {sizes(self.found, self.design, 0)}"
        rest = f" It breaks other limits: {', '.join(broken)}." if broken else ""
        if self.reaches:
            return f"One that reaches all: {which}.{rest}"
        i, missed = cases.worst, int(np.sum(~cases.reached))
        asked, gives = float(cases.task.force[i]), float(cases.largest[i])
        share = f" ({-100 * float(cases.relative[i]):.3g} %)" if asked > 0 else ""
        strain = 100 * cases.task.strain_of(cases.length)[i]
        does = f"gives {pretty(gives, 'force')}" if gives > 0 else "only pushes"
        return (
            f"The nearest is {which}. It misses {missed} of {len(cases.task)} load cases, worst"
            f" case {i + 1} by {pretty(-float(cases.spare[i]), 'force')}{share}:"
            f" {pretty(asked, 'force')} at {strain:.3g} % contraction, where it {does}.{rest}"
        )

    def remedies(self) -> list[str]:
        """What would reach the task, a sentence for each change [-]."""
        told = [self._remedy(one) for one in self.ways]
        if any(self._too_far(one) for one in self.ways) and self.found.task.stroke is None:
            told.append(
                "A braid with a smaller angle contracts further; a stroke in mm, stroke instead of"
                " strain, asks less of longer muscles."
            )
        return told

    def _broken_limits(self) -> list[str]:
        values, place = self.found.values, self.place
        return [
            f"{words(name)} {shown(name, float(values[name][place]))}"
            for name, limit in other_limits(self.found.limits).items()
            if not limit.holds(values[name][place])
        ]

    def _barred(self) -> list[tuple[str, str]]:
        return [
            (f"{name} may not be used", why) for name, why in self.found.excluded_products.items()
        ]

    def _too_far(self, one: Remedy) -> bool:
        strain = self._strain(one)
        return one.value is None and one.largest <= 0 and strain > one.free_strain

    def _strain(self, one: Remedy) -> float:
        length = one.most if one.what == "length" else self.summary.cases.length
        return float(self.found.task.strain_of(length)[one.worst])

    def _remedy(self, one: Remedy) -> str:
        what = words(one.what)
        if one.value is not None:
            return f"{what}: {self._change(one)}{self._broken(one)}."
        top = f"{one.most:.0f}" if one.what == "muscles" else _up(one.most, _DIMENSIONS[one.what])
        none = "no number" if one.what == "muscles" else "none"
        if self._too_far(one):
            at = f"at {top}" if one.what == "supply_pressure" else "at this pressure"
            upto = f" up to {top}" if one.what == "length" else ""
            return (
                f"{what}: {none}{upto} does: {at} these muscles contract by"
                f" {100 * one.free_strain:.3g} % at most, case {one.worst + 1} asks for"
                f" {100 * self._strain(one):.3g} %."
            )
        return (
            f"{what}: {none} up to {top} does: there case {one.worst + 1} still misses"
            f" {pretty(one.short, 'force')}."
        )

    def _change(self, one: Remedy) -> str:
        assert one.value is not None
        if one.what == "muscles":
            *held, last = [int(n) for n in self.design.counts[0] if n]
            units = "+".join(str(n) for n in [*held, last + round(one.value - one.now)])
            return f"{one.value:.0f} of this size instead of {one.now:.0f} ({units})"
        kind = _DIMENSIONS[one.what]
        text = f"{_up(one.value, kind)} instead of {pretty(one.now, kind)}"
        if one.what == "supply_pressure" and one.value > one.measured:
            text += f", beyond the {pretty(one.measured, kind)} that the tuning was measured up to"
        return f"{text}, walls in proportion" if one.what == "radius" else text

    def _broken(self, one: Remedy) -> str:
        told = []
        for name, value in one.breaks:
            limit = self.found.limits[name]
            end = limit.most if value > limit.most else limit.least
            told.append(f"{words(name)} {shown(name, value)}, limited to {shown(name, end)}")
        return f"; it breaks a limit then: {', '.join(told)}" if told else ""


def answer(found: SearchResult) -> Summary | Unreached:
    """The recommended design, summarized, or what is told where there is none; `found` [-]."""
    return Unreached(found) if found.cheapest is None else summarize_result(found, found.cheapest)


def nothing_left(found: SearchResult) -> list[str]:
    """Which other limit leaves how many designs, where none keeps all; `found` [-]."""
    lines = []
    for name, limit in other_limits(found.limits).items():
        values = found.values[name]
        kept = int(np.sum(limit.holds(values)))
        if kept == len(values) or found.judged > len(found.index):
            continue
        lines.append(
            f"{words(name)}: {kept} of {len(values)} designs keep its limit; they lie between"
            f" {shown(name, float(values.min()))} and {shown(name, float(values.max()))}."
        )
    return lines


def _up(value: float, dimension: str) -> str:
    """A value that is enough [SI] for a reader: four figures, none of them rounded down."""
    kind = DIMENSIONS[dimension]
    size = float(kind.factors[kind.shown])
    places = 3 - math.floor(math.log10(value / size))
    # what is a round number already must not become the next one
    figure = math.ceil(value / size * 10.0**places * (1 - 1e-12)) / 10.0**places
    return pretty(figure * size, dimension, 4)
