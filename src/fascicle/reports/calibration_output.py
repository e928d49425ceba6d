"""Outputs of a calibration: the files of its folder, its JSON, and a notebook of the fit."""

import json
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..calibrate.calibration import Calibration, Profile, Selection
from ..calibrate.plot_data import curves_csv, figures
from ..calibrate.verdict import constant_rows, judge, verdict_lines
from ..files.calibration_files import calibrated_files
from ..plot import to_bytes
from ..records.record import dumps as record_text
from .calibration import report


if TYPE_CHECKING:
    from ..calibrate.comparison import LawComparison
    from ..calibrate.posterior import Posterior


class CalibrationResult(NamedTuple):
    """A calibration, how it was selected, and its optional analyses."""

    fit: Calibration
    choice: Selection | None = None
    remarks: tuple[str, ...] = ()
    profiles: tuple[Profile, ...] = ()
    posterior: "Posterior | None" = None
    comparison: "LawComparison | None" = None


def output_files(
    result: CalibrationResult, date: str, with_notebook: bool = False
) -> dict[str, bytes]:
    """Content of a calibration's files, by name: muscle, log, report, curves and figures.

    `with_notebook`: also a notebook, and the record that it reads.
    """
    fit, comparison = result.fit, result.comparison
    drawings = figures(fit, result.profiles, result.posterior, comparison)
    drawn = {name: to_bytes(figure, "svg") for name, figure in drawings.items()}
    page = report(
        fit, date, drawings, result.profiles, result.posterior,
        [] if comparison is None else comparison.rows,
        remarks=result.remarks, drawn=drawn, choice=result.choice,
    )  # fmt: skip
    texts = calibrated_files(fit, date, result.choice)
    texts |= {"report.html": page, "curves.csv": curves_csv(fit, result.posterior)}
    if with_notebook:
        texts |= {"record.csv": record_text(fit.record), "fit.ipynb": notebook(result)}
    content = {name: text.encode() for name, text in texts.items()}
    for name, figure in drawings.items():
        content |= {f"{name}.png": to_bytes(figure, "png"), f"{name}.svg": drawn[name]}
    return content


def notebook(result: CalibrationResult) -> str:
    """Notebook that draws a calibration's record, curves and residuals, as JSON.

    It reads `record.csv`, `muscle.toml` and `curves.csv` beside it.
    """
    first, last = verdict_lines(result.fit, judge(result.fit, result.choice))
    rows = ["| constant | value | 90 % interval |", "|---|---|---|"]
    rows += [f"| `{name}` | {value} | {interval} |" for name, value, interval in
             constant_rows(result.fit.parameters)]  # fmt: skip
    names = ", ".join(source.name for source in result.fit.record.sources) or "a record"
    text = "\n\n".join([f"# Calibration: {names}", *first, "\n".join(rows), *last])
    cells = [
        {"cell_type": "markdown", "id": "verdict", "metadata": {}, "source": text},
        *(
            {"cell_type": "code", "id": name, "metadata": {}, "source": source,
             "execution_count": None, "outputs": []}
            for name, source in _CELLS.items()
        ),
    ]  # fmt: skip
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    content = {
        "cells": cells, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5
    }  # fmt: skip
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


# code of the notebook, by the cell's name
_CELLS = {
    "load": """\
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import fascicle as fs

record = fs.records.load("record.csv")
muscle = fs.load("muscle.toml")
curves = pd.read_csv("curves.csv")
muscle""",
    "curves": """\
figure, ax = plt.subplots()
points = ax.scatter(record.strain, record.force, s=8, c=record.pressure / 1e3, cmap="viridis")
for pressure, curve in curves.groupby("pressure [kPa]"):
    color = points.to_rgba(pressure)
    ax.plot(curve["strain [-]"], curve["force [N]"], color=color, lw=1)
    low, high = curve["low [N]"], curve["high [N]"]
    ax.fill_between(curve["strain [-]"], low, high, color=color, alpha=0.1)
figure.colorbar(points, label="Pressure [kPa]")
ax.set(xlabel="Contraction [-]", ylabel="Force [N]", title="Readings, fit, and 90 % of readings")
plt.show()""",
    "residuals": """\
# contractions of the record refer to its rest length
strain = record.strain * ((record.rest_length or float(muscle.length)) / float(muscle.length))
force = np.asarray(muscle.force(record.pressure, strain))
residual = np.where(record.censored, np.nan, record.force - force)
x, label = (record.strain, "Contraction [-]") if record.time is None else (record.time, "Time [s]")
figure, ax = plt.subplots()
points = ax.scatter(x, residual, s=8, c=record.pressure / 1e3, cmap="viridis")
ax.axhline(0, color="0.5", lw=0.8)
figure.colorbar(points, label="Pressure [kPa]")
ax.set(xlabel=label, ylabel="Measured less fitted force [N]")
plt.show()
print(f"root mean square error: {np.sqrt(np.nanmean(residual**2)):.4g} N")""",
}


def summary(result: CalibrationResult) -> dict[str, Any]:
    """JSON of a calibration, in SI units."""

    def pick(source: Any, *names: str) -> dict[str, Any]:
        values = {name: getattr(source, name) for name in names}
        return {
            name: value.tolist() if isinstance(value, np.ndarray | np.generic) else value
            for name, value in values.items()
        }

    fit, diagnosis = result.fit, result.fit.diagnosis
    content = {
        **pick(fit, "rmse", "relative_rmse", "points", "censored", "status"),
        "parameters": {
            p.name: pick(p, "value", "low", "high", "identifiable", "bound") for p in fit.parameters
        },
        "verdict": vars(judge(fit, result.choice)),
        "synthetic": fit.record.synthetic,
        "method": fit.method,
        "noise": float(fit.problem.noise),
        "warnings": list(fit.warnings),
        "notes": [*result.remarks, *fit.record.notes],
        "starts": fit.starts,
        "readings": fit.fit_data.counts(),
        "trends": [pick(trend, "along", "share", "chance", "found") for trend in diagnosis.trends],
        "runs": [vars(run) for run in diagnosis.runs],
        "wider": dict(zip(fit.names, fit.wider.tolist(), strict=True)),
        "causes": [vars(cause) for cause in diagnosis.causes],
        "untold": list(diagnosis.confounded),
        "gauge": fit.gauge.faults,
        "channel_faults": [vars(fault) for fault in fit.fit_data.faults],
        "loop": None if fit.loop is None else pick(fit.loop, "pressure", "width", "share", "half"),
        "friction": None,
        "intervals": "quick" if fit.bootstrapped is None else "bootstrap",
    }
    if (friction := fit.friction) is not None:
        springs = ("stiffness", "slip_force", "slip_force_slope")
        law = friction.law
        content["friction"] = {
            **({name: [] for name in springs} if law is None else pick(law, *springs)),
            "told": list(friction.resolved),
            **pick(friction, "breakaway", "rmse", "pressures"),
        }  # fmt: skip
    if (choice := result.choice) is not None:
        content["candidates"] = [
            vars(candidate) | {"names": list(candidate.names)} for candidate in choice.candidates
        ]
        content["reasons"] = list(choice.reasons)
    if result.profiles:
        content["profiles"] = {p.name: pick(p, "low", "high") for p in result.profiles}
    if (posterior := result.posterior) is not None:
        columns = (posterior.names, posterior.interval(), posterior.r_hat, posterior.ess)
        content["posterior"] = {
            **pick(posterior, "agrees", "divergences"),
            "parameters": {
                name: {"low": float(low), "high": float(high), "r_hat": float(r_hat),
                       "ess": float(ess)}
                for name, (low, high), r_hat, ess in zip(*columns, strict=True)
            },
        }  # fmt: skip
    if result.comparison is not None:
        content["comparison"] = [vars(row) for row in result.comparison.rows]
    return content
