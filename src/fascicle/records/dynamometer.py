r"""A virtual dynamometer: the protocol of section 5.3 on a model of a muscle.

The muscle contracts freely at the highest pressure, which gives the stroke; it is cycled
until its rubber has softened; then, pressure by pressure, the plates close by the stroke
and open again, slowly. A reading at pressure $P_i$ and strain $\varepsilon$ on branch
$b = \pm 1$ (1 while it contracts) is

$$F = m_i\text{-stiffened } F(P_i, \varepsilon) - \tfrac{b}{2} h F(P_i, 0) + \text{noise}, \qquad
  m_i = 1 + m\, e^{-c_i/c}. \tag{D1}$$

*Hysteresis* is friction between fibers, which opposes motion and grows with pressure: a
muscle pulls harder while it is drawn out than while it contracts. *Mullins softening*: in
its first cycles the rubber is stiffer by $m$, which decays over $c$ cycles; a pressure
counts as one cycle, after those of preconditioning. *Fabrication scatter*: muscles built to one
drawing differ slightly: their length and braid angle are normally distributed,

$$L = L_0 (1 + s_L z_1), \qquad \alpha = \alpha_0 + s_\alpha z_2, \tag{D2}$$

independent of each other and from one muscle to the next.

**Not simulated:** creep, dynamics, temperature, the softening's dependence on the largest
strain. Every record is synthetic, and marked as such.
**Source:** Kim, Mazzoleni and Bryant (2021), sections 5.3 and 6; friction between fibers after
Chou and Hannaford (1996); softening after Mullins (1969).
"""

from functools import partial
from typing import Any

import attrs
import numpy as np

from ..core.errors import InvalidInputError
from ..core.module import with_fields
from ..core.types import Batch, BatchLike, Values
from ..core.validation import HIGHEST_PRESSURE
from ..fluid.fields import interval_field
from ..muscle import Muscle
from ..muscle.materials import AbstractMaterial, Slopes
from ..units import pretty
from .record import Record


_LEVELS = tuple(413.7e3 * i / 12 for i in range(13))  # Pa, 0 to 60 psi in steps of 5 psi
_MAX_SCATTER = 0.2  # of the length, and rad: more is no scatter of one drawing
_field_from_zero = partial(interval_field, low=0.0, high=np.inf, closed=(True, False))
_share_field = partial(_field_from_zero, high=1.0, remedy='5 % is 0.05 or "5 %"')
_positive_field = partial(interval_field, low=0.0, high=np.inf)
_scatter_field = partial(
    interval_field, low=0.0, high=_MAX_SCATTER, closed=(True, True), default=0.0
)


class StiffenedMaterial(AbstractMaterial):
    """A `material` with its stiffness times a `factor` [-]."""

    material: AbstractMaterial
    factor: Batch

    @property
    def youngs_modulus(self) -> Batch:
        """$E$ [Pa]."""
        return self.factor * self.material.youngs_modulus

    @property
    def poisson_ratio(self) -> Batch:
        """$\\nu$ [-]."""
        return self.material.poisson_ratio

    def energy(self, axial_squared: BatchLike, hoop_squared: BatchLike) -> Batch:
        """Energy density $W$ [J/m³] at squared stretches $\\lambda_1^2$, $\\lambda_2^2$ [-]."""
        return self.factor * self.material.energy(axial_squared, hoop_squared)

    def slopes(self, axial_squared: BatchLike, hoop_squared: BatchLike) -> Slopes:
        """Slopes of the energy density [J/m³] over the squared stretches [-]."""
        slopes = self.material.slopes(axial_squared, hoop_squared)
        return Slopes(*(self.factor * slope for slope in slopes))


@attrs.frozen(slots=False)
class Scatter:
    """Standard deviations of `length`, over the length itself [-], and `braid_angle` [rad]."""

    length: Values = _scatter_field("length")
    braid_angle: Values = _scatter_field("braid_angle", unit="rad")

    def draw(self, muscle: Muscle, generator: np.random.Generator, size: Any = ()) -> Muscle:
        """Muscle with a random length and braid angle, or a batch of them of shape `size`; the
        means are the `muscle`'s, the numbers the `generator`'s.
        """
        z = generator.standard_normal((2, *size))
        length = muscle.length * (1 + self.length * z[0])
        angle = muscle.braid_angle + self.braid_angle * z[1]
        return with_fields(muscle, length=length, braid_angle=angle)


@attrs.frozen
class VirtualDynamometer:
    """A machine and its faults. By default only the load cell's noise is simulated.

    - `pressures`: gauge pressures in the order of the test [Pa].
    - `samples`: readings in one sweep, at least 2.
    - `both_ways`: false to record the contraction alone.
    - `speed`: of the plates [m/s], from which the readings' times follow.
    - `noise`: of the load cell, standard deviation over the largest force [-].
    - `resolution`: step of the load cell's readings [N]; 0 for none.
    - `pressure_noise`: of the transducer, standard deviation [Pa]; a reading below zero becomes 0.
    - `displacement_noise`: of the gauge of length, standard deviation [m].
    - `hysteresis`: width of the loop over the blocked force at that pressure [-].
    - `mullins`: excess stiffness of new rubber [-], 0.3 for 30 %.
    - `mullins_cycles`: cycles in which that falls to 1/e [-].
    - `preconditioning`: cycles before the first reading.
    - `length_scatter`: of fabrication, standard deviation over the length [-].
    - `angle_scatter`: of fabrication, standard deviation of the braid angle [rad].
    - `clip`: true for a gauge that can't push: it reads zero instead of a negative force.
    """

    pressures: Values = interval_field(
        "pressures", 0.0, HIGHEST_PRESSURE, (True, True), unit="Pa", default=_LEVELS
    )
    samples: int = attrs.field(default=200, validator=attrs.validators.instance_of(int))
    both_ways: bool = True
    speed: Values = _positive_field("speed", unit="m/s", default=1e-3)
    noise: float = _share_field("noise", default=0.005)
    resolution: Values = _field_from_zero("resolution", unit="N", default=0.0)
    pressure_noise: Values = _field_from_zero("pressure_noise", unit="Pa", default=0.0)
    displacement_noise: Values = _field_from_zero("displacement_noise", unit="m", default=0.0)
    hysteresis: float = _share_field("hysteresis", default=0.0)
    mullins: float = _field_from_zero("mullins", default=0.0)
    mullins_cycles: float = _positive_field("mullins_cycles", default=3.0)
    preconditioning: int = 5
    length_scatter: Values = _scatter_field("length_scatter")
    angle_scatter: Values = _scatter_field("angle_scatter", unit="rad")
    clip: bool = False

    def __attrs_post_init__(self):
        """**Raises:** `InvalidInputError` for a setting out of range."""
        if np.ndim(self.pressures) != 1 or not np.any(np.asarray(self.pressures) > 0):
            rule = "must hold at least one pressure above 0 Pa, in a list"
            raise InvalidInputError("pressures", rule, None)
        if self.samples < 2 or self.preconditioning < 0:
            rule = "must be at least 2 and `preconditioning` at least 0"
            values = self.samples, self.preconditioning
            raise InvalidInputError("samples", rule, values, shown=f"{values[0]} and {values[1]}")

    def record(self, muscle: Muscle, seed: int = 0) -> Record:
        """Simulate a test of one muscle: a synthetic record of its readings.

        **Arguments:**

        - `muscle`: the muscle on the drawing.
        - `seed`: random seed; the same seed gives the same bits.

        **Returns:** a synthetic `Record`, whose notes hold every setting.

        **Raises:** `InvalidInputError` for a batch of muscles.
        """
        # a stream each, so that no fault changes another one's numbers
        cell, transducer, ruler, fabrication = np.random.default_rng(seed).spawn(4)
        muscle = Scatter(self.length_scatter, self.angle_scatter).draw(muscle, fabrication)
        pressure, strain, branch, force = self._sweeps(muscle)
        largest, shape, L = float(np.abs(force).max()), force.shape, float(muscle.length)
        force = force + self.noise * largest * cell.standard_normal(shape)
        if self.resolution:
            force = self.resolution * np.round(force / self.resolution)
        censored = (force <= 0) & self.clip
        pressure = pressure[:, None] + self.pressure_noise * transducer.standard_normal(shape)
        stroke = np.ptp(strain)
        step = stroke * L / (self.samples - 1) / self.speed
        strain = strain + self.displacement_noise / L * ruler.standard_normal(shape)
        settings = [
            f"{field.name} = {getattr(self, field.name)} {field.metadata.get('unit', '')}"
            for field in attrs.fields(type(self))
            if field.name != "pressures"
        ]
        notes = (
            f"made by a virtual dynamometer, seed {seed}: no muscle was measured",
            f"full scale {largest:.6g} N, stroke {stroke:.6g} of strain",
            f"muscle on the machine: length {pretty(L, 'length', 6)},"
            f" braid angle {pretty(float(muscle.braid_angle), 'angle', 6)}",
            *(text.removesuffix(" -").rstrip() for text in settings),
        )
        return Record.of(
            np.maximum(pressure, 0.0), strain, np.where(censored, 0.0, force), censored, branch,
            time=step * np.arange(force.size), rest_length=L, synthetic=True, notes=notes,
        )  # fmt: skip

    def _sweeps(self, muscle: Muscle) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Pressures [Pa], strains [-] and branches by column, and forces [N] of a perfect gauge."""
        if any(np.ndim(size) for size in (muscle.length, muscle.outer_radius, muscle.braid_angle)):
            raise InvalidInputError("muscle", "must be a single muscle", None)
        P = np.asarray(self.pressures, dtype=float)
        # cycled until it is soft, so the stroke is the softened muscle's
        strain = np.linspace(0.0, float(muscle.free_strain(P.max())), self.samples)
        if self.mullins:
            cycle = self.preconditioning + np.arange(P.size)
            factor = 1 + self.mullins * np.exp(-cycle / self.mullins_cycles)
            rubber = StiffenedMaterial(muscle.material, factor[:, None])
            muscle = with_fields(muscle, material=rubber)
        force = np.asarray(muscle.force(P[:, None], strain))
        half = 0.5 * self.hysteresis * force[:, :1]
        if not self.both_ways:
            return P, strain, np.ones(strain.size, int), force - half
        both = np.hstack([force - half, force[:, ::-1] + half])
        return P, np.r_[strain, strain[::-1]], np.repeat([1, -1], self.samples), both
