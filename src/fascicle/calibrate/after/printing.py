"""How a calibration prints: what was fitted, how well, how sure each constant is, what to know."""

from typing import Any

from ...repr_table import ReprTable
from ...units import pretty


def sheet(made: Any) -> ReprTable:
    """A calibration's constants with their intervals, its error and its warnings.

    **Arguments:** `made`: it [-].

    **Returns:** what is printed [-].
    """
    clipped = f", of which {made.censored} only say that it doesn't pull" if made.censored else ""
    facts = [
        ("method", made.method),
        ("fitted to", f"{made.points} readings{clipped}"),
        ("error, rms", f"{made.rmse:.3g} N, {100 * made.relative_rmse:.2g} % of the largest force"),
        ("best start", made.status),
        ("intervals", made.intervals),
    ]
    rows = [
        [
            one.name,
            *(pretty(x, one.dimension) for x in (one.value, one.low, one.high)),
            "yes" if one.identifiable else "no: as it began",
        ]
        for one in made.parameters
    ]
    heads = ("fitted", "value", "from, 90 %", "to", "told by the data")
    kind = "synthetic readings" if made.record.synthetic else "a record"
    return ReprTable(
        f"Calibration to {kind}", facts, heads, rows, [f"! {w}" for w in made.warnings]
    )


def choice_sheet(choice: Any) -> ReprTable:
    """A `choice`: the calibration that was taken, and why it was [-]."""
    of_made = sheet(choice.made)
    tried = f"{len(choice.candidates)} candidates" if choice.candidates else "none beside it"
    return of_made._replace(
        title=f"Choice: {of_made.title[0].lower()}{of_made.title[1:]}",
        facts=[*of_made.facts, ("tried", tried)],
        notes=[*choice.reasons, *of_made.notes],
    )
