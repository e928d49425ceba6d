"""`fascicle design`: the bundle for a task."""

import json
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...core.errors import require
from ...io.sanitize import dump_json
from .. import options
from ..errors import INCOMPLETE, user_errors
from ..inputs import load_laws
from ..options import argument, option
from ..outputs import SOURCE, print_line, print_table, result_folder, status, today, write_folder


if TYPE_CHECKING:
    from ...design.exhaustive_search import SearchResult
    from ...files.task import TaskFile
    from ...report.design_summary import InfeasibleResult


_PRINTED = 8  # designs of the front in the table; the report has more
_SAVED = 30  # designs of the front as files: more would be hard to choose from
_CASES = 10  # load cases in the table, those with the least to spare; the report has more


def run(
    task: str = argument(
        "TASK.toml",
        "Task file: demands, buildable sizes, objectives; `fascicle init --task` writes one.",
    ),
    out: str | None = option(
        "Folder of report, data and bundles; default: designed-TASK, none with --json.",
        "--out -o",
        metavar="FOLDER",
    ),
    also: str | None = option(
        "Objectives to record as well, such as reversal_depth,largest_force.",
        metavar="LIST",
    ),
    generations: int | None = option(
        "Generations of an NSGA-II search with continuous sizes, in place of an evaluation of every"
        " design (needs pymoo).",
        min=1,
        max=100_000,
    ),
    population: int = option("Number of designs in a generation.", default=100, min=4, max=10_000),
    seed: int = options.SEED,
    overwrite: bool = options.OVERWRITE,
    as_json: bool = options.JSON,
) -> int:
    """Recommend the cheapest bundle for a task, and alternatives.

    Exit code 3 if no design reaches every load case: then you get the nearest design, its misses
    and the changes that would reach the task.
    """
    folder = result_folder(out, f"designed-{Path(task).stem}", as_json, overwrite)
    if generations is not None:
        require("pymoo")
    load_laws()
    from ...files.task import load_task

    with user_errors():
        file = load_task(task)
    problem = (file.space, file.task, file.senses, file.limits)
    extra = tuple(name.strip() for name in also.split(",")) if also is not None else ()
    begin = time.perf_counter()
    with status(f"evaluating {len(file.space)} designs") as update, user_errors():
        if generations is None:
            from ...design.exhaustive_search import search

            result = search(
                *problem, extra, lambda done, count: update(f"{done} of {count} designs"),
                file.catalog, file.least_margin,
            )  # fmt: skip
        else:
            from ...design.genetic import evolve

            result = evolve(
                *problem, population, generations, seed,
                extra=extra,
                watch=lambda done: update(f"{done} of {generations} generations"),
                catalog=file.catalog, least_margin=file.least_margin,
            )  # fmt: skip
        result, answer = judge_result(result, file, update)
    seconds = time.perf_counter() - begin
    paths: list[str] = []
    if folder is not None:
        with status("drawing the report"):
            paths = _write(result, answer, file.notes, seconds, folder, overwrite)
    if as_json:
        print(_json(result, answer, file.notes))
        return 0 if result.recommended is not None else INCOMPLETE
    code = print_answer(result, answer, file.notes)
    if paths:
        page, *data_files = paths
        print_line(f"wrote {page} with all details and {len(data_files)} more files")
    return code


def judge_result(
    result: "SearchResult", file: "TaskFile", update: Callable[[str], None]
) -> tuple["SearchResult", Any]:
    """Result of a search with its safety, and its `Summary` or `InfeasibleResult`.

    `file`: of the task; `update`: is told what is being done.
    """
    from ...design.exhaustive_search import judge_safety
    from ...report.design_summary import InfeasibleResult, run_cycle_of, summarize_search

    if file.uncertainty is not None:
        update("judging designs in draws of scatter")
        result = judge_safety(result, file.uncertainty)
    result = replace(result, cycle=file.cycle)
    answer = summarize_search(result)
    if not isinstance(answer, InfeasibleResult) and file.cycle is not None:
        update("running the recommended design in time")
        answer = run_cycle_of(result, answer)
    return result, answer


def print_answer(result: "SearchResult", answer: Any, notes: tuple[str, ...] = ()) -> int:
    """Print the recommended design, its load cases and the front; or the nearest design.

    **Arguments:**

    - `result`: of a search.
    - `answer`: its `Summary` or `InfeasibleResult`, by `summarize_search`.
    - `notes`: on omitted products and fit errors.

    **Returns:** the exit code: 0, or `INCOMPLETE`.
    """
    from ...report import design_summary

    infeasible, summary = _unpack_answer(answer)
    is_feasible = infeasible is None
    lines = design_summary.summary_lines(result, summary) if is_feasible else infeasible.lines()
    for line in [*lines, *(f"note: {note}" for note in notes)]:
        print_line(line)
    rows, caption = design_summary.case_rows(summary, _CASES)
    title = f"Load cases, {design_summary.composition_text(summary)}"
    print_table(title, list(design_summary.HEADS), rows, caption)
    if result.front.size:
        _print_front(result)
    return 0 if is_feasible else INCOMPLETE


def _unpack_answer(answer: Any) -> "tuple[InfeasibleResult | None, Any]":
    """The `InfeasibleResult` of an answer of `summarize_search`, or `None`, and its `Summary`."""
    from ...report.design_summary import InfeasibleResult

    is_infeasible = isinstance(answer, InfeasibleResult)
    return (answer, answer.summary) if is_infeasible else (None, answer)


def _print_front(result: "SearchResult") -> None:
    """Print the designs of the Pareto front."""
    from ...report import design_summary

    values, reported = result.values, result.front
    counts = ""
    if result.judged == len(result.index):
        reaching, allowed = int(result.reaches_task.sum()), int(result.allowed.sum())
        requirement = design_summary.task_requirement(result)
        counts = f" {reaching} {requirement}, {allowed} also keep all limits,"
    marks = {result.compromise: "c", result.recommended: "*"}
    if result.compromise == result.recommended:
        marks[result.recommended] = "* c"
    indices = {*range(min(len(result.front), _PRINTED)), *(i for i in marks if i is not None)}
    rows = [
        [
            f"{index + 1} {marks.get(index, '')}".strip(),
            result.designs.labels[index],
            *(design_summary.format_objective(name, float(values[name][reported[index]]))
              for name in result.reported_objectives),
            *design_summary.low_margin(result, index),
            design_summary.muscle_sizes(result, result.designs, index),
        ]
        for index in sorted(map(int, indices))
    ]  # fmt: skip
    objectives = list(map(design_summary.objective_head, result.reported_objectives))
    objectives += design_summary.low_margin_heads(result)
    safe = " of those that are safe" if result.safety and result.safety.holds else ""
    caption = f"{result.judged} designs,{counts} {len(result.front)} on the front{safe}"
    caption += "; *: recommended, c: best compromise" if result.cheapest is not None else ""
    if result.safety is not None:
        caption += f"; percentiles of the first {result.safety.spread.met.shape[1]} draws"
    if omitted := len(result.front) - len(rows):
        caption += f"; {omitted} more are in the files"
    heads = ["design", "muscles by unit", *objectives, "sizes"]
    print_table("Pareto front, and the recommended design", heads, rows, caption)


def _write(
    result: "SearchResult",
    answer: Any,
    notes: tuple[str, ...],
    seconds: float,
    folder: Path,
    overwrite: bool,
) -> list[str]:
    """Write report, data and bundles; returns their paths, the report's first. `answer`: by
    `summarize_search`.
    """
    from ...files import dumps
    from ...report.design import report
    from ...results import design_tables
    from ...results.labelled import dataset, write_netcdf

    bundles = {
        f"bundle_{index + 1}.toml": dumps(result.designs.bundle(index, result.task))
        for index in range(min(len(result.front), _SAVED))
    }
    data: dict[str, Any] = {"designs.nc": design_tables.all_design_variables(result)}
    infeasible, summary = _unpack_answer(answer)
    if infeasible is None and result.recommended is not None:
        recommended = dumps(result.designs.bundle(result.recommended, result.task))
        bundles = {"recommended.toml": recommended, **bundles}
        data["front.nc"] = design_tables.front_variables(result) | design_tables.case_variables(
            summary
        )
    files = [*data, *bundles]
    page = report(result, today(), files, seconds, notes, answer)
    attributes = {"title": f"Designs for {result.task.name}", "source": SOURCE}
    attributes |= {"notes": " ".join(notes)} if notes else {}

    def fill(draft: Path) -> None:
        for name, text in {"report.html": page, **bundles}.items():
            (draft / name).write_text(text, encoding="utf-8")
        for name, variables in data.items():
            write_netcdf(dataset(variables, **attributes), draft / name)

    write_folder(folder, overwrite, fill)
    return [str(folder / name) for name in ("report.html", *files)]


def _json(result: "SearchResult", answer: Any, notes: tuple[str, ...]) -> str:
    """JSON of the front and the recommended design, or of the nearest design."""
    from ...report.design_summary import design_warnings
    from ...results.design_tables import case_variables, design_variables, front_variables
    from ...results.labelled import to_json

    infeasible, summary = _unpack_answer(answer)
    warnings = [] if infeasible is not None else design_warnings(result, summary)
    data = {
        "reached": bool(summary.cases.reached.all()),
        "limits_kept": infeasible is None or infeasible.keeps,
        "notes": [*notes, *([] if infeasible is None else [infeasible.verdict()])],
        "least_margin": result.least_margin,
        "warnings": warnings,
    }
    if (safety := result.safety) is not None:
        data["safety"] = {
            "holds": safety.holds, "probability": safety.probability,
            "least_probability": safety.uncertainty.share, "draws": safety.uncertainty.draws,
            "judged": safety.judged, "assumptions": safety.uncertainty.assumptions,
        }  # fmt: skip
    if (sizing := summary.sizing) is not None:
        data["cycle"] = {
            "case": sizing.case + 1, "conductance": sizing.conductance.tolist(),
            "b": sizing.cycle.b, "hose_bore": sizing.bore, "fill": sizing.fill,
            "vent": sizing.vent, "valves": [valve and valve.name for valve in sizing.valves],
            "normal_flow": summary.flow, "supply_power": summary.supply_power, "run": summary.run,
        }  # fmt: skip
    if infeasible is None:
        variables = front_variables(result) | case_variables(summary)
        return dump_json(data | json.loads(to_json(variables)))
    nearest = design_variables(infeasible.design) | case_variables(summary)
    data |= {"recommended": None, "nearest": json.loads(to_json(nearest))}
    data["would_reach"] = [
        {"change": change.what, "now": change.now, "value": change.value,
         "looked_up_to": change.most, "breaks": dict(change.breaks)}
        for change in infeasible.changes
    ]  # fmt: skip
    return dump_json(data | {"told": infeasible.lines()})
