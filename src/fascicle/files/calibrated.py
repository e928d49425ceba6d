"""A calibration as the `[calibration]` of the fitted muscle's file.

Loading the file gives the muscle; `provenance` gives this back. Values are written with
their units, so that a program can read what a reader sees, and with as many digits as are known
of them. The coordinates and their covariance, in the order of the parameters' names, keep all of
theirs: they belong together, and of nearly dependent constants a covariance that is rounded is
none.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..calibrate.after.calibration import Calibration, Estimate
from ..calibrate.after.friction import Friction
from ..muscle.laws import LAWS
from ..units import exact, pretty
from .measured import NONE
from .rounding import as_known, told


if TYPE_CHECKING:
    from ..calibrate.fits.finding import Choice


_ERROR = 4  # digits of an error, a noise or a width: none is known to a ten-thousandth
_GIVEN = 10  # digits of what was given, past what going to a coordinate and back rounds


def calibrated_text(made: Calibration, date: str, choice: "Choice | None" = None) -> str:
    """The fitted muscle's file, its numbers rounded to what is known of them.

    **Arguments:** those of `provenance_of` [-].

    **Returns:** the TOML [-]; its `[calibration]` says how far it was rounded.
    """
    from .writing import dumps

    muscle, how = as_known(made)
    of = provenance_of(made, date, choice)
    own = {"fitted_length": exact(float(muscle.length), "length"), "rounded": how}
    return dumps(muscle, of | own)


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
        "rmse": pretty(made.rmse, "force", _ERROR),
        "relative_rmse": _short(made.relative_rmse),
        "noise": pretty(float(made.problem.noise), "force", _ERROR),
        "inflation": _short(made.inflation),
        "wider": [_short(x) for x in made.wider.tolist()],
        "intervals": "quick" if made.bootstrapped is None else "bootstrap",
        "not_told": list(made.untold),
        "rest_length": _rest_length(made),
        "fitted_length": exact(float(made.muscle.length), "length"),
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
            {"against": one.along, "share": _short(one.share), "chance": _short(one.chance),
             "noise": not one.found}
            for one in made.seen.trends
        ]
        + [
            {"against": f"signs along {one.along}", "pairs": one.pairs, "changes": one.changes,
             "chance": _short(one.chance), "noise": not one.found}
            for one in made.seen.runs
        ],
    }  # fmt: skip
    if loop is not None:
        found["hysteresis"] = {
            "pressure": [pretty(float(x), "pressure", _ERROR) for x in loop.pressure],
            "width": [pretty(float(x), "force", _ERROR) for x in loop.width],
            "half": pretty(loop.half, "force", _ERROR),
            **_springs(made.friction),
        }
    if choice is not None:
        found["reasons"] = list(choice.reasons)
        found["candidate"] = [
            {
                "free": one.label, "numbers": one.constants, "rmse": _short(one.rmse),
                "left_out_rmse": _short(one.left_out_rmse), "on": one.readings,
                "taken": one.chosen,
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
    springs = {
        key: [pretty(float(x), unit, _ERROR) for x in row] for key, (row, unit) in numbers.items()
    }
    return {
        "kind": "maxwell_slip", **springs, "width_rmse": pretty(friction.rmse, "force", _ERROR),
        "told": list(friction.told),
    }  # fmt: skip


def laws_of(made: Calibration) -> dict[str, str]:
    """The names of the laws [-] that were fitted, by kind, of a calibration [-]."""
    return {kind: str(getattr(made.muscle, kind).name) for kind in LAWS}


def _rest_length(made: Calibration) -> str:
    """What the record's strains refer to."""
    if made.record.rest_length is None:
        return "the muscle's own length"
    return exact(made.record.rest_length, "length")


def _parameter(one: Estimate) -> Mapping[str, Any]:
    width = one.high - one.low
    return {
        "name": one.name,
        "value": told(one.value, one.dimension, width),
        "low": told(one.low, one.dimension, width),
        "high": told(one.high, one.dimension, width),
        "prior": pretty(one.start, one.dimension, _GIVEN),
        "identifiable": one.identifiable,
    }


def _short(number: float) -> float:
    """A `number` of an error [any] with as many digits as are known of one."""
    return float(f"{number:.{_ERROR}g}")
