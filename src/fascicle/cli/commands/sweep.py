"""`fascicle sweep`: a study of many designs on many workers, that can be stopped and resumed."""

import contextlib
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from ..options import Replace
from ..outputs import say
from ..problems import StoppedError, UserError, refusing
from ..telling import telling


StudyFile = Annotated[
    str,
    typer.Argument(
        metavar="STUDY.toml",
        help="A task file, as `fascicle design` takes; [sweep] block says how it is cut up.",
        show_default=False,
    ),
]
Out = Annotated[
    str | None,
    typer.Option(
        "--out", "-o", metavar="FOLDER", help="Where results go; left out, swept-STUDY.",
        show_default=False,
    ),
]  # fmt: skip
Resume = Annotated[bool, typer.Option("--resume", help="Go on with what is there.")]
Scheduler = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        metavar="ADDRESS",
        help="Of a Dask scheduler, tcp://…, whose workers see FOLDER under the same path; left"
        " out, workers on this machine.",
        show_default=False,
    ),
]
Workers = Annotated[
    int | None,
    typer.Option(
        "--workers", min=0, max=4096, help="On this machine; left out, one a core; 0: no cluster.",
        show_default=False,
    ),
]  # fmt: skip
_KEPT = "finished blocks are kept in {}, --resume goes on with them."
_QUEUE = 600.0  # s that a scheduler's workers may take to come; clusters have queues
_FRONT = 5_000_000  # designs of which the front is looked for in the end


def run(
    study: StudyFile,
    out: Out = None,
    resume: Resume = False,
    scheduler: Scheduler = None,
    workers: Workers = None,
    overwrite: Replace = False,
) -> int:
    """Judge every design of a study, block by block, into a folder with a zarr store."""
    from importlib.util import find_spec

    if scheduler is not None and workers is not None:
        raise UserError("--scheduler and --workers: a scheduler has its own workers, take one.")
    needed = ["zarr"] if workers == 0 else ["zarr", "distributed", "cryptography"]
    for name in needed:
        if find_spec(name) is None:
            raise UserError(f"sweeping needs the package {name}: pip install 'fascicle[sweep]'.")
    from ..startup import prepare

    prepare()
    with telling("loading the task"):
        from ...design.sweep import Study, sweep
        from ...files.task import load_task

    folder = Path(f"swept-{Path(study).stem}" if out is None else out)
    with refusing(), telling("reading the task"):
        file = load_task(study)
        made = Study.of(file.space, file.task, file.senses, file.limits, block=file.block)
    # what can't be is said before a cluster is started
    with refusing(), telling("looking into the folder"):
        from ...design.sweep import Store
        from ...files.ours import check_file

        Store.check(folder, made, resume)
        check_file(folder / "front.nc", overwrite)
    with _cluster(scheduler, workers) as client, _told(made.block) as watch, refusing():
        call = partial(sweep, made, folder, client, resume, watch)
        store = _swept(call if scheduler is None else partial(call, alone=_QUEUE), folder)
    say(f"{len(made.space)} designs in {made.blocks} blocks: {folder / 'designs.zarr'}")
    if len(made.space) > _FRONT:
        print(f"of more than {_FRONT} designs none is recommended, nor is a front looked for")
        return 0
    with refusing():
        return _front(store, file, folder, overwrite)


def _swept(sweep: Callable[[], Any], folder: Path) -> Any:
    """The store, complete; or in one line what happened, and what can be done about it."""
    try:
        return sweep()
    except KeyboardInterrupt:
        say(f"interrupted; {_KEPT.format(folder)}", error=True)
        raise
    except ConnectionError as error:
        raise StoppedError(f"{error}; {_KEPT.format(folder)}") from None
    except OSError as error:
        where = error.filename or folder
        raise UserError(
            f"{where}: {error.strerror or error}; once that is mended, {_KEPT.format(folder)}"
        ) from None


def _front(store: Any, file: Any, folder: Path, overwrite: bool) -> int:
    """Print and write which design to take and the front; gives the exit code."""
    import numpy as np

    from ...design.exhaustive_search import concluded
    from ...files.ours import replacing
    from ...reports.unreached import Unreached, answer
    from ...results.designed import case_variables, front_variables
    from ...results.labelled import write
    from ..outputs import SOURCE
    from .design_results import print_answer

    index, values = np.arange(len(file.space)), store.all()
    with telling("looking for the front"):
        found = concluded(
            file.space, file.task, file.senses, file.limits, index, values, catalog=file.catalog,
            least_margin=file.least_margin,
        )  # fmt: skip
        answered = answer(found)
        if not isinstance(answered, Unreached):
            title = f"Front of designs for {file.task.name}"
            variables = front_variables(found) | case_variables(answered)
            about = {"notes": " ".join(file.notes)} if file.notes else {}
            with replacing(folder / "front.nc", overwrite) as draft:
                write(variables, draft, title=title, source=SOURCE, **about)
    return print_answer(found, answered, file.notes)


@contextlib.contextmanager
def _cluster(scheduler: str | None, workers: int | None) -> Iterator[Any]:
    """A client of the scheduler asked for, or of workers on this machine; `None` for neither."""
    if workers == 0:
        yield None
        return
    from ...design.cluster import local, remote

    if scheduler is None:
        with contextlib.ExitStack() as stack:
            try:
                with telling("starting the workers"):
                    client = stack.enter_context(local(workers))
            except ConnectionError as error:
                raise StoppedError(f"{error}: try again, or with fewer --workers.") from None
            yield client
        return
    with contextlib.ExitStack() as stack:
        try:
            client = stack.enter_context(remote(scheduler))
        except ConnectionError as error:
            raise UserError(f"--scheduler {scheduler}: {error}.") from None
        if not client.nthreads():
            sys.stderr.write(f"the scheduler has no workers yet: waiting, {_QUEUE:g} s at most\n")
        yield client


@contextlib.contextmanager
def _told(block: int) -> Iterator[Any]:
    """Progress on stderr: a moving bar for a terminal, now and then a line for a file."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(file=sys.stderr)
    if not console.is_terminal:
        yield _Lines(block)
        return
    columns = (
        BarColumn(), TextColumn("{task.completed} of {task.total} blocks, {task.fields[rate]}"),
        TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=console) as bar:
        line = bar.add_task("sweep", total=None, rate="")

        def watch(now: Any) -> None:
            rate = f"{now.rate:,.0f} designs/s" if now.designs else "compiling"
            bar.update(line, completed=now.done, total=now.all, rate=rate)

        yield watch


class _Lines:
    """A line at the start, after every tenth of the blocks, and at the end."""

    def __init__(self, block: int):
        self.block, self.told, self.memory = block, -1, 0

    def __call__(self, now: Any) -> None:
        if now.last is not None:
            self.memory = max(self.memory, now.last.memory)
        tenth = 10 * now.done // max(1, now.all)
        if tenth == self.told and now.done < now.all:
            return
        self.told = tenth
        left = ""
        if now.designs and now.done < now.all:
            seconds = (now.all - now.done) * self.block / now.rate
            left = f", {seconds:.0f} s left"
        memory = f", {self.memory / 2**20:.0f} MiB a worker" if self.memory else ""
        rate = f", {now.rate:,.0f} designs/s" if now.designs else ""
        sys.stderr.write(f"{now.done} of {now.all} blocks{rate}{left}{memory}\n")
