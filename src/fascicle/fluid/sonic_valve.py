r"""Gas through a valve, by what its data sheet says: ISO 6358.

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
them gives (60 random pairs, a test); next to equal pressures, beyond 0.998, up to 41 % more flows
than through two linear ends. Flow back meets the hose first, and is another.

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
from ..core.types import Batch, BatchLike, BoolBatch
from ..core.validation import Range, is_concrete
from .entry import ROOM_TEMPERATURE, above_zero, between, part
from .line import Line


REFERENCE_DENSITY = 1.185  # kg/m³, as printed
LAMINAR_FROM = 0.999  # β
_DATA_SHEET = "take it from the valve's data sheet"


class SonicValve(Module):
    """A gas valve: equation (F4), with a hose behind it (F5).

    `C`: sonic conductance [m³/(s·Pa)], wide open; 1 L/(s·bar) is 1e-8. `b`: critical pressure ratio
    [-]. `m`: subsonic index [-]. `line`: a hose behind it [-], or none. `reference_density`:
    $\\rho_0$ [kg/m³].
    """

    source: ClassVar[str] = "ISO 6358 (1989, 2013)"

    C: Batch = above_zero("C", Range("m³/(s·Pa)", 1e-15, 1e-12, 1e-6, 1e-3), _DATA_SHEET)
    b: Batch = between("b", 0.0, 1.0, remedy=_DATA_SHEET)
    m: Batch = between("m", 0.0, 1.0, closed=(False, True), default=0.5)
    line: Line | None = part("line", (Line,), default=None)
    reference_density: Batch = above_zero(
        "reference_density", Range("kg/m³", 1e-3, 0.05, 10.0, 100.0), default=REFERENCE_DENSITY
    )

    def __check_init__(self):
        if self.line is not None and is_concrete(self.m) and np.any(np.asarray(self.m) != 0.5):
            remedy = "leave `m` or `line` out"
            raise InvalidInputError("m", "must be 0.5 with a `line`", float(np.max(self.m)), remedy)

    def flow(
        self,
        absolute_1: BatchLike,
        absolute_2: BatchLike,
        temperature_1: BatchLike,
        temperature_2: BatchLike,
        opening: BatchLike = 1.0,
    ) -> Batch:
        """Mass flow from 1 to 2, equation (F4).

        **Arguments:**

        - `absolute_1`, `absolute_2`: pressures on both sides, absolute [Pa].
        - `temperature_1`, `temperature_2`: of the gas there [K]; that upstream counts.
        - `opening`: share of the valve that is open [-], from 0, where nothing flows, to 1.

        **Returns:** mass flow [kg/s], negative from 2 to 1.
        """
        onward = absolute_1 >= absolute_2
        high = where(onward, absolute_1, absolute_2)
        low = where(onward, absolute_2, absolute_1)
        T = where(onward, temperature_1, temperature_2)
        C, b = self._passage(onward, opening)
        ratio = low / guarded(high > 0, high)
        turbulent = ratio < LAMINAR_FROM
        share = _choking(where(turbulent, ratio, LAMINAR_FROM), b, self.m)
        driving = where(turbulent, high, (high - low) / (1 - LAMINAR_FROM))
        size = C * self.reference_density * sqrt(ROOM_TEMPERATURE / T) * share * driving
        return where(onward, size, -size)

    def _passage(self, onward: BoolBatch, opening: BatchLike) -> tuple[Batch, Batch]:
        """Conductance [m³/(s·Pa)] and critical ratio [-], the hose's included."""
        own = opening * self.C
        if self.line is None:
            return own, self.b
        hose, b = self.line.conductance, self.line.critical_pressure_ratio
        first = where(onward, own, hose), where(onward, self.b, b)
        return in_series(*first, where(onward, hose, own), where(onward, b, self.b))


def in_series(C_1: Batch, b_1: Batch, C_2: Batch, b_2: Batch) -> tuple[Batch, Batch]:
    """Conductance [m³/(s·Pa)] and critical ratio [-] of one element behind another, equation (F5).

    **Arguments:**

    - `C_1`, `b_1`: of the first, upstream: conductance [m³/(s·Pa)] and critical ratio [-].
    - `C_2`, `b_2`: of the second [m³/(s·Pa)], [-]; one of both conductances may be zero.

    **Returns:** those of the pair [m³/(s·Pa)], [-].
    """
    narrow_end = b_1 * C_2 < C_1  # else the first one alone decides where they choke
    q = where(narrow_end, C_2 / guarded(narrow_end, C_1), 1 / b_1)
    inside = 1 + q**2 * (1 - 2 * b_1)
    between = (b_1 + (1 - b_1) * sqrt(inside)) / (1 + q**2 * (1 - b_1) ** 2)
    of_first = where(narrow_end, q * between, 1.0)
    of_second = where(narrow_end, between, C_1 / guarded(C_2 > 0, C_2))
    C = where(narrow_end, C_2 * between, C_1)
    return C, 1 - of_first**2 * (1 - b_1) - of_second**2 * (1 - b_2)


def _choking(ratio: BatchLike, b: Batch, m: Batch) -> Batch:
    """$\\psi$ [-] at a pressure `ratio` [-] up to $\\beta$."""
    y = where(ratio > b, (ratio - b) / (1 - b), 0.0)
    return (1 - y**2) ** m
