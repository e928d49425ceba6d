"""The leg of the docs: its muscles are sized with the right signs, and it walks in their tables."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest


pytest.importorskip("mujoco", reason="the extra robots isn't here")
pytest.importorskip("PIL", reason="the pictures need pillow")
SCRIPT = Path(__file__).resolve().parents[3] / "docs" / "walker_leg.py"


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("walker_leg", SCRIPT)
    assert spec is not None and spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    return script


@pytest.fixture(scope="module")
def leg(script):
    return script.build()


def test_each_muscle_of_the_leg_turns_its_joint_as_named(script, leg):
    for sizing, turns in zip(leg.sizings, script.MUSCLES.values(), strict=True):
        joint, sign = next(iter(turns.items()))
        assert sizing.route.torque_joint == joint
        assert (np.sign(sizing.route.moment_arms) == sign).all()
        assert sizing.chosen.margin >= 0.5


@pytest.mark.slow
def test_the_leg_follows_its_gait_inside_of_the_tables(script, leg):
    seen = script.walk(leg, 1.0)
    assert not any(entry["status"].any() for entry in seen)
    errors = np.rad2deg([entry["angles"] - entry["targets"] for entry in seen])
    # below the swing of the knee, and the hip has swung
    assert np.abs(errors).max() < 0.7 * 24.0 and np.ptp([x["angles"][0] for x in seen]) > 0.3
