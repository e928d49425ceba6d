"""Text of a calibration on the terminal: a verdict of a few lines, and the details."""

import math
import textwrap
from typing import TYPE_CHECKING

from ..io.sanitize import escape_invisible
from ..units import pretty
from .outputs import print_line, print_table


if TYPE_CHECKING:
    from ..calibrate.calibration import Selection
    from ..reports.calibration import CalibrationResult

_LABEL_WIDTH = 35  # characters: a table fits next to it
# in notes without a doubt
_CERTAIN = (" read as ", " read with it", ": note: ", ": source: ", "columns not read",
            "all readings at ", "corrected for ", "its name gives ",
            "lines above the header", "time from X0")  # fmt: skip
_DOUBTS = 3  # in a line that is still read
_LINES = 10  # of a verdict with the constants: more are not read
_SHARE = "errors over the largest force"
_CRITERIA = (
    "left-out error: at pressures left out of the fit; pull at clipped: largest pull of the law"
    " where a reading is clipped; AIC, BIC: by the likelihood of all readings, also of clipped ones"
)


def print_calibration(result: "CalibrationResult", verbose: bool) -> None:
    """Print the verdict and the constants; with `verbose`, all tables and warnings."""
    from ..calibrate.verdict import constant_rows, gauge_errors, judge, verdict_lines

    fit = result.fit
    first, last = verdict_lines(fit, judge(fit, result.choice))
    # how columns were read is in the report, unless a choice is doubtful; so are a file's own notes
    doubts = [n for n in fit.record.notes if not any(text in n for text in _CERTAIN)]
    gauges = [f"{text[0].lower()}{text[1:]}" for text in gauge_errors(fit).values()]
    doubts = [*gauges, *result.remarks, *doubts]
    if doubts:
        remainder = f"; {len(doubts) - _DOUBTS} more in the report" if len(doubts) > _DOUBTS else ""
        last.insert(0, f"Check: {'; '.join(doubts[:_DOUBTS])}{remainder}.")
    for line in first:
        print_line(line)
    # the verdict names the others, and the report has them
    rows = constant_rows(tuple(e for e in fit.parameters if e.identifiable and not e.bound))
    count = len(result.choice.candidates) if result.choice is not None else 0
    chosen = f", best of {count} candidate sets," if count else ""
    method = "linear approximation" if fit.bootstrapped is None else "bootstrap"
    if rows:
        print(f"Constants{chosen} with 90 % intervals ({method}):")
    elif fit.parameters:
        print(f"Constants{chosen.rstrip(',')}: the data determine none of them.")
    else:
        print(f"Constants: as given{chosen.rstrip(',')}; none was fitted.")
    last += _analysis_lines(result)
    # with the heading of the constants, and the line on the files that were written
    room = len(rows) if verbose else max(_LINES - len(first) - len(last) - 2, 1)
    shown = rows if len(rows) <= room else rows[: room - 1]
    widths = [max((len(row[i]) for row in shown), default=0) for i in range(2)]
    for name, value, interval in shown:
        print(escape_invisible(f"  {name:<{widths[0]}}  {value:>{widths[1]}}  {interval}"))
    if further := [f"{name} {value} ({interval})" for name, value, interval in rows[len(shown) :]]:
        print(escape_invisible(f"  {'also ' if shown else ''}{', '.join(further)}"))
    for line in last:
        print_line(line)
    if verbose:
        _print_details(result)


def _analysis_lines(result: "CalibrationResult") -> list[str]:
    """Lines on a comparison of laws and on samples of the posterior."""
    lines = []
    if result.comparison is not None:
        best = result.comparison.rows[0]
        lines.append(
            f"Best of {len(result.comparison.rows)} laws, by AIC: {best.label}, error"
            f" {pretty(best.rmse, 'force', 3)}."
        )
    if (posterior := result.posterior) is not None:
        converged = "converged" if posterior.agrees else "not converged yet"
        lines.append(
            f"Posterior: {converged}, R-hat up to {max(posterior.r_hat):.4f}, effective sample size"
            f" {min(posterior.ess):.0f}, {posterior.divergences} divergences."
        )
    return lines


def _print_details(result: "CalibrationResult") -> None:
    """Print how readings were read, the candidates, the compared laws, and all warnings."""
    from ..calibrate import messages

    fit = result.fit
    for line in (*fit.record.notes, *messages.fit_data_lines(fit.fit_data)):
        print_line(line)
    if result.choice is not None:
        _print_choice(result.choice)
    if result.comparison is not None:
        rows = [
            [textwrap.fill(row.label, _LABEL_WIDTH), str(row.free), f"{row.rmse:.4g}",
             f"{row.left_out_rmse:.4g}", f"{row.clipped_pull:.4g}", f"{row.aic:.1f}",
             f"{row.bic:.1f}"]
            for row in result.comparison.rows
        ]  # fmt: skip
        heads = ["law", "fitted constants", "rms error [N]", "left-out error [N]",
                 "pull at clipped [N]", "AIC", "BIC"]  # fmt: skip
        print_table("Laws compared", heads, rows, _CRITERIA)
    print_line(f"Search: {fit.status}.")
    print_line(f"Intervals: {fit.intervals}.")
    if fit.loop is not None:
        print_line(messages.hysteresis_message(fit))
    for topic, lines in fit.warnings_by_topic.items():
        print_line(f"Warnings ({topic}):")
        for line in lines:
            print_line(f"- {line}")


def _print_choice(choice: "Selection") -> None:
    """Print the candidates, and the reasons for the selected one."""

    def percent(fraction: float) -> str:
        """Text of a fraction in percent; "-" if it isn't finite."""
        return f"{100 * fraction:.3g}" if math.isfinite(fraction) else "-"

    titles = {"pulling": "readings that pull", "all": "all readings"}
    for readings, title in titles.items():
        rows = [
            [textwrap.fill(candidate.label, _LABEL_WIDTH), str(candidate.constants),
             percent(candidate.relative_rmse), percent(candidate.relative_left_out_rmse),
             "selected" if candidate.chosen else ""]
            for candidate in choice.candidates
            if candidate.readings == readings
        ]  # fmt: skip
        if rows:
            heads = ["fitted constants", "number", "rms error [%]", "cross-validated error [%]", ""]
            print_table(f"Candidates, fitted to {title}", heads, rows, _SHARE)
    for line in choice.reasons:
        print_line(line)
