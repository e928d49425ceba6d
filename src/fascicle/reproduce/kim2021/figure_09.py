"""Fig. 9: the force-strain space of two motor units, without and with resistance."""

from dataclasses import replace
from functools import cache

import numpy as np

from ...bundle.recruitment import Overlap, Space, overlap, space
from ...describe.results import Variable
from ...plot.space import spaces
from ..claims import Claim
from ..record import Record
from . import setting


LEVELS = np.array([0.0, 68.9, 137.9, 206.8, 275.8, 344.7, 413.7]) * 1e3  # Pa, every 10 psi
NAMED = 275.8e3  # Pa, whose free strain section 4.1 gives
NEAR = (0.18, 0.26), (0.0, 110.0)  # strain and force of (c) and (d)
_LEVELS = 241
_LAST_TENTH = 0.9  # of the largest free strain, from where on it is near


@cache
def found(resistance: bool) -> tuple[Space, Overlap]:
    """The space and its overlap, computed once."""
    pair = setting.bundle(setting.muscle("figure_9"), (1, 1), setting.HIGHEST)
    # as many levels as the regions are taken over, so that both are compiled once
    levels = np.linspace(0.0, setting.HIGHEST, _LEVELS)
    shown = [int(np.argmin(np.abs(levels - level))) for level in LEVELS]
    levels[shown] = LEVELS
    it = space(pair, levels=levels, resistance=resistance)
    return replace(it, level=LEVELS, force=it.force[:, shown]), overlap(it)


def compute() -> Record:
    """The space of 1 + 1 of Fig. 9's muscles."""
    without, with_it = found(False), found(True)
    muscle = setting.muscle("figure_9")
    return Record(
        key="figure_09",
        title="Fig. 9. Force–strain space of two motor units",
        conditions=(
            f"Two motor units of one muscle each: {setting.sizes(muscle)}. Orderly recruitment, "
            f"supply {setting.HIGHEST / 1e3:g} kPa.",
            "Curves at " + ", ".join(f"{p / 1e3:g}" for p in LEVELS)
            + " kPa, thicker for higher pressure: of unit 1 in state 1, of unit 2 in state 2 "
            "(numbers in (c), (d)), where unit 1 stays at the supply's.",
            "Yellow: points that both states reach, over all pressures of each.",
        ),
        data=_data(without, with_it),
        draw=lambda: spaces(
            {"resistance neglected": without, "resistance included": with_it}, NEAR
        ),
        claims=_claims(without, with_it, float(muscle.free_strain(NAMED))),
    )  # fmt: skip


def _data(without: tuple[Space, Overlap], with_it: tuple[Space, Overlap]) -> dict[str, Variable]:
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


def _claims(
    without: tuple[Space, Overlap], with_it: tuple[Space, Overlap], named: float
) -> tuple[Claim, ...]:
    (bare, disjoint), (full, shared) = without, with_it
    largest = float(full.strain[-1])
    widest = float(shared.strain[np.argmax(shared.width[0])])
    level = int(np.argmin(np.abs(LEVELS - NAMED)))
    gain = bare.force[1, level] - bare.force[1, 0]
    helped = bare.strain[gain > 1e-9]
    behind = full.force[1, :, :] < full.force[0, -1, :]
    reached = full.force[0, -1, :] > 0
    deepest = float((full.force[0, -1] - full.force[1].min(axis=0))[reached].max())
    return (
        Claim(
            "section 4.1",
            "At 275.8 kPa the muscle's free strain is 0.24.",
            f"{named:.4f}.",
            # the paper gives two digits
            holds=round(named, 2) == 0.24,
            must_hold=True,
        ),
        Claim(
            "section 4.1",
            "Without resistance, 275.8 kPa on unit 2 raises the force below that strain and "
            "changes "
            "nothing above it.",
            f"It raises the force up to ε = {helped[-1]:.4f}, by {gain[0]:.0f} N at ε = 0; beyond, "
            f"the difference is {np.abs(gain[bare.strain > named]).max():.0f} N.",
            holds=bool(abs(helped[-1] - named) < 2 * np.diff(bare.strain).max()),
        ),
        Claim(
            "Fig. 9b, d",
            "With resistance the two recruitment states overlap.",
            f"They share an area of {shared.area[0]:.2f} N (force times strain), over strains from "
            f"{shared.strain[np.isfinite(shared.low[0])][0]:.3f} to "
            f"{shared.strain[np.isfinite(shared.low[0])][-1]:.3f}.",
            holds=bool(shared.area[0] > 0),
            must_hold=True,
        ),
        Claim(
            "Fig. 9d",
            "The overlap is widest near the largest free strain.",
            f"Widest at ε = {widest:.3f}, {shared.width[0].max():.1f} N in force; the largest free "
            f"strain is {largest:.4f}.",
            holds=bool(widest > _LAST_TENTH * largest),
            must_hold=True,
        ),
        Claim(
            "Fig. 9a, c",
            "Without resistance they don't overlap: the boundary between them is distinct.",
            f"Shared area {disjoint.area[0]:.2g} N.",
            holds=bool(disjoint.area[0] == 0),
            must_hold=True,
        ),
        Claim(
            "section 4.1",
            "As unit 2's pressure rises from zero, the curves of state 2 first recede into state "
            "1.",
            f"{int(behind[1:].any(axis=1).sum())} of the {LEVELS.size - 1} curves with unit 2 "
            "under "
            f"pressure fall below state 1 fully active, by up to {deepest:.1f} N.",
            holds=bool(behind[1].any() and deepest > 0),
        ),
    )
