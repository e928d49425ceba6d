r"""A virtual dynamometer: the protocol of section 5.3 on a muscle that is a model.

The muscle contracts freely at the highest pressure, which gives the stroke; it is cycled
until its rubber has softened; then, pressure by pressure, the plates close by the stroke
and open again, slowly. A reading at pressure $P_i$ and strain $\varepsilon$ on branch
$b = \pm 1$ (1 while it contracts) is

$$F = m_i\text{-stiffened } F(P_i, \varepsilon) - \tfrac{b}{2} h F(P_i, 0) + \text{noise}, \qquad
  m_i = 1 + m\, e^{-c_i/c}. \tag{D1}$$

*Hysteresis* is friction between fibers, which opposes motion and grows with pressure: a
muscle pulls harder while it is drawn out than while it contracts. *Mullins softening*: in
its first cycles the rubber is stiffer by $m$, which decays over $c$ cycles; a pressure
counts as one cycle, after those of preconditioning. *Scatter*: the muscle on the machine
isn't the one on the drawing. Left alone, only the load cell's noise is simulated.

**Not simulated:** creep, dynamics, temperature, the softening's dependence on the largest
strain. Everything that comes out is synthetic and says so.
**Source:** Kim, Mazzoleni and Bryant (2021), section 5.3; friction between fibers after
Chou and Hannaford (1996); softening after Mullins (1969).
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import equinox as eqx
import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Batch, BatchLike, Bool, Float, Int, Values
from ..core.validation import HIGHEST_PRESSURE, check_interval, to_si
from ..muscle import Muscle
from ..muscle.materials import AbstractMaterial, Slopes
from ..units import pretty
from .fabrication import Scatter
from .record import Record


_LEVELS = tuple(413.7e3 * i / 12 for i in range(13))  # Pa, 0 to 60 psi in steps of 5 psi
_NOT_NEGATIVE = ("noise", "resolution", "pressure_noise", "displacement_noise", "hysteresis",
                 "mullins", "length_scatter", "angle_scatter")  # fmt: skip
_SCATTERS = {"length": "length_scatter", "braid_angle": "angle_scatter"}


class Stiffer(AbstractMaterial):
    """A `material` that is stiffer by a `factor` [-] in everything."""

    material: AbstractMaterial
    factor: Batch

    def __init__(self, material: AbstractMaterial, factor: Values):
        """**Arguments:** `material` [-]; `factor`: on its energy and modulus [-]."""
        self.material, self.factor = material, factor

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
        """Its derivatives [J/m³] at squared stretches $\\lambda_1^2$, $\\lambda_2^2$ [-]."""
        slopes = self.material.slopes(axial_squared, hoop_squared)
        return Slopes(*(self.factor * one for one in slopes))


@dataclass(frozen=True, eq=False)
class Sweeps:
    """What a perfect gauge would read, a row for each pressure, in the order of time.

    - `pressure`: gauge pressure of each row [Pa].
    - `strain`: contraction at each column [-].
    - `branch`: 1 contracting, −1 extending, of each column [-].
    - `force`: pulling force, with hysteresis and softening [N].
    """

    pressure: Float[np.ndarray, " level"]
    strain: Float[np.ndarray, " point"]
    branch: Int[np.ndarray, " point"]
    force: Float[np.ndarray, "level point"]

    @property
    def full_scale(self) -> float:
        """The largest force, either way [N]."""
        return float(np.abs(self.force).max())


@dataclass(frozen=True)
class VirtualDynamometer:
    """A machine and its faults; called with a muscle, it writes a synthetic record.

    - `pressures`: gauge pressures in the order of the test [Pa].
    - `samples`: readings in one sweep [-], at least 2.
    - `both_ways`: whether the way back is recorded too [-].
    - `speed`: of the plates [m/s]; gives the readings their times, nothing else.
    - `noise`: of the load cell, standard deviation over the largest force [-].
    - `resolution`: step of the load cell's readings [N]; 0 for none.
    - `pressure_noise`: of the transducer, standard deviation [Pa]; a reading below zero is
      written as zero.
    - `displacement_noise`: of the gauge of length, standard deviation [m].
    - `hysteresis`: width of the loop over the blocked force at the same pressure [-].
    - `mullins`: how much stiffer new rubber is [-], 0.3 for 30 %.
    - `mullins_cycles`: cycles in which that falls to 1/e [-].
    - `preconditioning`: cycles before the first reading [-].
    - `length_scatter`: of fabrication, standard deviation over the length [-].
    - `angle_scatter`: of fabrication, standard deviation of the braid angle [rad].
    - `clip`: whether the gauge only pulls, so that it reads zero for a push [-].
    """

    pressures: Values = _LEVELS
    samples: int = 200
    both_ways: bool = True
    speed: Values = 1e-3
    noise: float = 0.005
    resolution: Values = 0.0
    pressure_noise: Values = 0.0
    displacement_noise: Values = 0.0
    hysteresis: float = 0.0
    mullins: float = 0.0
    mullins_cycles: float = 3.0
    preconditioning: int = 5
    length_scatter: float = 0.0
    angle_scatter: Values = 0.0
    clip: bool = False

    def __post_init__(self):
        """**Raises:** `ValueError` for a setting that can't be."""
        for name in ("pressures", *_NOT_NEGATIVE, "speed"):
            unit = "Pa" if name == "pressures" else _unit(name)
            object.__setattr__(self, name, to_si(getattr(self, name), name, unit))
        P = check_interval(
            self.pressures, 0.0, HIGHEST_PRESSURE, "pressures", "Pa", "(gauge)", (True, True)
        )
        if P.ndim != 1 or not np.any(np.asarray(P) > 0):
            raise InvalidInputError(
                "pressures", "must hold at least one pressure above 0 Pa, in a list", None
            )
        for name in _NOT_NEGATIVE:
            # a share of the force itself: 5 was meant as 5 %
            most = 1.0 if name in ("noise", "hysteresis") else np.inf
            value = getattr(self, name)
            remedy = f"write {value:g} %" if most == 1 and np.all(value >= 1) else ""
            check_interval(value, 0.0, most, name, _unit(name), closed=(True, False), remedy=remedy)
        for name in ("speed", "mullins_cycles"):
            check_interval(getattr(self, name), 0.0, np.inf, name, _unit(name))
        if self.samples < 2 or self.preconditioning < 0:
            raise InvalidInputError(
                "samples",
                "must be at least 2 and `preconditioning` at least 0",
                (self.samples, self.preconditioning),
                shown=f"{self.samples} and {self.preconditioning}",
            )
        try:
            Scatter(self.length_scatter, self.angle_scatter)  # which knows its own limits
        except InvalidInputError as error:
            name, angle = _SCATTERS[error.argument], error.argument == "braid_angle"
            shown = pretty(error.value, "angle") if angle else None
            raise InvalidInputError(name, error.rule, error.value, error.remedy, shown) from None

    def record(self, muscle: Muscle, seed: int = 0) -> Record:
        """One test of one muscle.

        **Arguments:**

        - `muscle`: the muscle on the drawing [-].
        - `seed`: of everything that is drawn [-]; the same seed gives the same bits.

        **Returns:** a `Record` [-], synthetic, whose notes hold every setting.

        **Raises:** `ValueError` for a muscle that is a batch of several.
        """
        muscle = self.fabricated(muscle, seed)
        exact = self.sweeps(muscle)
        _, transducer, ruler, _ = _streams(seed)
        force, censored = self._read(exact, seed)
        shape = force.shape
        pressure = exact.pressure[:, None] + self.pressure_noise * transducer.standard_normal(shape)
        L = float(muscle.length)
        strain = exact.strain + self.displacement_noise / L * ruler.standard_normal(shape)
        step = np.ptp(exact.strain) * L / (self.samples - 1) / self.speed
        return Record.of(
            np.maximum(pressure, 0.0),
            strain,
            force,
            censored,
            exact.branch,
            time=step * np.arange(force.size),
            rest_length=L,
            synthetic=True,
            notes=self._notes(muscle, exact, seed),
        )

    def sweeps(self, muscle: Muscle) -> Sweeps:
        """What is measured, before any noise: worth keeping where many seeds are drawn.

        **Arguments:** `muscle`: the muscle on the machine [-].

        **Returns:** `Sweeps`: forces [N] over pressures [Pa] and strains [-].

        **Raises:** `ValueError` for a muscle that is a batch of several.
        """
        if any(np.ndim(size) for size in (muscle.length, muscle.outer_radius, muscle.braid_angle)):
            raise InvalidInputError(
                "muscle", "must be a single muscle", None, "a batch can't be on one machine"
            )
        P = np.asarray(self.pressures, dtype=float)
        # cycled until it is soft, so the stroke is the softened muscle's
        closing = np.linspace(0.0, float(muscle.free_strain(P.max())), self.samples)
        clean = np.asarray(self._softening(muscle).force(P[:, None], closing))
        half = 0.5 * self.hysteresis * clean[:, :1]
        if not self.both_ways:
            return Sweeps(P, closing, np.ones(closing.size, int), clean - half)
        return Sweeps(
            P,
            np.r_[closing, closing[::-1]],
            np.repeat([1, -1], self.samples),
            np.hstack([clean - half, clean[:, ::-1] + half]),
        )

    def forces(
        self, muscle: Muscle | Sweeps, seeds: Sequence[int]
    ) -> Float[np.ndarray, "seed level point"]:
        """The forces of many tests of one muscle, the model evaluated once for all.

        **Arguments:**

        - `muscle`: the muscle [-], or its `sweeps` [-].
        - `seeds`: one for each test [-]; each gives the forces that `record` does.

        **Returns:** readings [N]: seeds, pressures, readings in the order of time.

        **Raises:** `ValueError` where the seeds would change the muscle itself.
        """
        if self.length_scatter or self.angle_scatter:
            raise InvalidInputError(
                "length_scatter",
                "and `angle_scatter` must be 0 for many tests of one muscle",
                (self.length_scatter, self.angle_scatter),
                "use `record`",
                shown=f"{self.length_scatter:g} and {self.angle_scatter:g} rad",
            )
        exact = muscle if isinstance(muscle, Sweeps) else self.sweeps(muscle)
        return np.stack([self._read(exact, seed)[0] for seed in seeds])

    def fabricated(self, muscle: Muscle, seed: int) -> Muscle:
        """The muscle that comes out when `muscle` [-] is made, by `seed` [-]."""
        scatter = Scatter(self.length_scatter, self.angle_scatter)
        return scatter.draw(muscle, _streams(seed)[-1])

    def _softening(self, muscle: Muscle) -> Muscle:
        """The muscle as stiff as it is at each pressure, on a first axis."""
        if not self.mullins:
            return muscle
        cycle = self.preconditioning + np.arange(len(self.pressures))
        factor = 1 + self.mullins * np.exp(-cycle / self.mullins_cycles)
        stiffer = Stiffer(muscle.material, factor[:, None])
        return eqx.tree_at(lambda m: m.material, muscle, stiffer)

    def _read(
        self, exact: Sweeps, seed: int
    ) -> tuple[Float[np.ndarray, "level point"], Bool[np.ndarray, "level point"]]:
        """What the load cell says, and where it only says that it isn't pulled."""
        cell = _streams(seed)[0]
        scale = self.noise * exact.full_scale
        force = exact.force + scale * cell.standard_normal(exact.force.shape)
        if self.resolution:
            force = self.resolution * np.round(force / self.resolution)
        censored = (force <= 0) & self.clip
        return np.where(censored, 0.0, force), censored

    def _notes(self, muscle: Muscle, exact: Sweeps, seed: int) -> tuple[str, ...]:
        settings = [
            f"{field.name} = {getattr(self, field.name)!r} {_unit(field.name)}".removesuffix(" -")
            for field in fields(self)
            if field.name != "pressures"
        ]
        return (
            f"made by a virtual dynamometer, seed {seed}: no muscle was measured",
            f"full scale {exact.full_scale:.6g} N, stroke {np.ptp(exact.strain):.6g} of strain",
            f"muscle on the machine: length {pretty(float(muscle.length), 'length', 6)},"
            f" braid angle {pretty(float(muscle.braid_angle), 'angle', 6)}",
            *settings,
        )


def _streams(seed: int) -> list[np.random.Generator]:
    """Load cell, transducer, ruler, fabrication: none changes with another's setting."""
    return np.random.default_rng(seed).spawn(4)


def _unit(name: str) -> str:
    units: dict[str, Values] = {"speed": "m/s", "resolution": "N", "pressure_noise": "Pa",
                                "displacement_noise": "m", "angle_scatter": "rad"}  # fmt: skip
    return units.get(name, "-")
