"""Picture of a muscle that was sized to a tendon."""

import numpy as np
from matplotlib.figure import Figure

from ..plot.theme import BLUE, DOUBLE, GRAY, VERMILION, letters, new_figure, styled
from .sizing import Sizing


@styled
def plot_sizing(sizing: Sizing) -> Figure:
    """Plot a `sizing`: the tendon's length with the muscle's contraction, the moment arm, and the
    torques, over the coordinate of the torque's joint.
    """
    route, chosen = sizing.route, sizing.chosen
    order = np.argsort(route.coordinate, kind="stable")
    x = (np.rad2deg(route.coordinate) if route.hinge else 1e3 * route.coordinate)[order]
    line = {} if len(route.joints) == 1 else {"marker": ".", "linestyle": "none", "markersize": 3}
    figure, axes = new_figure(1, 3, width=DOUBLE, height=0.32 * DOUBLE)
    left, middle, right = axes[0]
    left.plot(x, 1e3 * route.lengths[order], color=BLUE, **line)
    left.axhline(1e3 * chosen.rest_length, color=GRAY, linestyle=":", linewidth=1)
    left.set_ylabel("Length of the tendon [mm]")
    rest_length, length = 1e3 * chosen.rest_length, 10 * chosen.length  # mm, and mm for 1 %
    functions = (lambda y: (rest_length - y) / length, lambda e: rest_length - e * length)
    left.secondary_yaxis("right", functions=functions).set_ylabel("Contraction [%]")
    middle.plot(x, 1e3 * route.moment_arms[order], color=BLUE, **line)
    middle.axhline(0, color=GRAY, linewidth=0.6)
    middle.set_ylabel("Moment arm [mm]" if route.hinge else "Transmission [mm/m]")
    unit = "N·m" if route.hinge else "N"
    loaded = sizing.torque != 0
    right.plot(x, sizing.available_torque[order], color=BLUE, label="available", **line)
    points = x[loaded[order]], sizing.torque[order][loaded[order]]
    right.plot(*points, color=VERMILION, label="asked for", **line)
    right.set_ylabel(f"{'Torque' if route.hinge else 'Force'} [{unit}]")
    right.legend()
    for ax in axes[0]:
        ax.set_xlabel(f"{route.torque_joint} [{'deg' if route.hinge else 'mm'}]")
    title = f"{chosen.count} × {chosen.name}, {1e3 * chosen.length:.0f} mm"
    figure.suptitle(f"{sizing.tendon}: {title}", fontsize="medium")
    letters(axes[0], ("", "", ""))
    return figure
