"""A poster of the model, and the picture of links to the docs: code draws all of it.

python docs/poster.py poster.pdf        A4, portrait, to be printed as A1; or .svg, .png
python docs/poster.py --card docs/_static/card.png
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import fascicle as fs
from fascicle.plot.shapes import draw_muscle, outlines
from fascicle.plot.theme import CODE_FIGURES, LIGHT, letters, new_figure, pressure_colors, to_bytes
from fascicle.plot.workspace import draw_workspace


A4 = 8.27, 11.69  # inch, ISO 216; printed as A1, text of 8 pt has 23 pt
CARD = 1200, 630  # pixels, the size that sites recommend for pictures of links
MARGINS = {"rect": (0.02, 0.015, 0.96, 0.92)}  # left, bottom, width, height, as shares
TITLE = 0.975  # height of the title's middle, as a share
MUSCLE = fs.example("kim2021_figure_6")
PRESSURE = 137.9e3  # Pa


def draw_shapes(ax: Axes) -> None:
    """The muscle at rest, at its free strain, buckled and folded, to one scale."""
    free, fold = float(MUSCLE.free_strain(PRESSURE)), float(MUSCLE.collapse_strain(PRESSURE))
    strains = [0.0, free, (free + fold) / 2, fold + 0.03]
    names = "blocked", "free strain", "buckled", "folded"
    states, level = outlines(MUSCLE, [PRESSURE] * 4, strains), 0.0
    for state, name, strain in zip(states, names, strains, strict=True):
        draw_muscle(ax, state, level)
        ax.text(145, level, f"{name}\nε = {strain:.2f}", va="center")
        level -= 30 - min(0.0, state.lowest * 1e3 + 7)
    ax.set(xlim=(-15, 190), ylim=(level + 5, 15), aspect="equal")
    ax.axis("off")


def draw_forces(ax: Axes) -> None:
    """Force over contraction at several pressures."""
    strain, pressures = np.linspace(0, 0.33, 400), np.array([0, 34.5, 68.9, 137.9, 206.8]) * 1e3
    for pressure, color in zip(pressures, pressure_colors(pressures.size), strict=True):
        label = f"{pressure / 1e3:.0f} kPa"
        ax.plot(strain, MUSCLE.force(pressure, strain), color=color, label=label)
    ax.axhline(0, color=LIGHT.edge, linewidth=0.5)
    ax.set(xlabel="Contraction ε [-]", ylabel="Force F [N]")
    ax.legend()


def draw_reversal(ax: Axes) -> None:
    """Free strain of a bundle 1 + 4 while its second unit is filled."""
    bundle = fs.Bundle([fs.MotorUnit(MUSCLE, count=1), fs.MotorUnit(MUSCLE, count=4)])
    second = np.linspace(0, 344.7e3, 200)
    pressures = np.stack([np.full_like(second, 344.7e3), second], axis=-1)
    for resistance, label in ((True, "resisting muscles"), (False, "ideal")):
        reach = bundle.free_strain(pressures, resistance=resistance)
        ax.plot(second / 1e3, reach, "-" if resistance else "--", label=label)
    ax.set(xlabel="Pressure of the second unit [kPa]", ylabel="Free strain of the bundle [-]")
    ax.legend()


def draw_space(ax: Axes) -> None:
    """Forces and strains of a bundle 1 + 4, and where its states overlap."""
    bundle = fs.example("kim2021_bundle_1_4")
    space = bundle.workspace()
    draw_workspace(ax, space, fs.recruitment.overlap(space))
    ax.legend()


def poster() -> Figure:
    """Title, four panels, and the lines that compute them."""
    figure, axes = new_figure(3, 2, *A4, height_ratios=(1, 1, 0.55))
    figure.set_layout_engine("constrained", **MARGINS)
    figure.suptitle(
        "fascicle: from the braid angle to the force of a bundle", y=TITLE, va="center", fontsize=16
    )
    draw_shapes(axes[0, 0])
    draw_forces(axes[0, 1])
    draw_reversal(axes[1, 0])
    draw_space(axes[1, 1])
    letters(axes[:2], ("One muscle at 137.9 kPa", "Its force: it pulls, then resists",
                       "More pressure, less reach", "What a bundle of 1 + 4 can do"))  # fmt: skip
    code, text = axes[2]
    code.text(0, 1, _CODE, va="top", family=CODE_FIGURES, fontsize=7)
    text.text(0, 1, _TEXT, va="top", fontsize=9)
    for ax in (code, text):
        ax.axis("off")
    return figure


_CODE = """import fascicle as fs

muscle = fs.Muscle.from_dimensions(
    "127 mm", "6.35 mm", "1.6 mm", "33 deg")
muscle.force("137.9 kPa", 0.1)
muscle.free_strain("137.9 kPa")
muscle.collapse_strain("137.9 kPa")

bundle = fs.Bundle(
    [fs.MotorUnit(muscle, 1),
     fs.MotorUnit(muscle, 4)],
    supply_pressure="60 psi")
bundle.recruit("40 N", 0.12).pressures"""
_TEXT = """Fluidic artificial muscles and bundles of them,
in Python. Muscles at low pressure buckle, fold,
and resist the others; the ideal law leaves this out.

Fit a muscle to a record. Choose a bundle for a task.
Run it in time with valves and supply. Export it to C,
FMI, MuJoCo.

Model: Kim, Mazzoleni and Bryant (2021),
doi 10.3390/act10030042. All curves are computed;
none is measured. License: Apache-2.0."""


def card() -> Figure:
    """The first two panels."""
    figure, axes = new_figure(1, 2, CARD[0] / 150, CARD[1] / 150)  # inch, at 150 dots per inch
    figure.set_layout_engine("constrained", **MARGINS)
    draw_shapes(axes[0, 0])
    draw_forces(axes[0, 1])
    figure.suptitle(
        "fascicle: fluidic artificial muscles and their bundles", y=TITLE - 0.02, va="center"
    )
    return figure


def main() -> None:
    """Draw one of both."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--card", action="store_true", help="the picture of links")
    arguments = parser.parse_args()
    figure = card() if arguments.card else poster()
    kind = arguments.out.suffix.removeprefix(".")
    arguments.out.write_bytes(to_bytes(figure, kind, dpi=150))


if __name__ == "__main__":
    main()
