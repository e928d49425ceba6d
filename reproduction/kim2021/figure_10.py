"""Fig. 10: efficiency over the force-strain space, and its average against motor units."""

import equinox as eqx
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fascicle.bundle import Bundle
from fascicle.bundle.energetics import EfficiencyMap, efficiency_map
from fascicle.muscle import Muscle
from fascicle.plot.curves import components_of
from fascicle.plot.theme import BLUE, DOUBLE, GRAY, VERMILION, letter, new_figure, styled
from fascicle.plot.workspace import draw_efficiency
from fascicle.results.labelled import Variable

from ..claims import Claim
from ..figures import PaperFigure
from . import setting
from .setting import claim


UNITS = np.arange(1, 7)
PATHS = ("isobaric", "isotonic")
_ROWS = 320  # of forces in a picture


def semu() -> Muscle:
    """One muscle with the section of two of Fig. 9's: $\\sqrt2$ times as thick."""
    muscle = setting.muscle("figure_9")
    sizes = (muscle.outer_radius * np.sqrt(2), muscle.wall_thickness * np.sqrt(2))
    return eqx.tree_at(lambda m: (m.outer_radius, m.wall_thickness), muscle, sizes)


@setting.cached
def efficiency_of(units: int, path: str, resistance: bool, rows: int = 80) -> EfficiencyMap:
    """One map of the family on the grid of section 4.2's averages [R18], computed once.

    The grid is the library's own with 80 `rows` of force; a picture takes more.
    """
    bundle = family(units)
    muscle = bundle.motor_units[0].muscle
    # equal units: one muscle says where the grid ends
    largest = units * float(muscle.blocked_force(setting.HIGHEST))
    columns = int(float(muscle.free_strain(setting.HIGHEST)) * 375)
    return efficiency_map(
        bundle,
        path=path,
        force=largest * np.arange(1, rows + 1) / rows,
        strain=np.arange(1, columns + 1) / 375,
        resistance=resistance,
    )


def family(units: int) -> Bundle:
    """`units` motor units in the section of one."""
    return Bundle.constant_cross_section(semu(), units, setting.HIGHEST)


def averages(path: str, resistance: bool) -> np.ndarray:
    """Average efficiency [-] against the number of motor units."""
    return np.array([efficiency_of(int(n), path, resistance).average for n in UNITS])


def compute() -> PaperFigure:
    """Maps of two motor units, averages of one to six."""
    maps = {path: efficiency_of(2, path, True, _ROWS) for path in PATHS}
    mean = {(path, way): averages(path, way) for path in PATHS for way in (True, False)}
    return PaperFigure(
        key="figure_10",
        title="Fig. 10. Efficiency",
        conditions=(
            "(a), (b): two motor units of Fig. 9's muscle, with resistance: "
            f"{setting.sizes(setting.muscle('figure_9'))}. (c), (d): N motor units in the same "
            "cross-section, r₀ = R/√N and t₀/r₀ unchanged, N = 1 being the single equivalent motor "
            f"unit (SEMU), R = {float(semu().outer_radius) * 1e3:.2f} mm.",
            f"Supply {setting.HIGHEST / 1e3:g} kPa; orderly recruitment. Where states overlap, the "
            "higher efficiency counts. Averages over the points of an even grid that the bundle "
            "reaches: forces in steps of 1/80 of the largest, strains in steps of 1/375. White "
            "lines: where a further unit is recruited.",
            "(c) stands below its map, so it is the isobaric one; the caption in print has the two "
            "averages the other way round.",
        ),
        data=_data(maps, mean),
        draw=lambda: draw(maps, mean),
        claims=(
            *efficiency_claims(mean),
            slender_claim(*resistances()),
            unit_claim(unit_resistances()),
        ),
    )


@styled
def draw(maps: dict[str, EfficiencyMap], mean: dict[tuple[str, bool], np.ndarray]) -> Figure:
    """Two maps above, two averages below."""
    figure, axes = new_figure(2, 2, DOUBLE, 0.78 * DOUBLE)
    highest = max(float(np.nanmax(result.efficiency)) for result in maps.values())
    images = [
        draw_efficiency(ax, maps[path], highest) for ax, path in zip(axes[0], PATHS, strict=True)
    ]
    for ax, mark, path in zip(axes[0], "ab", PATHS, strict=True):
        letter(ax, mark, f"{path} contraction")
    axes[0, 1].set_ylabel("")
    figure.colorbar(images[0], ax=axes[0], label="Efficiency η [–]", pad=0.01)
    top = 1.12 * max(float(values.max()) for values in mean.values())
    for ax, mark, path in zip(axes[1], "cd", PATHS, strict=True):
        _average(ax, mean[path, False], mean[path, True])
        ax.set_ylim(0, top)
        letter(ax, mark, f"{path}, average")
    axes[1, 0].set_ylabel("Average efficiency η [–]")
    axes[1, 0].legend(loc="lower right")
    return figure


def _average(ax: Axes, without: np.ndarray, with_it: np.ndarray) -> None:
    ax.plot(UNITS, without, "o--", color=VERMILION, markersize=5.5, fillstyle="none",
            label="resistance neglected")  # fmt: skip
    ax.plot(UNITS, with_it, "o-", color=BLUE, markersize=3.2, label="resistance included")
    ax.axhline(with_it[0], color=GRAY, linewidth=0.8, linestyle=":")
    ax.text(UNITS[-1], with_it[0] - 0.015, "SEMU", ha="right", va="top", color=GRAY)
    ax.set_xlabel("Motor units N [–]")
    ax.set_xticks(UNITS)


def _data(
    maps: dict[str, EfficiencyMap], mean: dict[tuple[str, bool], np.ndarray]
) -> dict[str, Variable]:
    first, grid = maps[PATHS[0]], ("force", "strain")
    data = {
        "force": Variable(("force",), first.force, "N", "bundle force"),
        "strain": Variable(("strain",), first.strain, "-", "contraction"),
        "units": Variable(("units",), UNITS, "-", "motor units in one cross-section"),
    }
    for path, result in maps.items():
        data[f"{path}_efficiency"] = Variable(grid, result.efficiency, "-", "two units", "(30)")
        data[f"{path}_state"] = Variable(grid, result.state, "-", "recruitment state; 0: none")
    for (path, resistance), values in mean.items():
        name = f"{path}_average" + ("" if resistance else "_without_resistance")
        data[name] = Variable(("units",), values, "-", "average efficiency", "section 4.2")
    return data


def efficiency_claims(mean: dict[tuple[str, bool], np.ndarray]) -> tuple[Claim, ...]:
    """Claims on averages [-], by path and whether with resistance."""
    costs = {path: 1 - mean[path, True] / mean[path, False] for path in PATHS}
    return (
        *(_rise_claim(path, mean[path, True]) for path in PATHS),
        claim(
            "resistance_costs_little",
            (100 * max(float(cost.max()) for cost in costs.values()),),
            "; ".join(
                f"{path}: " + ", ".join(f"{100 * x:.2f}" for x in cost) + " % of the average"
                for path, cost in costs.items()
            )
            + f" for N = 1 to {UNITS[-1]}.",
        ),
    )


def _rise_claim(path: str, values: np.ndarray) -> Claim:
    rise = np.diff(values)
    return claim(
        f"{path}_average_rises",
        (float(rise.min()), float(np.diff(rise).max())),
        f"N = 1 to {UNITS[-1]}: " + ", ".join(f"{x:.3f}" for x in values) + ".",
    )


def resistances() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Strains [-], and the forces [N] of one inactive unit of two and of four of five there."""
    thick, thin = (family(n).motor_units[0].muscle for n in (2, 5))
    inactive = np.zeros(1)
    parts = [components_of(muscle, inactive, setting.STRAIN) for muscle in (thick, thin)]
    strain = np.linspace(0.0, setting.tested(thick), 301)[1:]
    one, four = (
        n * np.interp(strain, part.strain, part.force[0])
        for n, part in zip((1, 4), parts, strict=True)
    )
    return strain, one, four


def slender_claim(strain: np.ndarray, one: np.ndarray, four: np.ndarray) -> Claim:
    """Claims on `one` inactive unit of two against `four` of five [N] over strains."""
    weaker = strain[one >= four]
    last = float(weaker[-1]) if weaker.size else 0.0
    place = 0.05
    at = [float(np.interp(place, strain, f)) for f in (one, four)]
    return claim(
        "one_of_two_against_four_of_five",
        (float((one / four).min()),),
        (f"Only beyond ε ≈ {last:.2f}" if weaker.size else "At every strain")
        + f". At ε = {place:g}: {at[0]:.1f} N of the one, {at[1]:.1f} N of the four; at "
        f"{strain[-1]:.2f}: {one[-1]:.1f} and {four[-1]:.1f} N.",
    )


def unit_resistances() -> np.ndarray:
    """Largest resistance [N] of one unit without pressure, against the number of units."""
    muscles = [family(int(n)).motor_units[0].muscle for n in UNITS]
    strain = np.linspace(0.0, setting.tested(muscles[0]), 301)  # one for all: t0/r0 is the same
    return np.array([-float(setting.array(muscle.force(0.0, strain)).min()) for muscle in muscles])


def unit_claim(resistance: np.ndarray) -> Claim:
    """Claim on the `resistance` [N] of one unit, against the number of units."""
    return claim(
        "resistance_of_a_unit_falls",
        (float((resistance[1:] / resistance[:-1]).max()),),
        f"N = 1 to {UNITS[-1]}: {', '.join(f'{x:.2f}' for x in resistance)} N.",
    )
