r"""Empirical laws of Festo's muscles, with the constants published for single muscles.

Sárosi's six numbers, which take nothing from the muscle: its sizes say only how it buckles,

$$F = (a P + b)\, e^{c \varepsilon} + d P \varepsilon + e P + f, \tag{S}$$

with an exponential that dies out after a few percent and a plane.

Bolen's largest force that grows with length, and two exponentials,

$$F = F_m \left(a_0 (e^{-a_1 \varepsilon/\varepsilon_m} - 1)
  + \frac{P}{P_m} e^{-a_3 (\varepsilon/\varepsilon_m)^2}\right), \qquad
  F_m = F_\infty \arctan\frac{L_0 - l_0}{l_1}, \tag{BF}$$

with $P_m$ = 620 kPa and $\varepsilon_m$ the largest contraction at $P_m$, measured on the muscle.

Martens and Boblan's wall, whose modulus follows its length. Fibers at $\theta = \alpha_0 + \delta$
enclose the bore, of the inner radius $r_i$; with
$\rho = D/D_0 = \sqrt{1 + \varepsilon (2 - \varepsilon) \cot^2\theta}$

$$T = \pi r_i^2 P \left(3 \lambda^2 \cot^2\theta - \frac{1}{\sin^2\theta}\right)
  - 2 \pi r_i t_0 E(\lambda) \left((\lambda - 1) \rho
  + \frac{\rho - 1}{\rho} \lambda^2 \cot^2\theta\right), \quad
  E = \sum_{k=0}^3 e_k \lambda^k. \tag{MB}$$

The polynomial and the correction $\delta$ of the braid angle, in radians, are fitted to one
muscle. It is published over the length in meters; here it is one of $\lambda = L/L_0$, which is
equal at the fitted length and scales with the muscle at others. The wall's axial term has the
published sign: it pulls where the muscle is shorter than at rest, and the fit of $E$ makes up for
it. The wall keeps its thickness. Where fibers at $\theta$ are nearly straight the wall's force is
constant.

In (S) and (BF) the terms that grow with pressure are counted as the mesh's, the others as the
bladder's.

**Sign:** pull and contraction positive. **Assumes** nothing: fits to pulling muscles. **Valid for**
the muscles they were fitted to, from rest to the free strain: (S) above some 0.5 bar (without
pressure it gives small forces that aren't zero); (BF) from 0 to 620 kPa, some 0.1 to 0.5 m; (MB) at
$\alpha_0$ = 28.6 deg and $t_0$ = 1.8 mm.
**Source:** Sárosi (2012, 2017); Bolen; Martens and Boblan (2017) and its erratum (2018): constants
and forms as quoted by the public code of the Agile and Adaptive Robotics laboratory, Portland State
University (functions f_festo and maxBPAforce for (BF), whose comparison calls the law Bolen's), not
from the papers.
"""

from collections.abc import Iterator, Sequence
from typing import ClassVar, Self

import numpy as np

from ...core.array_namespace import arctan, exp, minimum, sin, sqrt, tan, where
from ...core.parameters import POSITIVE, Constant, log1p_scale, symmetric_scale
from ...core.roots import root
from ...core.types import Batch, BatchLike, Values
from ...core.validation import to_si
from ..bladder import Bladder
from . import AbstractTension, Offset, Pull, force_residual


class AbstractEmpirical(AbstractTension):
    """A law whose constants are `published` for one muscle, in the order and units of its `rows`.

    A row: name, symbol, dimension, unit [SI], bounds, meaning. Two bounds instead of four are
    ratios to the published number, of a constant of either sign.
    """

    conservative: ClassVar[bool] = False
    linear_in_pressure: ClassVar[bool] = True
    rows: ClassVar[tuple[tuple, ...]]
    rows_source: ClassVar[str]
    published: ClassVar[tuple[float, ...]]

    def __init_subclass__(cls, **options: object) -> None:
        if "published" in vars(cls):
            for constant in cls.published_constants():
                cls.__annotations__[constant.name] = Batch
                setattr(cls, constant.name, constant.field())
        super().__init_subclass__(**options)

    @classmethod
    def published_constants(cls) -> Iterator[Constant]:
        """Declarations of the law's constants, with the published values [SI] as defaults."""
        for row, number in zip(cls.rows, cls.published, strict=True):
            name, symbol, dimension, unit, limits, about = row
            value, bounds, scale = number * unit, limits, POSITIVE
            if len(limits) == 2:
                usual, possible = (ratio * abs(value) for ratio in limits)
                bounds, scale = (-possible, -usual, usual, possible), symmetric_scale(abs(value))
            elif limits[0] <= 0:
                scale = symmetric_scale(limits[3] / 10) if limits[0] else log1p_scale(5e-3)
            source = cls.rows_source
            yield Constant(name, symbol, dimension, bounds, scale, value, about, source)

    def _numbers(self) -> list[Batch]:
        """Values of the constants, in their order."""
        return [getattr(self, constant.name) for constant in self.constants()]


_BAR, _PERCENT = 1e5, 1e-2  # the papers' units in SI
_SIGNED = (100, 1e6)  # of a constant of either sign: past the largest ratio it is a slip


class AbstractSarosi(AbstractEmpirical):
    """Six numbers for a muscle of one size, equation (S), published for bar and percent."""

    rows = (
        ("exponential_slope", "a", "slip", 1 / _BAR, _SIGNED,
         "slope of the exponential with pressure"),
        ("exponential_force", "b", "force", 1.0, _SIGNED, "exponential at zero pressure"),
        ("exponent", "c", "number", 1 / _PERCENT, _SIGNED,
         "rate of the exponential over the strain"),
        ("strain_slope", "d", "slip", 1 / (_BAR * _PERCENT), _SIGNED,
         "slope of the plane with pressure and strain"),
        ("pressure_slope", "e", "slip", 1 / _BAR, _SIGNED, "slope of the plane with pressure"),
        ("force_offset", "f", "force", 1.0, _SIGNED, "offset of the plane"),
    )  # fmt: skip
    rows_source, free = "Sárosi (2012)", tuple(name for name, *_ in rows)

    def pull(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Pull:
        """Terms that grow with pressure, and the others [N], equation (S)."""
        a, b, c, d, e, f = self._numbers()
        fading = exp(c * strain)
        return Pull(
            mesh=pressure * (a * fading + d * strain + e),
            bladder=b * fading + f,
            mesh_slope=pressure * (a * c * fading + d),
            bladder_slope=b * c * fading + 0.0 * pressure,
        )


class Sarosi(AbstractSarosi):
    """(S) with the constants published for a Festo DMSP-20-200N as defaults."""

    name, title = "sarosi", "Sárosi, DMSP-20-200"
    source = "Sárosi (2012), 20 mm, 200 mm long"
    reference_muscle, reference_diameter, reference_length = "a Festo DMSP-20-200N", 20e-3, 0.2
    published = -4.00180705, 292.4620246, -0.32930845, -9.33564098, 294.0538256, -280.498151


class Sarosi10(AbstractSarosi):
    """(S) with constants published in 2012 for a 10 mm Festo DMSP-10, as defaults."""

    name, title, source = "sarosi_10", "Sárosi, DMSP-10", "Sárosi (2012), 10 mm"
    reference_muscle, reference_diameter = "a Festo DMSP-10", 10e-3
    published = -9.2194029, 203.7012413, -0.34221042, -3.2255991, 109.2038216, -208.372034


class Sarosi20Long(AbstractSarosi):
    """(S) with the constants published for a Festo muscle of 20 mm, 400 mm long as defaults."""

    name, title = "sarosi_20_400", "Sárosi, DMSP-20-400"
    source = "Sárosi (2017), 20 mm, 400 mm long"
    reference_muscle = "a Festo muscle of 20 mm, 400 mm long"
    reference_diameter, reference_length = 20e-3, 0.4
    published = -4.35573, 281.2237, -0.32866, -9.27035, 302.20107, -263.69185


_HIGHEST = 620e3  # Pa, P_m of the published law
_LEAST = 1e-6  # of an arc: a muscle too short to hold anything still has a free strain
_SMALL = (1e-3, 1e-2, 30.0, 100.0)  # bounds wide of the published numbers


class AbstractBolen(AbstractEmpirical):
    """A largest force that grows with length, and two exponentials, equation (BF)."""

    source: ClassVar[str] = "Bolen, as public code of the Agile and Adaptive Robotics laboratory"
    rows_source = "Agile and Adaptive Robotics laboratory, public code"
    rows = (
        ("bladder_share", "a_0", "number", 1.0, _SMALL,
         "share of the largest force that the bladder takes"),
        ("bladder_rate", "a_1", "number", 1.0, _SMALL, "rate of the bladder's rise"),
        ("pressure_rate", "a_3", "number", 1.0, _SMALL, "rate of the mesh's fall"),
        ("largest_strain", r"\varepsilon_m", "number", 1.0, (0.01, 0.05, 0.4, 0.6),
         "largest strain at 620 kPa, measured"),
        # the largest force is published over kPa, its length times kPa
        ("force_scale", r"F_\infty", "force", _HIGHEST / 1e3, (1e-2, 1.0, 1e5, 1e6),
         "scale of the largest force"),
        ("length_scale", "l_1", "length", 1e3 / _HIGHEST, (1e-4, 1e-3, 1.0, 10.0),
         "length over which the largest force rises"),
        ("end_length", "l_0", "length", 1.0, (0.0, 0.0, 0.1, 1.0), "muscle length at zero force"),
    )  # fmt: skip

    def blocked_force(self, length: BatchLike) -> Batch:
        """Blocked force $F_m$ [N] at 620 kPa of a muscle of `length` [m]."""
        *_, force_scale, length_scale, end_length = self._numbers()
        ratio = (length - end_length) / length_scale
        return force_scale * arctan(where(ratio > _LEAST, ratio, _LEAST))

    def pull(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Pull:
        """Terms that grow with pressure, and the others [N], equation (BF)."""
        a0, a1, a3, largest_strain, *_ = self._numbers()
        F_m, x = self.blocked_force(bladder.braid.length), strain / largest_strain
        exponential, bell = exp(-a1 * x), exp(-a3 * x**2)
        F = F_m * pressure / _HIGHEST
        per_strain = 1 / largest_strain
        return Pull(
            mesh=F * bell,
            bladder=F_m * a0 * (exponential - 1) + 0.0 * pressure,
            mesh_slope=-2 * a3 * x * F * bell * per_strain,
            bladder_slope=-a1 * F_m * a0 * exponential * per_strain + 0.0 * pressure,
        )


class Bolen(AbstractBolen):
    """(BF) with the constants published for Festo muscles of 10 mm as defaults."""

    name, title = "bolen", "Bolen, 10 mm"
    reference_muscle, reference_diameter = "Festo muscles of 10 mm", 10e-3
    # largest strains: 0.149 to 0.175 in muscles of 153 to 281 mm (Hunt et al. 2017, in that code)
    published = 0.5682, 4.254, 0.5597, 0.17, 0.4895, 1 / 0.03068, 7.5e-3


class Bolen20(AbstractBolen):
    """(BF) with the constants published for Festo muscles of 20 mm as defaults."""

    name, title = "bolen_20", "Bolen, 20 mm"
    reference_muscle, reference_diameter = "Festo muscles of 20 mm", 20e-3
    # the largest strain is a quarter, as that code takes it
    published = 0.2579, 6.477, 1.321, 0.25, 1.4877, 1 / 0.0248, 7.5e-3


_STRAIGHT = 0.02  # of ρ²: below it fibers are nearly straight, and the wall's force is constant


def moduli_by_stretch(length: float, *moduli: float) -> tuple[float, ...]:
    """Coefficients $e_k$ of the stretch [Pa] from `moduli` published over the length in meters,
    [Pa/m^k], for a muscle of a `length` [m].
    """
    return tuple(number * length**power for power, number in enumerate(moduli))


class AbstractMartens(AbstractEmpirical):
    """An ideal mesh and a wall whose modulus follows its length, equation (MB)."""

    rows = (
        *((f"modulus_{power}", f"e_{power}", "pressure", 1.0, (10, 1e3),
           f"coefficient of λ^{power} in the wall's modulus, λ: stretch") for power in range(4)),
        ("angle_correction", r"\delta", "angle", 1.0, (-0.5, -0.3, 0.3, 0.5),
         "correction added to the braid angle"),
    )  # fmt: skip
    rows_source = "Martens and Boblan (2017)"
    angle_correction: ClassVar[Batch]

    @classmethod
    def from_published(
        cls, length: Values, moduli: Sequence[float], angle_correction: Values
    ) -> Self:
        """Law with constants in the form of the paper.

        **Arguments:**

        - `length`: of the muscle that they were fitted to [m].
        - `moduli`: coefficients of the powers 0 to 3 of the length, [Pa] over the power of a meter.
        - `angle_correction`: $\\delta$ [rad].

        **Returns:** the law, whose `modulus_0` to `modulus_3` are those of the stretch [Pa].
        """
        numbers = *moduli_by_stretch(to_si(length, "length", "m"), *moduli), angle_correction
        names = (constant.name for constant in cls.constants())
        return cls(**dict(zip(names, numbers, strict=True)))

    def pull(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Pull:
        """Mesh and wall force [N], equation (MB)."""
        theta = bladder.braid.angle + self.angle_correction
        cot2, lam, r_i = 1 / tan(theta) ** 2, 1 - strain, bladder.inner_radius
        unit = np.pi * r_i**2 * pressure
        wall, wall_slope = self._wall(cot2, lam)
        section = 2 * np.pi * r_i * bladder.wall_thickness
        return Pull(
            mesh=unit * (3 * lam**2 * cot2 - 1 / sin(theta) ** 2),
            bladder=-section * wall,
            mesh_slope=-6 * unit * lam * cot2,
            bladder_slope=section * wall_slope + 0.0 * pressure,
        )

    def _wall(self, cot2: Batch, lam: BatchLike) -> tuple[Batch, Batch]:
        """Wall stress, $E$ times the bracket of (MB) [Pa], and its slope in $\\lambda$ [Pa]."""
        e0, e1, e2, e3, _ = self._numbers()
        longest = sqrt(1 + (1 - _STRAIGHT) / cot2)
        straight = longest < lam
        lam = minimum(lam, longest)
        E = e0 + lam * (e1 + lam * (e2 + lam * e3))
        E_slope = e1 + lam * (2 * e2 + lam * 3 * e3)
        rho = sqrt(1 + (1 - lam**2) * cot2)
        rho_slope = -lam * cot2 / rho
        bracket = (lam - 1) * rho + (1 - 1 / rho) * lam**2 * cot2
        slope = rho + (lam - 1) * rho_slope + cot2 * (
            rho_slope / rho**2 * lam**2 + 2 * lam * (1 - 1 / rho)
        )  # fmt: skip
        return E * bracket, where(straight, 0.0, E_slope * bracket + E * slope)

    def free_strain(self, bladder: Bladder, pressure: BatchLike, offset: Offset) -> Batch:
        """Free strain [-], the first at which the force equals `offset`, at most the mesh's."""
        cot2 = 1 / tan(bladder.braid.angle + self.angle_correction) ** 2
        far = 1 - sqrt((1 + 1 / cot2) / 3) + 0.0 * pressure
        theta = (self, bladder, pressure, offset(pressure))
        low = 0.5 * bladder.braid.straight_strain + 0.0 * far
        zero = root(force_residual, theta, low, far, 0.5 * far)
        # a muscle that still pulls there has no root before it, and the derivatives of the end
        return where(force_residual(theta, far)[0] > 0, far, zero)


class Martens2017(AbstractMartens):
    """(MB) with the constants published for a Festo DMSP-10-250 as defaults."""

    name, title = "martens2017", "Martens-Boblan, DMSP-10-250"
    source = "Martens and Boblan (2017), DMSP-10-250"
    reference_muscle, reference_diameter, reference_length = "a Festo DMSP-10-250", 10e-3, 0.25
    published = *moduli_by_stretch(0.25, 7.4085e07, -6.892e08, 1.837e09, -8.4879e08), -0.1


class Martens201720(AbstractMartens):
    """(MB) with the constants published for a Festo DMSP-20-300 as defaults."""

    name, title = "martens2017_20", "Martens-Boblan, DMSP-20-300"
    source = "Martens and Boblan (2017), DMSP-20-300"
    reference_muscle, reference_diameter, reference_length = "a Festo DMSP-20-300", 20e-3, 0.3
    published = *moduli_by_stretch(0.3, 9.3232e07, -7.1529e08, 1.5483e09, -5.0295e08), -0.073
