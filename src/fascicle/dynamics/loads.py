r"""Loads that a bundle moves, and motions that move it.

A load has one coordinate $q$, in which a bundle's plates come nearer by $c_0 + a\,q$ [m], and

$$M \ddot q = \sum_i n_i F_i L_i \frac{\partial \varepsilon_i}{\partial q}
  - \frac{\mathrm{d} U}{\mathrm{d} q} - d\,\dot q - F_{stop}, \tag{T1}$$

with its potential $U$ and its damper $d$. A stop is a spring and a damper that push one way only,

$$F_{stop} = \max\left(k s + c \dot s \frac{s}{s + s_0}, 0\right), \qquad
  s = \max(q - q_{high}, 0), \tag{T2}$$

and likewise at the low end, so that no event has to be found.

**Sign:** $q$ rises as the (first) bundle contracts. **Source:** Newton's second law.
"""

import abc
from typing import Any, ClassVar

import numpy as np

from ..core.array_namespace import cos, maximum, sin, where
from ..core.errors import InvalidInputError
from ..core.module import Module, record
from ..core.types import Batch, BoolBatch, Values
from ..core.validation import (
    Range,
    check_finite,
    check_interval,
    check_plausible,
    check_positive,
    is_concrete,
)


GRAVITY = 9.80665  # m/s², the standard value (CGPM 1901)

_MASS = Range("kg", 1e-6, 1e-3, 1e4, 1e7)
_STIFFNESS = Range("N/m", 0.0, 0.0, 1e8, 1e12)


def _positive_field(name: str, unit: str) -> Any:
    def checked(value: Values) -> Batch:
        return check_positive(value, name, unit)

    return record(converter=checked)


def _nonnegative_field(name: str, unit: str, default: float = 0.0) -> Any:
    def checked(value: Values) -> Batch:
        return check_interval(value, 0.0, np.inf, name, unit, closed=(True, False))

    return record(converter=checked, default=default)


def _finite_field(name: str, unit: str, default: float = 0.0) -> Any:
    def checked(value: Values) -> Batch:
        return check_finite(value, name, unit)

    return record(converter=checked, default=default)


def _end_field(name: str, default: float) -> Any:
    def checked(value: Values) -> Batch:
        return check_interval(value, -np.inf, np.inf, name, "m or rad", closed=(True, True))

    return record(converter=checked, default=default)


# m or rad: a damper that took hold at once would be a jump of force, which no step resolves
_TAKES_HOLD = 1e-3


class Stop(Module):
    """Two ends of the way, equation (T2), with $s_0$ of a millimeter or milliradian.

    `low`, `high`: where they begin, in the load's coordinate [m or rad]. `stiffness`: $k$ [N/m or
    N·m/rad]. `damping`: $c$ [N·s/m or N·m·s/rad].
    """

    low: Batch = _end_field("low", -np.inf)
    high: Batch = _end_field("high", np.inf)
    stiffness: Batch = _nonnegative_field("stiffness", "N/m", 1e5)
    damping: Batch = _nonnegative_field("damping", "N·s/m", 1e2)

    def __check_init__(self):
        if is_concrete(self.low, self.high) and np.any(
            np.asarray(self.low) >= np.asarray(self.high)
        ):
            raise InvalidInputError("low", "must be less than `high`", float(np.max(self.low)))

    def force(self, position: Batch, velocity: Batch) -> tuple[Batch, Batch]:
        """Force of the stop [SI] at `position` [SI] and `velocity` [SI], and of that the
        damper's.
        """
        over, under = maximum(position - self.high, 0.0), maximum(self.low - position, 0.0)
        depth = over + under
        spring = self.stiffness * (over - under)
        rate = self.damping * velocity * depth / (depth + _TAKES_HOLD)
        total = where(
            over > 0,
            maximum(spring + rate, 0.0),
            where(under > 0, -maximum(-(spring + rate), 0.0), 0.0),
        )
        return total, total - spring

    def energy(self, position: Batch) -> Batch:
        """In its springs [J] at `position` [SI]."""
        over, under = maximum(position - self.high, 0.0), maximum(self.low - position, 0.0)
        return self.stiffness * (over**2 + under**2) / 2

    def touched(self, position: Batch) -> BoolBatch:
        """True where the stop is touched at `position` [SI]."""
        return (position > self.high) | (position < self.low)


class AbstractLoad(Module):
    """A load with one coordinate.

    `arms`: for each bundle, by how much its plates are nearer at $q = 0$ [m] and how much more per
    unit of $q$ [m/m or m/rad]. `unit`: of the coordinate [-]. `moved`: whether the motion is
    given [-].
    """

    unit: ClassVar[str]
    moved: ClassVar[bool]
    stop: ClassVar[Stop | None]

    @property
    @abc.abstractmethod
    def arms(self) -> tuple[tuple[Batch, Batch], ...]:
        """See above [m], [SI]."""

    @property
    @abc.abstractmethod
    def inertia(self) -> Batch:
        """$M$, of mass or moment [SI]."""

    @abc.abstractmethod
    def force(self, position: Batch) -> Batch:
        """$-\\mathrm{d}U/\\mathrm{d}q$ [SI] at `position` [SI]."""

    @abc.abstractmethod
    def potential(self, position: Batch) -> Batch:
        """$U$ [J] at `position` [SI]."""

    @property
    @abc.abstractmethod
    def damper(self) -> Batch:
        """$d$ [SI]."""

    @property
    @abc.abstractmethod
    def stiffness(self) -> Batch:
        """About the largest $|\\mathrm{d}^2U/\\mathrm{d}q^2|$ [SI]."""

    @abc.abstractmethod
    def placed(self, time: Batch, position: Batch, velocity: Batch) -> tuple[Batch, Batch]:
        """Position and velocity [SI] at `time` [s], of a load that would move to `position` [SI]
        with `velocity` [SI].
        """


class AbstractFreeLoad(AbstractLoad):
    """A load that moves as forces tell it, with a damper of its own."""

    moved: ClassVar[bool] = False
    damping: ClassVar[Batch]

    @property
    def damper(self) -> Batch:
        """$d$ [SI]."""
        return self.damping

    def placed(self, time: Batch, position: Batch, velocity: Batch) -> tuple[Batch, Batch]:
        """Position and velocity: `position` [SI] and `velocity` [SI], at any `time` [s]."""
        del time
        return position, velocity


class HangingMass(AbstractFreeLoad):
    """A mass on the lower plate, lifted as the bundle contracts.

    `mass` [kg]. `gravity`: $g$ [m/s²]. `damping` [N·s/m]. `stop`: of its way [m], or none.
    """

    unit: ClassVar[str] = "m"
    source: ClassVar[str] = "Newton's second law"

    mass: Batch = _positive_field("mass", "kg")
    gravity: Batch = _nonnegative_field("gravity", "m/s²", GRAVITY)
    damping: Batch = _nonnegative_field("damping", "N·s/m")
    stop: Stop | None = None

    def __check_init__(self):
        check_plausible(self.mass, "mass", _MASS)

    @property
    def arms(self) -> tuple[tuple[Batch, Batch], ...]:
        """One bundle, as the mass rises [m], [-]."""
        return ((0.0, 1.0),)

    @property
    def inertia(self) -> Batch:
        """The mass [kg]."""
        return self.mass

    def force(self, position: Batch) -> Batch:
        """Its weight [N], anywhere: at `position` [m]."""
        return -self.mass * self.gravity + 0.0 * position

    def potential(self, position: Batch) -> Batch:
        """$m g q$ [J] at `position` [m]."""
        return self.mass * self.gravity * position

    @property
    def stiffness(self) -> Batch:
        """None [N/m]."""
        return 0.0 * self.mass


class InertiaSpringDamper(AbstractFreeLoad):
    """A mass between the bundle, a spring and a damper.

    `mass` [kg]. `stiffness`: of the spring [N/m], slack nowhere. `damping` [N·s/m]. `rest`: where
    the spring is at rest [m]. `force_outside`: that pulls against the bundle all the time [N].
    `stop`: of its way [m], or none.
    """

    unit: ClassVar[str] = "m"
    source: ClassVar[str] = "Newton's second law"

    mass: Batch = _positive_field("mass", "kg")
    spring_stiffness: Batch = _nonnegative_field("spring_stiffness", "N/m")
    damping: Batch = _nonnegative_field("damping", "N·s/m")
    rest: Batch = _finite_field("rest", "m")
    force_outside: Batch = _finite_field("force_outside", "N")
    stop: Stop | None = None

    def __check_init__(self):
        check_plausible(self.mass, "mass", _MASS)
        check_plausible(self.spring_stiffness, "spring_stiffness", _STIFFNESS)

    @property
    def arms(self) -> tuple[tuple[Batch, Batch], ...]:
        """One bundle [m], [-]."""
        return ((0.0, 1.0),)

    @property
    def inertia(self) -> Batch:
        """The mass [kg]."""
        return self.mass

    def force(self, position: Batch) -> Batch:
        """Of spring and outside [N] at `position` [m]."""
        return -self.spring_stiffness * (position - self.rest) - self.force_outside

    def potential(self, position: Batch) -> Batch:
        """Of both [J] at `position` [m]."""
        spring = self.spring_stiffness * (position - self.rest) ** 2 / 2
        return spring + self.force_outside * position

    @property
    def stiffness(self) -> Batch:
        """The spring's [N/m]."""
        return self.spring_stiffness


class AntagonisticJoint(AbstractFreeLoad):
    """Two bundles on a pulley, one pulling forward, one back, and a pendulum on its axis.

    `inertia_moment` [kg·m²]. `radius`: of the pulley [m]. `contraction`: of both bundles' plates
    at $q = 0$ [m]. `damping` [N·m·s/rad]. `gravity_moment`: $m g l$ of the pendulum, which hangs at
    $q = 0$ [N·m]. `stop`: of its way [rad], or none.
    """

    unit: ClassVar[str] = "rad"
    source: ClassVar[str] = "Newton's second law"

    inertia_moment: Batch = _positive_field("inertia_moment", "kg·m²")
    radius: Batch = _positive_field("radius", "m")
    contraction: Batch = _finite_field("contraction", "m")
    damping: Batch = _nonnegative_field("damping", "N·m·s/rad")
    gravity_moment: Batch = _nonnegative_field("gravity_moment", "N·m")
    stop: Stop | None = None

    @property
    def arms(self) -> tuple[tuple[Batch, Batch], ...]:
        """Two bundles, against each other [m], [m/rad]."""
        return (self.contraction, self.radius), (self.contraction, -self.radius)

    @property
    def inertia(self) -> Batch:
        """Moment of inertia of the joint [SI]."""
        return self.inertia_moment

    def force(self, position: Batch) -> Batch:
        """The pendulum's moment [N·m] at `position` [rad]."""
        return -self.gravity_moment * sin(position)

    def potential(self, position: Batch) -> Batch:
        """The pendulum's [J] at `position` [rad]."""
        return self.gravity_moment * (1 - cos(position))

    @property
    def stiffness(self) -> Batch:
        """The pendulum's at most [SI]."""
        return self.gravity_moment


class PrescribedMotion(AbstractLoad):
    """A dynamometer that moves the plates, $q = q_0 + A \\sin 2\\pi f t$.

    `mean`: $q_0$ [m]. `amplitude`: $A$ [m]. `frequency`: $f$ [Hz]. An amplitude of zero holds
    the plates.
    """

    unit: ClassVar[str] = "m"
    moved: ClassVar[bool] = True
    source: ClassVar[str] = "kinematics"

    mean: Batch = _finite_field("mean", "m")
    amplitude: Batch = _nonnegative_field("amplitude", "m")
    frequency: Batch = _nonnegative_field("frequency", "Hz")
    stop: Stop | None = None

    def __check_init__(self):
        if self.stop is not None:
            raise InvalidInputError(
                "stop", "can't hold a motion that is given", self.stop, "leave it out"
            )
        if is_concrete(self.amplitude, self.frequency):
            accelerations = np.asarray(self.amplitude) > 0
            if np.any(accelerations & (np.asarray(self.frequency) <= 0)):
                raise InvalidInputError(
                    "frequency", "must be positive where there is an amplitude", 0.0
                )

    @property
    def arms(self) -> tuple[tuple[Batch, Batch], ...]:
        """One bundle [m], [-]."""
        return ((0.0, 1.0),)

    @property
    def inertia(self) -> Batch:
        """None that counts [kg]."""
        return 1.0 + 0.0 * self.mean

    def force(self, position: Batch) -> Batch:
        """None but the motor's [N], at any `position` [m]."""
        return 0.0 * position

    def potential(self, position: Batch) -> Batch:
        """None [J], at any `position` [m]."""
        return 0.0 * position

    @property
    def damper(self) -> Batch:
        """None [SI]."""
        return 0.0 * self.mean

    @property
    def stiffness(self) -> Batch:
        """None [N/m]."""
        return 0.0 * self.mean

    def placed(self, time: Batch, position: Batch, velocity: Batch) -> tuple[Batch, Batch]:
        """Position [m] and velocity [m/s] at `time` [s], whatever `position` [m] and `velocity`
        [m/s] would be.
        """
        del position, velocity
        w = 2 * np.pi * self.frequency
        phase = w * time
        return (
            self.mean + self.amplitude * sin(phase),
            self.amplitude * w * cos(phase),
        )
