r"""A hose, in series with a valve or an orifice.

For a gas it is an element of ISO 6358 with, in SI,

$$C = \frac{0.029\, d^2}{\sqrt{L/d^{1.25} + 510}}, \qquad b = 474\, \frac{C}{d^2}. \tag{F6}$$

For a liquid laminar and turbulent resistance are added,

$$\Delta p = a \dot m + c \dot m^2, \qquad a = \frac{128 \mu L}{\pi d^4 \rho}, \qquad
  c = \frac{8 f L}{\pi^2 d^5 \rho}: \tag{F7}$$

exact where one of them is small, too much by up to the smaller one where they are alike.

**Assumes** a smooth, round, straight hose, no inertia, no volume: its volume belongs to a
chamber's `dead_volume`. **Source:** (F6) as commonly cited from Eckersten's measurements of
plastic hoses (the text wasn't at hand; a test holds it to within 17 % of Fanno's equation);
(F7) Hagen and Poiseuille, Darcy and Weisbach.
"""

import numpy as np

from ..core.array_namespace import sqrt
from ..core.module import Module
from ..core.types import Batch
from ..core.validation import Range
from .entry import above_zero


class Line(Module):
    """A hose: equations (F6) and (F7).

    `length`, `diameter`: $L$, and $d$ inside [m]. `viscosity`: $\\mu$ of a liquid in it [Pa·s];
    left out, that of a hydraulic oil. `friction_factor`: Darcy's $f$ where it is turbulent [-].
    """

    length: Batch = above_zero("length", Range("m", 1e-3, 0.01, 100.0, 1e4))
    diameter: Batch = above_zero("diameter", Range("m", 1e-5, 3e-4, 0.05, 1.0))
    viscosity: Batch = above_zero("viscosity", Range("Pa·s", 1e-6, 1e-4, 2.0, 1e4), default=0.039)
    friction_factor: Batch = above_zero(
        "friction_factor", Range("-", 1e-4, 5e-3, 0.1, 10.0), default=0.03
    )

    @property
    def conductance(self) -> Batch:
        """Sonic conductance $C$ [m³/(s·Pa)], equation (F6)."""
        d = self.diameter
        return 0.029 * d**2 / sqrt(self.length / d**1.25 + 510)

    @property
    def critical_pressure_ratio(self) -> Batch:
        """$b$ [-], equation (F6); between 0 and 0.61."""
        return 474 * self.conductance / self.diameter**2

    def laminar_resistance(self, density: Batch) -> Batch:
        """$a$ of equation (F7) [Pa·s/kg] for a liquid of `density` [kg/m³]."""
        return 128 * self.viscosity * self.length / (np.pi * self.diameter**4 * density)

    def turbulent_resistance(self, density: Batch) -> Batch:
        """$c$ of equation (F7) [Pa·s²/kg²] for a liquid of `density` [kg/m³]."""
        drop = 8 * self.friction_factor * self.length
        return drop / (np.pi**2 * self.diameter**5 * density)
