"""What `fascicle calibrate` found: printed, as JSON, and as a folder of files."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...units import pretty
from ..outputs import say


if TYPE_CHECKING:
    from ...calibrate.after.calibration import Calibration
    from ...calibrate.fits.finding import Choice


@dataclass(frozen=True)
class Found:
    """A calibration with all that was asked about it."""

    made: "Calibration"
    remarks: tuple[str, ...]
    choice: "Choice | None" = None
    profiles: tuple[Any, ...] = ()
    posterior: Any = None
    comparison: list[Any] = field(default_factory=list)
    figures: Mapping[str, Any] = field(default_factory=dict)

    def summary(self) -> dict[str, Any]:
        """What JSON shows, in SI units; what isn't finite is null."""
        made = self.made
        found = {
            "rmse": made.rmse,
            "relative_rmse": made.relative_rmse,
            "points": made.points,
            "censored": made.censored,
            "status": made.status,
            "parameters": {
                one.name: {
                    "value": one.value, "low": one.low, "high": one.high,
                    "identifiable": one.identifiable,
                    "bound": one.bound,
                }
                for one in made.parameters
            },
            "synthetic": made.record.synthetic,
            "method": made.method,
            "noise": float(made.problem.noise),
            "warnings": list(made.warnings),
            "notes": [*self.remarks, *made.record.notes],
            "starts": made.starts,
            "readings": made.taken.counts(),
            "trends": [
                {"along": one.along, "share": one.share, "chance": one.chance, "found": one.found}
                for one in made.seen.trends
            ],
            "runs": [vars(one) for one in made.seen.runs],
            "wider": dict(zip(made.names, made.wider.tolist(), strict=True)),
            "causes": [vars(one) for one in made.causes],
            "untold": list(made.untold),
            "loop": _loop(made.loop),
            "friction": _friction(made.friction),
            "intervals": "quick" if made.bootstrapped is None else "bootstrap",
        }  # fmt: skip
        if self.choice is not None:
            found["candidates"] = [
                {**vars(one), "names": list(one.names)} for one in self.choice.candidates
            ]
            found["reasons"] = list(self.choice.reasons)
        if self.profiles:
            found["profiles"] = {
                one.name: {"low": one.low, "high": one.high} for one in self.profiles
            }
        if self.posterior is not None:
            found["posterior"] = _posterior(self.posterior)
        if self.comparison:
            found["comparison"] = [vars(row) for row in self.comparison]
        return _finite(found)

    def show(self) -> None:
        """Print it for a reader."""
        from ..printed import show

        made = self.made
        if made.record.synthetic:
            print("synthetic: a model made these readings, no muscle was measured")
        # what was guessed is always shown; what a file remarks about itself is in the report
        for note in (*self.remarks, *(n for n in made.record.notes if ": note: " not in n)):
            say(note)
        say("; ".join(made.taken.words()))
        if self.choice is not None:
            self._show_choice()
        rows = [
            [
                one.name,
                *one.texts(),
                one.verdict,
            ]
            for one in made.parameters
        ]
        lost = any(one.verdict == "not known" for one in made.parameters)
        lines = ["not known: the data alone do not determine it"] if lost else []
        caption = "; ".join([f"intervals: {made.intervals}", *lines])
        if rows:
            show("Parameters", ["", "value", "90 % interval", ""], rows, caption)
        if self.comparison:
            rows = [
                [row.label, str(row.free), f"{row.rmse:.4g}", f"{row.left_out_rmse:.4g}",
                 f"{row.clipped_pull:.4g}", f"{row.aic:.1f}", f"{row.bic:.1f}"]
                for row in self.comparison
            ]  # fmt: skip
            heads = ["", "free", "rmse", "left out", "at clipped", "AIC", "BIC"]
            show("Laws, errors in N", heads, rows, _BY)
        if self.posterior is not None:
            good = "good enough" if self.posterior.agrees else "not good enough yet"
            print(
                f"posterior: draws {good}, R-hat to {max(self.posterior.r_hat):.4f}, worth"
                f" {min(self.posterior.ess):.0f} draws, {self.posterior.divergences} divergences"
            )
        print(
            f"{made.points} readings, {made.censored} of them clipped: rmse"
            f" {pretty(made.rmse, 'force')}, {100 * made.relative_rmse:.3g} % of the largest force;"
            f" {made.status}"
        )
        from ...calibrate.after.warned import hysteresis
        from ..printed import listed

        if made.loop is not None:
            say(hysteresis(made))
        for about, lines in made.warned.items():
            say(f"warning: {about}:")
            for line in lines:
                print(listed(line))

    def _show_choice(self) -> None:
        """What was tried, and why one of it was taken."""
        from textwrap import fill

        from ..printed import show

        assert self.choice is not None
        heads = ["", "free", "rmse", "left out", ""]
        for readings, title in _COMPARED.items():
            rows = [
                [fill(one.label, _WIDEST), str(one.constants), _percent(one.relative_rmse),
                 _percent(one.relative_left_out_rmse), "taken" if one.chosen else ""]
                for one in self.choice.candidates
                if one.readings == readings
            ]  # fmt: skip
            if rows:
                show(f"Tried on {title}: error over the largest force", heads, rows)
        for line in self.choice.reasons:
            say(line)

    def write(self, folder: Path, date: str, overwrite: bool) -> list[str]:
        """Write muscle, report and figures into `folder` [-]; `overwrite`: over others' too [-]."""
        from ...files.calibrated import calibrated_text
        from ...files.ours import write_folder
        from ...plot import to_bytes
        from ...reports.calibration import report

        made = self.made
        drawn = {name: to_bytes(figure, "svg") for name, figure in self.figures.items()}
        page = report(
            made, date, self.figures, self.profiles, self.posterior, self.comparison,
            remarks=self.remarks, drawn=drawn, choice=self.choice,
        )  # fmt: skip
        content = {
            "muscle.toml": calibrated_text(made, date, self.choice).encode(),
            "report.html": page.encode(),
        }
        for name, figure in self.figures.items():
            content[f"{name}.png"], content[f"{name}.svg"] = to_bytes(figure, "png"), drawn[name]

        def fill(draft: Path) -> None:
            for name, raw in content.items():
                (draft / name).write_bytes(raw)

        write_folder(folder, "calibrate", fill, overwrite)
        return [str(folder / name) for name in content]


_BY = (
    "AIC, BIC: by the likelihood of all readings, clipped ones too; at clipped: the most that a law"
    " pulls where a reading was clipped"
)
_WIDEST = 35  # characters of a label in a line, so that a table fits beside it
_COMPARED = {"pulling": "readings that pull", "all": "all readings"}


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %" if math.isfinite(share) else "-"


def _loop(loop: Any) -> dict[str, Any] | None:
    if loop is None:
        return None
    return {"pressure": loop.pressure.tolist(), "width": loop.width.tolist(),
            "share": loop.share.tolist(), "half": loop.half}  # fmt: skip


def _friction(friction: Any) -> dict[str, Any] | None:
    if friction is None:
        return None
    law, none = friction.law, {"stiffness": [], "slip_force": [], "slip_force_slope": []}
    springs = none if law is None else {name: getattr(law, name).tolist() for name in none}
    return {**springs, "breakaway": friction.breakaway.tolist(), "told": list(friction.told),
            "rmse": friction.rmse, "pressures": friction.pressures}  # fmt: skip


def _posterior(posterior: Any) -> dict[str, Any]:
    ends = posterior.interval()
    return {
        "agrees": posterior.agrees,
        "divergences": posterior.divergences,
        "parameters": {
            name: {
                "low": float(ends[i, 0]), "high": float(ends[i, 1]),
                "r_hat": float(posterior.r_hat[i]), "ess": float(posterior.ess[i]),
            }
            for i, name in enumerate(posterior.names)
        },
    }  # fmt: skip


def _finite(value: Any) -> Any:
    """The same, with `None` for numbers that JSON has none for."""
    if isinstance(value, dict):
        return {key: _finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(entry) for entry in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value
