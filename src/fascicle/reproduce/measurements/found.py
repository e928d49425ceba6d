"""Where measured records lie, and of which muscle each is."""

import math
import os
from dataclasses import dataclass
from pathlib import Path

from ...files import load as load_muscle
from ...muscle import Muscle
from ...records import load
from ...records.record import Record


VARIABLE = "FASCICLE_DATA"
# published sizes of records that are known here, whose folder holds no muscle: length, radius,
# wall and braid angle; a maker's wall and angle aren't published, and only begin the fit
_KNOWN = {
    "martens-boblan-2017/dmsp-20-300.csv": (
        0.3, 10e-3, 2e-3, math.radians(28.6),
        "Martens and Boblan (2017), doi:10.3390/act6040033, table A1, CC BY 4.0",
    ),
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Measured:
    """A measured `record` [-] by its `name` [-], the `muscle` of nominal sizes [-], its `source`
    [-]; or why it is `left_out` [-].
    """

    name: str
    record: Record | None = None
    muscle: Muscle | None = None
    source: str = ""
    left_out: str = ""


def data_folder() -> Path | None:
    """The folder that measured records are looked for in [-]; `None` where there is none."""
    named = os.environ.get(VARIABLE)
    if named is not None:
        return Path(named) if Path(named).is_dir() else None
    beside = Path(__file__).resolve().parents[5] / "shared" / "data"
    return beside if beside.is_dir() else None


def measured_records() -> list[Measured]:
    """Every CSV in that folder and its own [-], by name; those without a muscle say so."""
    folder = data_folder()
    if folder is None:
        return []
    return [_measured(path, folder) for path in sorted(folder.rglob("*.csv"))]


def _measured(path: Path, folder: Path) -> Measured:
    name = path.relative_to(folder).as_posix()
    beside = [path.with_suffix(".toml"), path.with_name("muscle.toml")]
    toml = next((one for one in beside if one.is_file() and _holds_a_muscle(one)), None)
    if toml is None and name not in _KNOWN:
        return Measured(name, left_out="no muscle.toml with its nominal sizes lies beside it")
    try:
        if toml is not None:
            muscle, source = load_muscle(toml), f"sizes from {toml.name}"
            if not isinstance(muscle, Muscle):
                return Measured(name, left_out=f"{toml.name} holds more than one muscle")
        else:
            length, radius, wall, angle, source = _KNOWN[name]
            muscle = Muscle.from_dimensions(length, radius, wall, angle)
        record = load(path, rest_length=float(muscle.length))
    except (ValueError, OSError) as error:
        return Measured(name, left_out=str(error))
    if record.synthetic:
        return Measured(name, left_out="it is synthetic: a model made it")
    return Measured(name, record, muscle, source)


def _holds_a_muscle(path: Path) -> bool:
    """Whether a file is a muscle's, not a record's own description."""
    return "[muscle" in path.read_text(encoding="utf-8", errors="replace")
