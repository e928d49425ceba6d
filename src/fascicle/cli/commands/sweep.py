"""`fascicle sweep`: a study of many designs on many workers, that can be stopped and resumed."""

import contextlib
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from ...core.errors import require
from .. import options
from ..errors import StoppedError, UserError, user_errors
from ..inputs import load_laws
from ..options import argument, flag, option
from ..outputs import SOURCE, check_file, print_line, replace_output, status
from .design import print_answer


_RESUME = "the finished blocks are in {}: continue with --resume."
_QUEUE = 600.0  # s that a scheduler's workers may take to come; clusters have queues
_FRONT = 5_000_000  # designs: the front of more may not fit into memory


def run(
    study: str = argument(
        "STUDY.toml", "Task file as for `fascicle design`; its [sweep] sets the designs per block."
    ),
    out: str | None = option(
        "Folder of results; default: swept-STUDY.", "--out -o", metavar="FOLDER"
    ),
    resume: bool = flag("Continuation of the interrupted study in FOLDER.", "--resume"),
    scheduler: str | None = option(
        "Address (tcp://…) of a Dask scheduler whose workers see FOLDER under the same path;"
        " default: workers on this machine.",
        metavar="ADDRESS",
    ),
    workers: int | None = option(
        "Worker processes on this machine, 0 for none; default: one per core.", min=0, max=4096
    ),
    overwrite: bool = options.OVERWRITE,
) -> int:
    """Evaluate every design of a task on many workers; can resume."""
    if scheduler is not None and workers is not None:
        raise UserError("--scheduler and --workers: a scheduler has its own workers, drop one.")
    for library in ["zarr"] if workers == 0 else ["zarr", "distributed", "cryptography"]:
        require(library)
    load_laws()
    from ...design.sweep import Store, Study, sweep
    from ...files.task import load_task

    folder = Path(f"swept-{Path(study).stem}" if out is None else out)
    with user_errors(), status("reading the task"):  # before a cluster is started
        task = load_task(study)
        designs = Study.of(task.space, task.task, task.senses, task.limits, block=task.block)
        Store.check(folder, designs, resume)
    if folder.is_dir():
        check_file("--out", folder / "front.nc", overwrite or resume)
    wait = {} if scheduler is None else {"worker_timeout": _QUEUE}
    with (
        _cluster(scheduler, workers) as client, _progress(designs.block) as watch, user_errors(),
        _resumable(folder),
    ):  # fmt: skip
        store = sweep(designs, folder, client, resume, watch, **wait)
    count, code = len(designs.space), 0
    if count > _FRONT:
        print(f"no front: {count} designs are more than {_FRONT}, too many for the memory")
    else:
        with user_errors():
            code = _report_result(store, task, folder / "front.nc", overwrite or resume)
    print_line(f"wrote {count} designs in {designs.blocks} blocks: {folder / 'designs.zarr'}")
    return code


@contextlib.contextmanager
def _resumable(folder: Path) -> Iterator[None]:
    """Context whose interruptions and errors say in one line how to resume the sweep."""
    hint = _RESUME.format(folder)
    try:
        yield
    except KeyboardInterrupt:
        print_line(f"interrupted; {hint}", error=True)
        raise
    except ConnectionError as error:
        raise StoppedError(f"{error}; {hint}") from None
    except OSError as error:
        path = error.filename or folder
        raise UserError(f"{path}: {error.strerror or error}; remove the cause; {hint}") from None


def _report_result(store: Any, task: Any, path: Path, overwrite: bool) -> int:
    """Print and write the recommended design and the front; returns the exit code."""
    import numpy as np

    from ...design.exhaustive_search import conclude, judge_safety
    from ...reports.design_summary import InfeasibleResult, run_cycle_of, summarize_search
    from ...results.design_tables import case_variables, front_variables
    from ...results.labelled import write

    with status("looking for the front"):
        result = conclude(
            task.space, task.task, task.senses, task.limits, np.arange(len(task.space)),
            store.all(), catalog=task.catalog, least_margin=task.least_margin,
        )  # fmt: skip
        if task.uncertainty is not None:
            result = judge_safety(result, task.uncertainty)
        result = replace(result, cycle=task.cycle)
        answer = summarize_search(result)
        if not isinstance(answer, InfeasibleResult):
            answer = run_cycle_of(result, answer)
            variables = front_variables(result) | case_variables(answer)
            attributes = {"title": f"Front of designs for {task.task.name}", "source": SOURCE}
            attributes |= {"notes": " ".join(task.notes)} if task.notes else {}
            with replace_output("", path, overwrite) as draft:
                write(variables, draft, **attributes)
    return print_answer(result, answer, task.notes)


@contextlib.contextmanager
def _cluster(scheduler: str | None, workers: int | None) -> Iterator[Any]:
    """A client of the scheduler, or of workers on this machine; `None` for no cluster."""
    if workers == 0:
        yield None
        return
    from ...design.cluster import local_client, scheduler_client

    with contextlib.ExitStack() as stack:
        try:
            with status("starting the workers"):
                cluster = (
                    local_client(workers) if scheduler is None else scheduler_client(scheduler)
                )
                client = stack.enter_context(cluster)
        except ConnectionError as error:
            if scheduler is None:
                raise StoppedError(f"{error}: try again, or with fewer --workers.") from None
            raise UserError(f"--scheduler {scheduler}: {error}.") from None
        if scheduler is not None and not client.nthreads():
            sys.stderr.write(f"the scheduler has no workers yet: waiting, {_QUEUE:g} s at most\n")
        yield client


@contextlib.contextmanager
def _progress(block: int) -> Iterator[Callable[[Any], None]]:
    """Show progress on standard error: on a terminal in one line, else a line for each tenth."""
    printed: set[int] = set()
    with status("compiling") as update:

        def watch(progress: Any) -> None:
            text = f"{progress.done} of {progress.all} blocks"
            if progress.designs:
                seconds = (progress.all - progress.done) * block / progress.rate
                text += f", {progress.rate:,.0f} designs/s, {seconds:.0f} s left"
            if progress.last is not None:
                text += f", {progress.last.memory / 2**20:.0f} MiB a worker"
            update(text)
            tenth = 10 * progress.done // max(1, progress.all)
            is_due = tenth not in printed or progress.done == progress.all
            if is_due and not sys.stderr.isatty():
                printed.add(tenth)
                sys.stderr.write(f"{text}\n")

        yield watch
