r"""Gases and liquids, and their specific energies and exergies.

A gas is ideal, $p = \rho R T$, with constant $c_p = \gamma R/(\gamma - 1)$ and $c_v = c_p - R$.
Its largest work in a room at $p_a$, $T_a$ is its exergy: streaming, and at rest in a volume,

$$e = c_p (T - T_a) - T_a \left(c_p \ln\frac{T}{T_a} - R \ln\frac{p}{p_a}\right), \tag{F1}$$
$$E = m \left(c_v (T - T_a) + p_a (v - v_a)
    - T_a \left(c_p \ln\frac{T}{T_a} - R \ln\frac{p}{p_a}\right)\right). \tag{F2}$$

A liquid has one temperature and a constant bulk modulus $K$, so that at gauge pressure $p$

$$\rho = \rho_0 e^{p/K}, \qquad h = \int_0^p \frac{\mathrm{d}p'}{\rho}
   = \frac{K}{\rho_0} \left(1 - e^{-p/K}\right), \qquad e = \int \frac{p\,\mathrm{d}\rho}{\rho^2}
   = h - \frac{p}{\rho}: \tag{F3}$$

$h$ is the energy of a streaming kilogram, $e$ that of a kilogram at rest.

**Valid for** gases far from where they become liquid, some 100 kPa to 2 MPa and 230 to 400 K.
**Source:** Bejan (2016), Advanced Engineering Thermodynamics, for exergies; constants beside them.
"""

from ..core.array_namespace import absolute as size_of
from ..core.array_namespace import exp, expm1, log, logical_not, where
from ..core.module import Module, static
from ..core.roots import guarded
from ..core.types import Batch
from ..core.validation import Range
from .fields import positive_field


class Gas(Module):
    """An ideal gas of constant heat capacities.

    `specific_gas_constant`: $R$ [J/(kg·K)]. `heat_capacity_ratio`: $\\gamma$ [-], above 1.
    `source`: of its numbers.
    """

    specific_gas_constant: Batch = positive_field(
        "specific_gas_constant", Range("J/(kg·K)", 10.0, 30.0, 4200.0, 1e4)
    )
    # 5/3, of a monatomic gas, is usual however it is rounded
    heat_capacity_ratio: Batch = positive_field(
        "heat_capacity_ratio", Range("-", 1.001, 1.05, 5 / 3 + 1e-9, 2.0)
    )
    source: str = static(default="")

    @property
    def c_p(self) -> Batch:
        """Heat capacity at constant pressure [J/(kg·K)]."""
        return self.heat_capacity_ratio * self.c_v

    @property
    def c_v(self) -> Batch:
        """Heat capacity at constant volume [J/(kg·K)]."""
        return self.specific_gas_constant / (self.heat_capacity_ratio - 1)

    def density(self, absolute: Batch, temperature: Batch) -> Batch:
        """Density [kg/m³] at `absolute` pressure [Pa] and `temperature` [K]."""
        return absolute / (self.specific_gas_constant * temperature)

    def flow_exergy(
        self, absolute: Batch, temperature: Batch, room_pressure: Batch, room_temperature: Batch
    ) -> Batch:
        """Exergy [J/kg] of a streaming kilogram, (F1), at a positive `absolute` pressure [Pa] and
        `temperature` [K], in a room of absolute `room_pressure` [Pa] and `room_temperature` [K].
        """
        p, T, p_a, T_a = absolute, temperature, room_pressure, room_temperature
        return self.c_p * (T - T_a) - T_a * self._entropy(p, T, p_a, T_a)

    def stored_exergy(
        self,
        mass: Batch,
        absolute: Batch,
        temperature: Batch,
        room_pressure: Batch,
        room_temperature: Batch,
    ) -> Batch:
        """Exergy [J] of a `mass` [kg] at rest in a volume, (F2); others as of `flow_exergy`."""
        p, T, p_a, T_a = absolute, temperature, room_pressure, room_temperature
        p = guarded(p > 0, p, p_a)
        room_work = self.specific_gas_constant * (T * p_a / p - T_a)
        entropy = self._entropy(p, T, p_a, T_a)
        return mass * (self.c_v * (T - T_a) + room_work - T_a * entropy)

    def _entropy(self, p: Batch, T: Batch, p_a: Batch, T_a: Batch) -> Batch:
        """Entropy over the room's [J/(kg·K)]; zero instead of a logarithm of zero."""
        p, T = guarded(p > 0, p, p_a), guarded(T > 0, T, T_a)
        return self.c_p * log(T / T_a) - self.specific_gas_constant * log(p / p_a)


class Liquid(Module):
    """A liquid of constant bulk modulus, equation (F3).

    `reference_density`: $\\rho_0$ at the room's pressure [kg/m³]. `bulk_modulus`: $K$ [Pa].
    `vapor_pressure`: absolute [Pa]. `source`: of its numbers.
    """

    reference_density: Batch = positive_field(
        "reference_density", Range("kg/m³", 1.0, 500.0, 2000.0, 2e4)
    )
    bulk_modulus: Batch = positive_field("bulk_modulus", Range("Pa", 1e5, 1e8, 1e10, 1e12))
    vapor_pressure: Batch = positive_field("vapor_pressure", Range("Pa", 1e-12, 1e-6, 2e4, 1e6))
    source: str = static(default="")

    def density(self, pressure: Batch) -> Batch:
        """Density $\\rho$ [kg/m³] at gauge `pressure` [Pa]."""
        return self.reference_density * exp(pressure / self.bulk_modulus)

    def flow_energy(self, pressure: Batch) -> Batch:
        """Specific enthalpy over that of the room, $h$ [J/kg], at gauge `pressure` [Pa]."""
        K, rho_0 = self.bulk_modulus, self.reference_density
        return -K / rho_0 * expm1(-pressure / K)

    def stored_energy(self, pressure: Batch) -> Batch:
        """Specific energy at rest, $e$ [J/kg], at gauge `pressure` [Pa]."""
        K, rho_0 = self.bulk_modulus, self.reference_density
        x = pressure / K
        # h and p/ρ agree in all but the last digits where x is small: their series there
        small = size_of(x) < 1e-2
        s, far = guarded(small, x, 0.0), guarded(logical_not(small), x, 1.0)
        series = s**2 * (1 / 2 - s * (1 / 3 - s * (1 / 8 - s * (1 / 30 - s * (1 / 144 - s / 840)))))
        return K / rho_0 * where(small, series, 1 - (1 + far) * exp(-far))


AIR = Gas(287.05, 1.4, "dry air: ISO 2533 (1975)")
NITROGEN = Gas(296.80, 1.4, "8.31446 J/(mol·K) over 28.0134 g/mol: CODATA 2018, IUPAC 2021")
# mineral oil's vapor pressure is far below a pascal in a room: dissolved air comes out first
OIL = Liquid(850.0, 1.4e9, 1e-2, "hydraulic oil, 46 mm²/s: Wolfram SystemModeler, Hydraulic.Media")
WATER = Liquid(998.21, 2.18e9, 2339.0, "at 20 °C: IAPWS-95")
