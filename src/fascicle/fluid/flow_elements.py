r"""Flow through valves, orifices and hoses: gas by ISO 6358, liquid by the root law.

`Line`: a hose, in series with a valve or an orifice. For a gas it is an element of ISO 6358 with,
in SI,

$$C = \frac{0.029\, d^2}{\sqrt{L/d^{1.25} + 510}}, \qquad b = 474\, \frac{C}{d^2}. \tag{F6}$$

For a liquid laminar and turbulent resistance are added,

$$\Delta p = a \dot m + c \dot m^2, \qquad a = \frac{128 \mu L}{\pi d^4 \rho}, \qquad
  c = \frac{8 f L}{\pi^2 d^5 \rho}: \tag{F7}$$

exact where one of them is small, too much by up to the smaller one where they are alike.

**Assumes** a smooth, round, straight hose, no inertia, no volume: its volume belongs to a
chamber's `dead_volume`. **Source:** (F6) as commonly cited from Eckersten's measurements (a test
holds it to within 17 % of Fanno's equation); (F7) Hagen and Poiseuille, Darcy and Weisbach.

`Orifice`: a liquid through an orifice, and a hose behind it.

$$\dot m = \frac{2 \Delta p}{a + \sqrt{a^2 + 4 c \sqrt{\Delta p^2 + \Delta p_{cr}^2}}}, \qquad
  c = \frac{1}{2 \rho (C_d A z)^2} + c_l, \qquad a = a_l. \tag{F8}$$

Without a hose that is $C_d A z \sqrt{2 \rho \Delta p}$ well above $\Delta p_{cr}$, the transition
to laminar flow, and linear below it. It is smooth everywhere, and zero where the opening $z$ is.

**Sign:** positive from 1 to 2. **Assumes** the density that is given on both sides. **Valid for**
pressures above the vapor's. **Source:** Merritt (1967), Hydraulic Control Systems, for the root
law; the transition is Simscape's; with a hose, derived here.

`SonicValve`: gas through a valve, by its data sheet.

From $p_1$, $T_1$ to a smaller $p_2$, absolute, with $r = p_2/p_1$,

$$\dot m = C \rho_0 p_1 \sqrt{\frac{T_0}{T_1}}\, \psi(r), \qquad
  \psi = \begin{cases}
    1 & r \le b \\
    \left(1 - \left(\frac{r - b}{1 - b}\right)^2\right)^m & b < r \le \beta \\
    \psi(\beta)\, \frac{1 - r}{1 - \beta} & \beta < r \end{cases} \tag{F4}$$

with $\beta = 0.999$: linear in $p_1 - p_2$ at last, where the root would have a vertical tangent.
The flow is continuous, with a kink at $\beta$; it is steepest at equal pressures.

A hose behind the valve is a second such element, $C_2$, $b_2$. The pair's $C$ is exact where it
chokes, its $b$ where the pressures are all but equal: with $q = C_2/C_1 \le 1/b_1$,

$$C = C_2\, \frac{b_1 + (1 - b_1) \sqrt{1 + q^2 (1 - 2 b_1)}}{1 + q^2 (1 - b_1)^2}, \qquad
  \frac{1 - b}{C^2} = \frac{1 - b_1}{C_1^2} + \frac{1 - b_2}{C_2^2}, \tag{F5}$$

and $C = C_1$ where $q$ is larger. Between, the pair is within 2 % of what the pressure between
them gives. Flow back meets the hose first, and is another.

**Sign:** positive from 1 to 2. **Assumes** the temperature kept through the valve, as an ideal
gas does. **Valid for** air as printed: $\rho_0$ = 1.185 kg/m³ at $T_0$ = 293.15 K and 100 kPa,
65 % humid, not $p/RT$ of dry air; for another gas give its `reference_density`, that of air times
$\sqrt{R_{air}/R}$ where $\gamma$ is alike.
**Source:** ISO 6358 (1989, 2013) for (F4); Sanville (1971) for its linear end; (F5) derived here.
"""

from typing import ClassVar

import numpy as np

from ..core.array_namespace import sqrt, where
from ..core.errors import InvalidInputError
from ..core.module import Module
from ..core.roots import guarded
from ..core.types import Batch, BoolBatch
from ..core.validation import Range, is_concrete
from .fields import ROOM_TEMPERATURE, component_field, interval_field, positive_field


class Line(Module):
    """Hose behind a valve: conductance for a gas, (F6), and resistances for a liquid, (F7).

    `length`, `diameter`: $L$, and $d$ inside [m]. `viscosity`: $\\mu$ of a liquid in it [Pa·s];
    left out, that of a hydraulic oil. `friction_factor`: Darcy's $f$ where it is turbulent [-].
    """

    length: Batch = positive_field("length", Range("m", 1e-3, 0.01, 100.0, 1e4))
    diameter: Batch = positive_field("diameter", Range("m", 1e-5, 3e-4, 0.05, 1.0))
    viscosity: Batch = positive_field(
        "viscosity", Range("Pa·s", 1e-6, 1e-4, 2.0, 1e4), default=0.039
    )
    friction_factor: Batch = positive_field(
        "friction_factor", Range("-", 1e-4, 5e-3, 0.1, 10.0), default=0.03
    )

    @property
    def conductance(self) -> Batch:
        """Sonic conductance $C$ [m³/(s·Pa)], equation (F6)."""
        d = self.diameter
        return 0.029 * d**2 / sqrt(self.length / d**1.25 + 510)

    @property
    def critical_pressure_ratio(self) -> Batch:
        """$b$ [-], equation (F6), which lies between 0 and 0.61 for every line."""
        return 474 * self.conductance / self.diameter**2

    def laminar_resistance(self, density: Batch) -> Batch:
        """$a$ of equation (F7) [Pa·s/kg] for a liquid of `density` [kg/m³]."""
        return 128 * self.viscosity * self.length / (np.pi * self.diameter**4 * density)

    def turbulent_resistance(self, density: Batch) -> Batch:
        """$c$ of equation (F7) [Pa·s²/kg²] for a liquid of `density` [kg/m³]."""
        drop = 8 * self.friction_factor * self.length
        return drop / (np.pi**2 * self.diameter**5 * density)


class Orifice(Module):
    """Orifice for liquid with a hose behind it, equation (F8).

    `area`: $A$, wide open [m²]. `density`: $\\rho$ of the liquid [kg/m³].
    `discharge_coefficient`: $C_d$ [-], in (0, 1]; left out, that of a sharp edge.
    `critical_pressure_difference`: $\\Delta p_{cr}$ [Pa]. `line`: a hose behind it, or none.
    """

    source: ClassVar[str] = "Merritt (1967)"

    area: Batch = positive_field("area", Range("m²", 1e-14, 1e-10, 1e-3, 10.0))
    density: Batch = positive_field(
        "density", Range("kg/m³", 1.0, 500.0, 2000.0, 2e4), default=850.0
    )
    discharge_coefficient: Batch = interval_field(
        "discharge_coefficient", 0.0, 1.0, closed=(False, True), default=0.611
    )
    critical_pressure_difference: Batch = positive_field(
        "critical_pressure_difference", Range("Pa", 1e-3, 1.0, 1e5, 1e7), default=1e3
    )
    line: Line | None = component_field("line", (Line,), default=None)

    def flow(
        self,
        absolute_1: Batch,
        absolute_2: Batch,
        T_1: Batch = 0,
        T_2: Batch = 0,
        opening: Batch = 1,
    ) -> Batch:
        """Mass flow [kg/s] from 1 to 2, negative back, equation (F8), at pressures `absolute_1`
        and `absolute_2` [Pa], both absolute or both gauge; `opening`: $z$ [-], from 0 to 1;
        temperatures `T_1`, `T_2` [K] don't count.
        """
        drop, z = absolute_1 - absolute_2, opening
        c_orifice = 1 / (2 * self.density * (self.discharge_coefficient * self.area) ** 2)
        root = sqrt(drop**2 + self.critical_pressure_difference**2)
        if self.line is None:
            return z * drop / sqrt(c_orifice * root)
        # z taken out of the root, so that nothing is divided by a closed orifice
        a = z * self.line.laminar_resistance(self.density)
        c = c_orifice + z**2 * self.line.turbulent_resistance(self.density)
        return 2 * z * drop / (a + sqrt(a**2 + 4 * c * root))


REFERENCE_DENSITY = 1.185  # kg/m³, as printed
LAMINAR_FROM = 0.999  # β
_DATA_SHEET = "take it from the valve's data sheet"


class SonicValve(Module):
    """Valve for gas, equation (F4), with a hose behind it (F5).

    `C`: sonic conductance [m³/(s·Pa)], wide open; 1 L/(s·bar) is 1e-8. `b`: critical pressure
    ratio [-]. `m`: subsonic index [-]. `line`: a hose. `reference_density`: $\\rho_0$ [kg/m³].
    """

    source: ClassVar[str] = "ISO 6358 (1989, 2013)"

    C: Batch = positive_field("C", Range("m³/(s·Pa)", 1e-15, 1e-12, 1e-6, 1e-3), _DATA_SHEET)
    b: Batch = interval_field("b", 0.0, 1.0, remedy=_DATA_SHEET)
    m: Batch = interval_field("m", 0.0, 1.0, closed=(False, True), default=0.5)
    line: Line | None = component_field("line", (Line,), default=None)
    reference_density: Batch = positive_field(
        "reference_density", Range("kg/m³", 1e-3, 0.05, 10.0, 100.0), default=REFERENCE_DENSITY
    )

    def __check_init__(self):
        if self.line is not None and is_concrete(self.m) and np.any(np.asarray(self.m) != 0.5):
            m = float(np.max(self.m))
            raise InvalidInputError("m", "must be 0.5 with a `line`", m, "leave `m` or `line` out")

    def flow(
        self, absolute_1: Batch, absolute_2: Batch, T_1: Batch, T_2: Batch, opening: Batch = 1.0
    ) -> Batch:
        """Mass flow [kg/s] from 1 to 2, negative back, equation (F4), at pressures `absolute_1`
        and `absolute_2` [Pa] and temperatures `T_1` and `T_2` [K], of which that upstream counts;
        `opening`: of the valve [-], from 0 to 1.
        """
        onward = absolute_1 >= absolute_2
        high = where(onward, absolute_1, absolute_2)
        low = where(onward, absolute_2, absolute_1)
        T = where(onward, T_1, T_2)
        C, b = self.hose_series(onward, opening)
        ratio = low / guarded(high > 0, high)
        turbulent = ratio < LAMINAR_FROM
        psi = flow_function(where(turbulent, ratio, LAMINAR_FROM), b, self.m)
        driving = where(turbulent, high, (high - low) / (1 - LAMINAR_FROM))
        size = C * self.reference_density * sqrt(ROOM_TEMPERATURE / T) * psi * driving
        return where(onward, size, -size)

    def hose_series(self, onward: BoolBatch, opening: Batch) -> tuple[Batch, Batch]:
        """Conductance [m³/(s·Pa)] and critical ratio [-] of valve and hose in series."""
        C = opening * self.C
        if self.line is None:
            return C, self.b
        hose, b = self.line.conductance, self.line.critical_pressure_ratio
        first = where(onward, C, hose), where(onward, self.b, b)
        return in_series(*first, where(onward, hose, C), where(onward, b, self.b))


def in_series(C_1: Batch, b_1: Batch, C_2: Batch, b_2: Batch) -> tuple[Batch, Batch]:
    """Conductance [m³/(s·Pa)] and critical ratio [-] of two elements in series, (F5), from theirs;
    one conductance may be zero.
    """
    narrow_end = b_1 * C_2 < C_1  # else the first one alone decides where they choke
    q = where(narrow_end, C_2 / guarded(narrow_end, C_1), 1 / b_1)
    inside = 1 + q**2 * (1 - 2 * b_1)
    between = (b_1 + (1 - b_1) * sqrt(inside)) / (1 + q**2 * (1 - b_1) ** 2)
    of_first = where(narrow_end, q * between, 1.0)
    of_second = where(narrow_end, between, C_1 / guarded(C_2 > 0, C_2))
    C = where(narrow_end, C_2 * between, C_1)
    return C, 1 - of_first**2 * (1 - b_1) - of_second**2 * (1 - b_2)


def flow_function(ratio: Batch, b: Batch, m: Batch = 0.5) -> Batch:
    """Flow over its choked flow, $\\psi$ [-] of (F4), at a pressure `ratio` below 1 [-]."""
    y = where(ratio > b, (ratio - b) / (1 - b), 0.0)
    return (1 - y**2) ** m
