"""The validation page: a table for each record, its picture, and what none of it says."""

import json
import math
from collections.abc import Callable, Sequence
from html import escape
from pathlib import Path
from typing import Any

from ...calibrate.after.pictures import fitted_of
from ...plot import calibration as plot
from ...plot import to_bytes
from ...reports.page import Page
from ...units import pretty
from .found import VARIABLE, Measured
from .judged import Against, Judged, judged


UNTESTED = (
    "Uncensored measurements of the force with which a muscle resists, past its free strain, are"
    " not public: gauges that only pull clip them at zero. Buckling, collapse and the hinge are"
    " therefore untested by any record here, and so is the tension law past the free strain. The"
    " paper's own Fig. 12 is known only as a picture.",
    "A lab that has such a record can send it: a CSV with pressure, force that may be negative, and"
    " length, units in the header, and muscle.toml beside it with the nominal sizes, maker and how"
    " it was measured; CONTRIBUTING says how.",
)
_WIDE = 0.15  # m
_HEADS = ("Law: free", "Numbers", "RMSE", "Left out", "Along pressure", "Along strain",
          "What it misses")  # fmt: skip


def run(
    folder: Path, records: Sequence[Measured], progress: Callable[[str], object] = lambda _: None
) -> list[Judged]:
    """Judge `records` [-] and write page, tables and pictures into a `folder` [-]; `progress`: is
    told what is being done [-]. Those that could be judged [-].
    """
    found = []
    for one in records:
        if not one.left_out:
            progress(f"fitting {one.name}")
            found.append(judged(one))
    page = Page("Measured muscles against every law")
    for text in UNTESTED:
        page.paragraph(text)
    for place, one in enumerate(found):
        picture = to_bytes(plot.fit(fitted_of(one.choice.made)), "png")
        (folder / f"record_{place + 1}.png").write_bytes(picture)
        _section(page, one, picture)
    left = [f"{one.name}: {one.left_out}" for one in records if one.left_out]
    if left:
        page.heading("Left out")
        page.points(left)
    (folder / "report.html").write_text(
        page.text("fascicle reproduce measurements"), encoding="utf-8"
    )
    told = {
        "untested": UNTESTED, "left_out": left,
        "records": [_told(one) for one in found],
    }  # fmt: skip
    text = json.dumps(_finite(told), indent=1, ensure_ascii=False)
    (folder / "measurements.json").write_text(text + "\n", encoding="utf-8")
    return found


def _section(page: Page, one: Judged, picture: bytes) -> None:
    made, source = one.choice.made, one.measured.source
    page.heading(one.measured.name)
    page.paragraph(f"{source}. {made.points} readings, {made.censored} of them clipped at zero.")
    page.points(one.choice.reasons)
    page.picture(picture, "png", f"{one.measured.name}: measured and fitted", _WIDE)
    rows = []
    for law in one.against:
        ends = (law.along_pressure, law.along_strain)
        rows.append([
            escape(law.row.label), str(law.row.free), _percent(law.row.relative_rmse),
            _percent(law.row.relative_left_out_rmse),
            *(f"{low:+.3g} to {high:+.3g} N" for low, high in ends), escape(law.misses),
        ])  # fmt: skip
    page.table(_HEADS, rows)
    page.table(["Constant", "Value", "90 % interval, quick", "Known by the data"], _constants(one))


def _constants(one: Judged) -> list[list[str]]:
    return [
        [one.name, pretty(one.value, one.dimension),
         one.texts()[1],
         "yes" if one.identifiable else "no"]
        for one in one.choice.made.parameters
    ]  # fmt: skip


def _told(one: Judged) -> dict[str, Any]:
    return {
        "name": one.measured.name, "source": one.measured.source,
        "reasons": list(one.choice.reasons), "warnings": list(one.choice.made.warnings),
        "taken": list(one.choice.made.names),
        "laws": [_law(law) for law in one.against],
    }  # fmt: skip


def _law(law: Against) -> dict[str, Any]:
    return {
        **vars(law.row), "bias_along_pressure": list(law.along_pressure),
        "bias_along_strain": list(law.along_strain), "misses": law.misses,
        "constants": {
            name: dict(zip(("value", "low", "high", "identifiable"), values, strict=True))
            for name, values in law.constants.items()
        },
    }  # fmt: skip


def _percent(share: float) -> str:
    return f"{share:.2%}" if math.isfinite(share) else "-"


def _finite(value: Any) -> Any:
    """The same with `None` where a number isn't finite."""
    if isinstance(value, dict):
        return {key: _finite(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def nothing() -> str:
    """What to say where no record is in reach [-]."""
    return (
        "no measured record is in reach: set"
        f" {VARIABLE} to a folder with CSV files, a muscle.toml beside each. {UNTESTED[0]}"
    )
