"""A calibration as the `[calibration]` of the fitted muscle's file.

Loading the file gives the muscle; `provenance` gives this back. Values are written with
their units, exactly, so that a program can read what a reader sees. The covariance is one
of coordinates, on which the parameters are free, in the order of their names.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..calibrate.after.calibration import Calibration, Estimate
from ..calibrate.after.friction import Friction
from ..units import exact
from .measured import NONE


if TYPE_CHECKING:
    from ..calibrate.fits.finding import Choice


def calibrated_text(made: Calibration, date: str, choice: "Choice | None" = None) -> str:
    """The fitted muscle's file, its numbers rounded to what is known of them.

    **Arguments:** those of `provenance_of` [-].

    **Returns:** the TOML [-]; its `[calibration]` says how far it was rounded.
    """
    from .rounding import as_known
    from .writing import dumps

    muscle, told = as_known(made)
    return dumps(muscle, provenance_of(made, date, choice) | {"rounded": told})


def provenance_of(made: Calibration, date: str, choice: "Choice | None" = None) -> dict[str, Any]:
    """Where the fitted muscle comes from.

    **Arguments:**

    - `made`: the calibration [-].
    - `date`: of the day it was made [-], such as "2026-05-04".
    - `choice`: what it was chosen from [-], or `None`.

    **Returns:** text, numbers and lists by key, one level of tables deep [-], as `save`
    takes it.
    """
    from .. import __version__

    record, loop = made.record, made.loop
    found = {
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
        "wider": made.wider.tolist(),
        "intervals": "quick" if made.bootstrapped is None else "bootstrap",
        "not_told": list(made.untold),
        "rest_length": _rest_length(made),
        "warnings": list(made.warnings),
        "notes": list(record.notes),
        "coordinate_names": list(made.names),
        "coordinates": made.coordinates.tolist(),
        "covariance": made.covariance.tolist(),
        "laws": laws_of(made),
        "record": [{"file": one.name, "sha256": one.sha256} for one in record.sources],
        "parameter": [_parameter(one) for one in made.parameters],
        "readings": made.taken.counts(),
        "residuals": [
            {"against": one.along, "share": one.share, "chance": one.chance, "noise": not one.found}
            for one in made.seen.trends
        ]
        + [
            {"against": f"signs along {one.along}", "pairs": one.pairs, "changes": one.changes,
             "chance": one.chance, "noise": not one.found}
            for one in made.seen.runs
        ],
    }  # fmt: skip
    if loop is not None:
        found["hysteresis"] = {
            "pressure": [exact(float(x), "pressure") for x in loop.pressure],
            "width": [exact(float(x), "force") for x in loop.width],
            "half": exact(loop.half, "force"),
            **_springs(made.friction),
        }
    if choice is not None:
        found["reasons"] = list(choice.reasons)
        found["candidate"] = [
            {
                "free": one.label, "numbers": one.constants, "rmse": one.rmse,
                "left_out_rmse": one.left_out_rmse, "on": one.readings, "taken": one.chosen,
            }
            for one in choice.candidates
        ]  # fmt: skip
    return found


def _springs(friction: Friction | None) -> dict[str, Any]:
    """What a scenario takes as its `[hysteresis]`."""
    if friction is None:
        return {}
    law = friction.law
    if law is None:
        return {"kind": NONE}
    numbers = {
        "stiffness": (law.stiffness, "stiffness"),
        "slip_force": (law.slip_force, "force"),
        "slip_force_slope": (law.slip_force_slope, "slip"),
    }
    springs = {key: [exact(float(x), unit) for x in row] for key, (row, unit) in numbers.items()}
    return {
        "kind": "maxwell_slip", **springs, "width_rmse": exact(friction.rmse, "force"),
        "told": list(friction.told),
    }  # fmt: skip


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
