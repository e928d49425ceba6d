r"""A liquid through an orifice, and a hose behind it.

$$\dot m = \frac{2 \Delta p}{a + \sqrt{a^2 + 4 c \sqrt{\Delta p^2 + \Delta p_{cr}^2}}}, \qquad
  c = \frac{1}{2 \rho (C_d A z)^2} + c_l, \qquad a = a_l. \tag{F8}$$

Without a hose that is $C_d A z \sqrt{2 \rho \Delta p}$ well above $\Delta p_{cr}$, the transition
to laminar flow, and linear below it; with one, whose resistances are $a_l$ and $c_l$ (F7), it is
the root of $\Delta p = a \dot m + c \dot m^2$. It is smooth everywhere, and zero where the opening
$z$ is.

**Sign:** positive from 1 to 2. **Assumes** the density that is given on both sides. **Valid for**
pressures above the vapor's. **Source:** Merritt (1967), Hydraulic Control Systems, for the root
law; the transition is Simscape's; with a hose, derived here.
"""

from typing import ClassVar

from ..core.array_namespace import sqrt
from ..core.module import Module
from ..core.types import Batch, BatchLike
from ..core.validation import Range
from .entry import above_zero, between, part
from .line import Line


class Orifice(Module):
    """An orifice for liquids, with a hose behind it: equation (F8).

    `area`: $A$, wide open [m²]. `density`: $\\rho$ of the liquid [kg/m³].
    `discharge_coefficient`: $C_d$ [-], in (0, 1]; left out, that of a sharp edge.
    `critical_pressure_difference`: $\\Delta p_{cr}$ [Pa]. `line`: a hose behind it [-], or none.
    """

    source: ClassVar[str] = "Merritt (1967)"

    area: Batch = above_zero("area", Range("m²", 1e-14, 1e-10, 1e-3, 10.0))
    density: Batch = above_zero("density", Range("kg/m³", 1.0, 500.0, 2000.0, 2e4), default=850.0)
    discharge_coefficient: Batch = between(
        "discharge_coefficient", 0.0, 1.0, closed=(False, True), default=0.611
    )
    critical_pressure_difference: Batch = above_zero(
        "critical_pressure_difference", Range("Pa", 1e-3, 1.0, 1e5, 1e7), default=1e3
    )
    line: Line | None = part("line", (Line,), default=None)

    def flow(
        self,
        absolute_1: BatchLike,
        absolute_2: BatchLike,
        temperature_1: BatchLike = 0.0,
        temperature_2: BatchLike = 0.0,
        opening: BatchLike = 1.0,
    ) -> Batch:
        """Mass flow from 1 to 2, equation (F8).

        **Arguments:**

        - `absolute_1`, `absolute_2`: pressures on both sides [Pa], both absolute or both gauge.
        - `temperature_1`, `temperature_2`: of a gas [K]; a liquid's don't count.
        - `opening`: share $z$ of the orifice that is open [-], from 0 to 1.

        **Returns:** mass flow [kg/s], negative from 2 to 1.
        """
        del temperature_1, temperature_2
        drop, z = absolute_1 - absolute_2, opening
        own = 1 / (2 * self.density * (self.discharge_coefficient * self.area) ** 2)
        root = sqrt(drop**2 + self.critical_pressure_difference**2)
        if self.line is None:
            return z * drop / sqrt(own * root)
        # z taken out of the root, so that nothing is divided by a closed orifice
        a = z * self.line.laminar_resistance(self.density)
        c = own + z**2 * self.line.turbulent_resistance(self.density)
        return 2 * z * drop / (a + sqrt(a**2 + 4 * c * root))
