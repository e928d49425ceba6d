"""Answer to a search: the recommended design in detail, or what keeps every design from the task.

**Levers.** If no design holds the task, one quantity of the nearest is changed at a time: the
supply's pressure, the number of muscles in the last motor unit, the radius of all muscles with
their walls in proportion, the braid angle and, where the task asks for a stroke, the muscles'
length. A design *holds* if it reaches the task and keeps all limits in the demanded share of random
draws; without scatter, as drawn. The smallest change that holds is searched on a grid from the
present value to the end of the range, then between the last that doesn't hold and the first that
does.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..core.findings import Finding, Severity
from ..core.validation import HIGHEST_PRESSURE
from ..muscle.validation import LENGTH_TOLERANCE
from .cycle import CycleRun, run_cycle
from .designs import Designs
from .evaluation import evaluate
from .exhaustive_search import SearchResult, staged_probabilities
from .objectives import SHARES, Limit, Limits, other_limits, reaches_task, within_limits
from .scatter import Spread, Uncertainty, spread
from .space import Product
from .summary import Splits, Summary, best_splits, summarize
from .task import Task


_LONGEST, _WIDEST = 10.0, 0.25  # m; some three times what has been built
_MOST_MUSCLES = 1000  # of a bundle, some ten times what has been built
_STEEPEST = np.radians(15.0)  # of a braid; a smaller angle isn't woven
_GRID = 33  # values from the present one to the end of the range
_PRECISION = 1e-6  # of a pressure or a size: finer than any gauge
_LESS_PRESSURE = 50e3  # Pa, by which a supply may sag
_FAR = 0.005  # of the length: a load that goes so far beyond its place is worth a word
_COARSE = 1e-3  # the same in random draws, whose share is known within 0.5 %


@dataclass(frozen=True)
class Remedy:
    """Change of one quantity for a design to hold its task.

    `what`: "supply_pressure" [Pa], "muscles", "radius" [m], "braid_angle" [rad] or "length" [m];
    `now`: its present value; `value`: the sufficient one, `None` if there is none; `most`: the end
    of the range that was tried; `reaches`: true if a value in the range reaches the task at least
    as drawn.
    """

    what: str
    now: float
    value: float | None
    most: float
    reaches: bool = True


def remedies(
    design: Designs,
    task: Task,
    limits: Limits,
    product: Product | None = None,
    uncertainty: Uncertainty | None = None,
) -> list[Remedy]:
    """Changes by which a single design would hold its task, each by itself, enough or not.

    `product`: that its muscles are sold as, if they are: only number, pressure and length can be
    changed then; `uncertainty`: by which it is judged; `None`: as drawn.
    """
    design = design.take(np.array([0]), int(design.units[0]))
    highest = HIGHEST_PRESSURE
    if product is not None and product.largest_pressure is not None:
        highest = min(highest, product.largest_pressure)
    # of each quantity the present value and the end of the range
    ranges = {
        "supply_pressure": (task.supply_pressure, highest),
        "muscles": (float(design.counts.sum()), float(_MOST_MUSCLES)),
    }
    if product is None:
        ranges["radius"] = float(design.radius.max()), _WIDEST
        ranges["braid_angle"] = float(design.angle.max()), float(_STEEPEST)
    if task.stroke is not None:
        ranges["length"] = float(design.length[0]), _LONGEST
    return [
        _smallest_change(design, task, what, *ends, limits, uncertainty)
        for what, ends in ranges.items()
    ]


def _apply_change(
    design: Designs, task: Task, what: str, present: float, value: float
) -> tuple[Designs, Task]:
    """The design and its task with a `value` [SI] of `what` for the `present` one; more muscles
    join the last unit, sizes are scaled.
    """
    if what == "supply_pressure":
        return design, replace(task, supply_pressure=value)
    if what == "muscles":
        counts = design.counts.copy()
        counts[0, -1] += round(value - present)
        return replace(design, counts=counts), task
    names = {"length": ["length"], "radius": ["radius", "wall"], "braid_angle": ["angle"]}[what]
    sizes = {name: getattr(design, name) * (value / present) for name in names}
    return replace(design, **sizes), task


def _smallest_change(
    design: Designs,
    task: Task,
    what: str,
    present: float,
    end: float,
    limits: Limits,
    uncertainty: Uncertainty | None,
) -> Remedy:
    """Remedy with the smallest change that holds, on a grid from the present value or between."""
    whole = what == "muscles"
    limits = {name: limit for name, limit in limits.items() if not (whole and name == "valves")}

    def holds(value: float) -> bool:
        changed = _apply_change(design, task, what, present, value)
        as_drawn = bool(within_limits(evaluate(*changed, limits), limits)[0])
        if not as_drawn or uncertainty is None:
            return as_drawn
        scatter, muscles = uncertainty.scatter, uncertainty.muscles

        def judge(_: np.ndarray, draws: int) -> Spread:
            return spread(*changed, (), limits, scatter, muscles, draws)

        probability, _ = staged_probabilities(np.zeros(1, int), uncertainty, judge)
        return bool(probability[0] >= uncertainty.share)

    spaced = np.linspace if what in ("supply_pressure", "braid_angle") else np.geomspace
    # a braid gets steeper, all else larger: a present value past the end is no way out
    outward = end <= present if what == "braid_angle" else end >= present
    grid = spaced(present, end, _GRID) if outward else np.array([present])
    grid = np.unique(grid.round()) if whole else grid
    first = next((i for i, value in enumerate(grid) if holds(float(value))), None)
    if first is None:
        changes = (_apply_change(design, task, what, present, float(value)) for value in grid)
        reaches = any(reaches_task(evaluate(*x, SHARES), limits)[0] for x in changes)
        return Remedy(what, present, None, float(grid[-1]), reaches)
    low, high = float(grid[max(first - 1, 0)]), float(grid[first])
    precision = 1.0 if whole else high * (_PRECISION if uncertainty is None else _COARSE)
    while abs(high - low) > precision:
        middle = 0.5 * (low + high)
        middle = float(np.floor(middle)) if whole else middle
        low, high = (low, middle) if holds(middle) else (middle, high)
    return Remedy(what, present, high, float(grid[-1]))


@dataclass(frozen=True, eq=False)
class Answer:
    """Answer to a search: `index` of the recommended recorded design, or the nearest, and its
    `summary`; its muscles in other numbers of motor units, `splits`; `changes` with which the
    nearest would hold the task; the `run` over time of the recommended one, if valves are sized and
    JAX is installed: one that fails its cycle isn't recommended; `robustness`: the least relative
    margin [-] of "weaker" muscles by 10 %, "supply" pressure 0.5 bar lower, and "failure" of one
    muscle; `findings`, errors first.
    """

    result: SearchResult
    index: int
    summary: Summary
    splits: Splits | None
    changes: list[Remedy]
    run: CycleRun | None
    robustness: dict[str, float]
    findings: list[Finding]

    @property
    def is_recommended(self) -> bool:
        """True if there is a recommended design."""
        return self.result.best is not None


def answer_search(result: SearchResult) -> Answer:
    """Answer to a search that evaluated at least one design."""
    index = result.nearest if result.best is None else result.best
    assert index is not None
    design, run, task = result.all_designs(np.array([index])), None, result.task
    summary = summarize(design, 0, task, result.catalog, result.cycle)
    changes: list[Remedy] = []
    if result.best is None and (result.safety is not None or not result.reaches_task[index]):
        judged = result.safety and result.safety.uncertainty
        changes = remedies(design, task, result.limits, summary.product, judged)
    sizing = summary.sizing if result.best is not None else None
    if sizing and sizing.feasible and (case := sizing.run_case) is not None:
        stroke = float(task.stroke_of(summary.cases.length)[case])
        try:
            run = run_cycle(design.bundle(0, task), float(task.force[case]), stroke, sizing)
        except ModuleNotFoundError as error:
            if (error.name or "").partition(".")[0] not in ("jax", "equinox", "diffrax"):
                raise
    findings = _findings(result, summary, run) + extrapolations(result, index)
    if findings[:1] and findings[0].severity is Severity.ERROR:
        result = replace(result, nearest=index)
    return Answer(
        *(result, index, summary, best_splits(result, index), changes, run),
        _robustness(design, task),
        findings,
    )


def _robustness(design: Designs, task: Task) -> dict[str, float]:
    """Least relative margin [-] of a design where something is worse, by name."""
    variants = {"weaker": (design, task, 0.9)}
    if task.supply_pressure > _LESS_PRESSURE:
        lower = replace(task, supply_pressure=task.supply_pressure - _LESS_PRESSURE)
        variants["supply"] = (design, lower, 1.0)
    if design.counts.sum() > 1:
        counts = design.counts.copy()
        counts[0, np.argmax(counts[0])] -= 1  # of the largest unit
        order = np.argsort(counts[0] == 0, kind="stable")  # zeros last
        sizes = {n: getattr(design, n)[:, order] for n in ("radius", "wall", "angle")}
        variants["failure"] = (replace(design, counts=counts[:, order], **sizes), task, 1.0)
    name = "relative_margin"
    return {
        key: float(evaluate(variant, changed, [name], force_factor=factor)[name][0])
        for key, (variant, changed, factor) in variants.items()
    }


def _findings(result: SearchResult, summary: Summary, run: CycleRun | None) -> list[Finding]:
    """Findings on a search and its best, or nearest, recorded design, errors first."""
    findings, safety, reaches = [], result.safety, result.reaches_task

    def add(code: str, severity: Severity, **data: object) -> None:
        findings.append(Finding(f"design.{code}", severity, data))

    error, warning, note = Severity.ERROR, Severity.WARNING, Severity.NOTE
    if result.best is None and safety is not None:
        share, demanded = safety.probability, safety.uncertainty.share
        add("unsafe", error, share=share, demanded=demanded, allowed=int(result.allowed.sum()))
    elif result.best is None:
        add(
            "limits_broken" if reaches.any() else "out_of_reach", error, reaching=int(reaches.sum())
        )
    sizing = summary.sizing if result.best is not None else None
    if sizing is not None and not sizing.feasible:
        add("no_valve", error, hose_length=sizing.cycle.hose_length)
    if run is not None and sizing is not None and not run.passes(sizing.cycle):
        times = {"lifted": run.lifted, "released": run.released, "overshoot": run.overshoot}
        add("cycle_failed", error, **times)
    for name, limit in other_limits(result.limits).items():
        values = result.values[name][reaches]
        costs = int(np.sum(~limit.holds(values)))
        if costs and result.judged <= len(reaches):
            ends = {"least": float(values.min()), "most": float(values.max())}
            add("limit_costs", note, objective=name, costs=costs, reaching=len(values), **ends)
    findings += result.catalog.excluded(result.space.drawings, result.task).values()
    if result.best is None:
        return findings
    margin = summary.relative_margin
    if not Limit(least=result.least_margin).holds(margin):
        add("small_margin", warning, margin=margin, least=result.least_margin)
    if safety is not None and not safety.complete:
        add("judged_in_part", note, judged=safety.judged)
    travel = summary.held_open - summary.cases.task.stroke_of(summary.cases.length)
    if np.nanmax(travel, initial=0.0) > _FAR * summary.cases.length:
        case = int(np.nanargmax(travel))
        add("held_open", note, case=case, position=float(summary.held_open[case]))
    return findings


def extrapolations(result: SearchResult, index: int) -> list[Finding]:
    """Findings on the recorded design with an `index` beyond what was measured of its muscle."""
    design, task = result.all_designs(np.array([index])), result.task
    name, length = list(design.drawings)[design.kind[0]], float(design.length[0])
    findings, fitted = list[Finding](), design.drawings[name].fitted_length
    if (of_measured := result.catalog.extrapolations.get(name)) is not None:
        findings += of_measured(task.supply_pressure, float(task.strain_of(length).max()))
    if fitted is not None and abs(length / fitted.length - 1) > LENGTH_TOLERANCE:
        data = {"muscle": name, "value": length, "measured": fitted.length}
        findings.append(Finding("muscle.length_extrapolated", Severity.WARNING, data))
    return findings
