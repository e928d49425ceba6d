"""`fascicle sweep`: a study of many designs on many workers, that can be stopped and resumed."""

import contextlib
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

from ...core.errors import require
from .. import options
from ..errors import StoppedError, UserError, user_errors
from ..inputs import load_laws
from ..options import argument, flag, option
from ..outputs import SOURCE, check_file, print_line, status, write_file
from .design import print_answer


_RESUME = "finished blocks are kept in {}, --resume goes on with them."
_QUEUE = 600.0  # s that a scheduler's workers may take to come; clusters have queues
_FRONT = 5_000_000  # designs of which the front is looked for in the end


def run(
    study: str = argument(
        "STUDY.toml", "Task file, as of `fascicle design`; its [sweep] sets the size of a block."
    ),
    out: str | None = option(
        "Folder of results; default: swept-STUDY.", "--out -o", metavar="FOLDER"
    ),
    resume: bool = flag("Resumption of the study in the folder.", "--resume"),
    scheduler: str | None = option(
        "Address of a Dask scheduler, tcp://…, whose workers see FOLDER under the same path;"
        " default: workers on this machine.",
        metavar="ADDRESS",
    ),
    workers: int | None = option(
        "Workers on this machine; default: one a core; 0: no cluster.", min=0, max=4096
    ),
    overwrite: bool = options.OVERWRITE,
) -> int:
    """Evaluate a study's designs block by block, on many workers."""
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
    with _cluster(scheduler, workers) as client, _progress(designs.block) as watch, user_errors():
        call = partial(sweep, designs, folder, client, resume, watch)
        store = _run(call if scheduler is None else partial(call, alone=_QUEUE), folder)
    count = len(designs.space)
    print_line(f"{count} designs in {designs.blocks} blocks: {folder / 'designs.zarr'}")
    if count > _FRONT:
        print(f"no front: {count} designs are more than {_FRONT}")
        return 0
    with user_errors():
        return _conclude(store, task, folder, overwrite or resume)


def _run(sweep: Callable[[], Any], folder: Path) -> Any:
    """The store, complete; or in one line what happened, and what can be done about it."""
    try:
        return sweep()
    except KeyboardInterrupt:
        print_line(f"interrupted; {_RESUME.format(folder)}", error=True)
        raise
    except ConnectionError as error:
        raise StoppedError(f"{error}; {_RESUME.format(folder)}") from None
    except OSError as error:
        path = error.filename or folder
        raise UserError(
            f"{path}: {error.strerror or error}; once that is mended, {_RESUME.format(folder)}"
        ) from None


def _conclude(store: Any, task: Any, folder: Path, overwrite: bool) -> int:
    """Print and write the recommended design and the front; returns the exit code."""
    import numpy as np

    from ...design.exhaustive_search import conclude
    from ...reports.design_summary import InfeasibleResult, summarize_search
    from ...results.design_tables import case_variables, front_variables
    from ...results.labelled import write

    with status("looking for the front"):
        result = conclude(
            task.space, task.task, task.senses, task.limits, np.arange(len(task.space)),
            store.all(), catalog=task.catalog, least_margin=task.least_margin,
        )  # fmt: skip
        answered = summarize_search(result)
        if not isinstance(answered, InfeasibleResult):
            title = f"Front of designs for {task.task.name}"
            variables = front_variables(result) | case_variables(answered)
            about = {"notes": " ".join(task.notes)} if task.notes else {}
            with write_file("", folder / "front.nc", overwrite) as draft:
                write(variables, draft, title=title, source=SOURCE, **about)
    return print_answer(result, answered, task.notes)


@contextlib.contextmanager
def _cluster(scheduler: str | None, workers: int | None) -> Iterator[Any]:
    """A client of the scheduler, or of workers on this machine; `None` for neither."""
    if workers == 0:
        yield None
        return
    from ...design.cluster import local, remote

    with contextlib.ExitStack() as stack:
        try:
            if scheduler is None:
                with status("starting the workers"):
                    client = stack.enter_context(local(workers))
            else:
                client = stack.enter_context(remote(scheduler))
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

        def watch(now: Any) -> None:
            text = f"{now.done} of {now.all} blocks"
            if now.designs:
                seconds = (now.all - now.done) * block / now.rate
                text += f", {now.rate:,.0f} designs/s, {seconds:.0f} s left"
            if now.last is not None:
                text += f", {now.last.memory / 2**20:.0f} MiB a worker"
            update(text)
            tenth = 10 * now.done // max(1, now.all)
            if not sys.stderr.isatty() and (tenth not in printed or now.done == now.all):
                printed.add(tenth)
                sys.stderr.write(f"{text}\n")

        yield watch
