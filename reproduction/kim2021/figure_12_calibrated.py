"""Fig. 12 the way its curves came about: records of a dynamometer, and muscles tuned to them.

The paper's measurements are nowhere to be had, so the dynamometer is a virtual one: records
of Table 1's two muscles by the protocol of section 5.3, with a load cell's noise. They are
synthetic, and labelled so. The calibration begins with the untuned muscles and is told
nothing else; beside what it finds stand the curves of Table 1.
"""

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from fascicle.calibrate.calibration import Calibration
from fascicle.calibrate.fitting import fit
from fascicle.muscle import Muscle
from fascicle.plot.curves import Components
from fascicle.plot.theme import (
    BLACK,
    DOUBLE,
    force_strain_axes,
    in_kilopascals,
    letter,
    new_figure,
    pressure_colors,
    styled,
)
from fascicle.records.dynamometer import VirtualDynamometer
from fascicle.records.record import Record
from fascicle.results.labelled import Variable

from ..figures import PaperFigure
from . import setting
from .figure_12 import NAMES, PRESSURES


_SEEDS = (8, 10)  # their slendernesses: unlike, so that the two records err apart
_SHOWN = 40  # points of each curve


@dataclass(frozen=True, eq=False)
class Recovered:
    """A muscle of Table 1, its synthetic record, the calibration, and both muscles' forces."""

    name: str
    truth: Muscle
    measured: Record
    found: Calibration
    strain: np.ndarray
    table: np.ndarray
    force: np.ndarray


def compute() -> PaperFigure:
    """Both muscles calibrated to their synthetic records."""
    both = [_recovered(name, seed) for name, seed in zip(NAMES, _SEEDS, strict=True)]
    noise = 100 * VirtualDynamometer().noise
    return PaperFigure(
        key="figure_12_calibrated",
        title="Calibrated to synthetic records: Fig. 12's two muscles",
        conditions=(
            "Synthetic: no muscle was measured. Virtual dynamometer, protocol of section 5.3: 0 to "
            f"413.7 kPa in 13 steps, a sweep both ways at each, noise {noise:g} % of full scale, "
            f"seeds {_SEEDS[0]} and {_SEEDS[1]}. Five of the 13 pressures are drawn.",
            "The calibration begins with the untuned muscle: C₁ = 0, C₂ = 1, factors 1, β 25.",
            *(f"{_title(one.name)}: {_found(one.found)}. {recovery(one)}" for one in both),
            "That a model's own factors are found again in data made with them is a check of the "
            "calibration, not a claim of the paper, and isn't counted as one.",
        ),
        data=_data(both),
        draw=lambda: draw(both),
        missing="The measurements themselves, to which the paper's Table 1 was fitted.",
    )


def _recovered(name: str, seed: int) -> Recovered:
    truth = setting.muscle(name)
    measured = VirtualDynamometer().record(truth, seed=seed)
    untuned = Muscle(
        truth.length, truth.outer_radius, truth.wall_thickness, truth.braid_angle, truth.material
    )
    found = fit(measured, untuned)
    strain = np.linspace(0.0, float(measured.strain.max()), 301)
    known: Components = setting.forces(name).at(setting.FIGURE_12)
    table = np.array([
        np.interp(strain, known.strain, row) for row in known.force
    ])  # fmt: skip
    force = np.asarray(found.muscle.force(PRESSURES[:, None], strain))
    return Recovered(name, truth, measured, found, strain, table, force)


@styled
def draw(both: list[Recovered]) -> Figure:
    """Two panels: synthetic readings, the calibrated muscle, and Table 1's."""
    figure, axes = new_figure(1, 2, DOUBLE, 0.45 * DOUBLE, sharey=True)
    colors = pressure_colors(PRESSURES.size)
    for ax, mark, one in zip(axes.flat, "ab", both, strict=True):
        force_strain_axes(ax)
        for pressure, color, table, force in zip(
            PRESSURES, colors, one.table, one.force, strict=True
        ):
            strain, measured = _near(one.measured, pressure)
            ax.plot(strain, measured, ".", color=color, markersize=2.2, alpha=0.55)
            ax.plot(one.strain, force, color=color, label=in_kilopascals(pressure))
            ax.plot(one.strain, table, color=BLACK, linewidth=0.7, linestyle=(0, (4, 3)))
        ax.set_xlim(0.0, 0.27)
        letter(ax, mark, f"{_title(one.name)}, synthetic record")
    axes[0, 1].set_ylabel("")
    axes[0, 0].plot([], [], ".", color=BLACK, label="synthetic readings")
    axes[0, 0].plot([], [], color=BLACK, linewidth=0.7, linestyle=(0, (4, 3)), label="Table 1")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    order = [4, 3, 2, 1, 0, 6, 5]
    axes[0, 1].legend([handles[i] for i in order], [labels[i] for i in order], ncols=2)
    return figure


def _near(measured: Record, pressure: float) -> tuple[np.ndarray, np.ndarray]:
    """Readings [-], [N] at the tested pressure nearest to `pressure` [Pa], thinned."""
    level = measured.pressure[np.argmin(np.abs(measured.pressure - pressure))]
    places = np.flatnonzero(measured.pressure == level)
    places = places[:: max(places.size // _SHOWN, 1)]
    return measured.strain[places], measured.force[places]


def _title(name: str) -> str:
    return name.replace("_", " ")


def _found(found: Calibration) -> str:
    """Estimates and intervals, in the units of Table 1."""
    texts = []
    for one in found.parameters:
        scale, unit = (1e5, " per bar") if one.dimension == "inverse_pressure" else (1.0, "")
        value, low, high = (scale * x for x in (one.value, one.low, one.high))
        texts.append(f"{one.name} {value:.3g}{unit} ({low:.3g} to {high:.3g})")
    return ", ".join(texts)


def _real(truth: Muscle) -> np.ndarray:
    """Table 1's numbers, in the order of the calibration's."""
    t = truth.tuning
    return np.array([
        float(x) for x in (
            t.youngs_modulus_factor, t.collapse_moment_factor, t.hinge_stiffness_factor,
            t.hinge_stiffness_slope, truth.transition_rate,
        )
    ])  # fmt: skip


def recovery(one: Recovered) -> str:
    """How many of the intervals hold the numbers that the record was made with [-]."""
    real, found = _real(one.truth), one.found.parameters
    within = [p.low < x < p.high for p, x in zip(found, real, strict=True)]
    misses = [p.name for p, good in zip(found, within, strict=True) if not good]
    return (
        f"{sum(within)} of {len(found)} intervals of 90 % hold Table 1's value"
        + (f", not {' and '.join(misses)}" if misses else "")
        + f"; residuals of {one.found.rmse:.3g} N, {100 * one.found.relative_rmse:.2g} % of the "
        "largest force."
    )


def _data(both: list[Recovered]) -> dict[str, Variable]:
    data = {"pressure": Variable(("pressure",), PRESSURES, "Pa", "gauge pressure")}
    for one in both:
        strain, dims = f"strain_{one.name}", ("pressure", f"strain_{one.name}")
        data[strain] = Variable((strain,), one.strain, "-", "contraction")
        data[f"force_{one.name}"] = Variable(
            dims, one.force, "N", "force of the muscle calibrated to a synthetic record", "(27)"
        )
        data[f"table_1_force_{one.name}"] = Variable(
            dims, one.table, "N", "force with Table 1's factors", "(27)"
        )
    return data
