"""Task files: what they say reaches the task, the space and the chance."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.describe.drawn import drawn
from fascicle.describe.task import load_task, loads_task


PLAIN = """format = 1
[task]
force = ["60 N", "10 lbf"]
strain = [0.16, "5 %"]
time = ["0 s", "500 ms"]
supply_pressure = "60 psi"
scheme = "batch"
[design]
muscle = "kim2021_figure_6"
"""


def test_units_and_lists():
    file = loads_task(PLAIN + 'muscles = [2, 3]\nlength = "100 mm:140 mm:20 mm"\nsplits = "all"\n')
    assert_allclose(file.task.force, [60.0, 44.4822], rtol=1e-5)
    assert_allclose(file.task.strain, [0.16, 0.05])
    assert_allclose(file.task.weight, [0.25, 0.25])
    assert_allclose(file.task.supply_pressure, 413685.4, rtol=1e-6)
    assert file.task.scheme == "batch"
    assert_allclose(file.space.length, [0.1, 0.12, 0.14])
    assert len(file.space) == 3 * (2 + 4)
    # what usually matters
    assert file.senses["mean_efficiency"] == "max" and file.senses["valves"] == "min"
    assert file.block == 4096 and file.chance is None


def test_limits_have_units_and_valves_bound_the_space():
    file = loads_task(
        PLAIN + "muscles = 4\n[limits]\nvalves = { at_most = 2 }\n"
        'envelope = { at_most = "60 mm" }\npeak_energy = { at_least = "10 mJ", at_most = "1 kJ" }\n'
    )
    assert file.limits["envelope"].most == 0.06
    assert (file.limits["peak_energy"].least, file.limits["peak_energy"].most) == (0.01, 1000.0)
    assert len(file.space) == 4


def test_splits_written_out_and_another_law():
    file = loads_task(PLAIN + 'splits = ["1+4", "2+3"]\nbuckling = "elastica"\n')
    assert file.space.at(np.arange(2)).labels == ["1+4", "2+3"]
    assert next(iter(file.space.drawings.values())).buckling.name == "elastica"


def test_a_muscle_file_stands_beside_the_task(tmp_path):
    fs.save(fs.example("kim2021_figure_6"), tmp_path / "mine.toml")
    (tmp_path / "task.toml").write_text(
        PLAIN.replace("kim2021_figure_6", "mine.toml")
        + 'muscles = 2\n[scatter]\nlength = "1 %"\nbraid_angle = "1 deg"\ndraws = 50\n'
    )
    file = load_task(tmp_path / "task.toml")
    assert list(file.space.drawings) == ["mine.toml"]
    assert file.chance.draws == 50 and file.chance.muscles is None
    assert_allclose(file.chance.scatter.braid_angle, np.radians(1.0))


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("muscles = 2\n[scatter]\ndraws = 1\n", "scatter.draws = 1: must lie in"),
        ("muscles = 2\n[scatter]\ncalibrated = true\n", "needs a muscle file"),
        ('muscles = 2\n[scatter]\nlength = "30 %"\n', "`length` must lie in"),
        ("muscles = 2\n[sweep]\nblock = 0\n", "sweep.block = 0: must lie in"),
        ("muscles = 2.5\n", "must be a whole number, or a list of them"),
        ('muscles = [3]\nsplits = ["1+4"]\n', "must be left out where the splits are written out"),
        ("muscles = 2\n[limits]\nvalves = {}\n", "empty: write { at_most"),
        ('muscles = 2\n[limits]\nenvelope = { at_most = "6 N" }\n', "'N' is no unit of length"),
        ('muscles = 2\nunit_factors = "-1"\n', "`unit_factors` must lie in"),
    ],
)
def test_what_a_task_file_can_not_say(more, message):
    with pytest.raises(ValueError) as refused:  # noqa: PT011 the line is looked at
        loads_task(PLAIN + more, "t.toml")
    line = str(refused.value)
    assert line.startswith("t.toml: ") and message in line and "\n" not in line


def test_constants_are_drawn_from_the_calibration(tmp_path):
    muscle = fs.example("kim2021_slenderness_10")
    names = ["youngs_modulus_factor", "collapse_moment_factor"]
    center = np.log([0.95, 0.75])
    told = {
        # not in the order in which they are put
        "coordinate_names": names[::-1],
        "coordinates": center[::-1].tolist(),
        "covariance": [[0.04, 0.0], [0.0, 0.0001]],
    }
    fs.save(muscle, tmp_path / "fitted.toml", told)
    draws = drawn(tmp_path / "fitted.toml", 4000, seed=1)
    stiff = np.log(np.asarray(draws.tuning.youngs_modulus_factor))
    strong = np.log(np.asarray(draws.tuning.collapse_moment_factor))
    assert stiff.shape == (4000,)
    # four deviations of a mean, and of a deviation, of 4000 draws
    assert_allclose([stiff.mean(), strong.mean()], center, atol=4 * 0.2 / np.sqrt(4000))
    assert_allclose([stiff.std(), strong.std()], [0.01, 0.2], rtol=4 / np.sqrt(8000))


def test_a_muscle_without_a_calibration(tmp_path):
    fs.save(fs.example("kim2021_figure_6"), tmp_path / "plain.toml")
    with pytest.raises(ValueError, match="has no \\[calibration\\] with a covariance"):
        drawn(tmp_path / "plain.toml")
