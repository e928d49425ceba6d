"""A calibration as the `[calibration]` of the fitted muscle's file.

Loading the file gives the muscle; `provenance` gives this back. Values are written with
their units, exactly, so that a program can read what a reader sees. The covariance is one
of coordinates, on which the parameters are free, in the order of their names.
"""

from collections.abc import Mapping
from typing import Any

from ..calibrate.calibration import Calibration, Estimate
from ..units import exact


def provenance_of(made: Calibration, date: str) -> dict[str, Any]:
    """Where the fitted muscle comes from.

    **Arguments:**

    - `made`: the calibration [-].
    - `date`: of the day it was made [-], such as "2026-05-04".

    **Returns:** text, numbers and lists by key, one level of tables deep [-], as `save`
    takes it.
    """
    from .. import __version__

    record = made.record
    return {
        "method": made.method,
        "date": date,
        "fascicle": __version__,
        "synthetic": record.synthetic,
        "status": made.status,
        "loss": made.problem.loss,
        "points": made.points,
        "censored": made.censored,
        "rmse": exact(made.rmse, "force"),
        "relative_rmse": made.relative_rmse,
        "noise": exact(float(made.problem.noise), "force"),
        "inflation": float(made.inflation),
        "rest_length": _rest_length(made),
        "warnings": list(made.warnings),
        "notes": list(record.notes),
        "coordinate_names": list(made.names),
        "coordinates": made.coordinates.tolist(),
        "covariance": made.covariance.tolist(),
        "laws": laws_of(made),
        "record": [{"file": one.name, "sha256": one.sha256} for one in record.sources],
        "parameter": [_parameter(one) for one in made.parameters],
    }


def laws_of(made: Calibration) -> dict[str, str]:
    """The names of the laws [-] that were fitted, by kind, of a calibration [-]."""
    kinds = ("tension", "buckling", "collapse", "post_collapse")
    return {kind: str(getattr(made.muscle, kind).name) for kind in kinds}


def _rest_length(made: Calibration) -> str:
    """What the record's strains refer to."""
    if made.record.rest_length is None:
        return "the muscle's own length"
    return exact(made.record.rest_length, "length")


def _parameter(one: Estimate) -> Mapping[str, Any]:
    return {
        "name": one.name,
        "value": exact(one.value, one.dimension),
        "low": exact(one.low, one.dimension),
        "high": exact(one.high, one.dimension),
        "prior": exact(one.start, one.dimension),
        "identifiable": one.identifiable,
    }
