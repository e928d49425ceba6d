"""A strip to print that measures a braid angle: threads of known angles, at true scale."""

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from .theme import BLACK, GRAY, new_figure, styled


_ANGLES = np.arange(16.0, 56.0, 2.0)  # deg, of muscles that contract
_HEIGHT, _WIDTH = 10.0, 26.0  # mm, of a field
_COLUMNS, _MARGIN, _HEAD = 6, 8.0, 22.0  # fields in a row; mm


@styled
def protractor() -> Figure:
    """Figure of fields with threads at angles from the tube's axis, which is horizontal.

    Print it at 100 %, cut a row, and hold it along the tube: the field whose threads run on in the
    braid's has its angle.
    """
    rows = -(-len(_ANGLES) // _COLUMNS)
    width = _COLUMNS * _WIDTH + 2 * _MARGIN
    height = rows * (_HEIGHT + 6.0) + _HEAD + _MARGIN
    figure, axes = new_figure(1, 1, width / 25.4, height / 25.4)
    figure.set_layout_engine("none")
    ax = axes[0, 0]
    ax.set_position((0, 0, 1, 1))
    ax.set(xlim=(0, width), ylim=(height, 0), aspect="equal")
    ax.axis("off")
    text = "Braid angle: hold a row along the tube; print at 100 %, the bar is 100 mm long"
    ax.text(_MARGIN, 6, text)
    ax.plot([_MARGIN, _MARGIN + 100], [11, 11], color=BLACK, linewidth=1.0, solid_capstyle="butt")
    for index, degrees in enumerate(_ANGLES):
        row, column = divmod(index, _COLUMNS)
        x, y = _MARGIN + column * _WIDTH, _HEAD + row * (_HEIGHT + 6.0)
        ax.text(x, y - 1, f"{degrees:g}°")
        run = _HEIGHT / np.tan(np.radians(degrees))
        starts = np.arange(x - 2 * run, x + _WIDTH, 2.5)
        both = [[(s, y + _HEIGHT), (s + run, y)] for s in starts]
        both += [[(s, y), (s + run, y + _HEIGHT)] for s in starts]
        threads = LineCollection(both, colors=BLACK, linewidths=0.35)
        frame = Rectangle((x, y), _WIDTH - 3, _HEIGHT, fill=False, edgecolor=GRAY, linewidth=0.4)
        ax.add_patch(frame)
        ax.add_collection(threads, autolim=False)
        threads.set_clip_path(frame)
    return figure
