"""`fascicle sweep`: a study of many designs on many workers, that can be stopped and resumed."""

import contextlib
import sys
from pathlib import Path

from ...core.errors import require
from .. import options
from ..errors import StoppedError, UserError, user_errors
from ..inputs import load_laws
from ..options import argument, flag, option
from ..outputs import SOURCE, check_file, print_line, replace_output, status
from .design import judge_result, print_answer


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
    import numpy as np

    from ...design.exhaustive_search import conclude
    from ...design.objectives import check_search, recorded_objectives, with_reach_limits
    from ...design.summary import Summary
    from ...design.sweep import Study, open_client, open_folder, sweep
    from ...files.task import load_task
    from ...results.design_tables import case_variables, front_variables
    from ...results.labelled import write

    folder = Path(f"swept-{Path(study).stem}" if out is None else out)
    with user_errors(), status("reading the task"):  # before a cluster is started
        task = load_task(study)
        check_search(task.senses, task.limits)
        names = recorded_objectives(task.senses, with_reach_limits(task.limits))
        designs = Study(task.space, task.task, names, task.block)
        path, front = open_folder(folder, designs, resume), folder / "front.nc"
        check_file("--out", front, overwrite or resume)
    hint = f"the finished blocks are in {folder}: continue with --resume."
    with status("starting the workers") as update, contextlib.ExitStack() as stack:

        def watch(done: int, blocks: int) -> None:
            update(f"blocks: {done} of {blocks}")
            is_tenth = 10 * done // blocks > 10 * (done - 1) // blocks
            if is_tenth and not sys.stderr.isatty():
                sys.stderr.write(f"{done} of {blocks} blocks\n")

        try:
            client = None if workers == 0 else stack.enter_context(open_client(scheduler, workers))
            values = sweep(designs, path, client, watch)
        except KeyboardInterrupt:
            print_line(f"interrupted; {hint}", error=True)
            raise
        except ConnectionError as error:
            raise StoppedError(f"no workers: {error}; {hint}") from None
        except OSError as error:
            name, reason = error.filename or folder, error.strerror or error
            raise UserError(f"{name}: {reason}; remove the cause; {hint}") from None
    with status("looking for the front") as update, user_errors():
        result = conclude(
            task.space, task.task, task.senses, task.limits, np.arange(len(task.space)),
            values, catalog=task.catalog, least_margin=task.least_margin,
        )  # fmt: skip
        result, answer = judge_result(result, task, update)
        if isinstance(answer, Summary):
            attributes = {"title": f"Front of designs for {task.task.name}", "source": SOURCE}
            with replace_output("", front, overwrite or resume) as draft:
                write(front_variables(result) | case_variables(answer), draft, **attributes)
    print_line(f"wrote {len(task.space)} designs in {designs.blocks} blocks: {path}")
    return print_answer(result, answer, task.notes)
