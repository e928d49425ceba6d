"""The oracle, part 2: the two post-buckling laws, at one pressure and one strain."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from oracle_muscle import (
    RTOL,
    XTOL,
    Muscle,
    area,
    bladder,
    collapse_moment,
    free_strain,
    mesh,
    modulus,
    second_moment,
    tension,
)
from scipy.optimize import brentq, minimize_scalar
from scipy.special import ellipe, ellipk


@dataclass(frozen=True)
class Bent:
    """A state past the free strain: arc strain, moment [N m], deflection [m], forces [N]."""

    arc_strain: float
    moment: float
    deflection: float
    mesh: float
    bladder: float
    bending: float

    @property
    def force(self):
        return self.mesh + self.bladder + self.bending


# ---- kim2021: mode shape and equivalent springs, (8)-(16)


def slack(muscle, pressure, strain):
    """v = 1 - w: the share of x that goes into bending; 0 at the free strain."""
    e_f = free_strain(muscle, pressure)
    L_fs = muscle.length * (1 - e_f)
    x = (strain - e_f) * muscle.length
    xi = x / L_fs
    EI, EA = modulus(muscle) * second_moment(muscle), modulus(muscle) * area(muscle)
    F_b = 4 * EI * math.pi**2 * (L_fs + x) / (L_fs - x) ** 3  # (12)
    a = F_b / (EA * xi * (1 - xi))

    def residual(v):  # w (1 + a h) = a h, with w = 1 - v
        w = 1 - v
        h = math.sqrt(1 - w * xi / (2 - xi)) / (1 - w * xi)
        return w - v * a * h

    return brentq(residual, 0.0, 1.0, xtol=XTOL, rtol=RTOL)


def kim2021(muscle, pressure, strain):
    """State between free strain and collapse."""
    e_f = free_strain(muscle, pressure)
    L_fs = muscle.length * (1 - e_f)
    x = (strain - e_f) * muscle.length
    if x <= 0:
        held = bladder(muscle, pressure, e_f)
        return Bent(e_f, 0.0, 0.0, mesh(muscle, pressure, e_f), held, 0.0)
    v = slack(muscle, pressure, strain)
    w, xi = 1 - v, x / L_fs
    EI, EA = modulus(muscle) * second_moment(muscle), modulus(muscle) * area(muscle)
    F_b = EA * xi * w * (1 - xi) / (1 - xi * w)  # (16), F'_b
    y_max = math.sqrt(4 * x * v * (L_fs - x)) / math.pi  # (10) with the shortened arc [R5]
    moment = 2 * math.pi**2 * EI * y_max / (L_fs - x) ** 2
    arc = e_f + w * x / muscle.length
    # [R6] F'_b opposes contraction
    return Bent(
        arc, moment, y_max, mesh(muscle, pressure, arc), bladder(muscle, pressure, e_f), -F_b
    )


def kim2021_peak(muscle, pressure):
    """Strain and value of the largest moment, searched between free strain and 0.99."""
    e_f = free_strain(muscle, pressure)
    grid = np.linspace(e_f, 0.99, 101)
    values = [kim2021(muscle, pressure, e).moment for e in grid]
    i = int(np.argmax(values))
    best = minimize_scalar(
        lambda e: -kim2021(muscle, pressure, e).moment,
        bounds=(grid[max(i - 1, 0)], grid[min(i + 1, 100)]),
        method="bounded",
        options={"xatol": 1e-10},
    )
    return (grid[i], values[i]) if values[i] >= -best.fun else (best.x, -best.fun)


def kim2021_collapse_strain(muscle, pressure):
    """First root of M_b = M_collapse, bracketed by the peak [R7]; inf if never."""
    limit = collapse_moment(muscle, pressure)
    e_f = free_strain(muscle, pressure)
    if limit <= 0:
        return e_f
    peak, highest = kim2021_peak(muscle, pressure)
    if highest < limit:
        return math.inf

    def excess(e):
        return kim2021(muscle, pressure, e).moment - limit

    grid = np.linspace(e_f, peak, 65)
    after = next(i for i in range(1, 65) if i == 64 or excess(grid[i]) >= 0)
    return brentq(excess, grid[after - 1], grid[after], xtol=1e-16, rtol=RTOL)


# ---- elastica: one energy


def chord(m):
    """d/l = 2E/K - 1, with m = k^2."""
    return 2 * ellipe(m) / ellipk(m) - 1


def push(m):
    """B = N l^2/EI * d/l = 16 K^2 (2E/K - 1): 4 pi^2 at m = 0, 0 where the ends meet."""
    K = ellipk(m)
    return 16 * K * (2 * ellipe(m) - K)


M_MEET = brentq(lambda m: 2 * ellipe(m) - ellipk(m), 0.8, 0.85, xtol=1e-16, rtol=RTOL)
_TABLE_M = np.linspace(0, M_MEET, 4001)
_TABLE_B = push(_TABLE_M)


def modulus_of_push(B):
    """The m that gives each B in an array; good to 1e-14 or so, for brackets only."""
    m = np.interp(-np.asarray(B), -_TABLE_B, _TABLE_M)
    for _ in range(3):  # Newton with a centered slope; B is monotonic and nearly linear in m
        step = 1e-5
        low, high = np.clip(m - step, 0, 0.9), np.clip(m + step, 0, 0.9)
        m = np.clip(m - (push(m) - B) * (high - low) / (push(high) - push(low)), 0, M_MEET)
    return m


class Elastica:
    """Every state that is joined to the free strain, at one pressure.

    phi(e) = -T(P, e) L0 (1 - e) is what the arc pushes with, times its length. A bent
    state of arc strain e satisfies phi(e) = (EI/L_fs) B(m), one m for each e; its chord
    strain is 1 - (1 - e) d/l(m). So the bent branch that starts at the first onset,
    phi = 4 pi^2 EI/L_fs, is a curve over e alone, walked here from the onset's e (m = 0)
    down to the free strain (the ends meet). Its strain may turn back on the way (a fold).
    *Followed state at a strain past the onset: the first point of that walk that reaches
    the strain.* Where the branch leaves the onset backward, straight is kept to the onset,
    and the first point that comes back to the onset's strain follows it.
    """

    def __init__(self, muscle: Muscle, pressure: float):
        self.muscle, self.pressure = muscle, pressure
        self.free_strain = free_strain(muscle, pressure)
        self.stiffness = (
            modulus(muscle) * second_moment(muscle) / (muscle.length * (1 - self.free_strain))
        )
        self.onset = self._first_onset()
        if math.isfinite(self.onset):
            s = np.linspace(0, 1, 2001)
            self.arc = self.onset + (self.free_strain - self.onset) * s
            self.m = modulus_of_push(np.clip(self.phi(self.arc) / self.stiffness, 0, 4 * np.pi**2))
            self.m[0], self.m[-1] = 0.0, M_MEET
            self.chord_strain = 1 - (1 - self.arc) * chord(self.m)
            self.chord_strain[0] = self.onset
            self.reached = np.maximum.accumulate(self.chord_strain)

    def phi(self, e):
        return -tension(self.muscle, self.pressure, e) * self.muscle.length * (1 - e)

    def _first_onset(self):
        """First strain where phi reaches 4 pi^2 EI/L_fs; inf if it doesn't below 0.95."""
        limit = 4 * math.pi**2 * self.stiffness

        def excess(e):
            return self.phi(e) - limit

        grid = np.linspace(self.free_strain, 0.95, 4001)
        values = excess(grid)
        for i in range(1, 4001):
            low, high = grid[i - 1], grid[i]
            if values[i] >= 0:
                return brentq(excess, low, high, xtol=1e-16, rtol=RTOL)
            if i < 4000 and values[i - 1] < values[i] > values[i + 1]:
                # a top between grid points may still touch the limit
                top = minimize_scalar(
                    lambda e: -excess(e), bounds=(low, grid[i + 1]), method="bounded"
                )
                if top.fun <= 0:
                    return brentq(excess, low, top.x, xtol=1e-16, rtol=RTOL)
        return math.inf

    def chord_strain_at(self, e):
        """Chord strain of the bent state of arc strain e, to full accuracy."""
        B = min(max(self.phi(e) / self.stiffness, 0.0), 4 * math.pi**2)
        m = brentq(lambda m: push(m) - B, 0.0, M_MEET * (1 + 1e-12), xtol=1e-17, rtol=RTOL)
        return 1 - (1 - e) * chord(m), m

    def state(self, strain):
        """Followed state at a strain from the free strain on; straight up to the onset."""
        if strain <= self.onset:
            return self._straight(strain)
        i = int(np.argmax(self.chord_strain >= strain))
        assert i > 0, "the walk ends at a strain of 1, so something reaches this one"

        def residual(m):  # at this chord, the arc that m implies must push with B(m)
            return self.phi(1 - (1 - strain) / chord(m)) - self.stiffness * push(m)

        low, high = sorted((self.m[max(i - 1, 0)], self.m[i]))
        margin = 1e-12
        low, high = max(low - margin, 0.0), min(high + margin, M_MEET * (1 - 1e-9))
        if residual(low) > 0 >= residual(high):
            m = brentq(residual, low, high, xtol=1e-17, rtol=RTOL)
        else:  # m turns within the step: walk in e instead
            e = brentq(
                lambda e: self.chord_strain_at(e)[0] - strain,
                self.arc[i],
                self.arc[i - 1],
                xtol=1e-17,
                rtol=RTOL,
            )
            m = self.chord_strain_at(e)[1]
        return self._bent(strain, m)

    def _straight(self, e):
        P, muscle = self.pressure, self.muscle
        return Bent(e, 0.0, 0.0, mesh(muscle, P, e), bladder(muscle, P, e), 0.0)

    def _bent(self, strain, m):
        P, muscle = self.pressure, self.muscle
        K = ellipk(m)
        e = 1 - (1 - strain) / chord(m)
        length = muscle.length * (1 - e)
        N = 16 * K**2 * self.stiffness / length
        pull, hold = mesh(muscle, P, e), bladder(muscle, P, e)
        k = math.sqrt(m)
        # the force is -N; bending is what mesh and bladder leave of it
        return Bent(e, 8 * k * K * self.stiffness, length * k / K, pull, hold, -N - pull - hold)

    def collapse(self):
        """Collapse strain and the state there (the one before a jump that goes over it)."""
        limit = collapse_moment(self.muscle, self.pressure)
        if not math.isfinite(self.onset):
            return math.inf, None

        def excess(m):
            return 8 * math.sqrt(m) * ellipk(m) * self.stiffness - limit

        if excess(M_MEET) < 0:
            return math.inf, None
        m_c = brentq(excess, 0.0, M_MEET, xtol=1e-17, rtol=RTOL) if limit > 0 else 0.0
        if m_c == 0:
            return self.onset, self._straight(self.onset)
        i = int(np.argmax(self.m >= m_c))
        e = brentq(
            lambda e: self.phi(e) - self.stiffness * push(m_c),
            self.arc[i],
            self.arc[i - 1],
            xtol=1e-17,
            rtol=RTOL,
        )
        strain = 1 - (1 - e) * chord(m_c)
        before = self.reached[i - 1]
        if strain >= before:
            return strain, self._bent(strain, m_c)
        if before == self.chord_strain[0]:  # jumped over at the onset: keep the straight side
            return self.onset, self._straight(self.onset)
        j = int(np.argmax(self.chord_strain >= before))  # jumped over at a later fold
        top = minimize_scalar(
            lambda e: -self.chord_strain_at(e)[0],
            bounds=(self.arc[j + 1], self.arc[j - 1]),
            method="bounded",
            options={"xatol": 1e-14},
        )
        return -top.fun, self._bent(-top.fun, self.chord_strain_at(top.x)[1])

    def count(self, strain):
        """How many equilibria there are at a strain: straight and sustained, or bent."""
        m = M_MEET * np.linspace(0, 1, 4002)[1:-1] ** 2
        arc = np.maximum(1 - (1 - strain) / chord(m), self.free_strain)
        residual = self.phi(arc) - self.stiffness * push(m)
        bends = int(np.sum(residual[:-1] * residual[1:] < 0))
        return bends + int(self.phi(strain) < 4 * math.pi**2 * self.stiffness)


@lru_cache(maxsize=4096)
def elastica(muscle, pressure):
    return Elastica(muscle, pressure)
