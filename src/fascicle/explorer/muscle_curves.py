"""Curves of a muscle at one pressure and strain, their marks, and alternative laws.

Pressures are a family of even ones and, last, the chosen one; strains are even ones with the
kinks among them, so that curves turn sharply where the law does.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ..core.errors import InvalidInputError
from ..core.validation import LARGEST_STRAIN
from ..muscle import Muscle, Tuning
from ..muscle.laws import LAWS
from ..plot.shapes import ARC_POINTS


POINTS, FAMILY = 201, 7  # along a curve, and curves at even pressures
PARTS = ("force", "mesh", "bladder", "bending")
REGIONS = ("in tension", "buckled", "collapsed", "compressed straight")
UNTUNED = "untuned"
MOST_COMPARED = 4  # more colors and dashes can't be told apart

_NEAR, _ASIDE = 6, 7  # pixels from a point to its label, above or below it and beside it
_LINE = 16  # pixels from a label to one above it
_BELOW = -22  # pixels to a label below its point
_LOW = 0.06  # of the forces drawn: closer to zero, labels of both ends stack
# share of the strains drawn beyond which a label stands left of its point, on a phone too
_LEFT = {"free": 0.74, "collapse": 0.62}


@dataclass(frozen=True)
class MuscleCurves:
    """Curves of a muscle, a row for each pressure of the family and last the chosen one's.

    `pressure` [Pa]; `strain` [-]; `force` and its components [N]; `free_strain`,
    `collapse_strain` [-], inf where it never collapses; `blocked` force [N]. Along the chosen
    pressure's curve its `regions`, and whether there are `branches`, other equilibria.

    At the chosen point: `force_here` [N], its `region`, whether there are `several` equilibria,
    `volume` of fluid [m³], `deflection` [m], `moment` [N·m], the centerline's `z`, `y` [m], the
    tube's `radius` [m] and the fibers' `angle` [rad].
    """

    pressure: np.ndarray
    strain: np.ndarray
    force: np.ndarray
    mesh: np.ndarray
    bladder: np.ndarray
    bending: np.ndarray
    free_strain: np.ndarray
    collapse_strain: np.ndarray
    blocked: np.ndarray
    regions: np.ndarray
    branches: np.ndarray
    force_here: float
    region: int
    several: bool
    volume: float
    deflection: float
    moment: float
    z: np.ndarray
    y: np.ndarray
    radius: float
    angle: float


def muscle_curves(
    muscle: Muscle, pressure: float, strain: float, supply: float, top: float
) -> MuscleCurves:
    """Curves of a muscle, and its state at a pressure and strain.

    **Arguments:**

    - `muscle`: the muscle.
    - `pressure`: gauge pressure [Pa].
    - `strain`: contraction [-].
    - `supply`: the family's highest pressure [Pa].
    - `top`: the largest strain of the curves [-].
    """
    pressures = np.r_[np.linspace(0.0, supply, FAMILY), pressure]
    with np.errstate(all="ignore"):  # of branches that aren't taken
        values = _evaluate(muscle, pressures, np.float64(strain), np.float64(top))
    arrays: dict[str, Any] = {name: np.asarray(value) for name, value in values.items()}
    plain = {name: x.item() if x.ndim == 0 else x for name, x in arrays.items()}
    return MuscleCurves(pressure=pressures, **plain)


def _evaluate(muscle: Muscle, pressures: Any, strain: Any, top: Any) -> dict[str, Any]:
    # one solution of the law for all that is shown: the public methods would solve it eight times
    state = muscle.law.at(pressures[:, None])
    free, collapse = state.column.free_strain, state.collapse
    kinks = np.clip(np.concatenate([free, collapse], axis=1), 0.0, top)
    even = np.broadcast_to(top * np.linspace(0.0, 1.0, POINTS), (FAMILY + 1, POINTS))
    grid = np.sort(np.concatenate([even, kinks], axis=1), axis=1)
    here = np.broadcast_to(strain, (FAMILY + 1, 1))
    response = state.response(np.concatenate([grid, np.zeros_like(here), here], axis=1))
    # the second is the last state whose arc the law knows
    line = state.shape(np.concatenate([here, np.minimum(here, collapse)], axis=1), ARC_POINTS)
    z, y = line.z[-1], line.y[-1]
    arc = np.sum(np.hypot(np.diff(z[1]), np.diff(y[1])))
    arc_strain = 1 - arc / muscle.length
    return {
        "strain": grid,
        **{name: getattr(response, name)[:, :-2] for name in PARTS},
        "free_strain": free[:, 0],
        "collapse_strain": collapse[:, 0],
        "blocked": response.force[:, -2],
        "regions": response.region[-1, :-2],
        "branches": response.several[-1, :-2],
        "force_here": response.force[-1, -1],
        "region": response.region[-1, -1],
        "several": response.several[-1, -1],
        "volume": muscle.braid.volume(strain) - muscle.bladder.volume,
        "deflection": state.deflection(here)[-1, 0],
        "moment": state.moment(here)[-1, 0],
        "z": z[0],
        "y": y[0],
        "radius": muscle.braid.radius_at(arc_strain),
        "angle": muscle.braid.angle_at(arc_strain),
    }  # fmt: skip


@lru_cache(maxsize=64)  # visitors share it
def strain_limit(muscle: Muscle, supply: float) -> float:
    """Largest strain [-] that is drawn, well past the free strain at `supply` [Pa]."""
    free = float(muscle_curves(muscle, supply, 0.0, supply, 0.3).free_strain[-1])
    return float(min(LARGEST_STRAIN, max(0.1, np.ceil(1.5 * free * 20) / 20)))


def region_strips(strain: np.ndarray, regions: np.ndarray) -> list[tuple[float, float, int]]:
    """Ends [-] and region of each stretch of a curve, in order.

    **Arguments:** `strain`: along the curve [-], rising; `regions`: there.
    """
    # a kink is among the strains, and belongs to the region that ends there
    last = np.flatnonzero(np.r_[np.diff(regions) != 0, True])
    edges = np.r_[strain[0], strain[last]]
    strips = zip(edges[:-1], edges[1:], regions[last], strict=True)
    return [(float(a), float(b), int(region)) for a, b, region in strips if b > a]


def curve_marks(curves: MuscleCurves, top: float, scale: float, unit: str) -> dict[str, list]:
    """Blocked force, free strain and collapse of the chosen curve, with labels that don't collide.

    **Arguments:**

    - `curves`: the curves.
    - `top`: the largest strain that is drawn [-].
    - `scale`: of the unit of force [N].
    - `unit`: its name.

    **Returns:** columns of a source: `x` [-], `y` [shown unit], `label`, how many pixels it stands
    `above` (below, if negative) and `beside`, and its `align`ment.
    """
    free, blocked = float(curves.free_strain[-1]), float(curves.blocked[-1])
    collapse = float(curves.collapse_strain[-1])
    stacked = abs(blocked) < _LOW * np.ptp(curves.force[:-1]) and free < 0.3 * top
    rows = [
        (0.0, blocked, f"blocked {blocked / scale:.4g} {unit}", _NEAR + _LINE * stacked, 1.0),
        (free, 0.0, f"free {free:.4f}", _NEAR, _LEFT["free"]),
    ]
    if collapse <= top:
        force = float(np.interp(collapse, curves.strain[-1], curves.force[-1]))
        rows.append((collapse, force, f"collapse {collapse:.4f}", _BELOW, _LEFT["collapse"]))
    left = [x > limit * top for x, *_, limit in rows]
    return {
        "x": [x for x, *_ in rows],
        "y": [force / scale for _, force, *_ in rows],
        "label": [label for _, _, label, *_ in rows],
        "above": [above for *_, above, _ in rows],
        "beside": [-_ASIDE if is_left else _ASIDE for is_left in left],
        "align": ["right" if is_left else "left" for is_left in left],
    }


def alternative_laws(muscle: Muscle) -> list[str]:
    """Laws that the muscle could have, such as `buckling:elastica`; `untuned` where it is tuned."""
    keys = [
        f"{kind}:{name}"
        for kind, known in LAWS.items()
        for name, law in known.items()
        if type(getattr(muscle, kind)) is not law
    ]
    return [*keys, UNTUNED] if is_tuned(muscle) else keys


def with_alternative(muscle: Muscle, key: str) -> Muscle:
    """The muscle with the law that a `key` of `alternative_laws` names."""
    if key == UNTUNED:
        return muscle.replace(tuning=Tuning())
    kind, _, name = key.partition(":")
    return muscle.replace(**{kind: name})


def is_tuned(muscle: Muscle) -> bool:
    """Whether the muscle has a tuning."""
    return muscle.tuning != Tuning()


def check_compared(keys: tuple[str, ...]) -> tuple[str, ...]:
    """Check `keys` of laws to compare and return them.

    **Raises:** `InvalidInputError` where they are too many, or one names no law.
    """
    if len(keys) > MOST_COMPARED:
        rule = f"must be {MOST_COMPARED} laws at most, as many as can be told apart"
        raise InvalidInputError("compare", rule, len(keys))
    for key in keys:
        kind, _, name = key.partition(":")
        if key != UNTUNED and name not in LAWS.get(kind, {}):
            raise InvalidInputError("compare", "must name laws such as buckling:elastica", key[:40])
    return keys
