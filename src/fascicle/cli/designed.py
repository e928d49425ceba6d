"""What `fascicle design` found: printed, as JSON, and as a folder of files."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from .outputs import say
from .problems import refusing
from .tables import show


if TYPE_CHECKING:
    from ..design.robust import Spread
    from ..design.searching import Found

_SHOWN, _SAVED = 20, 30  # designs of the front that are printed, and that get a file


def folder_for(out: str | None, path: str, as_json: bool, overwrite: bool) -> Path | None:
    """Where the files go.

    **Arguments:**

    - `out`: the folder that was asked for [-], or `None`.
    - `path`: of the task file [-].
    - `as_json`: whether JSON is printed [-].
    - `overwrite`: whether others' files may be replaced [-].

    **Returns:** the folder [-], checked; `None` where nothing is written.
    """
    from ..describe.ours import check_folder

    if out is None and as_json:
        return None
    folder = Path(f"designed-{Path(path).stem}" if out is None else out)
    with refusing("--out "):
        check_folder(folder, "design", overwrite)
    return folder


def print_front(found: "Found") -> None:
    """Print the front and the recommendation; `found` [-] by a search."""
    from ..design.objectives import OBJECTIVES
    from ..reports.design import nothing_left, recommendation, shown, sizes

    kept = (
        f" {int(found.allowed.sum())} within the limits,"
        if found.judged == len(found.index)
        else ""
    )
    print(f"{found.judged} designs,{kept} {len(found.front)} on the front")
    if found.recommended is None:
        for line in nothing_left(found):
            say(line)
        return
    names = [name for name in found.values if name in OBJECTIVES]
    first = range(min(len(found.front), _SHOWN))
    rows = [
        [
            f"{place + 1}{' *' if place == found.recommended else ''}",
            found.designs.labels[place],
            *(shown(name, float(found.values[name][found.front[place]])) for name in names),
            sizes(found, place),
        ]
        for place in sorted({*first, int(found.recommended)})
    ]
    heads = ["", "units", *(name.replace("_", " ") for name in names), "muscles"]
    more = len(found.front) - len(rows)
    caption = "*: recommended" + (f"; {more} more are in the files" if more else "")
    show("Designs that no other betters", heads, rows, caption)
    for line in recommendation(found):
        say(line)


def write(
    found: "Found",
    folder: Path,
    date: str,
    seconds: float,
    sure: "Spread | None" = None,
    overwrite: bool = False,
) -> list[str]:
    """Write report, data and bundles.

    **Arguments:**

    - `found`: by a search [-].
    - `folder`: where they go [-].
    - `date`: of the day [-].
    - `seconds`: that the search took [s].
    - `sure`: how the front's designs come out [-], if that was asked.
    - `overwrite`: whether others' files may be replaced [-].

    **Returns:** the files' paths [-].
    """
    from ..describe import dumps
    from ..describe.designed import every_variables, front_variables
    from ..describe.ours import write_folder
    from ..describe.results import dataset
    from ..reports.design import report
    from .outputs import SOURCE

    bundles = {
        f"bundle_{place + 1}.toml": dumps(found.designs.bundle(place, found.task))
        for place in range(min(len(found.front), _SAVED))
    }
    data: dict[str, Any] = {"designs.nc": every_variables(found)}
    if found.front.size:
        data["front.nc"] = front_variables(found, sure)
    files = [*data, *bundles]
    page = report(found, date, files, seconds, sure)

    def fill(draft: Path) -> None:
        (draft / "report.html").write_text(page, encoding="utf-8")
        for name, text in bundles.items():
            (draft / name).write_text(text, encoding="utf-8")
        for name, variables in data.items():
            made = dataset(variables, title=f"Designs for {found.task.name}", source=SOURCE)
            made.to_netcdf(draft / name, engine="netcdf4")

    write_folder(folder, "design", fill, overwrite)
    return [str(folder / name) for name in ("report.html", *files)]
