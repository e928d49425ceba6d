r"""Sizes of a muscle from what is sold and counted: a thread and its turns, a sleeve on a tube.

A thread of length $b$ that winds $n$ times around a braid of the length $L_0$ has

$$\cos\alpha_0 = \frac{L_0}{b}, \qquad r_0 = \frac{\sqrt{b^2 - L_0^2}}{2 \pi n}.$$

A sleeve keeps its threads and their turns, so that $r/\sin\alpha$ is one number. A sleeve that has
the angle $\alpha_n$ at its nominal diameter $D_n$ has on a tube of the outer diameter $D$

$$\sin\alpha_0 = \frac{D}{D_n} \sin\alpha_n.$$

**Assumes** threads that are thin beside the diameter, and a sleeve that lies on the tube.
**Source:** Chou and Hannaford (1996), IEEE Trans. Robot. Autom. 12, 90, for the thread; the sleeve
derived here.
"""

import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Batch, Values
from ..core.validation import check_positive


def thread_sizes(length: Values, thread_length: Values, turns: Values) -> tuple[Batch, Batch]:
    """Outer radius [m] and braid angle [rad] of a braid of a `length` $L_0$ [m], from the length
    $b$ of a thread [m] and its `turns` $n$ [-]; `InvalidInputError` for a thread that is shorter.
    """
    L = check_positive(length, "length", "m")
    b = check_positive(thread_length, "thread_length", "m")
    n = check_positive(turns, "turns", "-")
    if np.any(np.asarray(b) <= L):
        rule = f"must lie above the `length` of {float(np.max(L)):g} m"
        remedy = "a thread winds around the muscle"
        raise InvalidInputError("thread_length", rule, float(np.min(b)), remedy)
    return np.sqrt(b**2 - L**2) / (2 * np.pi * n), np.arccos(L / b)


def sleeve_angle(nominal_diameter: Values, nominal_angle: Values, tube_diameter: Values) -> Batch:
    """Braid angle [rad] on a tube of an outer `tube_diameter` $D$ [m], of a sleeve that has a
    `nominal_angle` [rad] at its `nominal_diameter` $D_n$ [m]; `InvalidInputError` for a tube that
    it doesn't go around.
    """
    D_n = check_positive(nominal_diameter, "nominal_diameter", "m")
    angle = check_positive(nominal_angle, "nominal_angle", "rad")
    D = check_positive(tube_diameter, "tube_diameter", "m")
    sine = D / D_n * np.sin(angle)
    if np.any(sine >= 1):
        rule = f"must lie below {float(np.min(D_n / np.sin(angle))):.3g} m"
        remedy = "the sleeve's threads are too short for it: take a wider sleeve"
        raise InvalidInputError("tube_diameter", rule, float(np.max(D)), remedy)
    return np.arcsin(sine)
