"""`fascicle design`: which bundle for a task."""

import datetime as dt
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from ..options import AsJson, Replace
from ..outputs import folder_for, say
from ..problems import INCOMPLETE, UserError, refusing
from ..telling import telling


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


Generations = Annotated[
    int | None,
    typer.Option(
        "--generations",
        min=1,
        max=100_000,
        help="Don't judge every design: search by NSGA-II for so long, with sizes anywhere between"
        " the least and the largest of the file (needs pymoo).",
        show_default=False,
    ),
]
Population = Annotated[
    int, typer.Option("--population", min=4, max=10_000, help="Designs of a generation.")
]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Of chance.")]
Checkpoint = Annotated[
    str | None,
    typer.Option(
        "--checkpoint",
        metavar="PATH",
        help="Keep every generation there, and go on from what is there.",
        show_default=False,
    ),
]


def run(
    task: Task,
    out: Out = None,
    also: Also = None,
    generations: Generations = None,
    population: Population = 100,
    seed: Seed = 0,
    checkpoint: Checkpoint = None,
    overwrite: Replace = False,
    as_json: AsJson = False,
) -> int:
    """Recommend the cheapest bundle that does a task, and show those that no other betters.

    Where no design reaches every load case, the nearest is told, what it misses and what would
    reach it; the exit code is 3 then.
    """
    from ..startup import prepare
    from .design_results import as_json as to_json
    from .design_results import print_answer, write

    folder = folder_for("design", out, task, as_json, overwrite)
    _check(generations, checkpoint)
    prepare()
    from ...design.exhaustive_search import search
    from ...files.task import load_task

    with refusing():
        file = load_task(task)
    extra = tuple(name.strip() for name in also.split(",")) if also is not None else ()
    begun = time.perf_counter()
    from ...reports.unreached import answer

    with telling(f"judging {len(file.space)} designs") as tell, refusing():
        if generations is None:
            found = search(
                file.space, file.task, file.senses, file.limits, extra,
                lambda done, all_: tell(f"{done} of {all_} designs"), file.catalog,
                file.least_margin,
            )  # fmt: skip
        else:
            found = _evolved(file, generations, population, seed, checkpoint, extra, tell)
        tell("what the best of them do")
        sure = _sure(found, file.chance)
        seconds = time.perf_counter() - begun
        answered = answer(found)
    written: list[str] = []
    if folder is not None:
        today = f"{dt.datetime.now().astimezone():%Y-%m-%d}"
        with telling("drawing the report"), refusing("--out "):
            written = write(found, folder, today, seconds, sure, file.notes, answered, overwrite)
    if as_json:
        print(to_json(found, answered, sure, file.notes))
        return 0 if found.recommended is not None else INCOMPLETE
    code = print_answer(found, answered, file.notes)
    if sure is not None and found.recommended is not None:
        share = sure.probability[found.recommended]
        print(f"as muscles come out, it meets the task with a probability of {share:.2f}")
    if written:
        shown = written if len(written) < 5 else [*written[:3], f"{len(written) - 3} files more"]
        say(f"wrote {', '.join(shown)}")
    return code


def _sure(found: Any, chance: Any) -> Any:
    """How the front's designs come out, where the task file asks for it."""
    if chance is None or not found.listed.size:
        return None
    from ...design.robust import spread

    names = tuple(found.values)
    return spread(
        found.designs, found.task, names, found.limits, chance.scatter, chance.muscles, chance.draws
    )


def _check(generations: int | None, checkpoint: str | None) -> None:
    """Refuse what would only fail after the file is read."""
    from importlib.util import find_spec

    if generations is not None and find_spec("pymoo") is None:
        raise UserError("--generations needs the package pymoo: pip install 'fascicle[design]'.")
    if checkpoint is not None:
        from ...io.atomic import check_writable

        if generations is None:
            raise UserError("--checkpoint: only --generations keeps one.")
        with refusing("--checkpoint "):
            check_writable(checkpoint)


def _evolved(
    file: Any,
    generations: int,
    population: int,
    seed: int,
    checkpoint: str | None,
    extra: tuple[str, ...],
    tell: Callable[[str], None],
) -> Any:
    from ...design.genetic import evolve

    return evolve(
        file.space, file.task, file.senses, file.limits, population, generations, seed,
        checkpoint=None if checkpoint is None else Path(checkpoint), extra=extra,
        watch=lambda done: tell(f"{done} of {generations} generations"), catalog=file.catalog,
        least_margin=file.least_margin,
    )  # fmt: skip
