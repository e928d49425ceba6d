"""The environments' names, told to Gymnasium where it is installed, without their modules."""

import os
from importlib.util import find_spec


NAMES = ("AntagonisticJoint", "HangingMass")
_PROCESS = os.getpid()  # that imported this
_STEPS = 200  # of 10 ms: an episode


def register() -> None:
    """Tell Gymnasium the environments' names."""
    if find_spec("gymnasium") is None:
        return
    import gymnasium

    for name in NAMES:
        at = f"fascicle/{name}-v0"
        if at not in gymnasium.registry:
            point = f"fascicle.robots.environments:{name}"
            gymnasium.register(id=at, entry_point=point, max_episode_steps=_STEPS)


def forked() -> bool:
    """True if this process was forked from one that had imported `fascicle.robots`."""
    return os.getpid() != _PROCESS
