r"""Tuning as data: two corrections of the tension and four factors, section 5.

$$F_{mod} = C_2 (F - C_1), \qquad F_{mesh,mod} = C_2 F_{mesh}, \qquad
  F_{bladder,mod} = C_2 (F_{bladder} - C_1). \tag{31-33}$$

$C_1(P)$ is the untuned force at the measured free strain (34) and $C_2(P)$ the ratio that
restores the measured blocked force (35). They are tables in pressure, linear between their
rows, flat beyond. At $P = 0$ both are 0/0 and are taken as 0 and 1 [R13], always a row.

Four factors correct what happens past the free strain: one on $E$ wherever $E$ stands
(bending, axial stiffness, collapse moment, hinge) but never in $C_{10}$, $C_{01}$; one on
the collapse moment and one, affine in pressure, on the hinge's stiffness, both on top of
it; and the transition rate $\beta$ itself.

A dead band $P_d$ is the pressure that closes the gap between bladder and braid. The tension
law, and $C_1$ and $C_2$ with it, see the rest of the pressure,

$$P_e = \max(P - P_d, 0); \tag{D}$$

collapse and hinge see $P$, which the bladder holds. The kink at $P = P_d$ is physics; value
and slope are finite there, the slope that of $P > P_d$.

**Source:** Kim, Mazzoleni and Bryant (2021), (31)-(35) and Table 1 [R14].
"""

from typing import NamedTuple

import numpy as np

from ..core.array_namespace import add_table_axis, array_namespace, sum_table, where
from ..core.errors import InvalidInputError
from ..core.module import Module
from ..core.types import AnyArray, Batch, BatchLike, Float, Values
from ..core.validation import (
    HIGHEST_PRESSURE,
    check_finite,
    check_interval,
    check_plausible,
    check_size,
    is_concrete,
    to_si,
    warn_user,
)
from .bladder import Bladder
from .ends import AbstractEnds, Rigid
from .tension import AbstractTension, Pull


Rows = Float[AnyArray, "*#muscles row"]


class Tuning(Module):
    """Measured corrections of one muscle's force; by default none."""

    pressures: Rows
    c1: Rows
    c2: Rows
    youngs_modulus_factor: Batch
    collapse_moment_factor: Batch
    hinge_stiffness_factor: Batch
    hinge_stiffness_slope: Batch
    transition_rate: Batch | None
    dead_band: Batch

    def __init__(
        self,
        pressures: Values = (),
        c1: Values = (),
        c2: Values = (),
        *,
        youngs_modulus_factor: Values = 1.0,
        collapse_moment_factor: Values = 1.0,
        hinge_stiffness_factor: Values = 1.0,
        hinge_stiffness_slope: Values = 0.0,
        transition_rate: Values = None,
        dead_band: Values = 0.0,
    ):
        """**Arguments:**

        - `pressures`: the table's gauge pressures [Pa], rising; a row at zero is optional.
        - `c1`: $C_1$ [N] at each of them.
        - `c2`: $C_2$ [-] at each of them, positive.
        - `youngs_modulus_factor`: on $E$ [-], positive.
        - `collapse_moment_factor`: on the collapse moment [-], positive.
        - `hinge_stiffness_factor`: on $k_r$ at zero pressure [-], positive.
        - `hinge_stiffness_slope`: its rise with pressure [1/Pa].
        - `transition_rate`: $\\beta$ [-], instead of the muscle's.
        - `dead_band`: pressure $P_d$ [Pa] that closes the gap between bladder and braid.

        **Raises:** `ValueError` for an impossible table or factor.
        """
        rate = transition_rate
        self.__attrs_init__(
            *_tuning_table(pressures, c1, c2),
            check_size(youngs_modulus_factor, "youngs_modulus_factor"),
            check_size(collapse_moment_factor, "collapse_moment_factor"),
            check_size(hinge_stiffness_factor, "hinge_stiffness_factor"),
            check_finite(hinge_stiffness_slope, "hinge_stiffness_slope", "1/Pa"),
            None if rate is None else check_size(rate, "transition_rate"),
            check_interval(
                dead_band, 0.0, HIGHEST_PRESSURE, "dead_band", "Pa", closed=(True, False)
            ),
        )
        if is_concrete(self.hinge_stiffness_factor, self.hinge_stiffness_slope):
            factor = self.hinge_stiffness_at(HIGHEST_PRESSURE)
            lowest = np.min(np.asarray(factor))
            if not lowest > 0:
                rule = f"must leave the factor positive up to {HIGHEST_PRESSURE / 1e6:g} MPa"
                text = f"a factor of {lowest:g} there"
                raise InvalidInputError("hinge_stiffness_slope", rule, lowest, shown=text)
            check_plausible(factor, "hinge_stiffness_factor")

    def effective_pressure(self, pressure: BatchLike) -> Batch:
        """Pressure $P_e$ [Pa] that the braid feels at gauge `pressure` [Pa], equation (D)."""
        P, P_d = pressure, self.dead_band
        # not `maximum`, which would halve the slope at P = 0 where there is no dead band
        return where(P_d <= P, P - P_d, 0.0 * P)

    def extrapolation_message(self, pressure: Values) -> str:
        """Warning of a `pressure` [Pa] above the table's last row, else an empty text."""
        rows, band = self.pressures, self.dead_band
        if rows.shape[-1] < 2 or not is_concrete(rows, band, pressure) or not np.size(pressure):
            return ""
        last, highest = np.max(np.asarray(rows)) + np.max(np.asarray(band)), np.max(pressure)
        # a row's pressure, written in other units, may come back a rounding higher
        if highest <= last * (1 + 1e-9):
            return ""
        return (
            f"The tuning was measured up to {last / 1e3:.4g} kPa and is held constant above"
            f" it; the highest pressure here is {highest / 1e3:.4g} kPa."
        )

    def warn_extrapolation(self, pressure: Values) -> None:
        """Warn of a `pressure` [Pa] above the table's last row."""
        warn_user(self.extrapolation_message(pressure))

    def c1_at(self, pressure: BatchLike) -> Batch:
        """Force correction $C_1$ [N] at effective `pressure` [Pa]."""
        return self._interpolate(pressure, self.c1)

    def c2_at(self, pressure: BatchLike) -> Batch:
        """Force factor $C_2$ [-] at effective `pressure` [Pa]."""
        return self._interpolate(pressure, self.c2)

    def _interpolate(self, pressure: BatchLike, rows: Rows) -> Batch:
        """The table's `rows` at effective `pressure` [Pa], constant above; one holds everywhere."""
        if rows.shape[-1] == 1:
            return rows[..., 0] + 0.0 * pressure  # nothing was measured
        P, start = add_table_axis(pressure), self.pressures[..., :-1]
        steps, rises = (x[..., 1:] - x[..., :-1] for x in (self.pressures, rows))
        # a sum of ramps is one pass over the points, a search for the row many; slopes at a
        # row are those to its right
        ramps = where(start <= P, where(start + steps <= P, steps, P - start), 0.0)
        slopes = where(steps > 0, rises / where(steps > 0, steps, 1.0), 0.0)
        return rows[..., 0] + sum_table(slopes * ramps)

    def hinge_stiffness_at(self, pressure: BatchLike) -> Batch:
        """Factor on the hinge's stiffness $k_r$ [-] at `pressure` [Pa]."""
        return self.hinge_stiffness_factor + self.hinge_stiffness_slope * pressure


class PressurizedTension(NamedTuple):
    """A `law` of a `bladder` and `ends` at given pressures: `pressure` $P_e$ [Pa] that the braid
    feels, and the corrections `c1` [N] and `c2` [-] there.
    """

    law: AbstractTension
    bladder: Bladder
    ends: AbstractEnds
    pressure: Batch
    c1: Batch
    c2: Batch

    @property
    def strain_ratio(self) -> Batch:
        """Ratio of the bladder's strain to the muscle's [-] without a force."""
        return self.ends.strain_ratio(self.bladder.braid.length)

    def pull(self, strain: BatchLike) -> Pull:
        """Mesh and bladder force [N] at the muscle's `strain` [-], (E7)."""
        return self.ends.pull(self, strain)

    def bladder_pull(self, strain: BatchLike) -> Pull:
        """Mesh and bladder force [N] at a `strain` [-] of the bladder, (32) and (33)."""
        c1, c2 = self.c1, self.c2
        mesh, bladder, mesh_slope, bladder_slope = self.law.pull(
            self.bladder, self.pressure, strain
        )
        return Pull(c2 * mesh, c2 * (bladder - c1), c2 * mesh_slope, c2 * bladder_slope)


class TunedTension(Module):
    """A muscle's tension law $T(P, \\varepsilon)$ with its tuning and its ends."""

    law: AbstractTension
    bladder: Bladder
    tuning: Tuning
    ends: AbstractEnds = Rigid()

    def at(self, pressure: BatchLike) -> PressurizedTension:
        """The law with its corrections at `pressure` [Pa]."""
        P_e = self.tuning.effective_pressure(pressure)
        c1, c2 = self.tuning.c1_at(P_e), self.tuning.c2_at(P_e)
        return PressurizedTension(self.law, self.bladder, self.ends, P_e, c1, c2)

    def pull(self, pressure: BatchLike, strain: BatchLike) -> Pull:
        """Mesh and bladder force [N] at `pressure` [Pa] and `strain` [-], (E7)."""
        return self.at(pressure).pull(strain)

    def force(self, pressure: BatchLike, strain: BatchLike) -> Batch:
        """Tuned force $F_{mod}$ [N] at `pressure` [Pa] and `strain` [-], (31)."""
        return self.pull(pressure, strain).force

    def rest_coenergy(self, pressure: BatchLike) -> Batch:
        """Co-energy less $P V(0)$ [J] at rest length and `pressure` [Pa]."""
        P_e = self.tuning.effective_pressure(pressure)
        return self.law.rest_coenergy(self.bladder, P_e) / self.strain_ratio

    def free_strain(self, pressure: BatchLike) -> Batch:
        """Strain $\\varepsilon_f$ [-] at which the tuned force vanishes at `pressure` [Pa]."""
        P_e = self.tuning.effective_pressure(pressure)
        return self.law.free_strain(self.bladder, P_e, self.tuning.c1_at) / self.strain_ratio

    @property
    def strain_ratio(self) -> Batch:
        """Ratio of the bladder's strain to the muscle's [-] without a force."""
        return self.ends.strain_ratio(self.bladder.braid.length)


def _tuning_table(pressures: Values, c1: Values, c2: Values) -> tuple[Rows, Rows, Rows]:
    """The table with a row at zero pressure, checked where it is concrete."""
    pressures, c1 = to_si(pressures, "pressures", "Pa"), to_si(c1, "c1", "N")
    xp = np if is_concrete(pressures, c1, c2) else array_namespace(pressures, c1, c2)
    P, rows1, rows2 = (xp.atleast_1d(xp.asarray(x, dtype=float)) for x in (pressures, c1, c2))
    if not P.shape == rows1.shape == rows2.shape or P.ndim != 1:
        rule = ", `c1` and `c2` must be lists of equal length"
        sizes = (P.size, rows1.size, rows2.size)
        text = "{}, {} and {} entries".format(*sizes)
        raise InvalidInputError("pressures", rule, sizes, shown=text)
    concrete = P.size and is_concrete(pressures)
    if concrete:
        lowest = check_finite(pressures, "pressures", "Pa").min()
        if lowest < 0 or np.any(np.diff(P) <= 0):
            rule, text = "must rise from 0 Pa or above", f"{P.tolist()} Pa"
            raise InvalidInputError("pressures", rule, P.tolist(), shown=text)
    if P.size and is_concrete(c1, c2):
        check_size(c1, "c1")
        check_size(c2, "c2")
        if concrete and P[0] == 0 and (rows1[0] != 0 or rows2[0] != 1):
            rule = "and `c2` must be 0 N and 1 at zero pressure"
            text = f"{rows1[0]:g} N and {rows2[0]:g}"
            raise InvalidInputError("c1", rule, float(rows1[0]), shown=text)
    if concrete and P[0] == 0:
        return P, rows1, rows2
    # harmless where a traced table begins at zero already: its first row holds there
    first = ((0.0, P), (0.0, rows1), (1.0, rows2))
    P, rows1, rows2 = (xp.concatenate([xp.full(1, value), rows]) for value, rows in first)
    return P, rows1, rows2
