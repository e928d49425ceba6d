"""Words of findings: what is so and what to do, by code; numbers in readable units.

Calibrations and designs have catalogues of their own, which need more than the finding.
"""

import string
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ..core.findings import Finding, Severity
from ..units import DIMENSIONS, pretty


_NO_CROSSING = "no crossing without a dip exists, hand_over acts as threshold: "
_SWINGS = (
    "`pressure_time` of {pressure_time:.4g} s is too fast: valves, measurements and samples are"
    " {lateness:.4g} s late, and pressures will swing; "
)
_EVENT = "{code} from {first:.4g} s to {last:.4g} s: "
_CATALOGUE = {
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
    "control.pressure_time_short": _SWINGS + "take {stable:.4g} s, or leave it out",
    "control.dead_time_undeclared": _SWINGS + "declare the valves' dead time: `delay` of"
    " {dead_time:.4g} s",
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


class Formatter(string.Formatter):
    """Formats `{value:force}` in units, `{names:list}` and `{share:percent}`."""

    def format_field(self, value: Any, format_spec: str) -> str:
        if format_spec in DIMENSIONS:
            return pretty(value, format_spec, 3)
        if format_spec == "list":
            return list_text(value)
        if format_spec == "percent":
            return f"{100 * value:.2g} %"
        return str(super().format_field(value, format_spec))


def list_text(words: Sequence[str]) -> str:
    """Enumeration with commas and "and"."""
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last


def notes(findings: Iterable[Finding]) -> list[str]:
    """Findings that are no errors, a sentence each."""
    return [f"{words(each)}." for each in findings if each.severity is not Severity.ERROR]


def words(finding: Finding) -> str:
    """A finding in words, without a full stop."""
    data: Mapping[str, Any] = {"code": finding.code.partition(".")[2], **finding.data}
    return Formatter().vformat(_CATALOGUE[finding.code], (), data)
