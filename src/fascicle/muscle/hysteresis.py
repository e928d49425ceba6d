r"""Friction of braid and bladder, with a memory of the displacement.

Each muscle of a unit has a friction force $z$ against its contraction $x = L_0 \varepsilon$.

`MaxwellSlip`: springs $k_j$ that slip at $f_j$. For a displacement that doesn't turn they have an
exact solution, however long it is,

$$z_j \leftarrow \operatorname{clip}(z_j + k_j\,\Delta x, -f_j, f_j), \tag{H1}$$

and so is `Dahl`'s, one spring that yields little by little,

$$\frac{\mathrm{d}z}{\mathrm{d}x} = k (1 - z \operatorname{sgn}(\mathrm{d}x)/f), \qquad
  z \leftarrow s f + (z - s f) e^{-k |\Delta x|/f}, \quad s = \operatorname{sgn} \Delta x.
  \tag{H2}$$

Between two turns $S$ apart, at $d$ from the first, a closed loop of (H1) is as wide as

$$w = \sum_j \min(k_j d, 2 a_j) + \min(k_j (S - d), 2 a_j) - 2 a_j, \qquad
  a_j = \min(f_j, k_j S/2): \tag{H4}$$

in its middle twice the slip forces. A closed loop between $\pm X$ costs $4 f (X - f/k)$ for (H1)
and $4 f [X - (f/k) \tanh(k X/f)]$ for (H2). The stored energy is $z^2/(2k)$: no displacement gives
energy. $f$ may rise with pressure, $f = f_0 + f_P P$; $k$ may not: a spring that stiffens while it
is bent makes energy.

`Coulomb` is dry friction, given as a width in pressure: the muscle pulls as at $P - w$ while it
contracts, and as at $P + w$ while it is stretched,

$$z = w \left|\frac{\partial F}{\partial P}\right| \tanh(\dot x/v_0), \tag{H3}$$

with no memory. `Damping` grows with the speed, with other constants for shortening and lengthening,

$$z = B(P)\, \dot x, \qquad B = \max(B_0 + B_P P, 0). \tag{H6}$$

**Source:** Iwan (1966), Maxwell slip; Dahl (1976); the width in pressure, by which
measured loops of muscles are described: Chou and Hannaford (1996); damping by pressure and
direction: Reynolds et al. (2003), Lilly and Quesada (2004).
"""

import abc
from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ..core.array_namespace import absolute, array_namespace, exp, maximum, minimum, where
from ..core.errors import InvalidInputError
from ..core.module import Module, record
from ..core.types import Batch, Numbers, Values
from ..core.validation import check_finite, check_nonnegative, check_positive


def _field(check: Callable, name: str, unit: str, **default: Values) -> Any:
    """Field of a `name` and a `unit`, whose value a `check` converts."""
    return record(unit=unit, converter=partial(check, name=name, unit=unit), **default)


class Motion(NamedTuple):
    """Motion of a muscle since its last step, without a turn: `displacement` $\\Delta x$ of its
    contraction [m], `velocity` $\\dot x$ now [m/s], `pressures` $P$ before and now [Pa], and its
    $\\partial F/\\partial P$ now, `pressure_slope` [m²].
    """

    displacement: Batch
    velocity: Batch
    pressures: tuple[Batch, Batch]
    pressure_slope: Batch


class FrictionStep(NamedTuple):
    """Spring forces on the last axis and their `force` [N], and the energy lost, `loss` [J]."""

    spring_forces: Numbers
    force: Batch
    loss: Batch


class AbstractHysteresis(Module):
    """Friction of one muscle against its contraction; `stiffness` [N/m] of those that have one."""

    stiffness: ClassVar[Numbers]

    @property
    @abc.abstractmethod
    def count(self) -> int:
        """Number of forces that it remembers."""

    @abc.abstractmethod
    def advance(self, forces: Numbers, motion: Motion) -> FrictionStep:
        """`FrictionStep` after a `motion`: any springs stretched by it, up to their slip
        force; `forces`: of the springs before, on the last axis [N].
        """

    @abc.abstractmethod
    def stored(self, forces: Numbers) -> Batch:
        """Energy in its springs [J] for its spring `forces` [N]."""

    def lost_power(self, motion: Motion) -> Batch:
        """Heat [W] of friction without memory in a `motion` [SI]; zero with memory, whose loss each
        step returns.
        """
        return 0.0 * (motion.velocity + motion.pressures[1] + motion.pressure_slope)


class MaxwellSlip(AbstractHysteresis):
    """Springs that slip, equation (H1).

    `stiffness`: $k_j$ of each [N/m]. `slip_force`: $f_j$ at no pressure [N].
    `slip_force_slope`: $f_P$, their rise with pressure [N/Pa]; zero by default.
    """

    source: ClassVar[str] = "Iwan (1966)"
    stiffness: Numbers = record(unit="N/m")
    slip_force: Numbers = record(unit="N")
    slip_force_slope: Numbers = record(unit="N/Pa")

    def __init__(self, stiffness: Values, slip_force: Values, slip_force_slope: Values = 0.0):
        """Arguments are the fields; a single slope is that of all springs. `ValueError` for invalid
        numbers, and for different numbers of springs.
        """
        k = np.atleast_1d(check_positive(stiffness, "stiffness", "N/m"))
        f = np.atleast_1d(check_nonnegative(slip_force, "slip_force", "N"))
        if np.shape(k) != np.shape(f):
            springs, remedy = np.size(f), f"`stiffness` has {np.size(k)}"
            raise InvalidInputError("slip_force", "must have one for each spring", springs, remedy)
        slope = check_nonnegative(slip_force_slope, "slip_force_slope", "N/Pa")
        self.__attrs_init__(k, f, np.broadcast_to(slope, np.shape(k)))

    @property
    def count(self) -> int:
        return int(np.shape(self.stiffness)[-1])

    def advance(self, forces: Numbers, motion: Motion) -> FrictionStep:
        k, displacement = self.stiffness, motion.displacement[..., None]
        before, f = (self._slip_force(P) for P in motion.pressures)
        new_forces = minimum(maximum(forces + k * displacement, -f), f)
        # a spring slips by what it doesn't bend, at a force that moves with pressure meanwhile
        loss = (before + f) / 2 * absolute(displacement - (new_forces - forces) / k)
        add = array_namespace(new_forces).sum
        return FrictionStep(new_forces, add(new_forces, axis=-1), add(loss, axis=-1))

    def loop_width(self, forward: Batch, back: Batch, pressure: Batch) -> Batch:
        """Width [N] of a closed loop, its pull on the way back less that on the way forward, (H4),
        at displacements `forward` and `back` from both turns [m] and a constant `pressure` [Pa].
        """
        k, forward, back = self.stiffness, forward[..., None], back[..., None]
        f = self._slip_force(pressure)
        a = minimum(f, k * (forward + back) / 2)  # a short stroke bends some springs, and no more
        width = minimum(k * forward, 2 * a) + minimum(k * back, 2 * a) - 2 * a
        return array_namespace(width).sum(width, axis=-1)

    def stored(self, forces: Numbers) -> Batch:
        return array_namespace(forces).sum(forces**2 / (2 * self.stiffness), axis=-1)

    def _slip_force(self, pressure: Batch) -> Numbers:
        """Slip force of each spring [N] at a `pressure` [Pa]."""
        return self.slip_force + self.slip_force_slope * maximum(pressure, 0.0)[..., None]


class Dahl(AbstractHysteresis):
    """A spring that yields gradually, equation (H2).

    `stiffness`: $k$ [N/m]. `slip_force`: $f$ at no pressure [N]. `slip_force_slope`: $f_P$, its
    rise with pressure [m²].
    """

    source: ClassVar[str] = "Dahl (1976)"
    stiffness: Batch = _field(check_positive, "stiffness", "N/m")
    slip_force: Batch = _field(check_positive, "slip_force", "N")
    slip_force_slope: Batch = _field(check_nonnegative, "slip_force_slope", "N/Pa", default=0.0)

    @property
    def count(self) -> int:
        return 1

    def advance(self, forces: Numbers, motion: Motion) -> FrictionStep:
        k, displacement = self.stiffness, motion.displacement
        f = self.slip_force + self.slip_force_slope * maximum(motion.pressures[1], 0.0)
        before = forces[..., 0]
        limited = minimum(maximum(before, -f), f)
        end = where(displacement >= 0, f, -f)
        new_forces = end + (limited - end) * exp(-k * absolute(displacement) / f)
        # the work against z is stored or lost: ∫z dx = s f |Δx| − (z − z0) s f/k
        work = end * displacement - (new_forces - limited) * end / k
        loss = work - (new_forces**2 - limited**2) / (2 * k) + (before**2 - limited**2) / (2 * k)
        return FrictionStep(new_forces[..., None], new_forces, loss)

    def stored(self, forces: Numbers) -> Batch:
        return forces[..., 0] ** 2 / (2 * self.stiffness)


class Coulomb(AbstractHysteresis):
    """Dry friction of a width in pressure, with a smooth sign of the speed, (H3): none at rest.

    `width`: $w$, by which the pressure seems lower in contraction, higher in extension [Pa].
    `velocity`: $v_0$, at which friction is three quarters of its limit [m/s].
    """

    source: ClassVar[str] = "Chou and Hannaford (1996)"
    width: Batch = _field(check_nonnegative, "width", "Pa")
    velocity: Batch = _field(check_positive, "velocity", "m/s", default=1e-3)

    @property
    def count(self) -> int:
        return 0

    def advance(self, forces: Numbers, motion: Motion) -> FrictionStep:
        sign = array_namespace(motion.velocity).tanh(motion.velocity / self.velocity)
        force = self.width * absolute(motion.pressure_slope) * sign
        return FrictionStep(forces, force, 0.0 * motion.displacement)  # its loss is `lost_power`

    def stored(self, forces: Numbers) -> Batch:
        return array_namespace(forces).sum(forces, axis=-1)  # zero: it has no entries

    def lost_power(self, motion: Motion) -> Batch:
        return self.advance(np.zeros(0), motion).force * motion.velocity


class Damping(Module):
    """Friction in proportion to the speed of contraction, (H6), beside any that has a memory.

    `shortening`, `lengthening`: $B_0$ of either direction [N·s/m]; `shortening_slope`,
    `lengthening_slope`: $B_P$, its change with pressure [N·s/(m·Pa)].
    """

    source: ClassVar[str] = "Lilly and Quesada (2004)"
    shortening: Batch = _field(check_finite, "shortening", "N·s/m")
    lengthening: Batch = _field(check_finite, "lengthening", "N·s/m")
    shortening_slope: Batch = _field(check_finite, "shortening_slope", "N·s/(m·Pa)", default=0.0)
    lengthening_slope: Batch = _field(check_finite, "lengthening_slope", "N·s/(m·Pa)", default=0.0)

    def coefficient(self, velocity: Batch, pressure: Batch) -> Batch:
        """$B$ [N·s/m] at a `velocity` of contraction [m/s] and a `pressure` [Pa]."""
        shortens = velocity >= 0
        constant = where(shortens, self.shortening, self.lengthening)
        slope = where(shortens, self.shortening_slope, self.lengthening_slope)
        return maximum(constant + slope * pressure, 0.0)

    def force(self, velocity: Batch, pressure: Batch) -> Batch:
        """Force against contraction [N] at a `velocity` [m/s] and a `pressure` [Pa]."""
        return self.coefficient(velocity, pressure) * velocity
