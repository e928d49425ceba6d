r"""Friction of braid and bladder that remembers the way.

Each muscle of a unit has a friction force $z$ against its contraction $x = L_0 \varepsilon$.

`MaxwellSlip`: springs $k_j$ that slip at $f_j$. Along a way that doesn't turn they are known
exactly, however long it is,

$$z_j \leftarrow \operatorname{clip}(z_j + k_j\,\Delta x, -f_j, f_j), \tag{H1}$$

and so is `Dahl`'s, one spring that yields little by little,

$$\frac{\mathrm{d}z}{\mathrm{d}x} = k (1 - z \operatorname{sgn}(\mathrm{d}x)/f), \qquad
  z \leftarrow s f + (z - s f) e^{-k |\Delta x|/f}, \quad s = \operatorname{sgn} \Delta x.
  \tag{H2}$$

Between two turns $S$ apart, at $d$ from the first, a closed loop of (H1) is as wide as

$$w = \sum_j \min(k_j d, 2 a_j) + \min(k_j (S - d), 2 a_j) - 2 a_j, \qquad
  a_j = \min(f_j, k_j S/2): \tag{H4}$$

in its middle twice what slips. A closed loop between $\pm X$ costs $4 f (X - f/k)$ for (H1) and
$4 f [X - (f/k) \tanh(k X/f)]$ for (H2). What is stored is $z^2/(2k)$, so that no way gives energy.
$f$ may rise with pressure, $f = f_0 + f_P P$; $k$ may not: a spring that stiffens while it is
bent makes energy.

`Coulomb` is friction as a width in pressure: the muscle behaves as at $P \mp w$,

$$z = w \left|\frac{\partial F}{\partial P}\right| \tanh(\dot x/v_0), \tag{H3}$$

with no memory.

**Source:** Iwan (1966), Maxwell slip; Dahl (1976); the width in pressure as measured loops of
muscles are told: Chou and Hannaford (1996).
"""

import abc
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ..core.array_namespace import absolute, array_namespace, exp, maximum, minimum, where
from ..core.errors import InvalidInputError
from ..core.module import Module
from ..core.types import Batch, Numbers, Values
from ..core.validation import check_interval, check_positive


class FrictionStep(NamedTuple):
    """A friction element after a way: its `spring_forces` on the last axis [N], the
    `force` against
    contraction [N], and the energy `lost` on the way [J].
    """

    spring_forces: Numbers
    force: Batch
    lost: Batch


class AbstractHysteresis(Module):
    """Friction of one muscle against its contraction; `stiffness` [N/m] of those that have one."""

    stiffness: ClassVar[Any]

    @property
    @abc.abstractmethod
    def count(self) -> int:
        """How many forces it remembers [-]."""

    @abc.abstractmethod
    def slid(
        self, forces: Numbers, displacement: Batch, velocity: Batch, pressures: tuple[Batch, Batch],
        by_pressure: Batch,
    ) -> FrictionStep:  # fmt: skip
        """Friction after a displacement that does not turn.

        **Arguments:**

        - `forces`: its forces before, on the last axis [N].
        - `displacement`: $\\Delta x$ of the contraction since then [m].
        - `velocity`: $\\dot x$ now [m/s].
        - `pressures`: $P$ before and now [Pa].
        - `by_pressure`: $\\partial F/\\partial P$ of the muscle now [m²].

        **Returns:** a `Slid`: forces [N] and energy [J].
        """

    @abc.abstractmethod
    def stored(self, forces: Numbers) -> Batch:
        """Energy in its springs [J] for its spring `forces` [N]."""

    @abc.abstractmethod
    def lost_power(self, velocity: Batch, pressure: Batch, by_pressure: Batch) -> Batch:
        """Heat [W] of what has no memory, at a `velocity` [m/s], `pressure` [Pa] and
        `by_pressure` [m²]; zero for what has.
        """


class MaxwellSlip(AbstractHysteresis):
    """Springs that slip, equation (H1).

    `stiffness`: $k_j$, one for each [N/m]. `slip_force`: $f_j$ at no pressure [N].
    `slip_force_slope`: $f_P$, their rise with pressure [N/Pa]; zero where left out.
    """

    source: ClassVar[str] = "Iwan (1966)"
    stiffness: Numbers
    slip_force: Numbers
    slip_force_slope: Numbers

    def __init__(self, stiffness: Values, slip_force: Values, slip_force_slope: Values = 0.0):
        """**Arguments:**

        - `stiffness`: $k_j$, one for each spring [N/m].
        - `slip_force`: $f_j$ at no pressure [N].
        - `slip_force_slope`: $f_P$, their rise with pressure [m²].

        **Raises:** `ValueError` for numbers that can't be, and for unlike many.
        """
        self.stiffness = np.atleast_1d(check_positive(stiffness, "stiffness", "N/m"))
        self.slip_force = np.atleast_1d(_check_nonnegative(slip_force, "slip_force", "N"))
        if np.shape(self.stiffness) != np.shape(self.slip_force):
            raise InvalidInputError(
                "slip_force", "must have one for each spring", np.size(self.slip_force),
                f"`stiffness` has {np.size(self.stiffness)}",
            )  # fmt: skip
        slope = _check_nonnegative(slip_force_slope, "slip_force_slope", "N/Pa")
        self.slip_force_slope = np.broadcast_to(slope, np.shape(self.stiffness))

    @property
    def count(self) -> int:
        """One force [-] for each spring."""
        return int(np.shape(self.stiffness)[-1])

    def slid(
        self, forces: Numbers, displacement: Batch, velocity: Batch, pressures: tuple[Batch, Batch],
        by_pressure: Batch,
    ) -> FrictionStep:  # fmt: skip
        """Equation (H1).

        **Arguments:**

        - `forces`: its forces before, on the last axis [N].
        - `displacement`: $\\Delta x$ of the contraction since then [m].
        - `velocity`: $\\dot x$ now [m/s].
        - `pressures`: $P$ before and now [Pa].
        - `by_pressure`: $\\partial F/\\partial P$ of the muscle now [m²].

        **Returns:** a `Slid`: forces [N] and energy [J].
        """
        del velocity, by_pressure
        k = self.stiffness
        before, f = (
            self.slip_force + self.slip_force_slope * maximum(P, 0.0)[..., None] for P in pressures
        )
        new_forces = minimum(maximum(forces + k * displacement[..., None], -f), f)
        # a spring slips by what it doesn't bend, at a force that moves with pressure meanwhile
        lost = (before + f) / 2 * absolute(displacement[..., None] - (new_forces - forces) / k)
        add = array_namespace(new_forces).sum
        return FrictionStep(new_forces, add(new_forces, axis=-1), add(lost, axis=-1))

    def loop_width(self, forward: Batch, back: Batch, pressure: Batch) -> Batch:
        """How wide a closed loop is, between two turns, equation (H4).

        **Arguments:**

        - `forward`: way from the turn where contraction begins [m].
        - `back`: way from the turn where it ends [m]; together they are the stroke.
        - `pressure`: $P$ [Pa], held.

        **Returns:** the pull on the way back less that on the way there [N].
        """
        k, forward, back = self.stiffness, forward[..., None], back[..., None]
        f = self.slip_force + self.slip_force_slope * maximum(pressure, 0.0)[..., None]
        a = minimum(f, k * (forward + back) / 2)  # a short stroke bends some springs, and no more
        wide = minimum(k * forward, 2 * a) + minimum(k * back, 2 * a) - 2 * a
        return array_namespace(wide).sum(wide, axis=-1)

    def stored(self, forces: Numbers) -> Batch:
        """$\\sum z_j^2/(2 k_j)$ [J] for its spring `forces` [N]."""
        return array_namespace(forces).sum(forces**2 / (2 * self.stiffness), axis=-1)

    def lost_power(self, velocity: Batch, pressure: Batch, by_pressure: Batch) -> Batch:
        """None [W] that its way doesn't tell, at any `velocity` [m/s], `pressure` [Pa] and
        `by_pressure` [m²].
        """
        return 0.0 * (velocity + pressure + by_pressure)


class Dahl(AbstractHysteresis):
    """A spring that yields little by little, equation (H2).

    `stiffness`: $k$ [N/m]. `slip_force`: $f$ at no pressure [N]. `slip_force_slope`: $f_P$, its
    rise with pressure [m²].
    """

    source: ClassVar[str] = "Dahl (1976)"
    stiffness: Batch
    slip_force: Batch
    slip_force_slope: Batch

    def __init__(self, stiffness: Values, slip_force: Values, slip_force_slope: Values = 0.0):
        """**Arguments:**

        - `stiffness`: $k$ [N/m].
        - `slip_force`: $f$ at no pressure [N].
        - `slip_force_slope`: $f_P$, its rise with pressure [m²].

        **Raises:** `ValueError` for numbers that can't be.
        """
        self.stiffness = check_positive(stiffness, "stiffness", "N/m")
        self.slip_force = check_positive(slip_force, "slip_force", "N")
        self.slip_force_slope = _check_nonnegative(slip_force_slope, "slip_force_slope", "N/Pa")

    @property
    def count(self) -> int:
        """One force [-]."""
        return 1

    def slid(
        self, forces: Numbers, displacement: Batch, velocity: Batch, pressures: tuple[Batch, Batch],
        by_pressure: Batch,
    ) -> FrictionStep:  # fmt: skip
        """Equation (H2).

        **Arguments:**

        - `forces`: its forces before, on the last axis [N].
        - `displacement`: $\\Delta x$ of the contraction since then [m].
        - `velocity`: $\\dot x$ now [m/s].
        - `pressures`: $P$ before and now [Pa].
        - `by_pressure`: $\\partial F/\\partial P$ of the muscle now [m²].

        **Returns:** a `Slid`: forces [N] and energy [J].
        """
        del velocity, by_pressure
        k = self.stiffness
        f = self.slip_force + self.slip_force_slope * maximum(pressures[1], 0.0)
        before = forces[..., 0]
        limited = minimum(maximum(before, -f), f)
        end = where(displacement >= 0, f, -f)
        new_forces = end + (limited - end) * exp(-k * absolute(displacement) / f)
        # the way is done against z and stored or lost: ∫z dx = s f |Δx| − (z − z0) s f/k
        work = end * displacement - (new_forces - limited) * end / k
        lost = work - (new_forces**2 - limited**2) / (2 * k) + (before**2 - limited**2) / (2 * k)
        return FrictionStep(new_forces[..., None], new_forces, lost)

    def stored(self, forces: Numbers) -> Batch:
        """$z^2/(2k)$ [J] for its `forces` [N]."""
        return forces[..., 0] ** 2 / (2 * self.stiffness)

    def lost_power(self, velocity: Batch, pressure: Batch, by_pressure: Batch) -> Batch:
        """None [W] that its way doesn't tell, at any `velocity` [m/s], `pressure` [Pa] and
        `by_pressure` [m²].
        """
        return 0.0 * (velocity + pressure + by_pressure)


class Coulomb(AbstractHysteresis):
    """Friction as a width in pressure, equation (H3).

    `width`: $w$ [Pa]. `velocity`: $v_0$, at which it is three quarters of it all [m/s].
    """

    source: ClassVar[str] = "Chou and Hannaford (1996)"
    width: Batch
    velocity: Batch

    def __init__(self, width: Values, velocity: Values = 1e-3):
        """**Arguments:**

        - `width`: $w$ [Pa].
        - `velocity`: $v_0$ [m/s].

        **Raises:** `ValueError` for numbers that can't be.
        """
        self.width = _check_nonnegative(width, "width", "Pa")
        self.velocity = check_positive(velocity, "velocity", "m/s")

    @property
    def count(self) -> int:
        """None [-]."""
        return 0

    def slid(
        self, forces: Numbers, displacement: Batch, velocity: Batch, pressures: tuple[Batch, Batch],
        by_pressure: Batch,
    ) -> FrictionStep:  # fmt: skip
        """Equation (H3).

        **Arguments:**

        - `forces`: its forces before, on the last axis [N].
        - `displacement`: $\\Delta x$ of the contraction since then [m].
        - `velocity`: $\\dot x$ now [m/s].
        - `pressures`: $P$ before and now [Pa].
        - `by_pressure`: $\\partial F/\\partial P$ of the muscle now [m²].

        **Returns:** a `Slid`: forces [N] and no energy [J], which `lost_power` tells.
        """
        del pressures
        force = (
            self.width
            * absolute(by_pressure)
            * array_namespace(velocity).tanh(velocity / self.velocity)
        )
        return FrictionStep(forces, force, 0.0 * displacement)

    def stored(self, forces: Numbers) -> Batch:
        """None [J], whatever its `forces` [N]."""
        return array_namespace(forces).sum(forces, axis=-1)

    def lost_power(self, velocity: Batch, pressure: Batch, by_pressure: Batch) -> Batch:
        """$z \\dot x$ [W] at a `velocity` [m/s], any `pressure` [Pa] and `by_pressure` [m²]."""
        displacement = 0.0 * velocity
        return (
            self.slid(
                displacement[..., None][..., :0],
                displacement,
                velocity,
                (pressure, pressure),
                by_pressure,
            ).force
            * velocity
        )


def _check_nonnegative(value: Values, name: str, unit: str) -> Batch:
    return check_interval(value, 0.0, np.inf, name, unit, closed=(True, False))
