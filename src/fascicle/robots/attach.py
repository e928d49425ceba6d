"""A bundle on a tendon: a MuJoCo actuator whose control is the bundle's pull.

**Sign:** a control pulls the tendon's ends together, and is positive where the bundle pulls.
"""

import difflib
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ..bundle import Bundle, MotorUnit
from ..core.errors import InvalidInputError
from ..core.types import Batch, Values
from ..core.validation import check_finite
from ..dynamics.loads import AbstractLoad
from ..muscle import Muscle
from .optional_imports import mujoco


class Attached(NamedTuple):
    """A `bundle` on a tendon: names of the `actuator` and the `tendon`, and the tendon's
    `rest_length` with the bundle at rest [m].
    """

    actuator: str
    tendon: str
    bundle: Bundle
    rest_length: float


def attach(
    spec: Any, tendon: str, bundle: Bundle | Muscle, rest_length: Values, name: str | None = None
) -> Attached:
    """Put a bundle in line with a tendon.

    The rest of the tendon is a cord that doesn't stretch: a tendon shorter than its `rest_length`
    contracts the bundle by the difference. A bundle past its free strain pushes.

    **Arguments:**

    - `spec`: MuJoCo's `MjSpec`, to which an actuator is added.
    - `tendon`: name of a fixed or a spatial tendon.
    - `bundle`: the bundle, or one muscle.
    - `rest_length`: of the tendon with the bundle at rest [m]; in a fixed tendon's own coordinate,
      which may be below zero.
    - `name`: of the actuator; left out, the tendon's with `_bundle`.

    **Returns:** an `Attached`, for `Drive.of` with the compiled model.

    **Raises:** `InvalidInputError` for a tendon that doesn't exist.
    """
    names = [entry.name for entry in spec.tendons]
    if tendon not in names:
        suggestions = difflib.get_close_matches(str(tendon), names, n=1, cutoff=0.4)
        remedy = f"it has {', '.join(names) or 'none'}"
        if suggestions:
            remedy = f"did you mean {suggestions[0]!r}?"
        rule = f"{tendon!r} isn't one of the model's"
        raise InvalidInputError("tendon", rule, tendon, remedy, shown="")
    if isinstance(bundle, Muscle):
        bundle = Bundle([MotorUnit(bundle)])
    if not isinstance(bundle, Bundle):
        raise InvalidInputError(
            "bundle", "must be a Bundle or a Muscle", bundle, shown=type(bundle).__name__
        )
    length = float(check_finite(rest_length, "rest_length", "m"))
    name = f"{tendon}_bundle" if name is None else name
    actuator = spec.add_actuator(name=name, target=tendon, trntype=mujoco.mjtTrn.mjTRN_TENDON)
    gain = np.zeros_like(actuator.gainprm)
    gain[0] = -1.0  # a positive force in MuJoCo would lengthen the tendon
    actuator.gainprm = gain
    return Attached(name, tendon, bundle, length)


class Tendons(AbstractLoad):
    """Load of bundles on tendons: MuJoCo, which moves the tendons.

    `bundles`: their number.
    """

    unit: ClassVar[str] = "m"
    prescribed: ClassVar[bool] = True

    bundles: int
    stop: None = None

    @property
    def arms(self) -> tuple[tuple[Batch, Batch], ...]:
        """(0 m, 1) for each bundle: the position is how far its tendon has shortened."""
        return ((0.0, 1.0),) * self.bundles

    @property
    def inertia(self) -> Batch:
        """Placeholder [kg]: MuJoCo has the inertia."""
        return np.float64(1.0)

    def force(self, position: Batch) -> Batch:
        """Zero [N] at any `position` [m]: MuJoCo has the forces."""
        return 0.0 * position

    def potential(self, position: Batch) -> Batch:
        """Zero [J] at any `position` [m]: MuJoCo has the potential."""
        return 0.0 * position

    @property
    def damper(self) -> Batch:
        """Zero [SI]: MuJoCo has the dampers."""
        return np.float64(0.0)

    @property
    def stiffness(self) -> Batch:
        """Zero [N/m]: MuJoCo has the springs."""
        return np.float64(0.0)

    def motion_at(self, time: Batch, position: Batch, velocity: Batch) -> tuple[Batch, Batch]:
        """Position [m] and velocity [m/s] of MuJoCo, at any `time` [s]."""
        del time
        return position, velocity
