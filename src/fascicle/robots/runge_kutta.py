"""A Runge-Kutta step of MuJoCo with forces that are evaluated at each of its stages."""

import threading
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..core.types import Numbers
from .optional_imports import mujoco


_LOCK = threading.Lock()  # MuJoCo has one gain callback: threads take it in turn


def runge_kutta_step(
    model: Any, data: Any, actuators: Sequence[int], pull: Callable[[Numbers], Numbers]
) -> None:
    """Step MuJoCo's `data` of a `model` whose `actuators` have a `pull` [N], which is a function of
    their lengths [m]. The gain callback that was there serves all other actuators, and is put back.
    """
    indices = {actuator: side for side, actuator in enumerate(actuators)}
    first = min(indices)  # MuJoCo calls in this order
    kinds = model.actuator_gaintype.copy()
    pulls = np.zeros(len(actuators))
    errors: list[Exception] = []

    def gain(stage_model: Any, stage_data: Any, actuator: int) -> float:
        """Negative pull of an actuator's bundle [N]; the first call evaluates all of them."""
        side = indices.get(actuator)
        if side is None:
            return 0.0 if before is None else before(stage_model, stage_data, actuator)
        if actuator == first and not errors:
            try:
                pulls[:] = pull(stage_data.actuator_length[list(actuators)].copy())
            except Exception as error:  # noqa: BLE001 raised below: none may leave a callback
                errors.append(error)
        return -float(pulls[side])

    with _LOCK:
        before = mujoco.get_mjcb_act_gain()
        model.actuator_gaintype[list(actuators)] = mujoco.mjtGain.mjGAIN_USER
        data.ctrl[list(actuators)] = 1.0
        mujoco.set_mjcb_act_gain(gain)
        try:
            mujoco.mj_step(model, data)
        finally:
            mujoco.set_mjcb_act_gain(before)
            model.actuator_gaintype[:] = kinds
    if errors:
        raise errors[0]
