"""Registration of the environments with Gymnasium, if it is installed."""

import os
from importlib.util import find_spec


NAMES = ("AntagonisticJoint", "HangingMass")  # of the environments
_PROCESS = os.getpid()  # of the first import
_STEPS = 200  # of 10 ms: an episode


def register() -> None:
    """Register the environments by name, without importing them."""
    if find_spec("gymnasium") is None:
        return
    import gymnasium

    for name in NAMES:
        key = f"fascicle/{name}-v0"
        if key not in gymnasium.registry:
            entry_point = f"fascicle.robots.environments:{name}"
            gymnasium.register(id=key, entry_point=entry_point, max_episode_steps=_STEPS)


def forked() -> bool:
    """True if this process was forked from one that had imported `fascicle.robots`."""
    return os.getpid() != _PROCESS
