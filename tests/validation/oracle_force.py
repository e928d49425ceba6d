"""The oracle, part 3: collapse, what follows it, and the piecewise law (27)."""

import math
from dataclasses import dataclass
from functools import lru_cache

from oracle_buckling import Bent, elastica, kim2021, kim2021_collapse_strain
from oracle_muscle import bladder, free_strain, mesh, modulus, rate, second_moment


TENSION, POST_BUCKLING, POST_COLLAPSE, STRAIGHT = 0, 1, 2, 3


@dataclass(frozen=True)
class Response:
    """Forces [N] and region at one pressure and strain."""

    force: float
    mesh: float
    bladder: float
    bending: float
    region: int


def hinge_moment(muscle, pressure):
    """k_r 2 theta_r = E I_r/t0 = pi E r0 t0^2/4 [R11], with k_r's factor, affine in P."""
    r0, t0 = muscle.outer_radius, muscle.wall_thickness
    tuning = muscle.tuning
    factor = tuning.hinge_stiffness_factor + tuning.hinge_stiffness_slope * pressure
    return factor * math.pi * modulus(muscle) * r0 * t0**2 / 4


def collapsed_force(muscle, pressure, strain):
    """F_c: one of [R10]'s three readings, and the hinge's force."""
    e_f = free_strain(muscle, pressure)
    L_fs = muscle.length * (1 - e_f)
    x = (strain - e_f) * muscle.length
    EI = modulus(muscle) * second_moment(muscle)
    arms = {
        "derived": EI * math.pi**2 * (L_fs + x) / (4 * (L_fs - x) ** 3),
        "consistent": EI * math.pi**2 * (L_fs + x) / (L_fs - x) ** 3,
        "printed": EI * math.pi**2 * L_fs / (4 * (L_fs - x) ** 2),
    }[muscle.post_collapse]
    return arms + hinge_moment(muscle, pressure) / math.sqrt(x * (L_fs - x))


@lru_cache(maxsize=4096)
def collapse(muscle, pressure) -> tuple[float, Bent | None]:
    """Collapse strain (inf: never) and the state there."""
    if muscle.buckling == "elastica":
        return elastica(muscle, pressure).collapse()
    e_c = kim2021_collapse_strain(muscle, pressure)
    return e_c, (kim2021(muscle, pressure, e_c) if math.isfinite(e_c) else None)


def collapse_strain(muscle, pressure):
    return collapse(muscle, pressure)[0]


def bent(muscle, pressure, strain):
    """State past the free strain as if nothing collapsed."""
    if muscle.buckling == "elastica":
        return elastica(muscle, pressure).state(strain)
    return kim2021(muscle, pressure, strain)


def response(muscle, pressure, strain):
    """(27)."""
    if strain <= free_strain(muscle, pressure):
        pull, hold = mesh(muscle, pressure, strain), bladder(muscle, pressure, strain)
        return Response(pull + hold, pull, hold, 0.0, TENSION)
    e_c, at = collapse(muscle, pressure)
    if strain <= e_c or at is None:
        state = bent(muscle, pressure, strain)
        straight = muscle.buckling == "elastica" and strain <= elastica(muscle, pressure).onset
        region = STRAIGHT if straight else POST_BUCKLING
        return Response(state.force, state.mesh, state.bladder, state.bending, region)
    F_c = collapsed_force(muscle, pressure, strain)
    decay = math.exp(-rate(muscle) * (strain - e_c))
    force = -F_c + (at.force + F_c) * decay  # (26) [R12]
    pull, hold = at.mesh * decay, at.bladder * decay
    return Response(force, pull, hold, force - pull - hold, POST_COLLAPSE)


def force(muscle, pressure, strain):
    return response(muscle, pressure, strain).force
