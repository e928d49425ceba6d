r"""Fabrication scatter: muscles built to one drawing come out a little unlike.

A muscle's length and braid angle are drawn from normal distributions around the drawing's,

$$L = L_0 (1 + s_L z_1), \qquad \alpha = \alpha_0 + s_\alpha z_2. \tag{D2}$$

**Assumes** that the two are independent, of each other and from one muscle to the next.
"""

from dataclasses import dataclass
from typing import Any

import equinox as eqx
import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Values
from ..core.validation import check_interval
from ..muscle import Muscle
from ..units import pretty


@dataclass(frozen=True)
class Scatter:
    """Standard deviations of `length`, over the length itself [-], and `braid_angle` [rad]."""

    length: float = 0.0
    braid_angle: Values = 0.0

    def __post_init__(self):
        """**Raises:** `ValueError` for a scatter that is negative or huge."""
        check_interval(self.length, 0.0, 0.2, "length", "-", "of the length", (True, True))
        try:
            angle = check_interval(
                self.braid_angle, 0.0, 0.2, "braid_angle", "rad", closed=(True, True)
            )
        except InvalidInputError as error:
            if not isinstance(error.value, float):
                raise
            shown = pretty(error.value, "angle")
            rule = f"must lie in [0, {np.degrees(0.2):.4g}] deg"
            raise InvalidInputError("braid_angle", rule, error.value, shown=shown) from None
        object.__setattr__(self, "braid_angle", float(angle))

    def draw(self, muscle: Muscle, generator: np.random.Generator, size: Any = ()) -> Muscle:
        """Muscles as they come out.

        **Arguments:**

        - `muscle`: the one on the drawing [-].
        - `generator`: the source of chance [-].
        - `size`: shape of the batch [-]; left out, a single muscle.

        **Returns:** the muscle, or a batch of them [-].
        """
        z = generator.standard_normal((2, *size))
        return eqx.tree_at(
            lambda m: (m.length, m.braid_angle),
            muscle,
            (
                muscle.length * (1 + self.length * z[0]),
                muscle.braid_angle + self.braid_angle * z[1],
            ),
        )
