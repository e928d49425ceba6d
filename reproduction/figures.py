"""A reproduced figure: its conditions, its data, how it is drawn, and the claims about it."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from matplotlib.figure import Figure

from fascicle.io.atomic import write
from fascicle.plot import to_bytes
from fascicle.results import labelled
from fascicle.results.labelled import Variable

from .claims import Claim


SOURCE = "Kim, Mazzoleni and Bryant (2021), Actuators 10, 42; computed by fascicle"


@dataclass(frozen=True)
class PaperFigure:
    """One figure. `key` names its files, `title` and `conditions` say what it shows, and
    `missing` what the publication shows there that can't be computed.
    """

    key: str
    title: str
    conditions: tuple[str, ...]
    data: Mapping[str, Variable]
    draw: Callable[[], Figure]
    claims: tuple[Claim, ...] = ()
    missing: str = ""

    @property
    def name(self) -> str:
        """The figure's number, "Fig. 6", else the whole title."""
        number = re.match(r"Fig\. \d+", self.title)
        return number.group() if number else self.title


@dataclass(frozen=True)
class WrittenFigure:
    """A written figure: picture as `svg`, its `width` [inch], `tables` as CSV by file name."""

    figure: PaperFigure
    svg: bytes
    width: float
    tables: Mapping[str, bytes]


def write_figure(figure: PaperFigure, folder: Path) -> WrittenFigure:
    """Write a figure's pictures and data into an existing `folder`, each file whole or not at all.

    Raises `OSError` where it can't be written.
    """
    drawing = figure.draw()
    pictures = {kind: to_bytes(drawing, kind) for kind in ("png", "svg")}
    for kind, content in pictures.items():
        path = folder / f"{figure.key}.{kind}"
        write(path, lambda draft, content=content: draft.write_bytes(content))
    labelled.write(figure.data, folder / f"{figure.key}.nc", title=figure.title, source=SOURCE)
    written = {}
    for name, table in tables(figure).items():
        labelled.write(table, folder / name)
        written[name] = (folder / name).read_bytes()
    return WrittenFigure(figure, pictures["svg"], float(drawing.get_figwidth()), written)


def tables(figure: PaperFigure) -> dict[str, dict[str, Variable]]:
    """Data of a figure as tables by file name: variables of like dimensions in one table."""
    coordinates = {name: v for name, v in figure.data.items() if v.dims == (name,)}
    groups: dict[tuple[str, ...], dict[str, Variable]] = {}
    for name, variable in figure.data.items():
        if name not in coordinates:
            groups.setdefault(variable.dims, {})[name] = variable
    files = {}
    for dims, group in groups.items():
        # the first table bears the figure's name alone
        tail = f"_{'_'.join(('by', *dims) if dims else ('numbers',))}" if files else ""
        used = {name: v for name, v in coordinates.items() if name in dims}
        files[f"{figure.key}{tail}.csv"] = used | group
    return files
