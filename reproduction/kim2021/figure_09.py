"""Fig. 9: the force-strain space of two motor units, without and with resistance."""

import numpy as np

from fascicle.bundle.space import Overlap, Space, overlap, space
from fascicle.plot.space import spaces
from fascicle.results.labelled import Variable

from ..claims import Claim, Criterion
from ..reproduced import Record
from . import setting


LEVELS = np.array([0.0, 68.9, 137.9, 206.8, 275.8, 344.7, 413.7]) * 1e3  # Pa, every 10 psi
NAMED = 275.8e3  # Pa, whose free strain section 4.1 gives
NEAR = (0.18, 0.26), (0.0, 110.0)  # strain and force of (c) and (d)
_LAST_TENTH = 0.9  # of the largest free strain, from where on it is near; the paper has no number


@setting.cached
def found(resistance: bool) -> tuple[Space, Overlap]:
    """The space and its overlap, computed once."""
    pair = setting.bundle(setting.muscle("figure_9"), (1, 1), setting.HIGHEST)
    it = space(pair, levels=LEVELS, resistance=resistance)
    return it, overlap(it)


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
        claims=claims(without, with_it, float(muscle.free_strain(NAMED))),
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


def claims(
    without: tuple[Space, Overlap], with_it: tuple[Space, Overlap], named: float
) -> tuple[Claim, ...]:
    """What the paper says of Fig. 9, of its spaces with their overlaps, and of the free strain
    at 275.8 kPa, `named` [-].
    """
    return (*_neglected_claims(*without, named), *_resisting_claims(*with_it))


def _neglected_claims(bare: Space, disjoint: Overlap, named: float) -> tuple[Claim, ...]:
    level = int(np.argmin(np.abs(LEVELS - NAMED)))
    gain = bare.force[1, level] - bare.force[1, 0]
    last = float(bare.strain[gain > 1e-9].max(initial=0.0))
    beyond = float(np.abs(gain[bare.strain > named]).max(initial=0.0))
    step = float(np.diff(bare.strain).max())
    return (
        Claim(
            key="free_strain_at_275_8_kpa",
            where="section 4.1",
            kind="input",
            text="At 275.8 kPa the muscle's free strain is 0.24.",
            quote="the model predicts that the force will increase for strain values less than "
            "0.24",
            criteria=(
                Criterion(
                    "free strain", named, "=", 0.24, tolerance=0.005,
                    ours="the paper gives two digits",
                ),
            ),
            model=f"{named:.4f}.",
            chosen="C₁₀ and C₀₁ [R3], three quarters of Klute and Hannaford's latex, which gives "
            "0.223.",
        ),
        Claim(
            key="nothing_beyond_without_resistance",
            where="section 4.1",
            kind="definition",
            text="Without resistance, 275.8 kPa on unit 2 raises the force below that strain and "
            "changes nothing above it.",
            quote="predicted to not affect the force output of the bundle",
            criteria=(
                Criterion("gain at zero strain", float(gain[0]), ">", 0.0, "N"),
                Criterion(
                    "where the gain ends", last, "=", named, tolerance=2 * step,
                    ours="two steps of the grid",
                ),
                Criterion("largest gain beyond", beyond, "=", 0.0, "N"),
            ),
            model=f"It raises the force up to ε = {last:.4f}, by {gain[0]:.0f} N at ε = 0; beyond, "
            f"the difference is {beyond:.0f} N.",
        ),
        Claim(
            key="distinct_without_resistance",
            where="section 4.1, Fig. 9a, c",
            kind="definition",
            text="Without resistance the states don't overlap: the boundary between them is "
            "distinct.",
            quote="the boundary between recruitment states 1 and 2 is distinct when resistive "
            "forces are neglected",
            criteria=(Criterion("shared area", float(disjoint.area[0]), "=", 0.0, "N"),),
            model=f"Shared area {disjoint.area[0]:.2g} N: no unit ever pushes, so a second one "
            "can't take force away.",
        ),
    )  # fmt: skip


def _resisting_claims(full: Space, shared: Overlap) -> tuple[Claim, ...]:
    largest = float(full.strain[-1])
    area, width = float(shared.area[0]), np.nan_to_num(shared.width[0])
    place = float(shared.strain[np.argmax(width)]) if width.any() else np.nan
    there = shared.strain[width > 0]
    ends = (float(there.min(initial=np.inf)), float(there.max(initial=-np.inf)))
    behind = full.force[1] < full.force[0, -1]
    reached = full.force[0, -1] > 0
    falls = (full.force[0, -1] - full.force[1])[:, reached].max(axis=1)
    return (
        Claim(
            key="states_overlap",
            where="section 4.1, Fig. 9b, d",
            kind="prediction",
            text="With resistance the two recruitment states overlap.",
            quote="an overlapping region between the first and second recruitment states",
            criteria=(Criterion("shared area, force times strain", area, ">", 0.0, "N"),),
            model=f"They share {area:.2f} N"
            + (f", over strains from {ends[0]:.3f} to {ends[1]:.3f}." if width.any() else "."),
        ),
        Claim(
            key="overlap_near_the_largest_strain",
            where="section 4.1, Fig. 9d",
            kind="prediction",
            text="The overlap is most prominent near the largest free strain.",
            quote="becomes prominent during strains near the maximum bundle free strain",
            criteria=(
                Criterion(
                    "strain where it is widest over the largest free strain",
                    place / largest, ">", _LAST_TENTH, ours="the paper gives no number",
                ),
            ),
            model=f"Widest at ε = {place:.3f}, {width.max():.1f} N in force; the largest free "
            f"strain is {largest:.4f}.",
        ),
        Claim(
            key="state_2_recedes",
            where="section 4.1, Fig. 9d",
            kind="prediction",
            text="As unit 2's pressure rises from zero, the curves of state 2 first recede into "
            "state 1.",
            quote="the isobaric force curve of recruitment state 2 recedes back into the "
            "force–strain space of recruitment state 1",
            criteria=(
                Criterion(
                    f"largest fall below state 1 fully active, at {LEVELS[1] / 1e3:g} kPa",
                    float(falls[1]), ">", 0.0, "N",
                ),
            ),
            model=f"{int(behind[1:].any(axis=1).sum())} of the {LEVELS.size - 1} curves with unit "
            f"2 under pressure fall below state 1 fully active, by up to {falls.max():.1f} N.",
        ),
    )  # fmt: skip
