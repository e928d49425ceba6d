"""A muscle prints its sizes with units, its laws and a small table; it can't be assigned to."""

import jax
import numpy as np
import pytest
from matplotlib.figure import Figure

import fascicle as fs
from fascicle import plot


MUSCLE = fs.example("kim2021_figure_6")


def test_a_muscle_prints_sizes_laws_and_a_table():
    lines = str(MUSCLE).splitlines()
    assert lines[0] == "Muscle"
    facts = dict(line.strip().split("  ", 1) for line in lines[1:12])
    facts = {name: value.strip() for name, value in facts.items()}
    assert facts["length"] == "127 mm" and facts["braid angle"] == "33 deg"
    assert facts["material"].startswith("silicone_kim2021: c10 88.8 kPa, c01 79.3 kPa")
    assert facts["tension"] == "klute_hannaford" and facts["post-collapse"] == "derived"
    assert facts["tuning"] == "none"
    row = next(line.split() for line in lines if line.split()[:1] == ["200"])
    found = (MUSCLE.blocked_force(2e5), MUSCLE.free_strain(2e5), MUSCLE.collapse_strain(2e5))
    np.testing.assert_allclose([float(x) for x in row[1:]], found, rtol=1e-3)


def test_a_tuning_is_told_and_the_table_ends_where_it_was_measured():
    tuning = fs.Tuning([1e5, 2e5], [1.0, 2.0], [0.9, 1.1], youngs_modulus_factor=1.25)
    text = str(MUSCLE.replace(tuning=tuning))
    assert "C1 and C2 at 3 pressures up to 200 kPa, E × 1.25" in text
    assert text.splitlines()[-1].split()[0] == "200"


def test_rows_of_muscles_print_how_far_they_reach():
    text = str(MUSCLE.replace(outer_radius=[5e-3, 6e-3]))
    assert "outer radius     5 mm to 6 mm, 2 of them" in text and "blocked" not in text


@pytest.mark.parametrize("name", fs.examples())
def test_the_one_line_form_makes_the_same_again(name):
    thing = fs.example(name)
    names = {**vars(fs.tension), "Muscle": fs.Muscle, "Bundle": fs.Bundle, "Tuning": fs.Tuning,
             "MotorUnit": fs.MotorUnit}  # fmt: skip
    if isinstance(thing, fs.Muscle | fs.Bundle):
        assert "\n" not in repr(thing)
        assert eval(repr(thing), names) == thing  # noqa: S307 its own words


def test_other_laws_are_told_with_their_numbers():
    muscle = MUSCLE.replace(tension=fs.tension.Meller2014(1.15, 0.9), buckling="elastica")
    assert "meller2014: strain factor 1.15, force factor 0.9" in str(muscle)
    assert "tension=Meller2014(strain_factor=1.15, force_factor=0.9)" in repr(muscle)
    assert "buckling='elastica'" in repr(muscle)


def test_a_response_prints_forces_and_region_names():
    lines = str(MUSCLE.response(1e5, [0.1, 0.2, 0.3])).splitlines()
    assert lines[0] == "Response, 3 points"
    assert [line.split()[-1] for line in lines[3:]] == [
        "tension", "post-buckling", "post-collapse",
    ]  # fmt: skip
    assert len(str(MUSCLE.response(1e5, np.linspace(0, 0.3, 500))).splitlines()) < 20
    assert "488 more" in str(MUSCLE.response(1e5, np.linspace(0, 0.3, 500)))


def test_traced_ones_print_without_numbers():
    seen = []

    @jax.jit
    def force(muscle):
        seen.extend(
            [str(muscle), repr(muscle), muscle._repr_html_(), str(muscle.response(1e5, 0.1))]
        )
        return muscle.force(1e5, 0.1)

    force(MUSCLE)
    assert "length=float64[]" in seen[0] and seen[0] == seen[1] and "<pre>" in seen[2]
    assert seen[3].startswith("Response(force=")


@pytest.mark.parametrize(
    ("assign", "words"),
    [
        (lambda: setattr(MUSCLE, "wall_thickness", 1e-3), "muscle.replace(wall_thickness=…)"),
        (lambda: setattr(fs.example("kim2021_bundle_1_4"), "scheme", "batch"),
         "bundle.replace(scheme=…)"),
        (lambda: setattr(MUSCLE.material, "c10", 1e5), "construct another one"),
        (lambda: setattr(MUSCLE, "color", "red"), "a Muscle is immutable"),
    ],
)  # fmt: skip
def test_an_assignment_says_what_to_write(assign, words):
    with pytest.raises(AttributeError) as refused:
        assign()
    assert words in str(refused.value) and "\n" not in str(refused.value)


def test_plots_have_labelled_axes_and_as_many_curves_as_pressures():
    figure = MUSCLE.plot(["0 kPa", "1 bar"])
    assert isinstance(figure, Figure)
    (ax,) = figure.axes
    assert ax.get_xlabel() == "Contraction ε [–]" and ax.get_ylabel() == "Force F [N]"
    legend = ax.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["100 kPa", "0 kPa"]
    assert len(MUSCLE.plot().axes[0].lines) == 6  # five, and zero force
    assert len(MUSCLE.plot([1e5, 2e5], components=True).axes) >= 2
    assert plot.to_bytes(figure, "png")[:4] == b"\x89PNG"
    with pytest.raises(fs.InvalidInputError, match="must be a single one"):
        MUSCLE.replace(outer_radius=[5e-3, 6e-3]).plot()
