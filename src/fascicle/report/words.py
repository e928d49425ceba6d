"""Words of findings: what is so and what to do, by code; numbers in readable units.

A catalogue has a `Part` for each code. Those of calibrations and designs stand beside their words.
"""

import string
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from ..core.findings import Finding, Severity
from ..core.validation import distinct_texts
from ..records.headers import dimension_of
from ..records.record import Record
from ..units import DIMENSIONS, pretty


_NO_CROSSING = "no crossing without a dip exists, hand_over acts as threshold: "
_SWINGS = (
    "`pressure_time` of {pressure_time:.4g} s is too fast: valves, measurements and samples are"
    " {lateness:.4g} s late, and pressures will swing; "
)
_EVENT = "{code} from {first:.4g} s to {last:.4g} s: "


def _excluded(data: Mapping[str, Any]) -> str:
    """Why a product must not be used."""
    demand, scale, unit = "supply has", 1e-3, "kPa"
    if data["quantity"] == "strain":
        demand, scale, unit = "task demands a contraction of", 100.0, "%"
    value, largest = distinct_texts(scale * data["value"], scale * data["largest"])
    return (
        f"{data['product']} must not be used: the {demand} {value} {unit}, its maker allows"
        f" {largest} {unit}"
    )


def _not_held(data: Mapping[str, Any]) -> str:
    """Why a free load moves under a demand of force."""
    least, most, lowest, highest = (
        f"{data[key]:.4g} {data['unit']}" for key in ("least", "most", "lowest", "highest")
    )
    own = least if least == most else f"{least} to {most}"
    return (
        f"the load is free and holds {own} at rest: under demands from {lowest} to {highest} it"
        " runs away; demand a position, or hold the load by a prescribed motion"
    )


Part = str | Callable[[Mapping[str, Any]], str]  # a format, or a function of a finding's data
_CATALOGUE: dict[str, Part] = {
    "run.unbalanced": "the {balance} doesn't close: its residual is {residual:.1e} of its largest"
    " term, more than {tolerance:g}",
    "run.volume_not_conjugate": "{energy:.3g} J in the {balance} are made by the volume: the"
    " straight braid's doesn't go with the force, take volume = \"conjugate\"",
    "run.folded": _EVENT + "a muscle's volume fell with pressure by more than its fluid and hose"
    " expand: its pressure isn't unique; give the chamber more dead volume or compliance",
    "run.cavitates": _EVENT + "a unit was sucked empty: its fluid can't follow",
    "run.off_table": _EVENT + "a strain or pressure left the muscles' tables; forces go on linearly"
    " there",
    "run.unsettled": _EVENT + "a pressure wasn't found to rounding in two steps; take a smaller"
    " `dt`",
    "run.supply_empty": _EVENT + "the supply has nothing left to give",
    "run.stop": _EVENT + "the load touched its stop",
    "run.stiff": _EVENT + "it would have needed more than 64 substeps; take a smaller `dt`",
    "run.broken": _EVENT + "numbers are not finite; take a smaller `dt`",
    "scenario.command_after_end": "the command at {time:.4g} s never comes: the run ends at"
    " {end:.4g} s",
    "scenario.command_delayed": "the command at {time:.4g} s comes with the next step, at"
    " {step:.4g} s",
    "muscle.pressure_extrapolated": "{muscle}: a pressure of {value:pressure} is an extrapolation,"
    " it was measured up to {measured:pressure}",
    "muscle.strain_extrapolated": "{muscle}: a contraction of {value:strain} is an extrapolation,"
    " it was measured up to {measured:strain}",
    "muscle.length_extrapolated": "{muscle}: a length of {value:length} is an extrapolation, it was"
    " fitted at {measured:length}",
    "design.product_excluded": _excluded,
    "design.judged_in_part": "only {judged} designs were judged in draws",
    "product.length_unavailable": "{product} isn't made {lengths:lengths} long, but from"
    " {shortest:length} to {longest:longest}",
    "product.parts_borrowed": "{products:list} have {parts:keys} of {muscle}",
    "control.pressure_time_short": _SWINGS + "take {stable:.4g} s, or leave it out",
    "control.dead_time_undeclared": _SWINGS + "declare the valves' dead time: `delay` of"
    " {dead_time:.4g} s",
    "control.force_not_held": _not_held,
    "control.position_gain_high": "`position_gain` of {gain:stiffness} is too high: about a"
    " position of {position:length} the load may swing from {limit:stiffness} on; take half"
    " of that",
    "crossing.not_needed": _NO_CROSSING + "the units before unit {unit} can hold all of the path,"
    " at least {reserve:.4g} N are left",
    "crossing.too_late": _NO_CROSSING + "the units before unit {unit} can't hold the path's"
    " beginning: {shortfall:.4g} N are missing",
    "crossing.no_gain": _NO_CROSSING + "unit {unit} gains nothing at these strains up to the"
    " supply's pressure",
    "crossing.dip_too_deep": _NO_CROSSING + "the units before unit {unit} can spare {reserve:.4g} N"
    " at most where the dip is {dip:.4g} N deep",
    "crossing.valves_too_slow": _NO_CROSSING + "the valves are too slow: the units before unit"
    " {unit} can spare the dip's {dip:.4g} N only while the demand is lower than when the hand-over"
    " would be over",
}


def _column(data: Mapping[str, Any]) -> str:
    """How a column of a record was read."""
    text = f"column `{data['header']}` read as {data['role'].replace('_', ' ')}"
    text += f" in {data['unit'] or 'fractions'}" if data["has_unit"] else ""
    text += f" as given, not in {data['replaced_unit']}" if data["replaced_unit"] else ""
    text += ", its sign turned" if data["sign"] < 0 else ""
    return text + (", less the atmosphere" if data["absolute"] else "")


_RECORD: dict[str, Part] = {
    "sidecar": "{sidecar} read with it",
    "sidecar_beside": "{sidecar} beside it read",
    "sidecar_of_muscle": "{sidecar} beside it not read: it describes a muscle",
    "name": "its name gives {values:quantities}",
    "constants": "all readings at {values:quantities}",
    "rest_length": "rest length {length:length} read from the file's comments",
    "default_length": "no rest length given: strains refer to the muscle's length, {length:length}",
    "weights": "column `{column}` holds masses in {unit}: the force is their weight",
    "unread_columns": "columns not read: {names:columns}",
    "unused_unit": "unit {unit!r} of {role} not used: there is no such column",
    "misread_column": "column `{column}` not read as {role}, its entries are unclear: if it is one,"
    " name the column",
    "rows_with_holes": "{count:row} with holes left out, the first in line {line}",
    "rows_of_words": "{count:row} of words left out, the first in line {line}",
    "resampled": "channels interpolated on one clock, every {step:g} s",
    "sampled_time": "time from X0 and Delta_X: a reading every {step:g} s",
    "time_is_date": "time is a date in {unit}, not in s",
    "time_goes_back": "time goes back in line {line}",
    "short_arms": "{count:reading} left out: the moment arm is below {least:percent} of the"
    " largest, {largest:length}",
    "pressures_below_zero": "{count} pressures below zero, down to {lowest:.3g} Pa, set to 0",
    "atmosphere": "the lowest pressure is {lowest:pressure}: if that is the atmosphere, give it to"
    " subtract it",
    "no_pull": 'no reading pulls: if they do, signs.force is "pushing positive"',
    "clipped": "{count} of {readings} readings clipped",
    "zero_forces": "{count} forces are exactly 0: if the gauge can't push, they are clipped at"
    " zero",
    "stretched": "{count} readings stretched beyond rest, down to {lowest:.3g}",
    "displaced": "all displacements are beyond {nearest}: if it is 0 there, give {nearest} as zero",
    "duplicates": "{first} and {second} hold the same readings, which count twice: leave one out",
    "averaged": "hysteresis averaged: {loops} of {levels} levels have both branches",
    "ramps": "{count} readings of ramps between sweeps left out of the fit",
    "column": _column,
}


def list_text(words: Sequence[str]) -> str:
    """Enumeration with commas and "and"."""
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last


def count_text(number: int, noun: str) -> str:
    """A number of things, in words."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


_FORMATS: dict[str, Callable[[Any], str]] = {
    "list": list_text,
    "keys": lambda names: list_text([name.replace("_", " ") for name in names]),
    "lengths": lambda lengths: list_text([pretty(x, "length") for x in lengths]),
    "longest": lambda length: "any length" if length is None else pretty(length, "length"),
    "percent": lambda share: f"{100 * share:.2g} %",
    "row": lambda number: count_text(number, "row"),
    "reading": lambda number: count_text(number, "reading"),
    "columns": lambda names: ", ".join(f"`{name}`" for name in names),
    "quantities": lambda values: ", ".join(
        f"{role} {pretty(value, dimension_of(role))}" for role, value in values.items()
    ),
}


class Formatter(string.Formatter):
    """Formats `{value:force}` in units, `{names:list}`, `{share:percent}` and other `_FORMATS`."""

    def format_field(self, value: Any, format_spec: str) -> str:
        if format_spec in DIMENSIONS:
            return pretty(value, format_spec, 3)
        if format_spec in _FORMATS:
            return _FORMATS[format_spec](value)
        return str(super().format_field(value, format_spec))


def render(part: Part, data: Mapping[str, Any]) -> str:
    """Text of a catalogue's `part`."""
    return part(data) if callable(part) else Formatter().vformat(part, (), data)


def notes(findings: Iterable[Finding]) -> list[str]:
    """Findings that are no errors, a sentence each."""
    return [f"{words(each)}." for each in findings if each.severity is not Severity.ERROR]


def words(finding: Finding) -> str:
    """A finding in words, without a full stop."""
    return render(
        _CATALOGUE[finding.code], {"code": finding.code.partition(".")[2], **finding.data}
    )


def record_lines(record: Record) -> list[str]:
    """How a record was read and what to check, then what people wrote of it, a line each."""
    return [*map(_record_line, record.findings), *record.notes]


def record_doubts(record: Record) -> list[str]:
    """What to check in a record, a line each."""
    return [_record_line(x) for x in record.findings if x.severity is Severity.WARNING]


def _record_line(finding: Finding) -> str:
    """Words of a record's finding, after the name of its file."""
    text = render(_RECORD[finding.code.removeprefix("record.")], finding.data)
    return f"{finding.data['file']}: {text}" if "file" in finding.data else text
