r"""A muscle as OpenSim's `McKibbenActuator`: the ideal braid of Chou and Hannaford.

OpenSim computes the force of a thread of length $b$ that winds $n$ times around a cylinder,

$$F = \frac{P}{4 \pi n^2} \left(3 L^2 - b^2\right)$$

at the length $L$, with the pressure as its control. It has no bladder, buckling or collapse: the
element says by how much its force differs from the muscle's while both pull. Files with this
element are read by OpenSim 4.4 and later, as its list of changes says.

**Source:** OpenSim, `McKibbenActuator`; Chou and Hannaford (1996), IEEE Trans. Robot. Autom.
12, 90.
"""

import math

import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Values
from ..core.validation import HIGHEST_PRESSURE, check_interval
from ..muscle import Muscle


_ELEMENT = """<!-- {name}, by fascicle: paste it into the ForceSet of a model, and give it a
     GeometryPath. The control is the gauge pressure in Pa. OpenSim's element has no bladder,
     buckling or collapse: from 0 to {supply:g} kPa and up to the free strain its force differs
     from the muscle's by at most {difference:.3g} N (largest force {largest:.3g} N); past the free
     strain it pushes without end. -->
<McKibbenActuator name="{name}">
    <min_control>0</min_control>
    <max_control>{supply_pascals:.17g}</max_control>
    <number_of_turns>{turns:.17g}</number_of_turns>
    <thread_length>{thread:.17g}</thread_length>
    <cord_length>0</cord_length>
</McKibbenActuator>
"""


def opensim_element(muscle: Muscle, name: str, supply_pressure: Values) -> str:
    """XML of a `McKibbenActuator` called `name` with the braid of a single `muscle`, whose highest
    control is the `supply_pressure` [Pa].
    """
    if np.ndim(muscle.length + muscle.outer_radius + muscle.braid_angle):
        raise InvalidInputError("muscle", "must be a single one, got an array", None)
    limits = (0.0, HIGHEST_PRESSURE, "supply_pressure", "Pa")
    supply = float(check_interval(supply_pressure, *limits, closed=(False, True)))
    length, angle = float(muscle.length), float(muscle.braid_angle)
    thread = length / math.cos(angle)
    turns = length * math.tan(angle) / (2 * math.pi * float(muscle.outer_radius))
    P = np.linspace(0.0, supply, 21)[1:]
    strain = np.linspace(0.0, 1.0, 41)[:, None] * np.asarray(muscle.free_strain(P))
    force = np.asarray(muscle.force(P, strain))
    ideal = P / (4 * math.pi * turns**2) * (3 * (length * (1 - strain)) ** 2 - thread**2)
    return _ELEMENT.format(
        name=name,
        supply=supply / 1e3,
        supply_pascals=supply,
        difference=float(np.max(np.abs(force - ideal))),
        largest=float(np.max(force)),
        turns=turns,
        thread=thread,
    )
