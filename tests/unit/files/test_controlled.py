"""Scenarios that are controlled: what they say reaches the controller."""

import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle.files import example_text, loads_scenario
from fascicle.table_model import FileError


RAMP = example_text("ramp_hand_over")
HELD = '"prescribed_motion"       # held by a dynamometer, at a strain of 0.2\nmean = "25.4 mm"'
HUNG = RAMP[: RAMP.index("[[demand]]")].replace(HELD, '"hanging_mass"\nmass = "5 kg"')
GAINS = 'position_gain = "4 N/mm"\nintegral_time = "0.5 s"\nvelocity_gain = "100 N*s/m"\n'
POSITION = HUNG.replace("policy =", f"{GAINS}policy =", 1) + "".join(
    f'[[demand]]\ntime = "{time} s"\nposition = "{position} mm"\n'
    for time, position in ((0, 11), (2, 21))
)


def test_control_keys_reach_the_controller():
    read = loads_scenario(RAMP)
    control = read.control
    assert read.schedule is None
    assert (control.controller.of, control.controller.every) == ("force", 2)
    assert_allclose(control.reference[[0, -1]], [15.0, 70 - 55 / 4000], rtol=1e-9)
    assert len(control.reference) == 4000
    assert_allclose(read.start.pressures, [265e3, 0.0])
    raised = loads_scenario(POSITION).control
    gains = raised.controller.gains
    assert raised.controller.of == "position"
    assert_allclose([gains.position, gains.integral, gains.velocity], [4e3, 8e3, 100.0])
    assert_allclose(raised.reference[[0, -1]], [11e-3, 21e-3 - 10e-3 / 4000], rtol=1e-9)


def test_a_position_without_a_gain_is_refused():
    with pytest.raises(FileError) as error:
        loads_scenario(POSITION.replace(GAINS, ""))
    assert error.value.argument == "control.position_gain"


@pytest.mark.parametrize(("mass", "codes"), [(5.0, ["control.force_not_held"]), (5.099, [])])
def test_a_force_that_a_hanging_mass_does_not_hold_is_named(mass, codes):
    text = HUNG.replace('mass = "5 kg"', f'mass = "{mass} kg"', 1)
    for time in (0, 4):  # 5.099 kg weigh 50 N
        text += f'[[demand]]\ntime = "{time} s"\nforce = "50 N"\n'
    findings = loads_scenario(text.replace('"hand_over"', '"threshold"')).findings
    assert [finding.code for finding in findings] == codes
    assert all(finding.data["most"] < finding.data["highest"] for finding in findings)


def held(gain: float):
    """A scenario whose mass is lifted from 12 to 13 mm by a position's `gain` [N/m] alone."""
    text = HUNG.replace('mass = "5 kg"', 'mass = "5 kg"\ndamping = "20 N*s/m"', 1)
    keys = f'position_gain = "{gain} N/m"\npressure_time = "40 ms"\n'
    text = text.replace("policy =", f"{keys}policy =", 1)
    for time, position in ((0, 12), (0.1, 13), (4, 13)):
        text += f'[[demand]]\ntime = "{time} s"\nposition = "{position} mm"\n'
    return loads_scenario(text)


def test_a_high_position_gain_is_named_before_it_swings():
    (finding,) = held(1e6).findings
    assert finding.code == "control.position_gain_high"
    limit, swings = finding.data["limit"], []
    for gain in (limit / 2, 2 * limit):
        scenario = held(gain)
        position = np.asarray(scenario.run().outputs.position)
        middle, end = (np.ptp(x) for x in (position[1000:2000], position[3000:]))
        swings.append(end / middle)
        assert bool(scenario.findings) == (gain > limit)
    # half of it settles, twice of it doesn't
    assert swings[0] < 0.5 < swings[1]


def test_shipped_controlled_scenarios_are_complete():
    gait = loads_scenario(example_text("joint_gait"))
    control = gait.control
    # springs of muscles that friction bends are along them, also where the load turns
    assert_allclose(gait.plant.hysteresis.stiffness, [20e3, 5e3])
    assert control.controller.friction is not None and control.controller.of == "position"
    assert_allclose(control.reference.max(), np.radians(27), rtol=1e-9)
    plain = gait.with_policy(compensate=False).control
    assert plain.controller.friction is None and plain.policy == "hand_over"
    other = gait.with_policy("batch")
    assert other.control.policy == "batch" and other.control.controller.friction is not None
    assert gait.with_policy().control is control


def test_hand_over_without_a_crossing_is_threshold():
    read = loads_scenario(RAMP.replace('time = "2 s"', 'time = "0.1 s"', 1))
    assert read.control.policy == "hand_over"
    assert read.control.hand_over_obstacle.code == "crossing.valves_too_slow"
    plain, other = read.with_policy("threshold").control, read.control.controller
    assert plain.hand_over_obstacle is None
    assert jax.tree.structure(plain.controller.policies) == jax.tree.structure(other.policies)
    assert jax.tree.leaves(plain.controller.policies) == jax.tree.leaves(other.policies)
    assert loads_scenario(RAMP).control.hand_over_obstacle is None
