"""Cords that stretch and go slack: forces against a bisection of the laws, and energy."""

import warnings

import numpy as np
import pytest

import fascicle as fs
from fascicle import fluid


mujoco = pytest.importorskip("mujoco", reason="the extra robots isn't here")

SUPPLY = 413.7e3
HELD = np.array([2e5, 1.5e5])
ROD = {"stiffness": 2e4}
CORD = {"stiffness": ["40 N/mm", 4e4], "slack": True}  # in series: as soft as the rod
CHAMBERS = {
    "supply": fluid.ConstantSupply(SUPPLY), "valve": fluid.SonicValve(1e-9, 0.3),
    "chamber": fluid.Isothermal(dead_volume=2e-6),
}  # fmt: skip


def bisect(function, low, high):
    """Root of a falling function, by a hundred halvings: no slope, no table."""
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if function(middle) > 0 else (low, middle)
    return (low + high) / 2


def series_pull(muscle, pressure, contraction, stiffness, slack):
    """Pull [N] of a muscle by its law in series with a spring."""
    length = float(muscle.length)

    def force(x):
        return float(muscle.force(pressure, x / length))

    if slack and force(contraction) <= 0:
        return 0.0
    x = bisect(lambda x: force(x) / stiffness - (x - contraction), -0.1 * length, 0.39 * length)
    return force(x)


@pytest.mark.parametrize("cord", [ROD, CORD, {"slack": True}], ids=["rod", "cord", "rigid cord"])
@pytest.mark.parametrize("pressure", [0.0, 5e4, 3e5])
def test_pull_is_that_of_law_and_spring(elbow, bundle, cord, pressure):
    drive, muscle = elbow(cord=cord)[2], bundle.motor_units[0].muscle
    stiffness = 2e4 if "stiffness" in cord else 1e12  # N/m, rigid but for rounding
    for strain in (-0.05, 0.0, 0.1, 0.25, 0.38):
        contraction = strain * float(muscle.length)
        lengths = drive.rest_lengths - np.array([contraction, 0.01])
        pull = drive.pull(np.array([pressure, 2e5]), lengths)[0]
        expected = series_pull(muscle, pressure, contraction, stiffness, "slack" in cord)
        # the table is coarse near straight fibers: its largest error there
        tolerance = max(drive.plant.muscles.muscles.table.errors[2], 1e-6)
        assert abs(pull - expected) < tolerance


def test_stiffness_is_a_positive_number_of_newtons_a_meter(elbow):
    for stiffness in (-1.0, "3 kPa"):
        with pytest.raises(fs.InvalidInputError) as error:
            elbow(cord={"stiffness": stiffness})
        assert error.value.argument == "stiffness"


@pytest.mark.parametrize("cord", [{}, ROD, CORD], ids=["rigid", "rod", "cord"])
@pytest.mark.parametrize("strain", [-0.25, -0.05, 0.1, 0.36, 0.45])
def test_pull_is_the_slope_of_the_stored_energy(elbow, bundle, cord, strain):
    """Inside of the table and past both of its ends, so that no path makes energy."""
    drive, step = elbow(cord=cord)[2], 1e-6
    lengths = drive.rest_lengths - np.array([strain * float(bundle.length), 0.01])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        pull = drive.pull(HELD, lengths)[0]
        ends = [drive.energy(HELD, lengths + np.array([x, 0.0])) for x in (step, -step)]
    # central differences of a spring of 1e5 N/m, of energies known to 1e-12 J
    assert abs((ends[0] - ends[1]) / (2 * step) - pull) < 1e-3 + 1e-5 * abs(pull)


@pytest.mark.parametrize(
    ("options", "seconds", "drift", "swing"),
    [
        ({}, 5, 1e-3, 0.02),
        ({"spatial": True}, 5, 1e-3, 0.02),
        ({"cord": ROD, "contraction": 0.25}, 2, 2e-3, 0.03),
        ({"cord": CORD, "contraction": 0.25}, 2, 2e-3, 0.03),
    ],
    ids=["fixed", "spatial", "rod", "cord"],
)
def test_muscles_at_constant_pressure_conserve_energy(
    elbow, energy, options, seconds, drift, swing
):
    model, data, drive = elbow(**options)
    begin, off, taut = energy(model, data, drive, HELD), [], []
    held = drive.start(model, data, HELD)
    for k in range(1000 * seconds):
        held = drive.step(model, data, held, HELD)
        taut.append(drive.rest_lengths - data.actuator_length > held.contractions)
        if k % 25 == 24:
            off.append(energy(model, data, drive, HELD) - begin)
    if options.get("cord") is CORD:
        assert 0.02 < np.mean(taut) < 0.98  # the cords go slack and taut
    # a symplectic step's energy swings by its order, and its mean stays: of two halves
    halves = np.reshape(off, (2, -1))
    assert abs(np.diff(halves.mean(axis=1))) < drift
    assert np.abs(off).max() < swing  # J, of 1 J that swings


def test_a_closed_chamber_balances_its_cord(elbow, bundle):
    """Mass and force balance, both by the exact law at the step's own pressure."""
    model, data, drive = elbow(cord=CORD, contraction=0.2, **CHAMBERS)
    held = drive.start(model, data, HELD)
    mass, muscle = held.chambers.copy(), bundle.motor_units[0].muscle
    for _ in range(300):
        mujoco.mj_fwdPosition(model, data)
        held = drive.step(model, data, held, np.zeros(2))
    np.testing.assert_array_equal(held.chambers, mass)
    pull, length = -data.actuator_force, float(muscle.length)
    for i in range(2):
        P, x = float(held.pressures[i]), float(held.contractions[i])
        # force of the law, to the table's error in the middle of its range
        np.testing.assert_allclose(pull[i], max(float(muscle.force(P, x / length)), 0.0), atol=0.05)
        volume = float(muscle.conjugate_volume(P, x / length)) + 2e-6
        chamber = drive.plant.chamber
        density = chamber.gas.density(P + chamber.room_pressure, chamber.room_temperature)
        np.testing.assert_allclose(density * volume, float(mass[i, 0]), rtol=1e-4)
    assert abs(held.pressures - HELD).max() > 100.0  # they have moved with the arm
