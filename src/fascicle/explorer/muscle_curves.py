"""All that the muscle's tab shows at one pressure and strain.

Pressures are a family of even ones and, last, the chosen one; strains are even ones with the
kinks among them, so that curves turn sharply where the law does.
"""

from dataclasses import dataclass
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


@dataclass(frozen=True)
class Picture:
    """A muscle at a pressure and strain, with a row for each pressure of the family and last
    the chosen one's: `pressure` [Pa]; `strain` [-]; `force` and its components [N];
    `free_strain`, `collapse_strain` [-], inf where it never collapses; `blocked` [N]. Along the
    chosen one's curve its `regions` [-], and where there are `branches`, other equilibria.

    At the chosen point: `force_here` [N], its `region` [-], whether there are `several`
    equilibria, `volume` of fluid [m³], `deflection` [m], `moment` [N·m], the centerline's `z`,
    `y` [m], the tube's `radius` [m] and the fibers' `angle` [rad].
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


def picture(muscle: Muscle, pressure: float, strain: float, supply: float, top: float) -> Picture:
    """The muscle at a pressure and strain, and its curves.

    **Arguments:**

    - `muscle`: the muscle [-].
    - `pressure`: gauge pressure [Pa].
    - `strain`: contraction [-].
    - `supply`: the family's highest pressure [Pa].
    - `top`: the largest strain of the curves [-].

    **Returns:** the picture: forces [N] over strains [-], and what is drawn.
    """
    pressures = np.r_[np.linspace(0.0, supply, FAMILY), pressure]
    with np.errstate(all="ignore"):  # of branches that aren't taken
        found = _picture(muscle, pressures, np.float64(strain), np.float64(top))
    values: dict[str, Any] = {name: np.asarray(value) for name, value in found.items()}
    for name, value in values.items():
        if value.ndim == 0:
            values[name] = value.item()
    return Picture(pressure=pressures, **values)


def strips(strain: np.ndarray, regions: np.ndarray) -> list[tuple[float, float, int]]:
    """Where a curve runs through which region.

    **Arguments:**

    - `strain`: along the curve [-], rising.
    - `regions`: there [-].

    **Returns:** the ends [-] and the region [-] of each stretch, in order.
    """
    # a kink is among the strains, and belongs to the region that ends there
    last = np.flatnonzero(np.r_[np.diff(regions) != 0, True])
    edges = np.r_[strain[0], strain[last]]
    found = zip(edges[:-1], edges[1:], regions[last], strict=True)
    return [(float(a), float(b), int(region)) for a, b, region in found if b > a]


def widest(muscle: Muscle, supply: float) -> float:
    """Largest strain [-] that is drawn, well past the free strain at `supply` [Pa]."""
    free = float(picture(muscle, supply, 0.0, supply, 0.3).free_strain[-1])
    return float(min(LARGEST_STRAIN, max(0.1, np.ceil(1.5 * free * 20) / 20)))


def _picture(muscle: Muscle, pressures: Any, strain: Any, top: Any) -> dict[str, Any]:
    # one solution of the law for all that is shown: the public methods would solve it eight times
    at = muscle.law.at(pressures[:, None])
    free, collapse = at.column.free_strain, at.collapse
    kinks = np.clip(np.concatenate([free, collapse], axis=1), 0.0, top)
    even = np.broadcast_to(top * np.linspace(0.0, 1.0, POINTS), (FAMILY + 1, POINTS))
    grid = np.sort(np.concatenate([even, kinks], axis=1), axis=1)
    here = np.broadcast_to(strain, (FAMILY + 1, 1))
    response = at.response(np.concatenate([grid, np.zeros_like(here), here], axis=1))
    # the second is the last state whose arc the law knows
    line = at.shape(np.concatenate([here, np.minimum(here, collapse)], axis=1), ARC_POINTS)
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
        "deflection": at.deflection(here)[-1, 0],
        "moment": at.moment(here)[-1, 0],
        "z": z[0],
        "y": y[0],
        "radius": muscle.braid.radius_at(arc_strain),
        "angle": muscle.braid.angle_at(arc_strain),
    }  # fmt: skip


_NEAR, _ASIDE = 6, 7  # pixels from a point to its name, above or below it and beside it
_LINE = 16  # pixels from a name to one above it
_BELOW = -22  # pixels: a name below its point
_LOW = 0.06  # of the forces drawn: closer to zero the names of both ends are one above the other
_LONG = {"free": 0.74, "collapse": 0.62}  # of the strains drawn: further right a name stands left
# of its point; on a phone's 300 pixels, too
Marks = dict[str, list[float] | list[str]]


def marks(found: Picture, top: float, scale: float, unit: str) -> Marks:
    """Points of the chosen pressure's curve and their names.

    **Arguments:**

    - `found`: the curves [-].
    - `top`: the largest strain that is drawn [-].
    - `scale`: of the unit of force [N].
    - `unit`: its name [-].

    **Returns:** columns of a figure's source [-]: `x` [-], `y` [shown unit], `label`, how many
    pixels it stands `below` (above, if positive) and `beside`, and its `align`ment.
    """
    free, blocked = float(found.free_strain[-1]), float(found.blocked[-1])
    collapse = float(found.collapse_strain[-1])
    low = abs(blocked) < _LOW * np.ptp(found.force[:-1]) and free < 0.3 * top
    rows = [
        (0.0, blocked, f"blocked {blocked / scale:.4g} {unit}", _NEAR + _LINE * low, 1.0),
        (free, 0.0, f"free {free:.4f}", _NEAR, _LONG["free"]),
    ]
    if collapse <= top:
        force = float(np.interp(collapse, found.strain[-1], found.force[-1]))
        rows.append((collapse, force, f"collapse {collapse:.4f}", _BELOW, _LONG["collapse"]))
    left = [x > most * top for x, *_, most in rows]
    return {
        "x": [x for x, *_ in rows],
        "y": [force / scale for _, force, *_ in rows],
        "label": [label for _, _, label, *_ in rows],
        "below": [below for *_, below, _ in rows],
        "beside": [-_ASIDE if one else _ASIDE for one in left],
        "align": ["right" if one else "left" for one in left],
    }


UNTUNED = "untuned"
MOST_COMPARED = 4  # at once: as many more colors and dashes as can be told apart


def alternatives(muscle: Muscle) -> list[str]:
    """What else its laws could be [-], as `buckling:elastica`; and `untuned` where it is tuned."""
    out = [
        f"{kind}:{name}"
        for kind, known in LAWS.items()
        for name, law in known.items()
        if type(getattr(muscle, kind)) is not law
    ]
    return [*out, UNTUNED] if is_tuned(muscle) else out


def alternative(muscle: Muscle, key: str) -> Muscle:
    """The muscle [-] with the law that a `key` of `alternatives` [-] names."""
    if key == UNTUNED:
        return muscle.replace(tuning=Tuning())
    kind, _, name = key.partition(":")
    return muscle.replace(**{kind: name})


def is_tuned(muscle: Muscle) -> bool:
    """Whether anything of its tuning differs from none [-]."""
    return muscle.tuning != Tuning()


def check_compared(keys: tuple[str, ...]) -> tuple[str, ...]:
    """The `keys` [-] again; `ValueError` where one names no law."""
    if len(keys) > MOST_COMPARED:
        raise InvalidInputError(
            "compare",
            f"must be {MOST_COMPARED} laws at most, as many as can be told apart",
            len(keys),
        )
    for key in keys:
        kind, _, name = key.partition(":")
        if key != UNTUNED and name not in LAWS.get(kind, {}):
            raise InvalidInputError("compare", "must name laws such as buckling:elastica", key[:40])
    return keys
