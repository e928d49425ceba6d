"""What `fascicle design` found: printed, as JSON, and as a folder of files."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..outputs import say
from ..printed import show
from ..problems import INCOMPLETE


if TYPE_CHECKING:
    from ...design.exhaustive_search import Found
    from ...design.robust import Spread
    from ...design.summary import Summary
    from ...reports.unreached import Unreached

_SHOWN, _SAVED = 20, 30  # designs of the front that are printed, and that get a file
_CASES = 20  # load cases that are printed


def print_answer(
    found: "Found", answered: "Summary | Unreached", notes: tuple[str, ...] = ()
) -> int:
    """Print which design to take, and the front; or that there is none.

    **Arguments:**

    - `found`: by a search [-].
    - `answered`: what the reports' `answer` says of it [-].
    - `notes`: on what the search left out [-].

    **Returns:** the exit code [-]: 0, or `INCOMPLETE`.
    """
    from ...reports.design import compromise
    from ...reports.engineering import HEADS, called, case_rows, facts, headline, margin_warning
    from ...reports.unreached import Unreached

    for note in notes:
        say(f"note: {note}")
    none = answered if isinstance(answered, Unreached) else None
    summary = answered.summary if isinstance(answered, Unreached) else answered
    if none is None:
        take, margin, *why = headline(found, summary)
        warning = margin_warning(found, summary)
        for line in (take, margin, *([f"warning: {warning}"] if warning else []), *why):
            say(line)
    rows, caption = case_rows(summary, _CASES)
    show(f"Load cases, {called(summary)}", list(HEADS), rows, caption)
    if none is not None:
        for line in none.lines():  # last, where it is read
            say(line)
        return INCOMPLETE
    for name, text in facts(found, summary).items():
        say(f"{name}: {text}")
    print_front(found)
    for line in compromise(found):
        say(line)
    return 0


def print_front(found: "Found") -> None:
    """Print the designs that no other betters; `found` [-] by a search that has some."""
    from ...reports.engineering import demand, shown, sizes, words

    kept = (
        f" {int(found.reaching.sum())} {demand(found)}, {int(found.allowed.sum())} keep all limits"
        " too,"
        if found.judged == len(found.index)
        else ""
    )
    print(f"{found.judged} designs,{kept} {len(found.front)} on the front")
    first = range(min(len(found.front), _SHOWN))
    marked = {found.recommended, found.compromise} - {None}
    rows = [
        [
            f"{place + 1}{_mark(found, place)}",
            found.designs.labels[place],
            *(shown(name, float(found.values[name][found.listed[place]])) for name in found.told),
            sizes(found, found.designs, place),
        ]
        for place in sorted({*first, *(int(place) for place in marked if place is not None)})
    ]
    heads = ["", "units", *map(words, found.told), "muscles"]
    more = len(found.listed) - len(rows)
    caption = "*: recommended, c: best compromise"
    if found.cheapest not in found.front:
        caption += "; the recommended one isn't on the front"
    caption += f"; {more} more are in the files" if more else ""
    show("Designs that no other betters", heads, rows, caption)


def _mark(found: "Found", place: int) -> str:
    marks = ["*"] if place == found.recommended else []
    marks += ["c"] if place == found.compromise else []
    return f" {' '.join(marks)}" if marks else ""


def write(
    found: "Found",
    folder: Path,
    date: str,
    seconds: float,
    sure: "Spread | None" = None,
    notes: tuple[str, ...] = (),
    answered: "Summary | Unreached | None" = None,
    overwrite: bool = False,
) -> list[str]:
    """Write report, data and bundles.

    **Arguments:**

    - `found`: by a search [-].
    - `folder`: where they go [-].
    - `date`: of the day [-].
    - `seconds`: that the search took [s].
    - `sure`: how the front's designs come out [-], if that was asked.
    - `notes`: on what the search left out [-].
    - `answered`: what the reports' `answer` says of it [-]; left out, it is asked.
    - `overwrite`: whether others' files may be replaced [-].

    **Returns:** the files' paths [-].
    """
    from ...files import dumps
    from ...files.ours import write_folder
    from ...reports.design import report
    from ...reports.unreached import Unreached, answer
    from ...results.designed import case_variables, every_variables, front_variables
    from ...results.labelled import dataset, write_netcdf
    from ..outputs import SOURCE

    answered = answer(found) if answered is None else answered
    bundles = {
        f"bundle_{place + 1}.toml": dumps(found.designs.bundle(place, found.task))
        for place in range(min(len(found.listed), _SAVED))
    }
    data: dict[str, Any] = {"designs.nc": every_variables(found)}
    if not isinstance(answered, Unreached) and found.recommended is not None:
        recommended = dumps(found.designs.bundle(found.recommended, found.task))
        bundles = {"recommended.toml": recommended, **bundles}
        data["front.nc"] = front_variables(found, sure) | case_variables(answered)
    files = [*data, *bundles]
    page = report(found, date, files, seconds, sure, notes, answered)
    about = {"notes": " ".join(notes)} if notes else {}

    def fill(draft: Path) -> None:
        (draft / "report.html").write_text(page, encoding="utf-8")
        for name, text in bundles.items():
            (draft / name).write_text(text, encoding="utf-8")
        for name, variables in data.items():
            title = f"Designs for {found.task.name}"
            made = dataset(variables, title=title, source=SOURCE, **about)
            write_netcdf(made, draft / name)

    write_folder(folder, "design", fill, overwrite)
    return [str(folder / name) for name in ("report.html", *files)]


def as_json(
    found: "Found",
    answered: "Summary | Unreached",
    sure: "Spread | None",
    notes: tuple[str, ...] = (),
) -> str:
    """What was found as JSON.

    **Arguments:**

    - `found`: by a search [-].
    - `answered`: what the reports' `answer` says of it [-].
    - `sure`: how the front's designs come out [-], if that was asked.
    - `notes`: on what the search left out [-].

    **Returns:** the text [-]: the front and which of it is recommended, or what is told of the
    nearest, and that none is; `reached` and `limits_kept` are of
    that design.
    """
    import json

    from ...io.sanitize import dump_json
    from ...reports.engineering import margin_warning
    from ...reports.unreached import Unreached
    from ...results.designed import case_variables, design_variables, front_variables
    from ...results.labelled import to_json

    none = answered if isinstance(answered, Unreached) else None
    summary = answered.summary if isinstance(answered, Unreached) else answered
    said = [] if none is None else [none.verdict()]
    about = {
        "reached": bool(summary.cases.reached.all()),
        "limits_kept": none is None or none.keeps,
        "notes": [*notes, *said],
    }
    warning = "" if none is not None else margin_warning(found, summary)
    about |= {"least_margin": found.least_margin, "warnings": [warning] if warning else []}
    if none is None:
        variables = front_variables(found, sure) | case_variables(summary)
        return dump_json(about | json.loads(to_json(variables)))
    nearest = design_variables(none.design) | case_variables(summary)
    remedies = [
        {"change": one.what, "now": one.now, "value": one.value, "looked_up_to": one.most,
         "breaks": dict(one.breaks)}
        for one in none.ways
    ]  # fmt: skip
    about |= {"recommended": None, "nearest": json.loads(to_json(nearest))}
    about |= {"would_reach": remedies}
    return dump_json(about | {"told": none.lines()})
