r"""Loads that a bundle moves, and motions that are prescribed.

A load has one coordinate $q$, in which a bundle's plates come nearer by $c_0 + a\,q$ [m], and

$$M \ddot q = \sum_i n_i F_i L_i \frac{\partial \varepsilon_i}{\partial q}
  - \frac{\mathrm{d} U}{\mathrm{d} q} - d\,\dot q - F_{stop}, \tag{T1}$$

with its potential $U$ and its damper $d$. A stop is a spring and a damper that push one way only,

$$F_{stop} = \max\left(k s + c \dot s \frac{s}{s + s_0}, 0\right), \qquad
  s = \max(q - q_{high}, 0), \tag{T2}$$

and likewise at the low end, so that the integrator needs no search for events.

**Sign:** $q$ rises as the (first) bundle contracts. **Source:** Newton's second law.
"""

import abc
from functools import partial
from typing import ClassVar

import numpy as np

from ..core.array_namespace import cos, maximum, sin, where
from ..core.errors import InvalidInputError
from ..core.module import Module
from ..core.types import Batch
from ..core.validation import Range, is_concrete
from ..fluid.fields import interval_field, nonnegative_field, positive_field


GRAVITY = 9.80665  # m/s², the standard value (CGPM 1901)

# outside the inner limits a warning asks for the unit; outside the outer ones a value is refused
_MASS = Range("kg", 1e-6, 1e-3, 1e4, 1e7)
_STIFFNESS = Range("N/m", 0.0, 0.0, 1e8, 1e12)
# m or rad: a damper that acts in full at once would be a jump of force, which no step resolves
DAMPER_DEPTH = 1e-3

_field_from_zero = partial(interval_field, low=0.0, high=np.inf, closed=(True, False), default=0.0)
_field_of_any_size = partial(interval_field, low=0.0, high=np.inf)
_field_of_any_sign = partial(interval_field, low=-np.inf, high=np.inf, default=0.0)


class Stop(Module):
    """Stop with a spring and a damper at each of two ends of a stroke, equation (T2): the damper
    comes in with depth, half of it at a depth $s_0$ of a millimeter or milliradian.

    `low`, `high`: ends, in the load's coordinate [m or rad]; `stiffness` $k$, `damping` $c$ [SI].
    """

    low: Batch = _field_of_any_sign("low", unit="m or rad", default=-np.inf, closed=(True, True))
    high: Batch = _field_of_any_sign("high", unit="m or rad", default=np.inf, closed=(True, True))
    stiffness: Batch = _field_from_zero("stiffness", unit="N/m", default=1e5)
    damping: Batch = _field_from_zero("damping", unit="N·s/m", default=1e2)

    def __check_init__(self):
        low, high = self.low, self.high
        if is_concrete(low, high) and np.any(np.asarray(low) >= np.asarray(high)):
            raise InvalidInputError("low", "must be less than `high`", float(np.max(self.low)))

    def force(self, position: Batch, velocity: Batch) -> tuple[Batch, Batch]:
        """Force against a rising coordinate, and the damper's part of it [SI]."""
        over, under = self._depths(position)
        depth = over + under
        spring = self.stiffness * (over - under)
        total = spring + self.damping * velocity * depth / (depth + DAMPER_DEPTH)
        total = where(over > 0, maximum(total, 0.0), where(under > 0, -maximum(-total, 0.0), 0.0))
        return total, total - spring

    def energy(self, position: Batch) -> Batch:
        """Energy of its springs [J] at `position` [SI]."""
        over, under = self._depths(position)
        return self.stiffness * (over**2 + under**2) / 2

    def _depths(self, position: Batch) -> tuple[Batch, Batch]:
        """Depths beyond `high` and `low` [SI], zero or more."""
        return maximum(position - self.high, 0.0), maximum(self.low - position, 0.0)


class AbstractLoad(Module):
    """Load with one coordinate, by default one bundle's contraction that no force acts on.

    `unit`: of the coordinate. `prescribed`: the motion is given. `stop`: of its stroke, or none.
    `damping`: $d$, `stiffness`: largest $|\\mathrm{d}^2U/\\mathrm{d}q^2|$, about [SI].
    """

    unit: ClassVar[str] = "m"
    prescribed: ClassVar[bool] = False
    stop: ClassVar[Stop | None]
    damping: ClassVar[Batch] = 0.0
    stiffness: ClassVar[Batch] = 0.0

    @property
    def arms(self) -> tuple[tuple[Batch, Batch], ...]:
        """For each bundle the shortening of its plates' distance at $q = 0$ [m] and per unit of $q$
        [m/m or m/rad].
        """
        return ((0.0, 1.0),)

    @property
    @abc.abstractmethod
    def inertia(self) -> Batch:
        """Inertia $M$ of the coordinate, a mass or a moment of inertia [SI]."""

    def force(self, position: Batch) -> Batch:
        """Force $-\\mathrm{d}U/\\mathrm{d}q$ [SI], positive towards a rising `position` [SI]."""
        return 0.0 * position

    def potential(self, position: Batch) -> Batch:
        """Potential energy $U$ [J] at `position` [SI]."""
        return 0.0 * position

    def motion_at(self, time: Batch, position: Batch, velocity: Batch) -> tuple[Batch, Batch]:
        """Position and velocity [SI] at `time` [s]: a free load's `position` and `velocity` [SI],
        or the prescribed ones.
        """
        return position, velocity


class _Mass(AbstractLoad):
    """Load of a mass alone."""

    mass: Batch = positive_field("mass", _MASS)

    @property
    def inertia(self) -> Batch:
        return self.mass


class HangingMass(_Mass):
    """A mass on the lower plate, lifted as the bundle contracts.

    `mass` [kg]. `gravity`: $g$ [m/s²]. `damping` [N·s/m]. `stop`: of its stroke [m], or none.
    """

    gravity: Batch = _field_from_zero("gravity", unit="m/s²", default=GRAVITY)
    damping: Batch = _field_from_zero("damping", unit="N·s/m")
    stop: Stop | None = None

    def force(self, position: Batch) -> Batch:
        return -self.mass * self.gravity + 0.0 * position

    def potential(self, position: Batch) -> Batch:
        return self.mass * self.gravity * position


class InertiaSpringDamper(_Mass):
    """A mass that the bundle pulls against a spring and a damper.

    `mass` [kg]. `spring_stiffness` [N/m], of a spring that is never slack. `damping` [N·s/m].
    `rest`: position at which the spring is at rest [m]. `force_outside`: constant force against
    the bundle [N]. `stop`: of its stroke [m], or none.
    """

    spring_stiffness: Batch = nonnegative_field("spring_stiffness", _STIFFNESS, default=0.0)
    damping: Batch = _field_from_zero("damping", unit="N·s/m")
    rest: Batch = _field_of_any_sign("rest", unit="m")
    force_outside: Batch = _field_of_any_sign("force_outside", unit="N")
    stop: Stop | None = None

    def force(self, position: Batch) -> Batch:
        return -self.spring_stiffness * (position - self.rest) - self.force_outside

    def potential(self, position: Batch) -> Batch:
        spring = self.spring_stiffness * (position - self.rest) ** 2 / 2
        return spring + self.force_outside * position

    @property
    def stiffness(self) -> Batch:
        return self.spring_stiffness


class AntagonisticJoint(AbstractLoad):
    """Two bundles on a pulley, one pulling forward, one back, and a pendulum on its axis.

    `inertia_moment` [kg·m²]. `radius`: of the pulley [m]. `contraction`: of both bundles' plates
    at $q = 0$ [m]. `damping` [N·m·s/rad]. `gravity_moment`: $m g l$ of the pendulum, which hangs at
    $q = 0$ [N·m]. `stop`: of its stroke [rad], or none.
    """

    unit: ClassVar[str] = "rad"

    inertia_moment: Batch = _field_of_any_size("inertia_moment", unit="kg·m²")
    radius: Batch = _field_of_any_size("radius", unit="m")
    contraction: Batch = _field_of_any_sign("contraction", unit="m")
    damping: Batch = _field_from_zero("damping", unit="N·m·s/rad")
    gravity_moment: Batch = _field_from_zero("gravity_moment", unit="N·m")
    stop: Stop | None = None

    @property
    def arms(self) -> tuple[tuple[Batch, Batch], ...]:
        return (self.contraction, self.radius), (self.contraction, -self.radius)

    @property
    def inertia(self) -> Batch:
        return self.inertia_moment

    def force(self, position: Batch) -> Batch:
        return -self.gravity_moment * sin(position)

    def potential(self, position: Batch) -> Batch:
        return self.gravity_moment * (1 - cos(position))

    @property
    def stiffness(self) -> Batch:
        return self.gravity_moment


class PrescribedMotion(AbstractLoad):
    """Load of a dynamometer, which moves the plates by $q = q_0 + A \\sin 2\\pi f t$.

    `mean`: $q_0$ [m]. `amplitude`: $A$ [m]. `frequency`: $f$ [Hz]. An amplitude of zero holds
    the plates.
    """

    prescribed: ClassVar[bool] = True

    mean: Batch = _field_of_any_sign("mean", unit="m")
    amplitude: Batch = _field_from_zero("amplitude", unit="m")
    frequency: Batch = _field_from_zero("frequency", unit="Hz")
    stop: Stop | None = None

    def __check_init__(self):
        if self.stop is not None:
            rule = "can't hold a prescribed motion"
            raise InvalidInputError("stop", rule, self.stop, "leave it out")
        A, f = self.amplitude, self.frequency
        if is_concrete(A, f) and np.any((np.asarray(A) > 0) & (f <= 0)):
            raise InvalidInputError("frequency", "must be positive if there is an amplitude", 0.0)

    @property
    def inertia(self) -> Batch:
        return 1.0 + 0.0 * self.mean  # any: it has no effect

    def motion_at(self, time: Batch, position: Batch, velocity: Batch) -> tuple[Batch, Batch]:
        """Prescribed position and velocity [SI] at `time` [s], whatever the other arguments."""
        w = 2 * np.pi * self.frequency
        return self.mean + self.amplitude * sin(w * time), self.amplitude * w * cos(w * time)
