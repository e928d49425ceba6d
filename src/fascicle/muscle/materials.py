r"""Bladder materials: the energy of a stretched wall, and its modulus in bending.

An incompressible wall stretched by $\lambda_1$ along the axis and $\lambda_2$ around it
stores, per volume of material (Mooney-Rivlin),

$$W = C_{10} (I_1 - 3) + C_{01} (I_2 - 3), \tag{W}$$
$$I_1 = \lambda_1^2 + \lambda_2^2 + \lambda_3^2, \qquad
  I_2 = \lambda_1^{-2} + \lambda_2^{-2} + \lambda_3^{-2}, \qquad
  \lambda_3 = 1/(\lambda_1 \lambda_2).$$

Its Young's modulus for small strains is $E = 6 (C_{10} + C_{01})$. Buckling and collapse
use a separate modulus and Poisson's ratio, which may be measured.

**Source:** Klute and Hannaford (2000) for (W) and latex; Kim, Mazzoleni and Bryant (2021),
section 3.4, for the silicone's modulus [R3].
"""

import abc
from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar, NamedTuple

from ..core.parameters import POSITIVE, Constant
from ..core.types import Batch, BatchLike, Values
from .law import Declared


class Slopes(NamedTuple):
    """Derivatives of an energy density [J/m³] by $p = \\lambda_1^2$ and $q = \\lambda_2^2$."""

    p: Batch
    q: Batch
    pp: Batch
    pq: Batch
    qq: Batch


class AbstractMaterial(Declared):
    """A bladder's material: an energy for stretching; a modulus and Poisson's ratio for bending."""

    youngs_modulus: ClassVar[Batch]
    poisson_ratio: ClassVar[Batch]

    @abc.abstractmethod
    def energy(self, axial_squared: BatchLike, hoop_squared: BatchLike) -> Batch:
        """Energy density $W$ [J/m³] at squared stretches $\\lambda_1^2$, $\\lambda_2^2$ [-]."""

    @abc.abstractmethod
    def slopes(self, axial_squared: BatchLike, hoop_squared: BatchLike) -> Slopes:
        """First and second derivatives of $W$ [J/m³] by the squared stretches [-]."""


LATEX_C10, LATEX_C01 = 118.4e3, 105.7e3  # Pa, of latex: Klute and Hannaford (2000)

_C10 = Constant(
    "c10", "C_{10}", "pressure", (1e-3, 500.0, 1e8, 1e10), POSITIVE, None,
    "constant C10 of the bladder's rubber", "Klute and Hannaford (2000)",
)  # fmt: skip
_C01 = Constant(
    # many rubbers have next to none
    "c01", "C_{01}", "pressure", (1e-6, 1e-6, 1e8, 1e10), POSITIVE, None,
    "constant C01 of the bladder's rubber", "Klute and Hannaford (2000)",
)  # fmt: skip
_E = Constant(
    # gels have 10 Pa, no bladder is stiffer than a hard plastic, 10 GPa; the softest silicones
    # have 20 kPa, polyethylene film 500 MPa
    "youngs_modulus", "E", "pressure", (10.0, 5e3, 1e9, 1e10), POSITIVE, None,
    "Young's modulus of the bladder in bending", "Kim, Mazzoleni and Bryant (2021)",
)  # fmt: skip


class MooneyRivlin(AbstractMaterial):
    """Rubber with the energy (W), and constants of its own for bending."""

    c10: Batch = _C10.field()
    c01: Batch = _C01.field()
    youngs_modulus: Batch = _E.field()
    # no fit moves it: that of rubber is known
    poisson_ratio: Batch = Constant(
        "poisson_ratio", r"\nu", "number", (0.0, 0.0, 0.5, 0.5), None, 0.5,
        "Poisson's ratio of the bladder in bending", "Kim, Mazzoleni and Bryant (2021)",
    ).field()  # fmt: skip

    def __init__(
        self, c10: Values, c01: Values, youngs_modulus: Values = None, poisson_ratio: Values = 0.5
    ):
        """**Arguments:**

        - `c10`: $C_{10}$ [Pa], positive.
        - `c01`: $C_{01}$ [Pa], positive.
        - `youngs_modulus`: $E$ [Pa] for bending; default: $6 (C_{10} + C_{01})$.
        - `poisson_ratio`: $\\nu$ [-], in [0, 0.5].

        **Raises:** `ValueError` where a constant is not positive or the ratio is off.
        """
        if youngs_modulus is None:
            youngs_modulus = 6 * (_C10.validate(c10) + _C01.validate(c01))
        self.__attrs_init__(c10, c01, youngs_modulus, poisson_ratio)

    @classmethod
    def from_youngs_modulus(
        cls, youngs_modulus: Values, poisson_ratio: Values = 0.5
    ) -> "MooneyRivlin":
        """Rubber with a measured `youngs_modulus` $E = 6 (C_{10} + C_{01})$ [Pa], constants in
        latex's ratio, and `poisson_ratio` $\\nu$ [-].
        """
        E = _E.validate(youngs_modulus)
        fraction = LATEX_C10 / (LATEX_C10 + LATEX_C01)
        return cls(fraction * E / 6, (1 - fraction) * E / 6, E, poisson_ratio)

    def energy(self, axial_squared: BatchLike, hoop_squared: BatchLike) -> Batch:
        """Energy density $W$ [J/m³] at squared stretches $\\lambda_1^2$, $\\lambda_2^2$ [-]."""
        p, q = axial_squared, hoop_squared
        radial_squared = 1 / (p * q)  # an incompressible wall
        I1 = p + q + radial_squared
        I2 = (p + q) * radial_squared + p * q
        return self.c10 * (I1 - 3) + self.c01 * (I2 - 3)

    def slopes(self, axial_squared: BatchLike, hoop_squared: BatchLike) -> Slopes:
        """First and second derivatives of $W$ [J/m³] by the squared stretches [-]."""
        p, q, a, b = axial_squared, hoop_squared, self.c10, self.c01
        s = 1 / (p * q)
        u, v = q * s, p * s  # 1/p and 1/q, for one division
        a_s = a * s
        U, V = u * (a_s + b * u), v * (a_s + b * v)  # of stretches that the wall's thinning causes
        return Slopes(p=a + b * q - U, q=a + b * p - V, pp=2 * u * U, pq=a_s * s + b, qq=2 * v * V)


# The default: Klute and Hannaford's latex, E = 1.34 MPa.
LATEX = MooneyRivlin(c10=LATEX_C10, c01=LATEX_C01)

# The paper gives its silicone's modulus (1.78 MPa, uniaxial) but not its constants. 0.75
# times latex meets its two statements on free strain and collapse within its figures [R3].
SILICONE_KIM2021 = MooneyRivlin(c10=88.8e3, c01=79.3e3, youngs_modulus=1.78e6)

MATERIALS: Mapping[str, MooneyRivlin] = MappingProxyType(
    {"latex": LATEX, "silicone_kim2021": SILICONE_KIM2021}
)
