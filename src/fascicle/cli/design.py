"""Commands that look for a bundle for a task: `design`, and `sweep` on many workers."""

import json
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import fascicle as fs

from .. import files
from ..core.errors import require
from ..io import atomic
from ..io.sanitize import dump_json
from ..units import parse
from . import options
from .errors import INCOMPLETE, UserError, user_errors
from .inputs import load_laws, read_bundle
from .options import Text, argument, flag, option
from .outputs import (
    PICTURES,
    SOURCE,
    check_file,
    print_if_lost,
    replace_output,
    result_folder,
    today,
    write_picture,
)
from .terminal import print_line, print_table, status


if TYPE_CHECKING:
    from ..core.findings import Finding
    from ..files.task import TaskFile

_PRINTED = 8  # designs of the front in the table; the report has more
_SAVED = 30  # designs of the front as files: more would be hard to choose from
_CASES = 10  # load cases in the table, those with the least to spare; the report has more


def design(
    task: str = argument(
        "TASK.toml",
        "Task file: demands, buildable sizes, objectives; `fascicle init --task` writes one. Or a"
        " muscle, with --units, --mass and --stroke.",
    ),
    units: options.Units = None,
    mass: Text = option("Mass that a muscle's --units lift: 25kg.", "MASS"),
    stroke: Text = option("Stroke that they lift it by: 40mm.", "LENGTH"),
    supply: Text = option("Supply pressure of a muscle's --units; default: 4bar.", "PRESSURE"),
    out: options.OutFolder = None,
    also: Text = option("Objectives to record, too: reversal_depth,largest_force.", "LIST"),
    generations: int | None = option(
        "Generations of an NSGA-II search of continuous sizes (needs pymoo), in place of all"
        " designs.",
        min=1,
        max=100_000,
    ),
    population: int = option("Number of designs in a generation.", default=100, min=4, max=10_000),
    seed: options.Seed = 0,
    plot: Text = option("The recommendation on one page: .pdf, .svg or .png.", "PATH"),
    overwrite: options.Overwrite = False,
    as_json: options.Json = False,
) -> int:
    """Recommend a safe bundle for a task, and alternatives.

    Exit code 3 if no design is safe at every load case: then you get the nearest design, its
    misses and the changes that would make it safe.
    """
    folder = result_folder(out, f"designed-{Path(task).stem}", as_json, overwrite)
    if plot is not None:
        check_file("--plot", plot, overwrite, PICTURES)
    if generations is not None:
        require("pymoo")
    load_laws()
    with user_errors():
        file = _read_task(task, units, mass, stroke, supply)
    problem = (file.space, file.task, file.senses, file.limits)
    common: dict[str, Any] = {
        "extra": () if also is None else tuple(name.strip() for name in also.split(",")),
        "catalog": file.catalog,
        "least_margin": file.least_margin,
    }
    begin = time.perf_counter()
    with status(f"evaluating {len(file.space)} designs") as update, user_errors():
        if generations is None:
            common["progress"] = lambda done, count: update(f"{done} of {count} designs")
            result = fs.design.search(*problem, **common)
        else:
            common["watch"] = lambda done: update(f"{done} of {generations} generations")
            result = fs.design.evolve(*problem, population, generations, seed, **common)
        answer = _judge(result, file, update)
    seconds = time.perf_counter() - begin
    from ..report import words

    notes = words.notes(file.findings)

    def show() -> None:
        if as_json:
            print(_json(answer, notes, file.findings))
        else:
            _print_answer(answer, notes)

    names: list[str] = []
    if folder is not None:
        with print_if_lost(show), status("drawing the report"):
            names = _write(answer, notes, seconds, folder, overwrite)
    if plot is not None:
        from ..report.design import sheet

        write_picture("--plot", plot, overwrite, sheet(answer, today(), notes))
    show()
    if folder is not None and not as_json:
        print_line(f"wrote {folder / names[0]} with all details and {len(names) - 1} more files")
    return 0 if answer.is_recommended else INCOMPLETE


def _read_task(
    target: str, units: str | None, mass: str | None, stroke: str | None, supply: str | None
) -> "TaskFile":
    """Task in a file; or that of a muscle's `units` that lift a `mass` by a `stroke`."""
    from ..files.task import load_task, loads_task

    if units is mass is stroke is supply is None:
        return load_task(target)
    if units is None or mass is None or stroke is None:
        raise UserError("design of a muscle needs --units, --mass and --stroke together.")
    split = "+".join(str(unit.count) for unit in read_bundle(target, units).motor_units)
    lines = [
        "format = 1\n[task]",
        f'force = "{parse(mass, "mass", "--mass")!r} kgf"',
        f'stroke = "{parse(stroke, "length", "--stroke")!r} m"',
        f'supply_pressure = "{parse(supply or "4bar", "pressure", "--supply")!r} Pa"',
        f'[design]\nmuscle = {json.dumps(target)}\nsplits = ["{split}"]',
    ]
    return loads_task("\n".join(lines), target)


def _judge(
    result: "fs.design.SearchResult", file: "TaskFile", update: Callable[[str], None]
) -> "fs.design.Answer":
    """Answer to a search, judged in draws; `update`: is told what is being done."""
    if file.uncertainty is not None:
        update("judging designs in draws of scatter")
        result = fs.design.judge_safety(result, file.uncertainty)
    # each change is judged in draws, too, for up to a minute or two
    recommended = "looking at the recommended design"
    update("looking for changes to the nearest design" if result.best is None else recommended)
    return fs.design.answer_search(replace(result, cycle=file.cycle))


def _print_answer(answer: "fs.design.Answer", notes: list[str]) -> None:
    """Print what is recommended, or what is missing."""
    from ..report import design_summary as text

    findings = text.further_findings(answer)
    lines = [*text.headline(answer)]
    lines += [f"{x.severity.name.lower()}: {text.words(x, answer)}" for x in findings]
    lines += text.remedy_lines(answer)
    lines += [f"part: {part}" for part in text.parts(answer)]
    if answer.is_recommended:
        lines += [f"{name}: {fact}" for name, fact in text.facts(answer).items()]
    for line in [*lines, *(f"note: {note}" for note in notes)]:
        print_line(line)
    cases, front = text.cases_table(answer.summary, _CASES), text.front_table(answer, _PRINTED)
    tables = [cases, front]
    if answer.is_recommended:
        tables = [text.offers_table(answer), cases, text.splits_table(answer), front]
    for table in tables:
        if table is not None:
            print_table(*table)


def _write(
    answer: "fs.design.Answer",
    notes: list[str],
    seconds: float,
    folder: Path,
    overwrite: bool,
) -> list[str]:
    """Write report, data and bundles; returns their names, the report's first."""
    from ..report.design import report
    from ..results.labelled import dataset, write_netcdf

    result = answer.result
    count = min(len(result.front), _SAVED)
    bundles = {f"bundle_{i + 1}.toml": result.designs.bundle(i, result.task) for i in range(count)}
    data: dict[str, Any] = {"designs.nc": fs.tables.all_design_variables(result)}
    if result.recommended is not None:
        bundle = result.designs.bundle(result.recommended, result.task)
        bundles = {"recommended.toml": bundle, **bundles}
        cases = fs.tables.case_variables(answer.summary)
        data["front.nc"] = fs.tables.front_variables(result) | cases
    page = report(answer, today(), [*data, *bundles], seconds, notes)
    texts = {"report.html": page, **{name: files.dumps(bundle) for name, bundle in bundles.items()}}
    attributes = {"title": f"Designs for {result.task.name}", "source": SOURCE}
    attributes |= {"notes": " ".join(notes)} if notes else {}

    def fill(draft: Path) -> None:
        for name, text in texts.items():
            (draft / name).write_text(text, encoding="utf-8")
        for name, variables in data.items():
            write_netcdf(dataset(variables, **attributes), draft / name)

    with user_errors("--out "):
        atomic.write_folder(folder, fill, overwrite)
    return ["report.html", *data, *bundles]


def _json(answer: "fs.design.Answer", notes: list[str], findings: "list[Finding]") -> str:
    """JSON of the front and the recommended design, or of the nearest design."""
    import numpy as np

    from ..core.findings import Severity
    from ..design.answer import extrapolations
    from ..report.design_summary import assumptions, words
    from ..results.labelled import to_json

    result, summary, is_recommended = answer.result, answer.summary, answer.is_recommended
    warnings = [f for f in answer.findings if f.severity is Severity.WARNING]
    keeps = all(finding.code != "design.limits_broken" for finding in answer.findings)
    first = [] if is_recommended else [words(answer.findings[0], answer)]
    data: dict[str, Any] = {
        "reached": bool(summary.cases.reached.all()),
        "limits_kept": is_recommended or keeps,
        "notes": [*notes, *first],
        "least_margin": result.least_margin,
        "warnings": [words(finding, answer) for finding in warnings],
        "findings": [finding.to_json() for finding in [*answer.findings, *findings]],
        "robustness": answer.robustness,
        "extrapolations": [
            [finding.to_json() for finding in extrapolations(result, int(index))]
            for index in result.front
        ],
        "pressures": summary.cases.pressures.tolist(),
        "offers": result.offers,
    }
    if (safety := result.safety) is not None:
        data["safety"] = {
            "holds": safety.holds,
            "probability": safety.probability,
            "least_probability": safety.uncertainty.share,
            "draws": safety.uncertainty.draws,
            "judged": safety.judged,
            "model_error": float(safety.uncertainty.scatter.model_error),
            "model_error_basis": safety.uncertainty.basis,
            "assumptions": assumptions(safety.uncertainty),
        }
    if (sizing := summary.sizing) is not None:
        run = answer.run
        data["cycle"] = {
            "case": sizing.case + 1,
            "conductance": sizing.conductance.tolist(),
            "b": sizing.cycle.b,
            "hose_bore": sizing.bore,
            "fill": sizing.fill,
            "vent": sizing.vent,
            "valves": [valve and valve.name for valve in sizing.valves],
            "normal_flow": summary.flow,
            "supply_power": summary.supply_power,
            "run": run and run._asdict() | {"passes": run.passes(sizing.cycle)},
        }
    if is_recommended:
        variables = fs.tables.front_variables(result) | fs.tables.case_variables(summary)
        return dump_json(data | json.loads(to_json(variables)))
    design = result.all_designs(np.array([answer.index]))
    nearest = fs.tables.design_variables(design) | fs.tables.case_variables(summary)
    data |= {"recommended": None, "nearest": json.loads(to_json(nearest))}
    data["would_reach"] = [
        {"change": x.what, "now": x.now, "value": x.value, "looked_up_to": x.most}
        for x in answer.changes
    ]
    return dump_json(data)


def sweep(
    study: str = argument(
        "STUDY.toml", "Task file as for `fascicle design`; its [sweep] sets the designs per block."
    ),
    out: options.OutFolder = None,
    resume: bool = flag("Continuation of the interrupted study in FOLDER.", "--resume"),
    scheduler: Text = option("Address (tcp://…) of a Dask scheduler that sees FOLDER.", "ADDRESS"),
    workers: int | None = option(
        "Worker processes on this machine, 0 for none; default: one per core.", min=0, max=4096
    ),
    overwrite: options.Overwrite = False,
) -> int:
    """Evaluate every design of a task on many workers; can resume."""
    if scheduler is not None and workers is not None:
        raise UserError("--scheduler and --workers: a scheduler has its own workers, drop one.")
    for library in ["zarr"] if workers == 0 else ["zarr", "distributed", "cryptography"]:
        require(library)
    load_laws()
    from ..design import sweep as sweeps
    from ..design.exhaustive_search import conclude
    from ..design.objectives import recorded_objectives, with_reach_limits
    from ..files.task import load_task
    from ..results.labelled import write

    folder = Path(f"swept-{Path(study).stem}" if out is None else out)
    with user_errors(), status("reading the task"):  # before a cluster is started
        task = load_task(study)
        names = recorded_objectives(task.senses, with_reach_limits(task.limits))
        designs = sweeps.Study(task.space, task.task, names, task.block)
    with user_errors("" if scheduler is None else "--scheduler "):
        if scheduler is not None:  # before a folder is made
            sweeps.check_scheduler(scheduler)
    with user_errors("--out "):
        path, front = sweeps.open_folder(folder, designs, resume), folder / "front.nc"
        check_file("--out", front, overwrite or resume)
    hint = f"the finished blocks are in {folder}: continue with --resume."
    try:
        start = status("starting the workers")
        with start as update, sweeps.open_client(scheduler, workers) as client:

            def watch(done: int, blocks: int) -> None:
                update(f"blocks: {done} of {blocks}")
                if 10 * done // blocks > 10 * (done - 1) // blocks and not sys.stderr.isatty():
                    sys.stderr.write(f"{done} of {blocks} blocks\n")

            values = sweeps.sweep(designs, path, client, watch)
    except KeyboardInterrupt:
        print_line(f"interrupted; {hint}", error=True)
        raise
    except ConnectionError as error:
        raise UserError(f"no workers: {error}; {hint}", code=1) from None
    except OSError as error:
        name, reason = error.filename or folder, error.strerror or error
        raise UserError(f"{name}: {reason}; remove the cause; {hint}") from None
    with status("looking for the front") as update, user_errors():
        problem = (task.space, task.task, task.senses, task.limits)
        result = conclude(*problem, values, (), task.catalog, task.least_margin)
        answer = _judge(result, task, update)
        variables = fs.tables.front_variables(answer.result) | fs.tables.case_variables(
            answer.summary
        )
        with replace_output("", front, overwrite or resume) as draft:
            write(variables, draft, title=f"Front of designs for {task.task.name}", source=SOURCE)
    print_line(f"wrote {len(task.space)} designs in {designs.blocks} blocks: {path}")
    from ..report.words import notes

    _print_answer(answer, notes(task.findings))
    return 0 if answer.is_recommended else INCOMPLETE


COMMANDS = {"design": design, "sweep": sweep}
