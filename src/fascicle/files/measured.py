"""Friction that a calibration measured, for a scenario: `[hysteresis] kind = "measured"`.

`fascicle calibrate` keeps the springs that it found in the `[calibration.hysteresis]` of the fitted
muscle's file. A scenario takes them from the file that its `bundle` names, or from another one,
`muscle = "muscle.toml"`. They are of one muscle, and hold for each of the scenario's. Where both
branches were one, there is no friction, and the run is that without a `[hysteresis]`.
"""

from pathlib import Path
from typing import Any

from .places import Place
from .reading import provenance


MEASURED, NONE = "measured", "none"
_KEYS = ("stiffness", "slip_force", "slip_force_slope")


def with_measured(data: dict[str, Any], place: Place, folder: Path) -> dict[str, Any]:
    """A scenario's tables with the springs that its `[hysteresis]` only names.

    **Arguments:**

    - `data`: the tables [-].
    - `place`: of the whole file [-].
    - `folder`: where files stand that it names [-].

    **Returns:** the tables [-]; the same where nothing is measured.

    **Raises:** `ValueError`, in one line, where a file doesn't tell.
    """
    table = data.get("hysteresis")
    if not isinstance(table, dict) or table.get("kind") != MEASURED:
        return data
    for key in table:
        if key not in ("kind", "muscle"):
            raise place.refuse(("hysteresis", key), "measured: the file of the muscle has it.")
    name = table.get("muscle", data.get("bundle"))
    if not isinstance(name, str) or not (folder / name).is_file():
        rule = 'must name the calibrated muscle\'s file: write muscle = "muscle.toml".'
        raise place.refuse(("hysteresis", "muscle"), rule)
    with place.inner("hysteresis", kind="part").naming():
        told = provenance(folder / name).get("hysteresis")
    kind = told.get("kind") if isinstance(told, dict) else None
    rest = {key: value for key, value in data.items() if key != "hysteresis"}
    if kind == NONE:
        return rest
    if kind is None or not isinstance(told, dict) or any(key not in told for key in _KEYS):
        rule = f"{name} has no friction: `fascicle calibrate` finds it in records of both ways."
        raise place.refuse(("hysteresis", "kind"), rule)
    return rest | {"hysteresis": {"kind": kind} | {key: told[key] for key in _KEYS}}
