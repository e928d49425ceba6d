"""`fascicle design`: which bundle for a task."""

import datetime as dt
import time
from typing import Annotated, Any

import typer

from .options import AsJson
from .problems import UserError, refusing


Task = Annotated[
    str,
    typer.Argument(
        metavar="TASK.toml",
        help="What is demanded, may be built and is good; `fascicle init --task` writes one.",
        show_default=False,
    ),
]
Out = Annotated[
    str | None,
    typer.Option(
        "--out",
        "-o",
        metavar="FOLDER",
        help="Where report, data and bundles go; left out, designed-TASK, and nowhere with --json.",
        show_default=False,
    ),
]
Also = Annotated[
    str | None,
    typer.Option(
        "--also",
        metavar="LIST",
        help="Objectives to record that don't make the front: reversal_depth,largest_force.",
        show_default=False,
    ),
]


def run(task: Task, out: Out = None, also: Also = None, as_json: AsJson = False) -> None:
    """Judge every design of a task file's space, and show those that no other betters."""
    from .designed import folder_for, print_front, write
    from .startup import prepare

    folder = folder_for(out, task, as_json)
    prepare()
    from ..describe.task import load_task
    from ..design.searching import search

    with refusing():
        file = load_task(task)
    extra = tuple(name.strip() for name in also.split(",")) if also is not None else ()
    begun = time.perf_counter()
    with refusing():
        found = search(file.space, file.task, file.senses, file.limits, extra)
        sure = _sure(found, file.chance)
    seconds = time.perf_counter() - begun
    written: list[str] = []
    if folder is not None:
        with refusing("--out "):
            written = write(
                found, folder, f"{dt.datetime.now().astimezone():%Y-%m-%d}", seconds, sure
            )
    if as_json:
        from ..describe.designed import front_variables
        from ..describe.results import to_json

        if not found.front.size:
            raise UserError(f"{task}: no design keeps all limits.")
        print(to_json(front_variables(found, sure)))
        return
    print_front(found)
    if sure is not None and found.recommended is not None:
        share = sure.probability[found.recommended]
        print(f"as muscles come out, it meets the task with a probability of {share:.2f}")
    if written:
        shown = written if len(written) < 5 else [*written[:3], f"{len(written) - 3} files more"]
        print(f"wrote {', '.join(shown)}")


def _sure(found: Any, chance: Any) -> Any:
    """How the front's designs come out, where the task file asks for it."""
    if chance is None or not found.front.size:
        return None
    from ..design.robust import spread

    names = tuple(found.values)
    return spread(
        found.designs, found.task, names, found.limits, chance.scatter, chance.muscles, chance.draws
    )
