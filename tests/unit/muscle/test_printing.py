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


@pytest.mark.parametrize("name", fs.examples())
def test_the_one_line_form_makes_the_same_again(name):
    thing = fs.example(name)
    names = {**vars(fs.tension), "Muscle": fs.Muscle, "Bundle": fs.Bundle, "Tuning": fs.Tuning,
             "MotorUnit": fs.MotorUnit}  # fmt: skip
    if isinstance(thing, fs.Muscle | fs.Bundle):
        assert "\n" not in repr(thing)
        assert eval(repr(thing), names) == thing  # noqa: S307 its own words


def test_rows_traced_ones_and_responses_print():
    texts = [str(MUSCLE.replace(outer_radius=[5e-3, 6e-3]))]

    @jax.jit
    def force(muscle):
        texts.extend([str(muscle), repr(muscle), str(muscle.response(1e5, 0.1))])
        return muscle.force(1e5, 0.1)

    force(MUSCLE)
    assert all(texts)
    assert len(str(MUSCLE.response(1e5, np.linspace(0, 0.3, 500))).splitlines()) < 20


@pytest.mark.parametrize("one", [MUSCLE, MUSCLE.material, fs.example("kim2021_bundle_1_4")])
def test_values_are_immutable(one):
    with pytest.raises(AttributeError):
        one.length = 1.0


def test_plots_have_as_many_curves_as_pressures():
    figure = plot.force_strain(MUSCLE, ["0 kPa", "1 bar"])
    assert isinstance(figure, Figure)
    assert len(figure.axes[0].get_legend().get_texts()) == 2
    assert len(plot.force_strain(MUSCLE, [1e5, 2e5], components=True).axes) >= 2
    assert plot.to_bytes(figure, "png")[:4] == b"\x89PNG"
    with pytest.raises(fs.InvalidInputError):
        plot.force_strain(MUSCLE.replace(outer_radius=[5e-3, 6e-3]))
