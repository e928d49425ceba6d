"""A bundle on a tendon: an actuator of MuJoCo's whose control is the bundle's pull.

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
    """A `bundle` [-] that a tendon pulls by, both by name [-]: `tendon`, and the `actuator` for it;
    `rest_length`: of the tendon where the bundle is as long as at rest [m].
    """

    actuator: str
    tendon: str
    bundle: Bundle
    rest_length: float


def attach(
    spec: Any, tendon: str, bundle: Bundle | Muscle, rest_length: Values, name: str | None = None
) -> Attached:
    """Put a bundle in line with a tendon.

    What the tendon has beside the bundle is a cord that doesn't stretch: where the tendon is
    shorter than its `rest_length`, the bundle is contracted by the difference. It pushes, too,
    where it is contracted farther than it contracts by itself.

    **Arguments:**

    - `spec`: MuJoCo's `MjSpec`, to which an actuator is added [-].
    - `tendon`: its name, of a fixed or a spatial one [-].
    - `bundle`: the bundle, or one muscle [-].
    - `rest_length`: of the tendon where the bundle is at rest [m]; in a fixed tendon's own
      coordinate, which may be below zero.
    - `name`: of the actuator [-]; left out, the tendon's with `_bundle`.

    **Returns:** an `Attached` [-], for `Drive.of` once the spec is compiled.

    **Raises:** `ValueError`, one line, for a tendon that doesn't exist.
    """
    names = [name_known.name for name_known in spec.tendons]
    if tendon not in names:
        suggestions = difflib.get_close_matches(str(tendon), names, n=1, cutoff=0.4)
        hint = (
            f"did you mean {suggestions[0]!r}?"
            if suggestions
            else f"it has {', '.join(names) or 'none'}"
        )
        raise InvalidInputError(
            "tendon", f"{tendon!r} isn't one of the model's", tendon, hint, shown=""
        )
    if isinstance(bundle, Muscle):
        bundle = Bundle([MotorUnit(bundle)])
    if not isinstance(bundle, Bundle):
        raise InvalidInputError(
            "bundle", "must be a Bundle or a Muscle", bundle, shown=type(bundle).__name__
        )
    at = float(check_finite(rest_length, "rest_length", "m"))
    called = f"{tendon}_bundle" if name is None else name
    attached = spec.add_actuator(
        name=called, target=tendon, trntype=mujoco.mjtTrn.mjTRN_TENDON
    )  # fmt: skip
    gain = np.zeros_like(attached.gainprm)
    gain[0] = -1.0  # a positive force of MuJoCo's would lengthen the tendon
    attached.gainprm = gain
    return Attached(called, tendon, bundle, at)


class Tendons(AbstractLoad):
    """Load of bundles on tendons: MuJoCo, which knows where the tendons are.

    `bundles`: how many there are [-].
    """

    unit: ClassVar[str] = "m"
    prescribed: ClassVar[bool] = True

    bundles: int
    stop: None = None

    @property
    def arms(self) -> tuple[tuple[Batch, Batch], ...]:
        """Of each bundle [m], [-]: its plates come nearer as its tendon shortens."""
        return ((0.0, 1.0),) * self.bundles

    @property
    def inertia(self) -> Batch:
        """None that counts here [kg]."""
        return np.float64(1.0)

    def force(self, position: Batch) -> Batch:
        """None that counts here [N], at any `position` [m]."""
        return 0.0 * position

    def potential(self, position: Batch) -> Batch:
        """None that counts here [J], at any `position` [m]."""
        return 0.0 * position

    @property
    def damper(self) -> Batch:
        """None that counts here [SI]."""
        return np.float64(0.0)

    @property
    def stiffness(self) -> Batch:
        """None that counts here [N/m]."""
        return np.float64(0.0)

    def motion_at(self, time: Batch, position: Batch, velocity: Batch) -> tuple[Batch, Batch]:
        """Position [m] and velocity [m/s] of MuJoCo, at any `time` [s]."""
        del time
        return position, velocity
