"""The force taken apart, as in the paper's Fig. 6: mesh, bladder with bending, and their sum.

Beside them, dashed, the tension law continued past the free strain: what a model without
buckling would give.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..muscle import Muscle
from ..muscle.tuning import TunedTension
from .style import BLACK, BLUE, GRAY, VERMILION, force_strain_axes


@dataclass(frozen=True)
class Components:
    """Forces [N] over `pressure` [Pa] (rows) and `strain` [-] (columns): the law's `mesh`,
    `wall` (bladder and bending) and `force`; `straight_mesh` and `straight_bladder` of the
    tension law alone; `free_strain` and `collapse_strain` [-] by pressure.
    """

    pressure: np.ndarray
    strain: np.ndarray
    mesh: np.ndarray
    wall: np.ndarray
    force: np.ndarray
    straight_mesh: np.ndarray
    straight_bladder: np.ndarray
    free_strain: np.ndarray
    collapse_strain: np.ndarray

    @property
    def straight_force(self) -> np.ndarray:
        """The tension law's force [N], continued past the free strain."""
        return self.straight_mesh + self.straight_bladder

    def at(self, rows: Sequence[int]) -> "Components":
        """The same at some of its pressures, by their `rows`."""
        chosen = {
            field.name: getattr(self, field.name)
            if field.name == "strain"
            else getattr(self, field.name)[list(rows)]
            for field in fields(self)
        }
        return Components(**chosen)


def components_of(muscle: Muscle, pressures: Any, strains: Any) -> Components:
    """Force and parts [N] of `muscle` at all `pressures` [Pa] and `strains` [-].

    Free and collapse strains join the strains, so that kinks are drawn sharp.
    """
    P, eps = np.asarray(pressures, float), np.asarray(strains, float)
    free, collapse = (np.asarray(x(P)) for x in (muscle.free_strain, muscle.collapse_strain))
    # a fixed number of points, whichever kinks lie inside
    kinks = np.clip(np.nan_to_num(np.r_[free, collapse], posinf=eps.max()), eps.min(), eps.max())
    eps = np.sort(np.r_[eps, kinks])
    response = muscle.response(P[:, None], eps)
    tension = TunedTension(muscle.tension, muscle.bladder, muscle.tuning, muscle.ends)
    mesh, bladder = (
        np.broadcast_to(np.asarray(x), (P.size, eps.size))
        for x in tension.components(P[:, None], eps)
    )
    wall = np.asarray(response.bladder) + np.asarray(response.bending)
    return Components(
        P, eps, np.asarray(response.mesh), wall, np.asarray(response.force), mesh, bladder,
        free, collapse,
    )  # fmt: skip


def draw_components(ax: Axes, parts: Components, row: int) -> None:
    """The curves at one pressure, a `row` of `parts`."""
    eps = parts.strain
    past = eps >= parts.free_strain[row]
    force_strain_axes(ax)
    dashed = {"linestyle": (0, (4, 2)), "linewidth": 1.0}
    for force, color, label in (
        (parts.straight_mesh, BLUE, r"$F_{mesh}$, straight"),
        (parts.straight_bladder, VERMILION, r"$F_{bladder}$, straight"),
        (parts.straight_force, GRAY, r"$F_{mesh} + F_{bladder}$, straight"),
    ):
        ax.plot(eps[past], force[row][past], color=color, label=label, **dashed)
    wall = r"$F_{bladder}$ with bending $F'_b$"
    ax.plot(eps, parts.mesh[row], color=BLUE, label=r"$F'_{mesh}$, along the bent arc")
    ax.plot(eps, parts.wall[row], color=VERMILION, label=wall)
    ax.plot(eps, parts.force[row], color=BLACK, linewidth=1.8, label=r"$F_{total}$")
    ax.set_xlim(eps[0], eps[-1])


def components_legend(figure: Figure, ax: Axes) -> None:
    """One legend for all panels, below them, from the curves of `ax`."""
    handles, labels = ax.get_legend_handles_labels()
    figure.legend(handles[::-1], labels[::-1], loc="outside lower center", ncols=3)
