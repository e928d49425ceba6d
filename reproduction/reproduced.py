"""A reproduced figure: its conditions, its data, how it is drawn, and the claims about it."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from matplotlib.figure import Figure

from fascicle.io.atomic import write
from fascicle.plot import to_bytes
from fascicle.results import labelled as results
from fascicle.results.labelled import Variable

from .claims import Claim


SOURCE = "Kim, Mazzoleni and Bryant (2021), Actuators 10, 42; computed by fascicle"


@dataclass(frozen=True)
class Record:
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
class Written:
    """A record that has been written: its picture as `svg` and as it is wide [inch], and its
    `tables` as CSV by file name.
    """

    record: Record
    svg: bytes
    width: float
    tables: Mapping[str, bytes]


def write_record(record: Record, folder: Path) -> Written:
    """Write a record's pictures and data into `folder`, each file whole or not at all.

    **Arguments:**

    - `record`: what is written [-].
    - `folder`: where to [-]; it exists.

    **Returns:** what a page of it takes [-].

    **Raises:** `OSError` where it can't be written.
    """
    figure = record.draw()
    pictures = {kind: to_bytes(figure, kind) for kind in ("png", "svg")}
    for kind, content in pictures.items():
        _write_bytes(folder / f"{record.key}.{kind}", content)
    results.write(record.data, folder / f"{record.key}.nc", title=record.title, source=SOURCE)
    written = {}
    for name, table in tables(record).items():
        results.write(table, folder / name)
        written[name] = (folder / name).read_bytes()
    return Written(record, pictures["svg"], float(figure.get_figwidth()), written)


def tables(record: Record) -> dict[str, dict[str, Variable]]:
    """The data of a `record` as tables by file name: variables of like dimensions together."""
    coordinates = {name: v for name, v in record.data.items() if v.dims == (name,)}
    groups: dict[tuple[str, ...], dict[str, Variable]] = {}
    for name, variable in record.data.items():
        if name not in coordinates:
            groups.setdefault(variable.dims, {})[name] = variable
    found = {}
    for dims, group in groups.items():
        # the first table bears the figure's name alone
        tail = f"_{'_'.join(('by', *dims) if dims else ('numbers',))}" if found else ""
        used = {name: v for name, v in coordinates.items() if name in dims}
        found[f"{record.key}{tail}.csv"] = used | group
    return found


def _write_bytes(path: Path, content: bytes) -> None:
    write(path, lambda draft: draft.write_bytes(content))
