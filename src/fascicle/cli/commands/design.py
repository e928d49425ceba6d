"""`fascicle design`: the bundle for a task."""

import datetime as dt
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...core.errors import require
from ...io.sanitize import dump_json
from .. import options
from ..errors import INCOMPLETE, UserError, user_errors
from ..inputs import load_laws
from ..options import argument, option
from ..outputs import SOURCE, print_line, print_table, result_folder, status, write_folder


if TYPE_CHECKING:
    from ...design.exhaustive_search import SearchResult
    from ...reports.design_summary import InfeasibleResult


_PRINTED, _SAVED = 20, 30  # designs of the front that are printed, and that get a file
_CASES = 20  # load cases that are printed


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
        "Further objectives to record, apart from the front's: reversal_depth,largest_force.",
        metavar="LIST",
    ),
    generations: int | None = option(
        "Generations of a search with NSGA-II instead of an evaluation of every design; sizes vary"
        " continuously within the file's bounds (needs pymoo).",
        min=1,
        max=100_000,
    ),
    population: int = option("Designs of a generation.", default=100, min=4, max=10_000),
    seed: int = options.SEED,
    checkpoint: str | None = option(
        "Checkpoint file; the search resumes from it if it exists.", metavar="PATH"
    ),
    overwrite: bool = options.OVERWRITE,
    as_json: bool = options.JSON,
) -> int:
    """Recommend the cheapest bundle for a task, and alternatives.

    Exit code 3 where no design reaches every load case: the nearest design is shown then, with what
    it misses and what would reach it.
    """
    folder = result_folder("design", out, task, as_json, overwrite)
    if generations is not None:
        require("pymoo")
    if checkpoint is not None:
        if generations is None:
            raise UserError("--checkpoint: only a search with --generations has one: drop it.")
        from ...io.atomic import check_writable

        with user_errors("--checkpoint "):
            check_writable(checkpoint)
    load_laws()
    from ...files.task import load_task
    from ...reports.design_summary import summarize_search

    with user_errors():
        file = load_task(task)
    extra = tuple(name.strip() for name in also.split(",")) if also is not None else ()
    begin = time.perf_counter()
    with status(f"evaluating {len(file.space)} designs") as update, user_errors():
        result = _search(file, extra, generations, population, seed, checkpoint, update)
        update("evaluating the best of them")
        scatter = _scatter(result, file.chance)
        seconds = time.perf_counter() - begin
        answered = summarize_search(result)
    paths: list[str] = []
    if folder is not None:
        with status("drawing the report"):
            paths = _write(result, answered, scatter, file.notes, seconds, folder, overwrite)
    if as_json:
        print(_json(result, answered, scatter, file.notes))
        return 0 if result.recommended is not None else INCOMPLETE
    code = print_answer(result, answered, file.notes)
    if scatter is not None and result.recommended is not None:
        share = scatter.probability[result.recommended]
        print(f"with scatter of fabrication, it meets the task with a probability of {share:.2f}")
    if paths:
        shown = paths if len(paths) < 5 else [*paths[:3], f"{len(paths) - 3} files more"]
        print_line(f"wrote {', '.join(shown)}")
    return code


def _search(
    file: Any,
    extra: tuple[str, ...],
    generations: int | None,
    population: int,
    seed: int,
    checkpoint: str | None,
    update: Callable[[str], None],
) -> "SearchResult":
    """Evaluate every design, or search by generations."""
    if generations is None:
        from ...design.exhaustive_search import search

        return search(
            file.space, file.task, file.senses, file.limits, extra,
            lambda done, count: update(f"{done} of {count} designs"), file.catalog,
            file.least_margin,
        )  # fmt: skip
    from ...design.genetic import evolve

    return evolve(
        file.space, file.task, file.senses, file.limits, population, generations, seed,
        checkpoint=None if checkpoint is None else Path(checkpoint), extra=extra,
        watch=lambda done: update(f"{done} of {generations} generations"), catalog=file.catalog,
        least_margin=file.least_margin,
    )  # fmt: skip


def _scatter(result: "SearchResult", chance: Any) -> Any:
    """Scatter of the front's designs, where the task file asks for it."""
    if chance is None or not result.reported.size:
        return None
    from ...design.robust import spread

    return spread(
        result.designs, result.task, tuple(result.values), result.limits, chance.scatter,
        chance.muscles, chance.draws,
    )  # fmt: skip


def print_answer(result: "SearchResult", answered: Any, notes: tuple[str, ...] = ()) -> int:
    """Print the recommended design and the front; or the nearest design.

    **Arguments:**

    - `result`: of a search.
    - `answered`: of the reports' `answer`, a `Summary` or an `InfeasibleResult`.
    - `notes`: on what the search left out.

    **Returns:** the exit code: 0, or `INCOMPLETE`.
    """
    from ...reports.design import compromise
    from ...reports.design_summary import (
        HEADS,
        case_rows,
        composition_text,
        design_facts,
        headline,
        margin_warning,
    )

    for note in notes:
        print_line(f"note: {note}")
    unreached, summary = _parts(answered)
    if unreached is None:
        recommendation, margin, *reasons = headline(result, summary)
        warning = margin_warning(result, summary)
        warnings = [f"warning: {warning}"] if warning else []
        for line in (recommendation, margin, *warnings, *reasons):
            print_line(line)
    rows, caption = case_rows(summary, _CASES)
    print_table(f"Load cases, {composition_text(summary)}", list(HEADS), rows, caption)
    if unreached is not None:
        for line in unreached.lines():  # last, where it is read
            print_line(line)
        return INCOMPLETE
    for name, text in design_facts(result, summary).items():
        print_line(f"{name}: {text}")
    _print_front(result)
    for line in compromise(result):
        print_line(line)
    return 0


def _parts(answered: Any) -> "tuple[InfeasibleResult | None, Any]":
    """The nearest design where none reaches every load case, and the summary of a design."""
    from ...reports.design_summary import InfeasibleResult

    return (
        (answered, answered.summary) if isinstance(answered, InfeasibleResult) else (None, answered)
    )


def _print_front(result: "SearchResult") -> None:
    """Print the designs of the Pareto front."""
    from ...reports.design_summary import (
        format_objective,
        muscle_sizes,
        objective_label,
        task_requirement,
    )

    kept = ""
    if result.judged == len(result.index):
        reaching, allowed = int(result.reaches_task.sum()), int(result.allowed.sum())
        kept = f" {reaching} {task_requirement(result)}, {allowed} keep all limits too,"
    print(f"{result.judged} designs,{kept} {len(result.front)} on the front")
    marks = {result.compromise: "c", result.recommended: "*"}
    if result.compromise == result.recommended:
        marks[result.recommended] = "* c"
    first = range(min(len(result.front), _PRINTED))
    rows = [
        [
            f"{index + 1} {marks.get(index, '')}".strip(),
            result.designs.labels[index],
            *(format_objective(name, float(result.values[name][result.reported[index]]))
              for name in result.reported_objectives),
            muscle_sizes(result, result.designs, index),
        ]
        for index in sorted({*first, *(int(index) for index in marks if index is not None)})
    ]  # fmt: skip
    heads = ["", "units", *map(objective_label, result.reported_objectives), "muscles"]
    caption = "*: recommended, c: best compromise"
    if result.cheapest not in result.front:
        caption += "; the recommended one isn't on the front"
    if more := len(result.reported) - len(rows):
        caption += f"; {more} more are in the files"
    print_table("Designs on the Pareto front", heads, rows, caption)


def _write(
    result: "SearchResult",
    answered: Any,
    scatter: Any,
    notes: tuple[str, ...],
    seconds: float,
    folder: Path,
    overwrite: bool,
) -> list[str]:
    """Write report, data and bundles; returns the files' paths."""
    from ...files import dumps
    from ...reports.design import report
    from ...results.design_tables import case_variables, every_variables, front_variables
    from ...results.labelled import dataset, write_netcdf

    bundles = {
        f"bundle_{index + 1}.toml": dumps(result.designs.bundle(index, result.task))
        for index in range(min(len(result.reported), _SAVED))
    }
    data: dict[str, Any] = {"designs.nc": every_variables(result)}
    unreached, summary = _parts(answered)
    if unreached is None and result.recommended is not None:
        recommended = dumps(result.designs.bundle(result.recommended, result.task))
        bundles = {"recommended.toml": recommended, **bundles}
        data["front.nc"] = front_variables(result, scatter) | case_variables(summary)
    files = [*data, *bundles]
    today = f"{dt.datetime.now().astimezone():%Y-%m-%d}"
    page = report(result, today, files, seconds, scatter, notes, answered)
    about = {"notes": " ".join(notes)} if notes else {}

    def fill(draft: Path) -> None:
        for name, text in {"report.html": page, **bundles}.items():
            (draft / name).write_text(text, encoding="utf-8")
        for name, variables in data.items():
            title = f"Designs for {result.task.name}"
            write_netcdf(dataset(variables, title=title, source=SOURCE, **about), draft / name)

    write_folder(folder, overwrite, fill)
    return [str(folder / name) for name in ("report.html", *files)]


def _json(result: "SearchResult", answered: Any, scatter: Any, notes: tuple[str, ...]) -> str:
    """JSON of the front and the recommended design, or of the nearest design."""
    from ...reports.design_summary import margin_warning
    from ...results.design_tables import case_variables, design_variables, front_variables
    from ...results.labelled import to_json

    unreached, summary = _parts(answered)
    warning = "" if unreached is not None else margin_warning(result, summary)
    about = {
        "reached": bool(summary.cases.reached.all()),
        "limits_kept": unreached is None or unreached.keeps,
        "notes": [*notes, *([] if unreached is None else [unreached.verdict()])],
        "least_margin": result.least_margin,
        "warnings": [warning] if warning else [],
    }
    if unreached is None:
        variables = front_variables(result, scatter) | case_variables(summary)
        return dump_json(about | json.loads(to_json(variables)))
    nearest = design_variables(unreached.design) | case_variables(summary)
    remedies = [
        {"change": way.what, "now": way.now, "value": way.value, "looked_up_to": way.most,
         "breaks": dict(way.breaks)}
        for way in unreached.changes
    ]  # fmt: skip
    about |= {"recommended": None, "nearest": json.loads(to_json(nearest))}
    return dump_json(about | {"would_reach": remedies, "told": unreached.lines()})
