"""Catalog of measured muscles: for each a file `measured/NAME.toml` with an `[entry]`, which may
name a record beside it, readings whose license allows it.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from importlib.resources import as_file, files
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..core.findings import Finding, Severity
from ..core.types import Float
from ..core.validation import check_choice
from ..muscle import Muscle
from ..repr_table import ReprTable, with_table_repr
from ..table_model import validate
from ..units import format_digits, parse, pretty
from . import shipped_names, shipped_text
from .muscle_files import from_dict, parse_file
from .schema import EntryFile, EntrySection


if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..records.record import Record


_FOLDER = "measured"  # of shipped files
_RANGES = (("pressure", "pressure"), ("contraction", "strain"))  # words, and dimensions
_ROUNDING = 1e-9  # relative, of the ends of a range
_CURVES, _POINTS = 5, 201  # more are hard to tell apart in a small picture; smooth in print


class FitError(NamedTuple):
    """Error of a measured muscle's force: root mean square `rmse` [N], that and the `largest` error
    over the largest force, `relative_rmse` and `largest` [-]; `None` if unknown.
    """

    rmse: float | None
    relative_rmse: float | None
    largest: float | None

    def __str__(self) -> str:
        """Text with units."""
        text = "" if self.rmse is None else f"{format_digits(self.rmse, 3)} N"
        if self.relative_rmse is not None:
            text += f" ({format_digits(100 * self.relative_rmse, 2)} % of the largest force)"
        if self.largest is not None:
            text += f"{', ' if text else ''}at most {format_digits(100 * self.largest, 3)} %"
        return text or "not published"


class MeasuredRange(NamedTuple):
    """Least and largest `pressure` [Pa] and `strain` [-] that were measured, each `None` if the
    source does not give it. Strains are the muscle's, over its length.
    """

    pressure: tuple[float, float] | None
    strain: tuple[float, float] | None

    def __str__(self) -> str:
        """Text with units."""
        texts = [
            "not published" if ends is None else " to ".join(pretty(x, kind, 3) for x in ends)
            for ends, (_, kind) in zip(self, _RANGES, strict=True)
        ]
        return f"pressure {texts[0]}, contraction {texts[1]}"


def _entry_table(entry: "CatalogEntry") -> ReprTable:
    names = "maker", "sizes", "measured", "basis", "error", "range", "source", "url", "license"
    facts = [(name, str(getattr(entry, name))) for name in names]
    return ReprTable(entry.title, facts, notes=[f"Assumed: {text}" for text in entry.assumed])


@with_table_repr(_entry_table, lambda entry: f"<CatalogEntry {entry.name!r}: {entry.title}>")
@dataclass(frozen=True, eq=False)
class CatalogEntry:
    """A muscle that somebody measured.

    - `source`, `url`, `license`: citation and address of the numbers, and their license.
    - `sizes`, `measured`, `assumed`: published sizes, what was measured, and what the source does
      not give, in words.
    - `basis`: "fit" to the record by fascicle, or constants "published" by the source.
    - `muscle`: a fitted one has its active length, without the parts at the fittings.
    - `error`, `range`: error of its force, and the pressures and strains that were measured.
    - `rest_length`: reference of the source's contractions [m].
    - `record_file`: name of the file of readings, or `None`; `toml`: text of the muscle's file.
    """

    name: str
    title: str
    maker: str
    source: str
    url: str
    license: str
    sizes: str
    measured: str
    basis: str
    assumed: tuple[str, ...]
    muscle: Muscle
    error: FitError
    range: MeasuredRange
    rest_length: float
    record_file: str | None
    toml: str

    @property
    def strain_ratio(self) -> float:
        """The muscle's strain over that of its record [-]: rest length over the muscle's length."""
        return self.rest_length / float(self.muscle.length)

    @cached_property
    def record(self) -> "Record | None":
        """Readings, with strains over the rest length; `None` if the entry has none."""
        if self.record_file is None:
            return None
        from ..records import load

        with as_file(files("fascicle.files") / _FOLDER / self.record_file) as path:
            return load(path, rest_length=self.rest_length)

    def residuals(self) -> Float[np.ndarray, " reading"]:
        """Measured less computed force [N] of the record's readings that are not clipped; empty
        without a record.
        """
        if (record := self.record) is None:
            return np.array([])
        force = self.muscle.force(record.pressure, record.strain * self.strain_ratio)
        return (record.force - np.asarray(force))[~record.censored]

    def extrapolations(self, pressure: float, strain: float) -> list[Finding]:
        """Findings "muscle.pressure_extrapolated" and "muscle.strain_extrapolated": a largest
        `pressure` [Pa] or `strain` [-] beyond those that were measured, if these are known.
        """
        return [
            Finding(
                f"muscle.{kind}_extrapolated",
                Severity.WARNING,
                {"muscle": self.name, "value": value, "measured": ends[1]},
            )
            for value, ends, (_, kind) in zip((pressure, strain), self.range, _RANGES, strict=True)
            if ends is not None and value > ends[1] * (1 + _ROUNDING)
        ]

    def as_dict(self) -> dict[str, Any]:
        """Entry without its muscle: text, SI numbers and lists by name."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        values |= {"error": self.error._asdict(), "range": self.range._asdict()}
        return {name: value for name, value in values.items() if name != "muscle"}

    def plot(self) -> "Figure":
        """Figure of the force over contraction in the measured range, with readings as points."""
        from ..plot.curves import force_strain
        from ..plot.theme import pressure_colors

        (pressure, strain), record = self.range, self.record
        levels = None if pressure is None else np.linspace(*pressure, _CURVES)
        if record is not None:
            measured = np.unique(record.pressure[~record.censored])
            levels = measured[np.linspace(0, measured.size - 1, _CURVES).round().astype(int)]
        strains = None if strain is None else np.linspace(0.0, strain[1], _POINTS)
        figure = force_strain(self.muscle, levels, strains)
        if record is not None and levels is not None:
            for level, color in zip(levels, pressure_colors(levels.size), strict=True):
                is_drawn = (record.pressure == level) & ~record.censored
                x, y = record.strain[is_drawn] * self.strain_ratio, record.force[is_drawn]
                figure.axes[0].plot(x, y, "o", color=color, markersize=3, clip_on=False)
        if strain is not None:  # pushes were not measured
            figure.axes[0].set_ylim(bottom=0.0)
        return figure


class MuscleCatalog(Mapping[str, CatalogEntry]):
    """Measured muscles by name. An unknown name gives an `InvalidInputError` with a similar one."""

    def __getitem__(self, name: str) -> CatalogEntry:
        return read_entry(shipped_text(_FOLDER, check_choice(name, self, "name")), name)

    def __iter__(self) -> Iterator[str]:
        return iter(shipped_names(_FOLDER))

    def __len__(self) -> int:
        return len(shipped_names(_FOLDER))

    def __contains__(self, name: object) -> bool:
        return name in shipped_names(_FOLDER)

    def get(self, name: str, default: Any = None) -> Any:
        """Entry of a name, or a `default`."""
        return self[name] if name in self else default  # noqa: SIM401 defined here

    def __repr__(self) -> str:
        return f"<MuscleCatalog: {', '.join(self)}>"


catalog = MuscleCatalog()


def read_entry(text: str, name: str) -> CatalogEntry:
    """Entry with this `name` from the `text` of its file; `ValueError`, in one line, as `loads`."""
    data = parse_file(text, name)
    file = validate(EntryFile, data, name)
    muscle, entry = from_dict(data, name), file.entry
    if not isinstance(muscle, Muscle):
        raise ValueError(f"{name}: a bundle, an entry of the catalog is a muscle: drop [bundle].")
    texts = {field.name for field in fields(CatalogEntry)} & EntrySection.model_fields.keys()
    values: dict[str, Any] = {key: getattr(entry, key) for key in texts - {"rest_length"}}
    rest_length = float(muscle.length) if entry.rest_length is None else entry.rest_length
    ratio, pressure, strain = rest_length / float(muscle.length), entry.pressure, entry.strain
    pressures = (pressure[0], pressure[1]) if pressure else None
    strains = (strain[0] * ratio, strain[1] * ratio) if strain else None
    rmse = file.calibration.get("rmse")
    rmse = entry.rmse if rmse is None else parse(rmse, "force", "rmse")
    relative_rmse = file.calibration.get("relative_rmse", entry.relative_rmse)
    return CatalogEntry(
        name=name,
        **values,
        basis="fit" if file.calibration else "published",
        muscle=muscle,
        error=FitError(rmse, relative_rmse, entry.largest_error),
        range=MeasuredRange(pressures, strains),
        rest_length=rest_length,
        record_file=entry.record,
        toml=text,
    )
