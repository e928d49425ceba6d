"""What the virtual dynamometer does to a muscle's law, fault by fault."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import fascicle as fs
from fascicle import records
from fascicle.core.errors import InvalidInputError
from fascicle.core.module import with_fields
from fascicle.records.dynamometer import VirtualDynamometer


muscle = fs.example("kim2021_slenderness_10")
LEVELS, SAMPLES = (0.0, 100e3, 300e3), 25
QUIET = {"pressures": LEVELS, "samples": SAMPLES, "noise": 0.0}


def measured(seed=0, **settings):
    return VirtualDynamometer(**QUIET | settings).record(muscle, seed)


def shaped(values, ways=2):
    return values.reshape(len(LEVELS), ways, SAMPLES)


def test_the_protocol_is_that_of_section_5_3():
    record = VirtualDynamometer().record(muscle, 3)
    pressure, strain, branch = (
        x.reshape(13, 2, 200) for x in (record.pressure, record.strain, record.branch)
    )
    assert_allclose(pressure[:, 0, 0], np.linspace(0, 413.7e3, 13), rtol=1e-15)
    assert np.all(np.ptp(pressure, axis=(1, 2)) == 0)
    stroke = float(muscle.free_strain(413.7e3))
    assert strain.min() == 0 and strain.max() == stroke
    assert np.all(np.diff(strain[:, 0]) > 0) and np.all(np.diff(strain[:, 1]) < 0)
    assert np.all(branch[:, 0] == 1) and np.all(branch[:, 1] == -1)
    # one sample's way at the plates' speed
    assert_allclose(np.diff(record.time), stroke * 0.127 / 199 / 1e-3)
    assert (record.rest_length, record.synthetic) == (0.127, True)
    assert not record.censored.any()


def test_the_load_cell_s_noise_is_a_share_of_the_largest_force():
    record = VirtualDynamometer().record(muscle, 3)
    exact = np.asarray(muscle.force(record.pressure, record.strain))
    error = record.force - exact
    scale = 0.005 * np.abs(exact).max()
    # 5200 readings: a standard deviation is known to 1 %, a mean to 1.4 % of it
    assert_allclose(error.std(), scale, rtol=0.05)
    assert abs(error.mean()) < 0.06 * scale


def test_a_seed_fixes_every_bit_and_another_one_changes_them():
    noisy = {"noise": 0.01, "pressure_noise": 50.0, "displacement_noise": 1e-5,
             "length_scatter": 0.01, "angle_scatter": 0.01}  # fmt: skip
    first, again, other = (measured(seed, **noisy) for seed in (5, 5, 6))
    for name in ("pressure", "strain", "force"):
        assert_array_equal(getattr(first, name), getattr(again, name))
        assert np.any(getattr(first, name) != getattr(other, name))
    assert first.rest_length == again.rest_length != other.rest_length


def test_friction_opposes_motion_by_half_a_loop():
    force = shaped(measured(hysteresis=0.1).force)
    closing, opening = force[:, 0], force[:, 1, ::-1]
    blocked = np.asarray(muscle.blocked_force(np.array(LEVELS)))
    expected = np.broadcast_to(0.1 * blocked[:, None], closing.shape)
    # differences of some 1e2 N
    assert_allclose(opening - closing, expected, atol=1e-12)
    exact = shaped(measured().force)[:, 0]
    assert_allclose((opening + closing) / 2, exact, atol=1e-12)


def test_readings_come_in_the_load_cell_s_steps():
    force = measured(noise=0.01, resolution=0.25).force
    assert_allclose(force / 0.25, np.round(force / 0.25), atol=1e-9)
    assert np.ptp(force) > 0.25


def test_a_gauge_that_only_pulls_reads_zero_for_a_push_and_says_so():
    free, clipped = measured(noise=0.01), measured(noise=0.01, clip=True)
    assert_array_equal(clipped.force, np.maximum(free.force, 0))
    assert_array_equal(clipped.censored, free.force <= 0)
    assert 0 < clipped.censored.sum() < len(clipped)


def test_new_rubber_is_stiffer_and_softens_cycle_by_cycle():
    force = shaped(measured(mullins=0.4, mullins_cycles=2.0, preconditioning=1).force)[:, 0]
    strain = shaped(measured().strain)[0, 0]
    rubber = np.array([muscle.material.c10, muscle.material.c01, muscle.material.youngs_modulus])
    for level, (pressure, row) in enumerate(zip(LEVELS, force, strict=True)):
        stiff = fs.MooneyRivlin(*(rubber * (1 + 0.4 * math.exp(-(1 + level) / 2))))
        expected = with_fields(muscle, material=stiff).force(pressure, strain)
        assert_allclose(row, expected, rtol=1e-10, atol=1e-10)
    worn = measured(mullins=0.4, preconditioning=200)
    assert_allclose(worn.force, measured().force, rtol=1e-12, atol=1e-12)


def test_gauges_of_pressure_and_length_err_in_what_they_read_alone():
    record, exact = measured(pressure_noise=200.0, displacement_noise=1e-4), measured()
    assert_array_equal(record.force, exact.force)
    pressure = shaped(record.pressure)
    assert np.all(pressure >= 0) and np.any(pressure[0] > 0)
    # 100 readings: a standard deviation is known to 7 %
    assert_allclose((pressure[1:] - shaped(exact.pressure)[1:]).std(), 200.0, rtol=0.25)
    assert_allclose((record.strain - exact.strain).std() * 0.127, 1e-4, rtol=0.25)


def test_the_muscle_on_the_machine_is_the_one_that_was_made():
    made = records.Scatter(0.02, 0.01).draw(muscle, np.random.default_rng(3), (400,))
    lengths = np.asarray(made.length) / 0.127 - 1
    angles = np.asarray(made.braid_angle) - float(muscle.braid_angle)
    # 400 draws: a standard deviation is known to 3.5 %, a mean to 5 % of it
    assert_allclose([lengths.std(), angles.std()], [0.02, 0.01], rtol=0.15)
    assert abs(lengths.mean()) < 0.004 and abs(angles.mean()) < 0.002
    record = measured(4, length_scatter=0.02)
    longer = with_fields(muscle, length=record.rest_length)
    assert record.rest_length != 0.127
    assert_allclose(record.force, longer.force(record.pressure, record.strain), atol=1e-10)


@pytest.mark.parametrize(
    ("argument", "value"),
    [("pressures", [-1.0, 1e5]), ("pressures", [0.0]), ("pressures", []), ("noise", math.nan),
     ("speed", 0.0), ("samples", 1), ("angle_scatter", 1.0)],
)  # fmt: skip
def test_refuses_settings_that_can_not_be(argument, value):
    with pytest.raises(InvalidInputError) as error:
        VirtualDynamometer(**{argument: value})
    assert error.value.argument == argument
