"""Fig. 2: a muscle from its free length to past its collapse, drawn from its laws."""

import numpy as np

from fascicle.plot.shapes import draw_states
from fascicle.plot.theme import in_kilopascals
from fascicle.results.labelled import Variable

from ..claims import Claim
from ..figures import PaperFigure
from . import setting
from .progression import JUST, PRESSURE, Progression, progression
from .setting import claim


STATES = ("free length", "free strain", "post-buckling", "post-collapse")


def compute() -> PaperFigure:
    """The four states of Fig. 6's muscle, with their shapes."""
    p = progression()
    titles = [
        f"{name}: {in_kilopascals(P)}, ε = {eps:.3f}"
        for name, P, eps in zip(STATES, p.pressure, p.strain, strict=True)
    ]
    return PaperFigure(
        key="figure_02",
        title="Fig. 2. From free length to past collapse",
        conditions=(
            f"Fig. 6's muscle: {setting.sizes(p.muscle)}.",
            f"At {in_kilopascals(PRESSURE)} the free strain is {p.free_strain:.4f} and the "
            f"collapse strain {p.collapse_strain:.4f}; (c) is 90 % of the way between them, (d) at "
            "the free strain at 413.7 kPa, the end of the tested range.",
            "Drawn to scale: centerline from the shape laws, radius and angle of the fibers from "
            "the arc's length. The crease's width and the number of fibers are the drawing's.",
        ),
        data=_data(p),
        draw=lambda: draw_states(float(p.muscle.length), p.outlines, titles),
        claims=claims(p),
        missing="The paper shows photographs.",
    )


def _data(p: Progression) -> dict[str, Variable]:
    state, line = ("state",), ("state", "point")
    points = np.linspace(0.0, 1.0, 201)
    z = [np.interp(points * o.along[-1], o.along, o.z) for o in p.outlines]
    y = [np.interp(points * o.along[-1], o.along, o.y) for o in p.outlines]
    return {
        "state": Variable(state, np.arange(1, 5), "-", ", ".join(STATES)),
        "point": Variable(("point",), points, "-", "share of the arc"),
        "pressure": Variable(state, p.pressure, "Pa", "gauge pressure"),
        "strain": Variable(state, p.strain, "-", "contraction"),
        "moment": Variable(state, p.moment, "N*m", "largest bending moment"),
        "radius": Variable(state, [o.radius for o in p.outlines], "m", "outer radius", "(2)"),
        "braid_angle": Variable(state, [o.angle for o in p.outlines], "rad", "from the axis"),
        "z": Variable(line, z, "m", "centerline, along", "(8), (22)"),
        "y": Variable(line, y, "m", "centerline, across", "(8), (22)"),
    }


def claims(p: Progression) -> tuple[Claim, ...]:
    """Claims on these states,."""
    free, bent, hinged = (abs(float(outline.y.min())) for outline in p.outlines[1:])
    soon = p.first_deflection * 1e3
    off = abs(p.moment_at_collapse / p.collapse_moment - 1)
    return (
        claim(
            "bows_out_at_once",
            (free * 1e3, soon),
            f"The deflection is {free * 1e3:.2f} mm at the free strain, {soon:.2f} mm "
            f"{JUST:g} past it, {bent * 1e3:.1f} mm at ε = {p.strain[2]:.3f} and "
            f"{hinged * 1e3:.1f} mm at ε = {p.strain[3]:.3f}.",
        ),
        claim(
            "collapse_at_the_collapse_moment",
            (off, float(p.moment[2]) / p.collapse_moment),
            f"At ε = {p.collapse_strain:.4f} the moment is {p.moment_at_collapse:.5f} N·m, "
            f"the collapse moment {p.collapse_moment:.5f} N·m; before it is "
            f"{p.moment[2]:.5f} N·m.",
        ),
    )
