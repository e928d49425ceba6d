"""File of a calibration: the fitted muscle with its fit in `[calibration]`.

A muscle's numbers are rounded to `_DIGITS`: that changes a force by a millionth, a thousandth of a
measurement's scatter. Coordinates and covariance keep all digits: of nearly dependent constants a
rounded covariance is useless.
"""

import os
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..calibrate.calibration import Calibration, Estimate
from ..calibrate.findings import calibration_findings
from ..calibrate.gauges import DIMENSIONS as GAUGE_DIMENSIONS
from ..calibrate.parameters import put, select_parameters
from ..core.module import tree_map, with_fields
from ..muscle import Muscle
from ..muscle.laws import LAWS
from ..units import DIMENSIONS, exact, parse, pretty
from .muscle_files import dumps, load_muscle, provenance


_DIGITS = 7  # of a fitted muscle's numbers
_INTERVAL_DIGITS = 6  # of constants and their intervals
_ERROR_DIGITS = 4  # of an error, a noise or a width: none is known to a ten-thousandth


def calibrated_text(
    calibration: Calibration, date: str, warnings: Sequence[str] = (), notes: Sequence[str] = ()
) -> str:
    """Text of a fitted muscle's file; arguments as for `provenance_of`."""
    muscle = rounded_muscle(calibration.muscle)
    table = provenance_of(calibration, date, warnings, notes)
    table["fitted_length"] = exact(float(muscle.length), "length")
    return dumps(muscle, table)


def provenance_of(
    calibration: Calibration, date: str, warnings: Sequence[str] = (), notes: Sequence[str] = ()
) -> dict[str, Any]:
    """Provenance of a fitted muscle for `save`: text, numbers and lists by key, one level of tables
    deep. `warnings`, and `notes` on the record: in words.
    """
    from .. import __version__

    record, diagnosis = calibration.record, calibration.diagnosis
    rest_length = "the muscle's own length"
    if record.rest_length is not None:
        rest_length = exact(record.rest_length, "length")
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
    }
    if faults := calibration.gauge.faults:
        table["gauge"] = {key: exact(x, GAUGE_DIMENSIONS[key]) for key, x in faults.items()}
    if (loop := calibration.loop) is not None:
        table["hysteresis"] = {
            "pressure": [pretty(float(x), "pressure", _ERROR_DIGITS) for x in loop.pressure],
            "width": [_force_text(x) for x in loop.width],
            "half": _force_text(loop.half),
            **_springs(calibration),
        }
    if damping := _damping(calibration):
        table["damping"] = damping
    return table


def laws_of(calibration: Calibration) -> dict[str, str]:
    """Names of the fitted laws, by kind."""
    return {kind: str(getattr(calibration.muscle, kind).name) for kind in LAWS}


def rounded_muscle(muscle: Muscle) -> Muscle:
    """The fitted muscle as its file has it."""

    def short(value: Any) -> Any:
        values = np.asarray(value)
        if values.dtype.kind != "f":
            return value
        return np.vectorize(lambda x: float(f"{x:.{_DIGITS}g}"), otypes=[float])(values)[()]

    rounded: Muscle = tree_map(short, muscle)
    # the angle in degrees, as it is written
    degrees = float(muscle.braid_angle) / float(DIMENSIONS["angle"].factors["deg"])
    return with_fields(rounded, braid_angle=parse(f"{degrees:.{_DIGITS}g} deg", "angle"))


def sample_muscles(path: str | os.PathLike[str], draws: int = 1000, seed: int = 0) -> Muscle:
    """Muscle with draws of its calibrated constants, on the first axis of all its numbers, normally
    distributed in the fitted coordinates; those that the data don't determine stay as fitted.

    `path`: the muscle file of `fascicle calibrate`; `ValueError` for one without a calibration.
    """
    muscle, table = load_muscle(path), provenance(path)
    if not isinstance(muscle, Muscle) or "covariance" not in table:
        rule = "has no [calibration] with a covariance to draw from."
        raise ValueError(f"{os.fspath(path)}: {rule}")
    names = list(table["coordinate_names"])
    parameters = select_parameters(names, muscle)
    center, covariance = np.array(table["coordinates"]), np.array(table["covariance"])
    unknown = {row["name"] for row in table.get("parameter", ()) if not row["identifiable"]}
    determined = np.array([name not in unknown for name in names])
    covariance = np.where(np.outer(determined, determined), covariance, 0.0)
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
    """Table of a fitted constant."""
    ends = {"value": "value", "low": "low", "high": "high", "prior": "start"}
    table = {
        key: pretty(getattr(estimate, name), estimate.dimension, _INTERVAL_DIGITS)
        for key, name in ends.items()
    }
    return {"name": estimate.name, **table, "identifiable": estimate.identifiable}


def _force_text(force: Any) -> str:
    """Text of a `force` [N] with the digits of a calibration's error."""
    return pretty(float(force), "force", _ERROR_DIGITS)


def _rounded(number: float) -> float:
    return float(f"{number:.{_ERROR_DIGITS}g}")
