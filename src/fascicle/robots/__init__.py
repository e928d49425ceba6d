"""Muscles in MuJoCo and MJX: bundles on tendons, their chambers and valves, and environments.

It needs the extra `robots`: `pip install 'fascicle[robots]'`. Importing it registers the
environments with Gymnasium, if that is installed.
"""

import os
from importlib.util import find_spec

from .attach import Attached as Attached
from .attach import attach as attach
from .drive import Drive as Drive
from .drive import Fluid as Fluid
from .sizing import Sizing as Sizing
from .sizing import size as size
from .tables import TableStatus as TableStatus
from .tables import TableWarning as TableWarning


_PROCESS = os.getpid()  # of the first import: a forked process has another one
_STEPS = 200  # of 10 ms: an episode


def register() -> None:
    """Register the environments with Gymnasium by name, without importing them."""
    if find_spec("gymnasium") is None:
        return
    import gymnasium

    vectors = {"AntagonisticJoint": "antagonistic_joints", "HangingMass": "hanging_masses"}
    for name, vector in vectors.items():
        key = f"fascicle/{name}-v0"
        if key not in gymnasium.registry:
            gymnasium.register(
                id=key,
                entry_point=f"fascicle.robots.environments:{name}",
                vector_entry_point=f"fascicle.robots.vector_environment:{vector}",
                max_episode_steps=_STEPS,
            )


def forked() -> bool:
    """True if this process was forked from one that had imported `fascicle.robots`."""
    return os.getpid() != _PROCESS


register()
