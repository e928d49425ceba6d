"""Muscles in MuJoCo and MJX: bundles on tendons, their chambers and valves, and environments.

It needs the extra `robots`: `pip install 'fascicle[robots]'`.
"""

from .attach import Attached as Attached
from .attach import attach as attach
from .drive import Drive as Drive
from .drive import Fluid as Fluid
from .gym_registration import register as register


register()
