"""Task files: what they say reaches the task, the space and the chance."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.files.calibration_files import sample_muscles
from fascicle.files.task import load_task, loads_task
from refusing import refuses


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
    assert file.block == 4096
    assumed = file.uncertainty
    assert (assumed.share, assumed.draws, assumed.muscles) == (0.95, 2000, None)
    assert (assumed.scatter.length, assumed.scatter.wall_thickness) == (0.01, 0.05)
    assert_allclose(np.degrees(assumed.scatter.braid_angle), 1.5)
    assert assumed.scatter.model_error == 0.15 and assumed.basis == "assumed"


def test_limits_have_units_and_valves_bound_the_space():
    file = loads_task(
        PLAIN + "muscles = 4\n[limits]\nvalves = { at_most = 2 }\n"
        'envelope = { at_most = "60 mm" }\npeak_energy = { at_least = "10 mJ", at_most = "1 kJ" }\n'
    )
    assert file.limits["envelope"].most == 0.06
    assert (file.limits["peak_energy"].least, file.limits["peak_energy"].most) == (0.01, 1000.0)
    assert len(file.space) == 4


@pytest.mark.parametrize(
    ("limits", "share", "least"),
    [("", 0.2, None), ('margin = "35 %"\n', 0.35, None), ("margin = 0\n", 0.0, None),
     ('margin = { at_least = "50 N" }\n', 0.2, 50.0),
     ('margin = { warn_below = "35 %" }\n', 0.35, None),
     ('margin = { at_least = "50 N", warn_below = 0.35 }\n', 0.35, 50.0)],
)  # fmt: skip
def test_margin_of_the_warning(limits, share, least):
    file = loads_task(f"{PLAIN}muscles = 2\n[limits]\n{limits}")
    assert file.least_margin == share
    assert ("margin" in file.limits) is (least is not None)
    assert least is None or file.limits["margin"].least == least


def test_a_stroke_instead_of_a_strain():
    text = PLAIN.replace('strain = [0.16, "5 %"]', 'stroke = "25 mm"')
    file = loads_task(text + "muscles = 2\n")
    assert file.task.strain is None and file.task.stroke.tolist() == [0.025, 0.025]
    assert_allclose(file.task.strain_of(0.127), 0.025 / 0.127)
    assert_allclose(file.task.stroke_of(0.5), 0.025)


def test_an_example_keeps_its_times_and_takes_a_scheme_and_a_fluid():
    task = loads_task(
        'format = 1\n[task]\nexample = "walking_ankle"\nsupply_pressure = "4 bar"\n'
        'scheme = "batch"\nfluid = "liquid"\n'
        '[design]\nmuscle = "kim2021_figure_6"\nmuscles = 2\n'
    ).task
    assert (task.scheme, task.fluid, len(task.time)) == ("batch", "liquid", 23)


def test_cycle_is_read_and_needs_air():
    cycle = '[cycle]\ntime = "500 ms"\nper_minute = 20\nhose_length = "1.5 m"\n'
    read = loads_task(PLAIN + "muscles = 2\n" + cycle).cycle
    assert (read.lift + read.release, read.per_minute) == (0.5, 20)
    assert (read.hose_length, read.b) == (1.5, 0.3)
    for old, new, key in (("air", "liquid", "cycle"), ("= 20", "= 121", "cycle.per_minute")):
        text = PLAIN.replace('scheme = "batch"', 'fluid = "air"') + "muscles = 2\n" + cycle
        with refuses(key):
            loads_task(text.replace(old, new))


def test_prices_in_one_currency():
    more = '[prices]\nvalve = "90 EUR"\nmuscle = "20 EUR"\nair = "0.02 EUR/m^3"\n'
    catalog = loads_task(PLAIN + 'muscles = 2\ndensity = "1.1 g/cm^3"\n' + more).catalog
    assert (catalog.valve, catalog.muscle, catalog.air) == (90.0, 20.0, 0.02)
    assert (catalog.energy, catalog.currency, catalog.density) == (None, "EUR", 1100.0)


def test_listed_splits_and_another_law():
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
    assert file.space.drawings == {"mine.toml": fs.example("kim2021_figure_6")}
    assert file.uncertainty.draws == 50 and file.uncertainty.muscles is None
    assert_allclose(file.uncertainty.scatter.braid_angle, np.radians(1.0))


def test_constants_are_drawn_from_the_calibration(tmp_path):
    muscle = fs.example("kim2021_slenderness_10")
    names = ["youngs_modulus_factor", "collapse_moment_factor"]
    center = np.log([0.95, 0.75])
    calibration = {
        # not in the order in which they are put
        "coordinate_names": [*names[::-1], "transition_rate"],
        "coordinates": [*center[::-1].tolist(), 3.0],
        "covariance": [[0.04, 0.0, 0.0], [0.0, 0.0001, 0.0], [0.0, 0.0, 9.0]],
        "parameter": [{"name": "transition_rate", "identifiable": False}],
    }
    fs.save(muscle, tmp_path / "fitted.toml", calibration)
    draws = sample_muscles(tmp_path / "fitted.toml", 4000, seed=1)
    stiff = np.log(np.asarray(draws.tuning.youngs_modulus_factor))
    strong = np.log(np.asarray(draws.tuning.collapse_moment_factor))
    assert stiff.shape == (4000,)
    # four deviations of a mean, and of a deviation, of 4000 draws
    assert_allclose([stiff.mean(), strong.mean()], center, atol=4 * 0.2 / np.sqrt(4000))
    assert_allclose([stiff.std(), strong.std()], [0.01, 0.2], rtol=4 / np.sqrt(8000))
    # what the data don't determine would spread over decades
    assert_allclose(draws.tuning.transition_rate, np.exp(3.0))


def test_sixty_muscles_of_few_units_are_a_space():
    bundle = PLAIN + "muscles = 60\n"
    assert len(loads_task(bundle + "[limits]\nvalves = { at_most = 3 }\n").space) == 1771
    with refuses("design.muscles"):
        loads_task(bundle)


def test_safety_and_scatter_are_read_and_switched_off():
    given = 'muscles = 2\n[limits]\nsafety = "80 %"\n[scatter]\nmodel_error = 0\n'
    file = loads_task(PLAIN + given)
    assert file.uncertainty.share == 0.8 and "safety" not in file.limits
    # what isn't given keeps its default
    assert file.uncertainty.scatter.model_error == 0 and file.uncertainty.scatter.length == 0.01
    assert file.uncertainty.basis == "given"
    assert loads_task(PLAIN + "muscles = 2\n[scatter]\nenabled = false\n").uncertainty is None


def test_fitted_muscle_has_the_error_of_its_fit():
    text = PLAIN.replace("kim2021_figure_6", "festo-dmsp-20-300")
    uncertainty = loads_task(text + "muscles = 2\n").uncertainty
    assert uncertainty.scatter.model_error == 0.005673  # relative_rmse of the file
    assert uncertainty.basis == "fit"
