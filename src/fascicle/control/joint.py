r"""Inverse of an antagonistic joint: two pressures for a torque and a stiffness at an angle.

At the angle $\theta$ the agonist is shortened and the antagonist lengthened by $r \theta$ from
where both are at $\theta = 0$. With $x$, the shortening of a bundle, and open valves, so that
pressures are constant,

$$\tau = r\,(F_1 - F_2), \qquad
  K = -\frac{\partial \tau}{\partial \theta}
    = -r^2 \left(\frac{\partial F_1}{\partial x_1} + \frac{\partial F_2}{\partial x_2}\right).
  \tag{K9}$$

With shut valves the mass of gas $m \propto (P + p_a) V^*$ stays, which adds to each
$-\partial F/\partial x$

$$\left(\frac{\partial F}{\partial P}\right)^2
  \frac{P + p_a}{V^* + (P + p_a)\, \partial V^*/\partial P}, \qquad
  \frac{\partial V^*}{\partial x} = -\frac{\partial F}{\partial P}. \tag{K10}$$

Along the curve of constant torque the antagonist's pressure follows from the agonist's, on its
rising branch; of the agonist's pressures that give the stiffness the least is taken.

**Assumes** that all motor units of a bundle have one pressure. **Sign:** a positive torque turns
the joint the way the agonist pulls. **Source:** derived here.
"""

from enum import IntEnum
from functools import partial
from typing import NamedTuple

import attrs
import numpy as np
from scipy.optimize import elementwise

from ..bundle import Bundle
from ..bundle.bundle import as_bundle
from ..core.types import Numbers, Values, Whole
from ..core.validation import (
    HIGHEST_PRESSURE,
    check_choice,
    check_finite,
    check_interval,
    check_positive,
)
from ..fluid.fields import ROOM_PRESSURE
from .dip import unit_strain


_STEP = 100.0  # Pa, of slopes: far above rounding, far below a fold
EDGE = 1e-9  # of a curve
_STIFFEST = 1e12  # N·m/rad, stiffer than any joint
NODES = 33  # pressures that bracket a root, even in √P: the stiffness bends most at low pressure


class JointStatus(IntEnum):
    """Outcome of a demand on a joint: reached, or out of reach."""

    REACHED = 0
    STIFFNESS_TOO_HIGH = 1
    STIFFNESS_TOO_LOW = 2
    TORQUE_OUT_OF_REACH = 3


class JointPressures(NamedTuple):
    """Pressures of a joint's `agonist` and `antagonist` [Pa], the `torque` [N·m] and `stiffness`
    [N·m/rad] that they give, with open valves, and a `status`, one of `JointStatus`.
    """

    agonist: Numbers
    antagonist: Numbers
    torque: Numbers
    stiffness: Numbers
    status: Whole


_as_bundle = partial(as_bundle, name="agonist and antagonist")


@attrs.frozen
class Joint:
    """Two muscles or bundles, `agonist` and `antagonist`, that pull a joint in opposite directions.

    All motor units of a bundle have one pressure, the highest the lower of both bundles' supply
    pressures, 1 MPa without one. `moment_arm`: $r$ of both [m]; `strain`: of both bundles' plates
    at the angle zero [-].
    """

    agonist: Bundle = attrs.field(converter=_as_bundle)
    antagonist: Bundle = attrs.field(converter=_as_bundle)
    moment_arm: float = attrs.field(converter=lambda r: float(check_positive(r, "moment_arm", "m")))
    strain: float = attrs.field(
        default=0.0, converter=lambda x: float(check_finite(x, "strain", "-"))
    )

    def pressures(self, angle: Values, torque: Values, stiffness: Values) -> JointPressures:
        """Pressures that give a demanded `torque` [N·m] and `stiffness` [N·m/rad] with open valves
        at an `angle` [rad], (K9); the three broadcast.

        Where a demand is out of reach, those of the nearest stiffness at this torque, or else of
        the nearest torque. `InvalidInputError` for values that aren't finite, and an angle at which
        a muscle leaves its domain.
        """
        rows = np.broadcast_arrays(
            check_finite(angle, "angle", "rad"),
            check_finite(torque, "torque", "N*m"),
            check_finite(stiffness, "stiffness", "N*m/rad"),
        )
        demand = tuple(np.reshape(row, -1) + 0.0 for row in rows)
        theta, tau, _ = demand
        nodes = self._curve_nodes(theta, tau)
        excess = self._excess(nodes, *demand)
        feasible, batch = np.isfinite(excess), np.arange(theta.size)
        crosses = excess[:-1] * excess[1:] <= 0  # false beside a NaN
        crossed, k = crosses.any(axis=0), np.argmax(crosses, axis=0)
        bracket = nodes[k, batch], nodes[k + 1, batch]
        root = elementwise.find_root(self._excess, bracket, args=demand).x
        nearest = np.argmin(np.where(feasible, np.abs(excess), np.inf), axis=0)
        P1 = np.where(crossed, root, nodes[nearest, batch])
        P2 = self._antagonist_pressure(P1, theta, tau)
        wrong = JointStatus.STIFFNESS_TOO_HIGH, JointStatus.STIFFNESS_TOO_LOW
        status = np.where(excess[nearest, batch] < 0, *wrong)
        status = np.where(crossed, JointStatus.REACHED, status)
        # a torque that no pair of pressures gives: the largest or the least
        unreachable = ~feasible.any(axis=0)
        status = np.where(unreachable, JointStatus.TORQUE_OUT_OF_REACH, status)
        P1, P2 = np.where(unreachable, self._extreme_pressures(theta, tau), (P1, P2))
        result = P1, P2, *self._evaluate(P1, P2, theta), status
        return JointPressures(*(np.reshape(row, rows[0].shape)[()] for row in result))

    def stiffness(
        self, agonist: Values, antagonist: Values, angle: Values, valves: str = "open"
    ) -> Numbers:
        """Stiffness [N·m/rad] at gauge pressures of `agonist` and `antagonist` [Pa] and an `angle`
        [rad]; the three broadcast. `valves`: "open", at constant pressures, or "shut": the gas in
        the muscles stays, at the temperature of the room. Raises as `pressures`.
        """
        check_choice(valves, ("open", "shut"), "valves")
        pressures = (
            check_interval(P, 0.0, HIGHEST_PRESSURE, name, "Pa", "(gauge)", (True, True))
            for name, P in (("agonist", agonist), ("antagonist", antagonist))
        )
        *sides, theta = np.broadcast_arrays(*pressures, check_finite(angle, "angle", "rad"))
        total, bundles = 0.0 * theta, (self.agonist, self.antagonist)
        for bundle, P, eps in zip(bundles, sides, self._strains(theta), strict=True):
            gas = _gas_stiffness(bundle, P, eps) if valves == "shut" else 0.0
            total = total + _pull(bundle, P, eps)[1] + gas
        return self.moment_arm**2 * total

    def stiffness_range(self, angle: float, torque: float) -> tuple[float, float]:
        """Least and largest stiffness [N·m/rad] at an `angle` [rad] and a `torque` [N·m]; NaN if
        the torque is out of reach.
        """
        ends = self.pressures(angle, torque, np.array([-_STIFFEST, _STIFFEST]))
        low, high = np.where(ends.status == JointStatus.TORQUE_OUT_OF_REACH, np.nan, ends.stiffness)
        return float(low), float(high)

    @property
    def highest_pressure(self) -> float:
        """Highest pressure [Pa]."""
        supplies = (self.agonist.supply_pressure, self.antagonist.supply_pressure)
        return min((float(P) for P in supplies if P is not None), default=HIGHEST_PRESSURE)

    def _strains(self, angle: Values) -> tuple[Numbers, Numbers]:
        """Strains [-] of the plates of both bundles at an `angle` [rad]."""
        shortening = self.moment_arm * np.asarray(angle, float)
        first, second = float(self.agonist.length), float(self.antagonist.length)
        return self.strain + shortening / first, self.strain - shortening / second

    def _end_forces(self, angle: Numbers) -> tuple[Numbers, Numbers]:
        """Forces [N] of agonist and antagonist at an `angle` [rad], empty and at the highest
        pressure of the joint on the first axis.
        """
        ends = np.array([[0.0], [self.highest_pressure]])
        bundles = zip((self.agonist, self.antagonist), self._strains(angle), strict=True)
        first, second = (_pull(bundle, ends, strain)[0] for bundle, strain in bundles)
        return first, second

    def _extreme_pressures(self, angle: Numbers, torque: Numbers) -> Numbers:
        """Pressures [Pa] of the largest torque at an `angle` [rad], where a `torque` [N·m] is too
        large, or else of the least, each muscle empty or full.
        """
        first, second = self._end_forces(angle)
        middle = self.moment_arm * np.mean(first - second, axis=0)
        return self.highest_pressure * np.where(
            torque > middle,
            (np.argmax(first, axis=0), np.argmin(second, axis=0)),
            (np.argmin(first, axis=0), np.argmax(second, axis=0)),
        )

    def _curve_nodes(self, angle: Numbers, torque: Numbers) -> Numbers:
        """Pressures of the agonist [Pa], nodes on the first axis, on the curve of a `torque` [N·m]
        at an `angle` [rad]: from where one of both is empty to where one is full. NaN if there is
        no such curve.
        """
        first, second = self._end_forces(angle)
        # forces of the agonist that the antagonist balances, as far as it has them
        balanced = np.sort(second, axis=0) + torque / self.moment_arm
        low, high = np.sort(first, axis=0)
        exists = (balanced[0] <= high) & (balanced[1] >= low)
        strain, pressures = self._strains(angle)[0], []
        for force in np.clip(balanced, low, high):
            root = self._pressure_of(self.agonist, force, strain)
            root = np.where(force == first[1], self.highest_pressure, root)
            root = np.where(force == first[0], 0.0, root)
            pressures.append(np.where(exists, root, np.nan))
        start, end = np.sort(pressures, axis=0)
        # just inside: at an end itself rounding decides whether the antagonist's pressure exists
        fraction = EDGE + (1 - 2 * EDGE) * np.linspace(0.0, 1.0, NODES)[:, None] ** 2
        return start + fraction * (end - start)

    def _antagonist_pressure(self, agonist: Numbers, angle: Numbers, torque: Numbers) -> Numbers:
        """Pressure of the antagonist [Pa] with which a pressure of the `agonist` [Pa] gives a
        `torque` [N·m] at an `angle` [rad]; NaN if none does.
        """
        first, second = self._strains(angle)
        force = _pull(self.agonist, agonist, first)[0] - torque / self.moment_arm
        return self._pressure_of(self.antagonist, force, second)

    def _pressure_of(self, bundle: Bundle, force: Numbers, strain: Numbers) -> Numbers:
        """Pressure [Pa] of a `force` [N] of a bundle at a plates' `strain` [-]; NaN if none."""
        # an empty muscle pulls at least as much as a dip, so that the root on the branch that
        # leads from an empty to a full one is the only one
        arguments = np.broadcast_arrays(strain, force)
        ends = 0.0 * arguments[0], 0.0 * arguments[0] + self.highest_pressure
        return elementwise.find_root(
            lambda P, eps, demand: _pull(bundle, P, eps)[0] - demand, ends, args=arguments
        ).x

    def _excess(
        self, agonist: Numbers, angle: Numbers, torque: Numbers, stiffness: Numbers
    ) -> Numbers:
        """Stiffness above a demanded one [N·m/rad] along the curve of a `torque` [N·m]."""
        antagonist = self._antagonist_pressure(agonist, angle, torque)
        return self._evaluate(agonist, antagonist, angle)[1] - stiffness

    def _evaluate(
        self, agonist: Numbers, antagonist: Numbers, angle: Numbers
    ) -> tuple[Numbers, Numbers]:
        """Torque [N·m] and stiffness [N·m/rad] at pressures [Pa] and an `angle` [rad], (K9)."""
        first, second = self._strains(angle)
        F1, K1 = _pull(self.agonist, agonist, first)
        F2, K2 = _pull(self.antagonist, antagonist, second)
        return self.moment_arm * (F1 - F2), self.moment_arm**2 * (K1 + K2)


def _pull(bundle: Bundle, pressure: Numbers, strain: Numbers) -> tuple[Numbers, Numbers]:
    """Force [N] and stiffness [N/m] of a bundle at one `pressure` [Pa] and a plates' `strain`."""
    pressure, strain = np.broadcast_arrays(pressure, strain)
    force, stiffness = 0.0 * strain, 0.0 * strain
    with np.errstate(all="ignore"):  # of branches that aren't selected
        for number, unit in enumerate(bundle.motor_units, start=1):
            muscle = unit.muscle.law.at(pressure + 0.0)
            pull, slope = muscle.force_and_slope(unit_strain(bundle, number, strain))
            force = force + unit.count * pull
            stiffness = stiffness - unit.count * slope / float(unit.muscle.length)
    return force, stiffness


def _gas_stiffness(bundle: Bundle, pressure: Numbers, strain: Numbers) -> Numbers:
    """Stiffness [N/m] that the gas adds to a bundle at a `pressure` [Pa] and a `strain` [-] where
    its mass stays, (K10).
    """

    def volume(P: Numbers) -> Numbers:
        units = enumerate(bundle.motor_units, start=1)
        return sum(
            unit.count * unit.muscle.conjugate_volume(P, unit_strain(bundle, number, strain))
            for number, unit in units
        )

    # a shortening does work on the gas: the slope of the volume by it is that of the force by
    # pressure, with the other sign
    P = np.maximum(pressure, _STEP)
    forces = [_pull(bundle, P + side * _STEP, strain)[0] for side in (-1, 1)]
    by_pressure = (forces[1] - forces[0]) / (2 * _STEP)
    compliance = (volume(P + _STEP) - volume(P - _STEP)) / (2 * _STEP)
    absolute = pressure + ROOM_PRESSURE
    return by_pressure**2 * absolute / (volume(pressure) + absolute * compliance)
