"""Gymnasium's environments: its own check without a warning, seeded, and what a baseline scores."""

import os
import subprocess
import sys
import warnings

import numpy as np
import pytest


pytest.importorskip("mujoco", reason="the extra robots isn't here")
gymnasium = pytest.importorskip("gymnasium", reason="the extra robots isn't here")
from gymnasium.utils.env_checker import check_env  # noqa: E402 needs what was just looked for

import fascicle.robots  # noqa: E402, F401 tells Gymnasium the names
from fascicle.robots.environments import BASELINES, score  # noqa: E402 as above


NAMES = sorted(BASELINES)


@pytest.fixture(scope="module")
def environments():
    return {name: gymnasium.make(name) for name in NAMES}


@pytest.mark.parametrize("name", NAMES)
def test_gymnasium_check_passes(name, environments):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(environments[name].unwrapped)


@pytest.mark.parametrize("name", NAMES)
def test_a_seed_reproduces_an_episode(name, environments):
    one, runs = environments[name], []
    for _ in range(2):
        seen, _ = one.reset(seed=5)
        rows = [seen]
        one.action_space.seed(6)
        for _ in range(20):
            seen, *_ = one.step(one.action_space.sample())
            assert one.observation_space.contains(seen)
            rows.append(seen)
        runs.append(np.array(rows))
    np.testing.assert_array_equal(*runs)
    other, _ = one.reset(seed=7)
    assert other[2] != runs[0][0, 2]  # another target


@pytest.mark.parametrize("name", [NAMES[0], pytest.param(NAMES[1], marks=pytest.mark.slow)])
def test_the_baseline_beats_no_action(name, environments):
    one = environments[name]
    still = score(one, lambda _: np.zeros(2, np.float32), range(1))
    # the mean error of an episode with its beginning, where the target is far
    assert score(one, BASELINES[name], range(1)) > 0.5 * still


def test_an_episode_lasts_two_seconds(environments):
    one = environments[NAMES[0]]
    one.reset(seed=1)
    ends = [one.step(np.zeros(2, np.float32))[2:4] for _ in range(200)]
    assert ends[-1] == (False, True) and not any(any(end) for end in ends[:-1])


def test_rendering_is_refused(environments):
    with pytest.raises(ValueError, match="`render_mode` must be None"):
        type(environments[NAMES[0]].unwrapped)(render_mode="human")


ASYNC = """
import os
import subprocess
import sys
import warnings
import gymnasium, numpy as np
import fascicle.robots

name, act = "fascicle/AntagonisticJoint-v0", np.full((2, 2), 0.3, np.float32)
one = gymnasium.make(name)
one.reset(seed=1)
seen = [one.step(act[0])[0] for _ in range(3)][-1]  # compiled: JAX has begun its threads
if __name__ == "__main__":
    warnings.simplefilter("ignore")  # JAX's, of each fork
    many = gymnasium.make_vec(
        name, num_envs=2, vectorization_mode="async", vector_kwargs={"context": "fork"}
    )
    many.reset(seed=1)
    rows = [many.step(act)[0] for _ in range(3)][-1]
    # compiled or not, the same but for rounding; seen as 32 bits
    np.testing.assert_allclose(rows[0], seen, rtol=1e-5, atol=1e-6)
    many.close()
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system forks no processes")
def test_environments_of_forked_processes_step(tmp_path):
    """They waited for ever for the threads of the process that they were forked from."""
    (tmp_path / "async.py").write_text(ASYNC)
    done = subprocess.run(
        [sys.executable, tmp_path / "async.py"], capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr[-2000:]
