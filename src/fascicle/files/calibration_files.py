"""Files of a calibration: the fitted muscle, and a log of the whole fit.

The muscle's numbers have as many digits as the data support: each fitted constant stays within
`_TOLERANCE` of the width of its interval, each reading's force within `_TOLERANCE` of the root mean
square residual; constants that weren't fitted stay as they were. Coordinates and covariance keep
all digits: of nearly dependent constants a rounded covariance is useless.
"""

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..calibrate.calibration import Calibration, Estimate
from ..calibrate.findings import calibration_findings
from ..calibrate.gauges import DIMENSIONS as GAUGE_DIMENSIONS
from ..calibrate.parameters import parameters_of, put, select_parameters
from ..calibrate.readings import static_force
from ..core.module import tree_leaves, tree_replace, with_fields
from ..muscle import Muscle
from ..muscle.laws import LAWS
from ..muscle.validation import END_PARAMETERS
from ..units import DIMENSIONS, exact, parse, pretty
from .muscle_files import calibration_text, dumps, load_muscle, provenance


if TYPE_CHECKING:
    from ..calibrate.model_selection import Selection


_TOLERANCE = 0.01  # of an interval, and of the residual: far below a measurement's scatter
_MIN_DIGITS = 3  # of a rounded number: fewer look like a guess
_MAX_DIGITS = 17  # every float is exact
_ERROR_DIGITS = 4  # of an error, a noise or a width: none is known to a ten-thousandth
_PRIOR_DIGITS = 10  # beyond the rounding of a coordinate's transformation
# keys of the log that the muscle file repeats
_SUMMARY = ("method", "date", "fascicle", "synthetic", "status", "points", "rmse", "relative_rmse",
            "rest_length", "fitted_length", "rounded", "warnings")  # fmt: skip


def calibrated_files(
    calibration: Calibration,
    date: str,
    choice: "Selection | None" = None,
    warnings: Sequence[str] = (),
    reasons: Sequence[str] = (),
    notes: Sequence[str] = (),
    with_log: bool = True,
) -> dict[str, str]:
    """Texts of "muscle.toml", with a summary in `[calibration]`, and of its log, "muscle.log.toml",
    by name; or of a muscle file that holds the log itself. Arguments as for `provenance_of`.
    """
    muscle, rounding = rounded_muscle(calibration)
    table = provenance_of(calibration, date, choice, warnings, reasons, notes)
    table |= {"fitted_length": exact(float(muscle.length), "length"), "rounded": rounding}
    if not with_log:
        return {"muscle.toml": dumps(muscle, table)}
    summary = {key: table[key] for key in _SUMMARY}
    if not END_PARAMETERS.isdisjoint(table["coordinate_names"]):
        summary["fitted_ends"] = True
    log = "muscle.log.toml"
    intervals = {row["name"]: [row["low"], row["high"]] for row in table["parameter"]}
    summary |= {"log": log, "intervals_of": intervals}
    text = f"format = 1\n\n{calibration_text(table)}"
    return {"muscle.toml": dumps(muscle, summary), log: text}


def provenance_of(
    calibration: Calibration,
    date: str,
    choice: "Selection | None" = None,
    warnings: Sequence[str] = (),
    reasons: Sequence[str] = (),
    notes: Sequence[str] = (),
) -> dict[str, Any]:
    """Provenance of a fitted muscle for `save`: text, numbers and lists by key, one level of tables
    deep. `choice`: the model selection that chose the fit; `warnings`, `reasons`, `notes` on the
    record: in words.
    """
    from .. import __version__

    record, diagnosis = calibration.record, calibration.diagnosis
    rest_length = "the muscle's own length"
    if record.rest_length is not None:
        rest_length = exact(record.rest_length, "length")
    residuals: list[dict[str, Any]] = []
    for trend in diagnosis.trends:
        numbers = {"share": _rounded(trend.share), "chance": _rounded(trend.chance)}
        residuals.append({"against": trend.along, **numbers, "noise": not trend.found})
    for run in diagnosis.runs:
        numbers = {"pairs": run.pairs, "changes": run.changes, "chance": _rounded(run.chance)}
        residuals.append({"against": f"signs along {run.along}", **numbers, "noise": not run.found})
    table = {
        "method": calibration.method,
        "date": date,
        "fascicle": __version__,
        "synthetic": record.synthetic,
        "status": calibration.status,
        "loss": calibration.problem.loss,
        "points": calibration.points,
        "censored": calibration.censored,
        "rmse": _force_text(calibration.rmse),
        "relative_rmse": _rounded(calibration.relative_rmse),
        "noise": _force_text(calibration.problem.noise),
        "inflation": _rounded(diagnosis.inflation),
        "wider": [_rounded(x) for x in calibration.wider.tolist()],
        "undetermined": list(diagnosis.confounded),
        "rest_length": rest_length,
        "fitted_length": exact(float(calibration.muscle.length), "length"),  # not rounded
        "findings": [finding.code for finding in calibration_findings(calibration)],
        "warnings": list(warnings),
        "notes": list(notes),
        "coordinate_names": list(calibration.names),
        "coordinates": calibration.coordinates.tolist(),
        "covariance": calibration.covariance.tolist(),
        "laws": laws_of(calibration),
        "record": [{"file": source.name, "sha256": source.sha256} for source in record.sources],
        "parameter": [_parameter(estimate) for estimate in calibration.parameters],
        "readings": calibration.fit_data.counts(),
        "residuals": residuals,
    }
    if faults := calibration.gauge.faults:
        table["gauge"] = {key: exact(x, GAUGE_DIMENSIONS[key]) for key, x in faults.items()}
    if channel_faults := calibration.fit_data.faults:
        table["channel_fault"] = [vars(fault) for fault in channel_faults]
    if (loop := calibration.loop) is not None:
        table["hysteresis"] = {
            "pressure": [pretty(float(x), "pressure", _ERROR_DIGITS) for x in loop.pressure],
            "width": [_force_text(x) for x in loop.width],
            "half": _force_text(loop.half),
            **_springs(calibration),
        }
    if damping := _damping(calibration):
        table["damping"] = damping
    if choice is not None:
        table["reasons"] = list(reasons)
        table["candidate"] = [
            {
                "free": ", ".join(row.names), "method": row.method, "numbers": row.constants,
                "rmse": _rounded(row.rmse), "left_out_rmse": _rounded(row.left_out_rmse),
                "on": row.readings, "chosen": row.chosen,
            }
            for row in choice.candidates
        ]  # fmt: skip
    return table


def laws_of(calibration: Calibration) -> dict[str, str]:
    """Names of the fitted laws, by kind."""
    return {kind: str(getattr(calibration.muscle, kind).name) for kind in LAWS}


def rounded_muscle(calibration: Calibration) -> tuple[Muscle, str]:
    """The fitted muscle as its file has it, and a description of the rounding."""
    leaves = [np.asarray(leaf) for leaf in tree_leaves(calibration.start)]
    unfitted = {x for leaf in leaves if leaf.dtype.kind == "f" for x in leaf.ravel().tolist()}
    for digits in range(_MIN_DIGITS, _MAX_DIGITS):
        muscle = _round_constants(calibration.muscle, unfitted, digits)
        deviation = _force_deviation(calibration, muscle)
        if deviation is not None:
            muscle = with_fields(muscle, fitted_length=calibration.muscle.fitted_length)
            about = f"no fitted constant is off by more than {_TOLERANCE:.0%} of its interval"
            force = f"no reading's force by more than {pretty(deviation, 'force', 2)}"
            return muscle, f"to {digits} digits: {about}, {force}"
    return calibration.muscle, "not rounded"


def sample_muscles(path: str | os.PathLike[str], draws: int = 1000, seed: int = 0) -> Muscle:
    """Muscle with draws of its calibrated constants, on the first axis of all its numbers, normally
    distributed in the fitted coordinates.

    `path`: the muscle file of `fascicle calibrate`; `ValueError` for one without a calibration.
    """
    muscle, table = load_muscle(path), provenance(path)
    if not isinstance(muscle, Muscle) or "covariance" not in table:
        rule = "has no [calibration] with a covariance to draw from."
        if "log" in table:
            rule = f"its log with the covariance, {table['log']}, isn't beside it."
        raise ValueError(f"{os.fspath(path)}: {rule}")
    names = list(table["coordinate_names"])
    parameters = select_parameters(names, muscle)
    center, covariance = np.array(table["coordinates"]), np.array(table["covariance"])
    # the parameters' order may differ from that of the names in the file
    order = [names.index(parameter.name) for parameter in parameters]
    z = np.random.default_rng(seed).multivariate_normal(center, covariance, draws)[:, order]
    from ..jax import jax

    return jax.vmap(lambda row: put(parameters, muscle, row))(jax.numpy.asarray(z))


def _springs(calibration: Calibration) -> dict[str, Any]:
    """Keys of a scenario's `[hysteresis]`, with the width's error and what is determined."""
    friction = calibration.friction
    if friction is None:
        return {}
    if friction.law is None:
        return {"kind": "none"}
    keys = {"stiffness": "stiffness", "slip_force": "force", "slip_force_slope": "slip"}
    springs: dict[str, Any] = {
        key: [pretty(float(x), unit, _ERROR_DIGITS) for x in getattr(friction.law, key)]
        for key, unit in keys.items()
    }
    springs["width_rmse"] = _force_text(friction.rmse)
    return {"kind": "maxwell_slip", **springs, "determined": list(friction.resolved)}


def _damping(calibration: Calibration) -> dict[str, Any]:
    """Keys of a scenario's `[damping]`; empty if it is unknown."""
    if len(calibration.damping.unknown) == 2:
        return {}
    if (law := calibration.damping.law) is None:
        return {"kind": "none"}
    units = dict.fromkeys(("shortening", "lengthening"), "damping")
    units |= {f"{way}_slope": "damping_slope" for way in units}
    texts = {k: pretty(float(getattr(law, k)), unit, _ERROR_DIGITS) for k, unit in units.items()}
    return {"kind": "viscous", **texts}


def _parameter(estimate: Estimate) -> dict[str, Any]:
    """Table of a fitted constant, in the fewest digits, at least three, that keep each number
    within `_TOLERANCE` of its interval's width.
    """
    dimension, tolerance = estimate.dimension, _TOLERANCE * (estimate.high - estimate.low)

    def text(value: float) -> str:
        for digits in range(_MIN_DIGITS, _MAX_DIGITS):
            rounded = pretty(value, dimension, digits)
            if abs(parse(rounded, dimension) - value) <= tolerance:
                return rounded
        return exact(value, dimension)

    table = {key: text(getattr(estimate, key)) for key in ("value", "low", "high")}
    prior = pretty(estimate.start, dimension, _PRIOR_DIGITS)
    return {"name": estimate.name, **table, "prior": prior, "identifiable": estimate.identifiable}


def _force_text(force: Any) -> str:
    """Text of a `force` [N] with the digits of a calibration's error."""
    return pretty(float(force), "force", _ERROR_DIGITS)


def _rounded(number: float) -> float:
    return float(f"{number:.{_ERROR_DIGITS}g}")


def _force_deviation(calibration: Calibration, muscle: Muscle) -> float | None:
    """Largest change of a reading's force by rounding [N]; `None` if that, or the change of a
    constant, is too large.
    """
    parameters = parameters_of(calibration.muscle)
    for estimate in calibration.parameters:
        if parameters[estimate.name].of_gauge:
            continue
        value = parameters[estimate.name].value
        change = abs(float(value(muscle)) - float(value(calibration.muscle)))
        if not change <= _TOLERANCE * (estimate.high - estimate.low):
            return None
    readings = calibration.record.pressure, calibration.record.strain
    rounded, fitted = (static_force(m, *readings) for m in (muscle, calibration.muscle))
    change = float(np.nanmax(np.abs(rounded - fitted)))
    return change if change <= _TOLERANCE * calibration.rmse else None


def _round_constants(muscle: Muscle, unfitted: set[float], digits: int) -> Muscle:
    """Round all numbers of a muscle but the `unfitted` ones."""
    leaves = []
    for leaf in tree_leaves(muscle):
        values = np.asarray(leaf)
        if values.dtype.kind == "f":
            short = [x if x in unfitted else float(f"{x:.{digits}g}") for x in values.flat]
            leaf = np.reshape(np.array(short, values.dtype), values.shape)[()]  # noqa: PLW2901
        leaves.append(leaf)
    rounded: Muscle = tree_replace(muscle, leaves)
    angle = float(muscle.braid_angle)
    if angle in unfitted:
        return rounded
    # in degrees, as it is written
    degrees = angle / float(DIMENSIONS["angle"].factors["deg"])
    return with_fields(rounded, braid_angle=parse(f"{degrees:.{digits}g} deg", "angle"))
