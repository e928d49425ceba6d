"""A bundle on a tendon: a MuJoCo actuator whose control is the bundle's pull.

**Sign:** a control pulls the tendon's ends together, and is positive where the bundle pulls.
"""

import os
from collections.abc import Sequence
from typing import ClassVar, NamedTuple

import numpy as np

from ..bundle import Bundle
from ..bundle.bundle import as_bundle
from ..core.errors import InvalidInputError
from ..core.types import Batch, Values
from ..core.validation import check_choice, check_finite, check_positive
from ..dynamics.loads import AbstractLoad
from ..muscle import Muscle
from .optional_imports import Model, mujoco


_PULL = -1.0  # gain of a pull: a positive force in MuJoCo would lengthen the tendon


class Attached(NamedTuple):
    """A `bundle` on a tendon: names of the `actuator` and the `tendon`, the tendon's `rest_length`
    with the bundle at rest [m], the `compliance` of its cords and brackets [m/N], and whether a
    cord goes `slack` instead of letting the bundle push.
    """

    actuator: str
    tendon: str
    bundle: Bundle
    rest_length: float
    compliance: float = 0.0
    slack: bool = False

    def with_prefix(self, prefix: str, suffix: str = "") -> "Attached":
        """Copy for the sub-model that MuJoCo's `attach_body` put under a `prefix` and `suffix`."""
        actuator, tendon = (f"{prefix}{name}{suffix}" for name in (self.actuator, self.tendon))
        return self._replace(actuator=actuator, tendon=tendon)

    def actuator_in(self, model: Model) -> tuple[int, str]:
        """Index of the actuator in a compiled MuJoCo `model`, and its tendon's name.

        An actuator of a sub-model under a prefix or a suffix is found if it is the only one;
        `InvalidInputError` if the model has none, or several.
        """
        names = [model.actuator(i).name for i in range(model.nu)]
        tests = (str.__eq__, str.endswith, str.__contains__)
        matches = next(filter(None, ([x for x in names if t(x, self.actuator)] for t in tests)), [])
        if len(matches) == 1:
            index = names.index(matches[0])
            return index, model.tendon(int(model.actuator_trnid[index, 0])).name
        if matches:
            prefix = matches[0].partition(self.actuator)[0]
            rule = f"names the actuator {self.actuator!r}, which could be {' or '.join(matches)}"
            remedy = f"pass `attached.with_prefix({prefix!r})` for each one that you mean"
        else:
            rule = f"names the actuator {self.actuator!r}, which isn't in the model"
            remedy = f"it has {', '.join(names) or 'none'}; compile the MjSpec after `attach`"
        raise InvalidInputError("attached", rule, self.actuator, remedy, shown="")


def attach(
    spec: Model,
    tendon: str,
    bundle: Bundle | Muscle,
    rest_length: Values,
    name: str | None = None,
    stiffness: Values | Sequence[Values] = None,
    slack: bool = False,
) -> Attached:
    """Put a bundle in line with a tendon: an `Attached`, for `Drive.of` with the compiled model.

    The rest of the tendon is a cord: a tendon shorter than its `rest_length` contracts the bundle
    by the difference, less the stretch of the cord. A bundle past its free strain pushes, unless
    the cord can go slack.

    **Arguments:**

    - `spec`: MuJoCo's `MjSpec`, to which an actuator is added: before it is compiled, or compiled
      once more, and before or after MuJoCo attaches it to another one. Or a compiled `MjModel`
      that has one actuator on the tendon, which the bundle replaces.
    - `tendon`: name of a fixed or a spatial tendon.
    - `bundle`: the bundle, or one muscle.
    - `rest_length`: of the tendon with the bundle at rest [m]; in a fixed tendon's own coordinate,
      which may be below zero.
    - `name`: of the actuator; left out, the tendon's with `_bundle`.
    - `stiffness`: of cord and brackets in series [N/m], one or several; left out, they are rigid.
    - `slack`: true for a cord, which pulls and doesn't push; false for a rod.

    **Raises:** `InvalidInputError` for a path as a model, a tendon that doesn't exist, a `name`
    that is taken, and a model without an actuator to replace.
    """
    check_model(spec, "spec", ("MjSpec", "MjModel"))
    bundle = as_bundle(bundle)
    length = float(check_finite(rest_length, "rest_length", "m"))
    springs = stiffness if isinstance(stiffness, list | tuple | np.ndarray) else [stiffness]
    compliance = 0.0
    if stiffness is not None:
        compliance = sum(1 / float(check_positive(k, "stiffness", "N/m")) for k in springs)
    if isinstance(spec, mujoco.MjModel):
        check_choice(tendon, [spec.tendon(i).name for i in range(spec.ntendon)], "tendon")
        name = _replace_actuator(spec, tendon)
    else:
        check_choice(tendon, [entry.name for entry in spec.tendons], "tendon")
        name = f"{tendon}_bundle" if name is None else name
        if name in [actuator.name for actuator in spec.actuators]:
            rule = f"{name!r} is an actuator of the spec already"
            remedy = "attach once; a second bundle on the tendon needs another `name`"
            raise InvalidInputError("name", rule, name, remedy, shown="")
        _add_actuator(spec, tendon, name)
    return Attached(name, tendon, bundle, length, compliance, bool(slack))


def check_model(model: Model, argument: str, kinds: tuple[str, ...]) -> None:
    """Refuse a `model`, called `argument`, that is none of MuJoCo's `kinds`, such as a path."""
    if isinstance(model, tuple(getattr(mujoco, kind) for kind in kinds if hasattr(mujoco, kind))):
        return
    remedy = "pass `spec.compile()`" if hasattr(model, "compile") else "load one with mujoco"
    if isinstance(model, str | os.PathLike):
        load = "MjSpec.from_file" if kinds[0] == "MjSpec" else "MjModel.from_xml_path"
        remedy = f"load it: mujoco.{load}({str(model)!r})"
    rule = f"must be MuJoCo's {' or '.join(kinds)}"
    raise InvalidInputError(argument, rule, model, remedy, shown=type(model).__name__)


def _add_actuator(spec: Model, tendon: str, name: str) -> None:
    """Add an actuator on a `tendon` to `spec`, whose control is a pull [N]."""
    actuator = spec.add_actuator(name=name, target=tendon, trntype=mujoco.mjtTrn.mjTRN_TENDON)
    # what the model's defaults set for its own actuators would change or limit the force
    actuator.gaintype = mujoco.mjtGain.mjGAIN_FIXED
    actuator.biastype = mujoco.mjtBias.mjBIAS_NONE
    actuator.dyntype = mujoco.mjtDyn.mjDYN_NONE
    actuator.ctrllimited = actuator.forcelimited = mujoco.mjtLimited.mjLIMITED_FALSE
    actuator.gainprm = np.eye(1, len(actuator.gainprm))[0] * _PULL
    actuator.gear = np.eye(1, len(actuator.gear))[0]


def _replace_actuator(model: Model, tendon: str) -> str:
    """Make the actuator on a `tendon` of a compiled `model` one of pulls [N]; return its name."""
    on_tendon = (model.actuator_trntype == mujoco.mjtTrn.mjTRN_TENDON) & (
        model.actuator_trnid[:, 0] == model.tendon(tendon).id
    )
    indices = np.flatnonzero(on_tendon & (model.actuator_dyntype == mujoco.mjtDyn.mjDYN_NONE))
    if len(indices) != 1 or not model.actuator(int(indices[0])).name:
        rule = "must be an MjSpec, or an MjModel with one named `motor` on the tendon"
        remedy = f'add <motor name="{tendon}_bundle" tendon="{tendon}"/> to the XML'
        count = len(indices)
        raise InvalidInputError("spec", rule, count, remedy, shown=f"{count} of them")
    index = int(indices[0])
    model.actuator_gaintype[index] = mujoco.mjtGain.mjGAIN_FIXED
    model.actuator_biastype[index] = mujoco.mjtBias.mjBIAS_NONE
    model.actuator_gainprm[index] = np.eye(1, model.actuator_gainprm.shape[1])[0] * _PULL
    model.actuator_gear[index] = np.eye(1, 6)[0]
    model.actuator_ctrllimited[index] = model.actuator_forcelimited[index] = 0
    return model.actuator(index).name


class Tendons(AbstractLoad):
    """Load of so many `bundles` on tendons: MuJoCo, which has inertia, forces and dampers."""

    prescribed: ClassVar[bool] = True

    bundles: int
    stop: None = None

    @property
    def arms(self) -> tuple[tuple[Batch, Batch], ...]:
        return ((0.0, 1.0),) * self.bundles

    @property
    def inertia(self) -> Batch:
        return np.float64(1.0)  # any: it has no effect
