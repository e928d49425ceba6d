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
law, and $C_1$ and $C_2$ with it, see what is left of the pressure,

$$P_e = \max(P - P_d, 0); \tag{D}$$

collapse and hinge see $P$, which the bladder holds. The kink at $P = P_d$ is physics; value
and slope are finite there, the slope that of $P > P_d$.

**Source:** Kim, Mazzoleni and Bryant (2021), (31)-(35) and Table 1 [R14].
"""

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
    check_signed,
    check_size,
    is_concrete,
    to_si,
    warn_user,
)
from .bladder import Bladder
from .ends.ends_law import AbstractEnds, Rigid
from .tension.tension_law import AbstractTension, Pull


Rows = Float[AnyArray, "*#muscles row"]


class Tuning(Module):
    """Measured corrections of one muscle; all left out, the identity."""

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
        - `transition_rate`: $\\beta$ [-], instead of the muscle's own.
        - `dead_band`: pressure $P_d$ [Pa] that closes the gap between bladder and braid.

        **Raises:** `ValueError` where a table or a factor can't be.
        """
        self.pressures, self.c1, self.c2 = _table(pressures, c1, c2)
        self.youngs_modulus_factor = check_size(youngs_modulus_factor, "youngs_modulus_factor")
        self.collapse_moment_factor = check_size(collapse_moment_factor, "collapse_moment_factor")
        self.hinge_stiffness_factor = check_size(hinge_stiffness_factor, "hinge_stiffness_factor")
        self.hinge_stiffness_slope = check_finite(
            hinge_stiffness_slope, "hinge_stiffness_slope", "1/Pa"
        )
        self.transition_rate = (
            None if transition_rate is None else check_size(transition_rate, "transition_rate")
        )
        self.dead_band = check_interval(
            dead_band, 0.0, HIGHEST_PRESSURE, "dead_band", "Pa", closed=(True, False)
        )
        if is_concrete(self.hinge_stiffness_factor, self.hinge_stiffness_slope):
            highest = self.hinge_stiffness_at(HIGHEST_PRESSURE)
            if not np.all(np.asarray(highest) > 0):
                raise InvalidInputError(
                    "hinge_stiffness_slope",
                    f"must leave the factor positive up to {HIGHEST_PRESSURE / 1e6:g} MPa",
                    np.min(np.asarray(highest)),
                    shown=f"a factor of {np.min(np.asarray(highest)):g} there",
                )
            check_plausible(highest, "hinge_stiffness_factor")

    def effective_pressure(self, pressure: BatchLike) -> Batch:
        """$P_e$ [Pa] at gauge `pressure` [Pa], equation (D)."""
        P, P_d = pressure, self.dead_band
        # not `maximum`, which would halve the slope at P = 0 where there is no dead band
        return where(P_d <= P, P - P_d, 0.0 * P)

    def extrapolation_message(self, pressure: Values) -> str:
        """Warning of a `pressure` [Pa] above the table's last row, which holds from there on; empty
        below it.
        """
        if self.pressures.shape[-1] < 2 or not is_concrete(
            self.pressures, self.dead_band, pressure
        ):
            return ""
        last = np.max(np.asarray(self.pressures)) + np.max(np.asarray(self.dead_band))
        # a row's own pressure, written in other units, may come back a rounding higher
        if not np.size(pressure) or np.max(np.asarray(pressure)) <= last * (1 + 1e-9):
            return ""
        return (
            f"The tuning was measured up to {last / 1e3:.4g} kPa and is held constant above"
            f" it; the pressure is {np.max(np.asarray(pressure)) / 1e3:.4g} kPa."
        )

    def warn_extrapolation(self, pressure: Values) -> None:
        """Warn of a `pressure` [Pa] above the table's last row."""
        if message := self.extrapolation_message(pressure):
            warn_user(message)

    def c1_at(self, pressure: BatchLike) -> Batch:
        """$C_1$ [N] at effective `pressure` [Pa]."""
        return self._at(pressure, self.c1)

    def c2_at(self, pressure: BatchLike) -> Batch:
        """$C_2$ [-] at effective `pressure` [Pa]."""
        return self._at(pressure, self.c2)

    def _at(self, pressure: BatchLike, rows: Rows) -> Batch:
        """`rows` [any unit], joined by straight lines, at effective `pressure` [Pa]."""
        if rows.shape[-1] == 1:
            return rows[..., 0] + 0.0 * pressure  # nothing was measured
        P, start = add_table_axis(pressure), self.pressures[..., :-1]
        steps, rises = (x[..., 1:] - x[..., :-1] for x in (self.pressures, rows))
        # a sum of ramps is one pass over the points, a search for the row many; slopes at a
        # row are those to its right
        risen = where(start <= P, where(start + steps <= P, steps, P - start), 0.0)
        slopes = where(steps > 0, rises / where(steps > 0, steps, 1.0), 0.0)
        return rows[..., 0] + sum_table(slopes * risen)

    def hinge_stiffness_at(self, pressure: BatchLike) -> Batch:
        """Factor on the hinge's stiffness $k_r$ [-] at `pressure` [Pa]."""
        return self.hinge_stiffness_factor + self.hinge_stiffness_slope * pressure


class TunedTension(Module):
    """A muscle's tension law $T(P, \\varepsilon)$ as it is used: corrected by its tuning, at the
    strain of its ends.
    """

    law: AbstractTension
    bladder: Bladder
    tuning: Tuning
    ends: AbstractEnds = Rigid()

    def pull(self, pressure: BatchLike, strain: BatchLike) -> Pull:
        """Mesh and bladder force [N] at `pressure` [Pa] and `strain` [-], (E7)."""
        if self.ends.gives:
            return self.ends.pull(self, pressure, strain)
        return self.bladder_pull(pressure, strain)

    def bladder_pull(self, pressure: BatchLike, strain: BatchLike) -> Pull:
        """Mesh and bladder force [N] at a `strain` [-] of the bladder, (32) and (33)."""
        P_e = self.tuning.effective_pressure(pressure)
        c1, c2 = self.tuning.c1_at(P_e), self.tuning.c2_at(P_e)
        mesh, bladder, mesh_slope, bladder_slope = self.law.pull(self.bladder, P_e, strain)
        return Pull(c2 * mesh, c2 * (bladder - c1), c2 * mesh_slope, c2 * bladder_slope)

    def components(self, pressure: BatchLike, strain: BatchLike) -> tuple[Batch, Batch]:
        """The two components alone [N]."""
        pull = self.pull(pressure, strain)
        return pull.mesh, pull.bladder

    def force(self, pressure: BatchLike, strain: BatchLike) -> Batch:
        """$F_{mod}$ [N] at `pressure` [Pa] and `strain` [-], (31)."""
        return self.pull(pressure, strain).force

    def rest(self, pressure: BatchLike) -> tuple[Batch, Batch]:
        """Co-energy [J] that a braid that stretches takes up at rest length and `pressure` [Pa],
        beyond that of its volume; and its slope [m³].
        """
        gained, swollen = self.law.rest(self.bladder, self.tuning.effective_pressure(pressure))
        return gained / self.stretch, swollen / self.stretch

    def free_strain(self, pressure: BatchLike) -> Batch:
        """Strain $\\varepsilon_f$ [-] at which the force vanishes at `pressure` [Pa]."""
        P_e = self.tuning.effective_pressure(pressure)
        free = self.law.free_strain(self.bladder, P_e, self.tuning.c1_at)
        return free / self.stretch

    @property
    def stretch(self) -> Batch:
        """The bladder's strain over the ends' [-] where they hold no force."""
        return self.ends.stretch(self.bladder.braid.length) if self.ends.gives else 1.0


def _table(pressures: Values, c1: Values, c2: Values) -> tuple[Rows, Rows, Rows]:
    """The table with its row at zero pressure, checked where its values can be seen."""
    pressures, c1 = to_si(pressures, "pressures", "Pa"), to_si(c1, "c1", "N")
    xp = np if is_concrete(pressures, c1, c2) else array_namespace(pressures, c1, c2)
    P, rows1, rows2 = (xp.atleast_1d(xp.asarray(x, dtype=float)) for x in (pressures, c1, c2))
    if not P.shape == rows1.shape == rows2.shape or P.ndim != 1:
        raise InvalidInputError(
            "pressures",
            ", `c1` and `c2` must be lists of equal length",
            (P.size, rows1.size, rows2.size),
            shown=f"{P.size}, {rows1.size} and {rows2.size} entries",
        )
    seen = P.size and is_concrete(pressures)
    if seen and (check_finite(pressures, "pressures", "Pa").min() < 0 or np.any(np.diff(P) <= 0)):
        raise InvalidInputError(
            "pressures", "must rise from 0 Pa or above", P.tolist(), shown=f"{P.tolist()} Pa"
        )
    if P.size and is_concrete(c1, c2):
        check_signed(c1, "c1")
        check_size(c2, "c2")
        if seen and P[0] == 0 and (rows1[0] != 0 or rows2[0] != 1):
            raise InvalidInputError(
                "c1",
                "and `c2` must be 0 N and 1 at zero pressure",
                float(rows1[0]),
                shown=f"{rows1[0]:g} N and {rows2[0]:g}",
            )
    if seen and P[0] == 0:
        return P, rows1, rows2
    # harmless where a traced table begins at zero already: its own row holds there
    zero, one = xp.zeros(1), xp.ones(1)
    return (
        xp.concatenate([zero, P]),
        xp.concatenate([zero, rows1]),
        xp.concatenate([one, rows2]),
    )
