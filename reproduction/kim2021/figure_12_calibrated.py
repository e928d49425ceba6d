"""Fig. 12 by calibration: synthetic records of a dynamometer, and muscles tuned to them.

The paper's measurements are not public, so the dynamometer is a virtual one: records of Table 1's
two muscles by the protocol of section 5.3, with a load cell's noise. They are synthetic, and
labeled so. The calibration begins with the untuned muscles; its result is compared with Table 1.
"""

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from fascicle.calibrate.calibration import Calibration
from fascicle.calibrate.fitting import fit
from fascicle.muscle import Muscle
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


_SEEDS = (8, 10)  # unequal, so that the errors of the two records are independent
_POINTS = 40  # of each curve: more would hide it


@dataclass(frozen=True, eq=False)
class Recovery:
    """A muscle of Table 1, its synthetic record, the calibration, and both muscles' forces."""

    name: str
    truth: Muscle
    record: Record
    fit: Calibration
    strain: np.ndarray
    table: np.ndarray
    force: np.ndarray


def compute() -> PaperFigure:
    """Both muscles calibrated to their synthetic records."""
    both = [_recover(name, seed) for name, seed in zip(NAMES, _SEEDS, strict=True)]
    noise = 100 * VirtualDynamometer().noise
    return PaperFigure(
        key="figure_12_calibrated",
        title="Calibrated to synthetic records: Fig. 12's two muscles",
        conditions=(
            "Synthetic: no muscle was measured. Virtual dynamometer, protocol of section 5.3: 0 to "
            f"413.7 kPa in 13 steps, a sweep both ways at each, noise {noise:g} % of full scale, "
            f"seeds {_SEEDS[0]} and {_SEEDS[1]}. Five of the 13 pressures are drawn.",
            "The calibration begins with the untuned muscle: C₁ = 0, C₂ = 1, factors 1, β 25.",
            *(
                f"{_title(muscle.name)}: {_estimates(muscle.fit)}. {recovery(muscle)}"
                for muscle in both
            ),
            "That a model's own factors are found again in data made with them is a check of the "
            "calibration, not a claim of the paper, and isn't counted as muscle.",
        ),
        data=_data(both),
        draw=lambda: draw(both),
        missing="The measurements themselves, to which the paper's Table 1 was fitted.",
    )


def _recover(name: str, seed: int) -> Recovery:
    truth = setting.muscle(name)
    record = VirtualDynamometer().record(truth, seed=seed)
    untuned = Muscle(
        truth.length, truth.outer_radius, truth.wall_thickness, truth.braid_angle, truth.material
    )
    calibration = fit(record, untuned)
    strain = np.linspace(0.0, float(record.strain.max()), 301)
    forces = setting.forces(name).at(setting.FIGURE_12)
    table = np.array([np.interp(strain, forces.strain, row) for row in forces.force])
    force = np.asarray(calibration.muscle.force(PRESSURES[:, None], strain))
    return Recovery(name, truth, record, calibration, strain, table, force)


@styled
def draw(both: list[Recovery]) -> Figure:
    """Two panels: synthetic readings, the calibrated muscle, and Table 1's."""
    figure, axes = new_figure(1, 2, DOUBLE, 0.45 * DOUBLE, sharey=True)
    colors = pressure_colors(PRESSURES.size)
    for ax, mark, muscle in zip(axes.flat, "ab", both, strict=True):
        force_strain_axes(ax)
        for pressure, color, table, force in zip(
            PRESSURES, colors, muscle.table, muscle.force, strict=True
        ):
            strain, readings = _near(muscle.record, pressure)
            ax.plot(strain, readings, ".", color=color, markersize=2.2, alpha=0.55)
            ax.plot(muscle.strain, force, color=color, label=in_kilopascals(pressure))
            ax.plot(muscle.strain, table, color=BLACK, linewidth=0.7, linestyle=(0, (4, 3)))
        ax.set_xlim(0.0, 0.27)
        letter(ax, mark, f"{_title(muscle.name)}, synthetic record")
    axes[0, 1].set_ylabel("")
    axes[0, 0].plot([], [], ".", color=BLACK, label="synthetic readings")
    axes[0, 0].plot([], [], color=BLACK, linewidth=0.7, linestyle=(0, (4, 3)), label="Table 1")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    order = [4, 3, 2, 1, 0, 6, 5]
    axes[0, 1].legend([handles[i] for i in order], [labels[i] for i in order], ncols=2)
    return figure


def _near(record: Record, pressure: float) -> tuple[np.ndarray, np.ndarray]:
    """Readings [-], [N] at the tested pressure nearest to `pressure` [Pa], thinned."""
    level = record.pressure[np.argmin(np.abs(record.pressure - pressure))]
    indices = np.flatnonzero(record.pressure == level)
    indices = indices[:: max(indices.size // _POINTS, 1)]
    return record.strain[indices], record.force[indices]


def _title(name: str) -> str:
    return name.replace("_", " ")


def _estimates(calibration: Calibration) -> str:
    """Estimates and intervals, in the units of Table 1."""
    texts = []
    for parameter in calibration.parameters:
        scale, unit = (1e5, " per bar") if parameter.dimension == "inverse_pressure" else (1.0, "")
        value, low, high = (scale * x for x in (parameter.value, parameter.low, parameter.high))
        texts.append(f"{parameter.name} {value:.3g}{unit} ({low:.3g} to {high:.3g})")
    return ", ".join(texts)


def _table_1(truth: Muscle) -> np.ndarray:
    """Values of Table 1, in the order of the calibration's parameters."""
    t = truth.tuning
    return np.array([
        float(x) for x in (
            t.youngs_modulus_factor, t.collapse_moment_factor, t.hinge_stiffness_factor,
            t.hinge_stiffness_slope, truth.transition_rate,
        )
    ])  # fmt: skip


def recovery(muscle: Recovery) -> str:
    """Sentence on the intervals that contain the values of the record's muscle."""
    truth, estimates = _table_1(muscle.truth), muscle.fit.parameters
    within = [p.low < x < p.high for p, x in zip(estimates, truth, strict=True)]
    misses = [p.name for p, good in zip(estimates, within, strict=True) if not good]
    return (
        f"{sum(within)} of {len(estimates)} intervals of 90 % hold Table 1's value"
        + (f", not {' and '.join(misses)}" if misses else "")
        + f"; residuals of {muscle.fit.rmse:.3g} N, {100 * muscle.fit.relative_rmse:.2g} % of the "
        "largest force."
    )


def _data(both: list[Recovery]) -> dict[str, Variable]:
    data = {"pressure": Variable(("pressure",), PRESSURES, "Pa", "gauge pressure")}
    for muscle in both:
        strain, dims = f"strain_{muscle.name}", ("pressure", f"strain_{muscle.name}")
        data[strain] = Variable((strain,), muscle.strain, "-", "contraction")
        data[f"force_{muscle.name}"] = Variable(
            dims, muscle.force, "N", "force of the muscle calibrated to a synthetic record", "(27)"
        )
        data[f"table_1_force_{muscle.name}"] = Variable(
            dims, muscle.table, "N", "force with Table 1's factors", "(27)"
        )
    return data
