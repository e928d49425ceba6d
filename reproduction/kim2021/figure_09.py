"""Fig. 9: the force-strain space of two motor units, without and with resistance."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fascicle.bundle.recruitment import Overlap, Workspace, overlap, workspace
from fascicle.plot.theme import DOUBLE, WHITE, letters, new_figure, styled
from fascicle.plot.workspace import draw_workspace
from fascicle.results.labelled import Variable

from ..claims import Claim
from ..figures import PaperFigure
from . import setting
from .setting import claim


LEVELS = np.array([0.0, 68.9, 137.9, 206.8, 275.8, 344.7, 413.7]) * 1e3  # Pa, every 10 psi
NAMED = 275.8e3  # Pa, whose free strain section 4.1 gives
_LABELED = 2  # the state whose curves are labeled with their pressures
NEAR = (0.18, 0.26), (0.0, 110.0)  # strain and force of (c) and (d)


@setting.cached
def workspace_of(resistance: bool) -> tuple[Workspace, Overlap]:
    """The space and its overlap, computed once."""
    pair = setting.bundle(setting.muscle("figure_9"), (1, 1), setting.HIGHEST)
    it = workspace(pair, levels=LEVELS, resistance=resistance)
    return it, overlap(it)


def compute() -> PaperFigure:
    """The space of 1 + 1 of Fig. 9's muscles."""
    without, with_it = workspace_of(False), workspace_of(True)
    muscle = setting.muscle("figure_9")
    return PaperFigure(
        key="figure_09",
        title="Fig. 9. Force–strain space of two motor units",
        conditions=(
            f"Two motor units of one muscle each: {setting.sizes(muscle)}. Orderly recruitment, "
            f"supply {setting.HIGHEST / 1e3:g} kPa.",
            "Curves at "
            + ", ".join(f"{p / 1e3:g}" for p in LEVELS)
            + " kPa, thicker for higher pressure: of unit 1 in state 1, of unit 2 in state 2 "
            "(numbers in (c), (d)), where unit 1 stays at the supply's.",
            "Yellow: points that both states reach, over all pressures of each.",
        ),
        data=_data(without, with_it),
        draw=lambda: workspaces(
            {"resistance neglected": without, "resistance included": with_it}, NEAR
        ),
        claims=claims(without, with_it, float(muscle.free_strain(NAMED))),
    )


@styled
def workspaces(
    spaces: Mapping[str, tuple[Workspace, Overlap | None]],
    near: tuple[tuple[float, float], tuple[float, float]],
) -> Figure:
    """Figure of workspaces side by side, and below each its region near the largest strain.

    **Arguments:**

    - `spaces`: workspaces and overlaps by title, at most three.
    - `near`: limits of strain [-] and force [N] of the lower row.
    """
    figure, axes = new_figure(2, len(spaces), DOUBLE, 0.8 * DOUBLE)
    for row in axes:
        for ax, (drawn, shared) in zip(row, spaces.values(), strict=True):
            draw_workspace(ax, drawn, shared)
    letters(axes, [*spaces, *(f"{title}, near the largest strain" for title in spaces)])
    for ax, (drawn, _) in zip(axes[1], spaces.values(), strict=True):
        ax.set(xlim=near[0], ylim=near[1])
        _label_pressures(ax, drawn, _LABELED)
    for ax in axes[:, 1:].flat:
        ax.set_ylabel("")
    # the overlap last, behind the states
    entries = sorted(
        zip(*axes[0, -1].get_legend_handles_labels(), strict=True),
        key=lambda entry: entry[1].startswith("overlap"),
    )
    figure.legend(*zip(*entries, strict=True), loc="outside lower center", ncols=len(entries))
    return figure


def _label_pressures(ax: Axes, space: Workspace, state: int) -> None:
    """Write the throttled pressures along the curves of a `state`, one label for close curves."""
    (left, right), (_, top) = ax.get_xlim(), ax.get_ylim()
    inside = (space.strain >= left) & (space.strain <= right)
    strain, curves = space.strain[inside], space.force[state - 1][:, inside]
    labels: list[tuple[np.ndarray, str]] = []
    for level, curve in zip(space.level, curves, strict=True):
        text = f"{level / 1e3:.4g}"
        if labels and np.abs(labels[-1][0] - curve).max() < 0.01 * top:
            labels[-1] = labels[-1][0], f"{labels[-1][1]}, {text}"
        else:
            labels.append((curve, text))
    box = {"facecolor": WHITE, "edgecolor": "none", "alpha": 0.85, "pad": 0.2}
    step = 0.01 * (right - left)
    for i, (curve, text) in enumerate(labels):
        # the lowest beneath its line and further on, where no other curve crosses it
        low = strain[curve <= (0.7 if i == 0 else 0.87) * top]
        x = max(float(low[0]) if low.size else right, left + 0.06 * (right - left))
        ends = np.interp([x, x + step], strain, curve)
        ax.text(
            x, ends[0], f"{text} kPa", ha="center", fontsize=6,
            rotation=np.degrees(np.arctan2(ends[1] - ends[0], step)), rotation_mode="anchor",
            transform_rotates_text=True, va="top" if i == 0 else "center", bbox=box,
        )  # fmt: skip


def _data(
    without: tuple[Workspace, Overlap], with_it: tuple[Workspace, Overlap]
) -> dict[str, Variable]:
    (bare, _), (full, shared) = without, with_it
    curves, edge = ("state", "level", "strain"), ("state", "strain")
    return {
        "state": Variable(("state",), [1, 2], "-", "recruitment state"),
        "level": Variable(("level",), LEVELS, "Pa", "throttled pressure"),
        "strain": Variable(("strain",), full.strain, "-", "contraction"),
        "force_without_resistance": Variable(curves, bare.force, "N", "bundle force"),
        "force": Variable(curves, full.force, "N", "bundle force", "(27)"),
        "lowest_force": Variable(edge, full.low, "N", "lower edge of a state's region"),
        "highest_force": Variable(edge, full.high, "N", "upper edge of a state's region"),
        "overlap_low": Variable(("strain",), shared.low[0], "N", "lower edge of the overlap"),
        "overlap_high": Variable(("strain",), shared.high[0], "N", "upper edge of the overlap"),
    }


def claims(
    without: tuple[Workspace, Overlap], with_it: tuple[Workspace, Overlap], named: float
) -> tuple[Claim, ...]:
    """Claims on Fig. 9, of its spaces with their overlaps, and of the free strain
    at 275.8 kPa, `named` [-].
    """
    return (*_neglected_claims(*without, named), *_resisting_claims(*with_it))


def _neglected_claims(bare: Workspace, disjoint: Overlap, named: float) -> tuple[Claim, ...]:
    level = int(np.argmin(np.abs(LEVELS - NAMED)))
    gain = bare.force[1, level] - bare.force[1, 0]
    last = float(bare.strain[gain > 1e-9].max(initial=0.0))
    beyond = float(np.abs(gain[bare.strain > named]).max(initial=0.0))
    step = float(np.diff(bare.strain).max())
    return (
        claim("free_strain_at_275_8_kpa", (named,), f"{named:.4f}."),
        claim(
            "nothing_beyond_without_resistance",
            (float(gain[0]), (last, {"limit": named, "tolerance": 2 * step}), beyond),
            f"It raises the force up to ε = {last:.4f}, by {gain[0]:.0f} N at ε = 0; beyond, "
            f"the difference is {beyond:.0f} N.",
        ),
        claim(
            "distinct_without_resistance",
            (float(disjoint.area[0]),),
            f"Shared area {disjoint.area[0]:.2g} N: no unit ever pushes, so a second one "
            "can't take force away.",
        ),
    )


def _resisting_claims(full: Workspace, shared: Overlap) -> tuple[Claim, ...]:
    largest = float(full.strain[-1])
    area, width = float(shared.area[0]), np.nan_to_num(shared.high[0] - shared.low[0])
    place = float(shared.strain[np.argmax(width)]) if width.any() else np.nan
    there = shared.strain[width > 0]
    ends = (float(there.min(initial=np.inf)), float(there.max(initial=-np.inf)))
    behind = full.force[1] < full.force[0, -1]
    reached = full.force[0, -1] > 0
    falls = (full.force[0, -1] - full.force[1])[:, reached].max(axis=1)
    return (
        claim(
            "states_overlap",
            (area,),
            f"They share {area:.2f} N"
            + (f", over strains from {ends[0]:.3f} to {ends[1]:.3f}." if width.any() else "."),
        ),
        claim(
            "overlap_near_the_largest_strain",
            (place / largest,),
            f"Widest at ε = {place:.3f}, {width.max():.1f} N in force; the largest free "
            f"strain is {largest:.4f}.",
        ),
        claim(
            "state_2_recedes",
            (float(falls[1]),),
            f"{int(behind[1:].any(axis=1).sum())} of the {LEVELS.size - 1} curves with unit "
            f"2 under pressure fall below state 1 fully active, by up to {falls.max():.1f} N.",
        ),
    )
