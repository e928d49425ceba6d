"""Curve of a muscle at one pressure and strain, its marks, and alternative laws.

Among the strains are the law's kinks.
"""

from typing import NamedTuple

import numpy as np

from ..core.validation import LARGEST_STRAIN
from ..muscle import Muscle, Tuning
from ..muscle.laws import LAWS
from ..plot.shapes import ARC_POINTS


POINTS = 201  # along a curve
# of a force, which is the sum of the other three; and of the law, in the order of its numbers
PARTS = ("force", "mesh", "bladder", "bending")
REGIONS = ("in tension", "buckled", "collapsed", "compressed straight")
UNTUNED = "untuned"

_GAP_ABOVE, _GAP_BESIDE = 6, 6  # pixels from a point, or its leader line, to its label
# of the largest force drawn: labels stand above the curves, left of the legend
_HEIGHTS = {"free": 0.85, "collapse": 0.68}
_LEFT = (
    0.4  # share of the strains drawn beyond which a label stands left of its line, on a phone too
)


class MuscleCurves(NamedTuple):
    """Curve of a muscle at a pressure, and its state at a strain."""

    strain: np.ndarray  # [-]
    force: np.ndarray  # [N], the sum of the next three
    mesh: np.ndarray
    bladder: np.ndarray
    bending: np.ndarray
    regions: np.ndarray
    branches: np.ndarray  # True where there are other equilibria
    blocked: float  # [N]
    free_strain: float  # [-]
    collapse_strain: float  # [-], inf where it never collapses
    # at the strain
    point_force: float  # [N]
    region: int
    several: bool  # True where there are other equilibria
    volume: float  # of fluid [m³]
    deflection: float  # [m]
    moment: float  # [N·m]
    z: np.ndarray  # of the centerline [m]
    y: np.ndarray
    radius: float  # of the tube [m]
    angle: float  # of the fibers [rad]


def muscle_curves(muscle: Muscle, pressure: float, strain: float, top: float) -> MuscleCurves:
    """Curve of a muscle at a `pressure` [Pa] up to `top` [-], and its state at a `strain` [-]."""
    # one solution of the law for everything: a slider would wait for those of eight methods
    with np.errstate(all="ignore"):  # of branches that aren't taken
        state = muscle.law.at(np.float64(pressure))
        free, collapse = float(state.column.free_strain), float(state.collapse_strain)
        kinks = np.clip([free, collapse], 0.0, top)
        grid = np.sort(np.concatenate([np.linspace(0.0, top, POINTS), kinks]))
        response = state.response(np.append(grid, [0.0, strain]))
        # the second is the last state whose arc the law knows
        line = state.shape(np.array([strain, min(strain, collapse)]), ARC_POINTS)
        z, y = np.asarray(line.z), np.asarray(line.y)
        arc_strain = 1 - np.hypot(np.diff(z[1]), np.diff(y[1])).sum() / muscle.length
        return MuscleCurves(
            strain=grid,
            **{name: np.asarray(getattr(response, name))[:-2] for name in PARTS},
            regions=np.asarray(response.region)[:-2],
            branches=np.asarray(response.several)[:-2],
            blocked=float(response.force[-2]),
            free_strain=free,
            collapse_strain=collapse,
            point_force=float(response.force[-1]),
            region=int(response.region[-1]),
            several=bool(response.several[-1]),
            volume=float(muscle.braid.volume(np.float64(strain)) - muscle.bladder.volume),
            deflection=float(state.deflection(strain)),
            moment=float(state.moment(strain)),
            z=z[0],
            y=y[0],
            radius=float(muscle.braid.radius_at(arc_strain)),
            angle=float(muscle.braid.angle_at(arc_strain)),
        )


def strain_limit(muscle: Muscle, supply: float) -> float:
    """Largest strain [-] that is drawn, well past the free strain at `supply` [Pa]."""
    free = float(muscle.free_strain(supply))
    return float(min(LARGEST_STRAIN, max(0.1, np.ceil(1.5 * free * 20) / 20)))


def region_strips(strain: np.ndarray, regions: np.ndarray) -> list[tuple[float, float, int]]:
    """Ends [-] and region of each stretch of a curve, in order; `strain` rises."""
    # a kink is among the strains, and belongs to the region that ends there
    last = np.flatnonzero(np.r_[np.diff(regions) != 0, True])
    edges = np.r_[strain[0], strain[last]]
    strips = zip(edges[:-1], edges[1:], regions[last], strict=True)
    return [(float(a), float(b), int(region)) for a, b, region in strips if b > a]


def curve_marks(
    curves: MuscleCurves, top: float, high: float, scale: float, unit: str
) -> dict[str, list]:
    """Source of the blocked force, free strain and collapse, with labels at the height `place`;
    `high`: largest force [N] that is drawn.
    """
    blocked, collapse = curves.blocked, curves.collapse_strain
    kinks = {"free": (curves.free_strain, 0.0)}
    if collapse <= top:
        kinks["collapse"] = collapse, float(np.interp(collapse, curves.strain, curves.force))
    strains, forces = zip((0.0, blocked), *kinks.values(), strict=True)
    places = [blocked, *(_HEIGHTS[name] * high for name in kinks)]
    is_left = [strain > _LEFT * top for strain in strains]
    return {
        "x": list(strains),
        "y": [force / scale for force in forces],
        "place": [place / scale for place in places],
        "label": [
            f"blocked {blocked / scale:.4g} {unit}",
            *(f"{name} {strain:.4f}" for name, (strain, _) in kinks.items()),
        ],
        "above": [_GAP_ABOVE] + [-_GAP_ABOVE] * len(kinks),
        "beside": [-_GAP_BESIDE if left else _GAP_BESIDE for left in is_left],
        "align": ["right" if left else "left" for left in is_left],
    }


def alternative_laws(muscle: Muscle) -> list[str]:
    """Keys of the other laws, such as `buckling:elastica`, and `untuned` for a tuned muscle."""
    keys = [
        f"{kind}:{name}"
        for kind, laws in LAWS.items()
        for name, law in laws.items()
        if type(getattr(muscle, kind)) is not law
    ]
    return keys + [UNTUNED] * is_tuned(muscle)


def law_label(key: str) -> str:
    """Label of a `key` of `alternative_laws`, such as `buckling: elastica`."""
    return key.replace("_", " ").replace(":", ": ")


def with_alternative(muscle: Muscle, key: str) -> Muscle:
    """The muscle with the law that a `key` of `alternative_laws` names, or without its tuning."""
    kind, _, name = key.partition(":")
    return muscle.replace(tuning=Tuning()) if key == UNTUNED else muscle.replace(**{kind: name})


def is_tuned(muscle: Muscle) -> bool:
    """True for a muscle with a tuning."""
    return muscle.tuning != Tuning()
