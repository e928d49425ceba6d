"""Gymnasium's environments: its own check without a warning, seeded, and what a baseline scores."""

import os
import pickle
import subprocess
import sys
import warnings

import jax.numpy as jnp
import numpy as np
import pytest


pytest.importorskip("mujoco", reason="the extra robots isn't here")
gymnasium = pytest.importorskip("gymnasium", reason="the extra robots isn't here")
from gymnasium.utils.env_checker import check_env  # noqa: E402 needs what was just looked for

import fascicle as fs  # noqa: E402 as above
import fascicle.robots  # noqa: E402 tells Gymnasium the names
from fascicle import fluid  # noqa: E402 as above
from fascicle.core.errors import InvalidInputError  # noqa: E402 as above
from fascicle.robots import Attached, Drive  # noqa: E402 as above
from fascicle.robots.environments import BASELINES, score  # noqa: E402 as above
from fascicle.robots.vector_environment import VectorEnvironment  # noqa: E402 as above


NAMES = sorted(BASELINES)
SUPPLY = 413.7e3


@pytest.fixture(scope="module")
def environments():
    return {name: gymnasium.make(name) for name in NAMES}


@pytest.mark.parametrize("name", NAMES)
def test_gymnasium_check_passes(name, environments):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(environments[name].unwrapped, skip_render_check=True)  # tested below


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


def test_actions_that_are_no_numbers_are_refused(environments):
    one = environments[NAMES[0]].unwrapped
    one.reset(seed=1)
    for action in ([np.nan, 0.0], [np.inf, 0.0], [0.0]):
        with pytest.raises(InvalidInputError) as error:
            one.step(np.array(action, np.float32))
        assert error.value.argument == "action"
    assert one.fluid.consumption == 0.0  # nothing has moved


def test_what_is_measured(environments):
    one = environments[NAMES[0]].unwrapped
    _, before = one.reset(seed=1)
    _, _, _, _, info = one.step(np.array([1.0, -1.0], np.float32))
    assert info["pressures"][0] > before["pressures"][0] and info["pressures"][1] < 0.3 * 413.7e3
    np.testing.assert_allclose(
        info["forces"],
        one.drive.pull(info["pressures"], one.data.actuator_length),
        # the position has moved since, by half a millimeter a step at most
        rtol=0.02,
    )
    # the air of the opened valve alone, at most what a choked one lets through: C ρ₀ P for 10 ms
    assert 0 < info["air"] < 5e-10 * 1.185 * (413.7e3 + 101325) * 0.0101


def test_environments_are_pickled(environments):
    one = environments[NAMES[0]].unwrapped
    one.reset(seed=3)
    one.step(np.array([0.5, -0.5], np.float32))
    twin = pickle.loads(pickle.dumps(one))  # noqa: S301 our own
    action = np.array([0.2, 0.1], np.float32)
    np.testing.assert_array_equal(twin.step(action)[0], one.step(action)[0])
    wrapped = pickle.loads(pickle.dumps(environments[NAMES[0]]))  # noqa: S301 our own
    assert wrapped.spec.id == NAMES[0]


def test_other_render_modes_are_refused(environments):
    with pytest.raises(InvalidInputError) as error:
        type(environments[NAMES[0]].unwrapped)(render_mode="ansi")
    assert error.value.argument == "render_mode"


PICTURE = """
import numpy as np
from fascicle.robots.environments import AntagonisticJoint
one = AntagonisticJoint(render_mode="rgb_array")
one.reset(seed=1)
first = one.render()
for _ in range(20):
    one.step(np.array([1.0, -1.0]))
second = one.render()
assert first.shape == (480, 640, 3) and first.dtype == np.uint8
assert np.mean(first != second) > 0.01, np.mean(first != second)
one.close()
"""


def test_rendering_gives_pictures():
    """In a process of its own: MuJoCo takes its OpenGL from the environment at import."""
    variables = os.environ | {"MUJOCO_GL": "egl"}
    done = subprocess.run(
        [sys.executable, "-c", PICTURE], capture_output=True, text=True, env=variables, timeout=300
    )
    if done.returncode and "EGL" in done.stderr and "AssertionError" not in done.stderr:
        pytest.skip(f"no EGL here: {done.stderr.strip().splitlines()[-1]}")
    assert done.returncode == 0, done.stderr[-2000:]


@pytest.mark.skipif(sys.platform != "linux", reason="there a display is an address")
def test_a_window_without_a_display_is_refused(environments, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    one = type(environments[NAMES[0]].unwrapped)(render_mode="human")
    with pytest.raises(RuntimeError, match="needs a display"):
        one.reset()


@pytest.fixture(scope="module")
def vector():
    return gymnasium.make_vec(NAMES[0], num_envs=3, max_episode_steps=25)


def test_a_vector_of_environments_equals_single_ones(vector, environments):
    one = environments[NAMES[0]].unwrapped
    actions = np.random.default_rng(0).uniform(-1, 1, (12, 3, 2)).astype(np.float32)
    first, _ = vector.reset(seed=4)
    steps = [vector.step(rows) for rows in actions]
    for i in range(3):
        observation, _ = one.reset(seed=4 + i)
        np.testing.assert_array_equal(first[i], observation)
        for action, (rows, rewards, terminated, truncated, info) in zip(
            actions[:, i], steps, strict=True
        ):
            observation, reward, _, _, measured = one.step(action)
            # seen as 32 bits
            np.testing.assert_allclose(rows[i], observation, atol=1e-6)
            np.testing.assert_allclose(rewards[i], reward, rtol=1e-9)
            assert not (terminated[i] or truncated[i])
            for key, value in measured.items():
                np.testing.assert_allclose(info[key][i], value, rtol=1e-8)
    assert vector.observation_space.contains(steps[-1][0])


def test_a_vector_of_environments_resets_after_an_episode(vector):
    vector.reset(seed=1)
    still = np.zeros((3, 2), np.float32)
    steps = [vector.step(still) for _ in range(25)]
    assert steps[-1][3].all() and not np.any([step[3] for step in steps[:-1]])
    rows, rewards, *_, info = vector.step(still + 1.0)
    assert not rewards.any() and (info["position"] == 0).all() and (info["air"] == 0).all()
    assert (info["target"] != steps[-1][4]["target"]).all() and rows.shape == (3, 5)
    assert not vector.step(still)[3].any()


def test_a_vector_of_environments_refuses(vector):
    for argument, call in (
        ("action", lambda: vector.step(np.full((3, 2), np.nan, np.float32))),
        ("action", lambda: vector.step(np.zeros(2, np.float32))),
        ("num_envs", lambda: gymnasium.make_vec(NAMES[0], num_envs=0)),
        ("render_mode", lambda: gymnasium.make_vec(NAMES[0], num_envs=1, render_mode="human")),
    ):
        with pytest.raises(InvalidInputError) as error:
            call()
        assert error.value.argument == argument


def test_any_model_with_other_muscles_in_each_environment(elbow, bundle):
    """Each environment is the single simulation of its own drive, and the goal counts."""
    parts = {"supply": fluid.ConstantSupply(SUPPLY), "chamber": fluid.Isothermal(dead_volume=2e-6),
             "valve": fluid.SonicValve(5e-10, 0.3)}  # fmt: skip
    model, data, drive = elbow(spatial=True, **parts)
    thicker = bundle.motor_units[0].muscle.replace(wall_thickness=1.9e-3)
    other = fs.Bundle([fs.MotorUnit(thicker)], SUPPLY)
    attached = [
        Attached(f"{name}_bundle", name, other, length)
        for name, length in zip(drive.tendons, drive.rest_lengths, strict=True)
    ]
    drives = [drive, Drive.of(model, attached, **parts)]
    many = VectorEnvironment(
        model,
        drives,
        3,
        begin=lambda rng: (np.array([0.6]), np.zeros(1), np.float64(rng.uniform(0.2, 0.4))),
        observe=lambda e: jnp.concatenate([e.data.qpos, e.data.qvel, e.goal[None]]),
        reward=lambda e, _: -jnp.abs(e.data.qpos[0] - e.goal),
        measure=lambda e: {"pressures": e.fluid.pressures, "angle": e.data.qpos},
        pressures=1e5,
        frames=5,
        max_episode_steps=4,
    )
    first, _ = many.reset(seed=2)
    assert first.shape == (3, 3) and len(set(first[:, 2])) == 3
    actions = np.random.default_rng(0).uniform(-1, 1, (4, 3, 2)).astype(np.float32)
    steps = [many.step(rows) for rows in actions]
    for i in range(3):
        data.qpos[:], data.qvel[:] = 0.6, 0.0
        held = drives[i % 2].start(model, data, 1e5)
        for rows, (_, rewards, ended, _, info) in zip(actions, steps, strict=True):
            for _ in range(5):
                held = drives[i % 2].step(model, data, held, rows[i])
            # rounding of MuJoCo's and MJX's solvers
            np.testing.assert_allclose(info["angle"][i], data.qpos, rtol=1e-9)
            np.testing.assert_allclose(info["pressures"][i], held.pressures, rtol=1e-9)
            assert rewards[i] == pytest.approx(-abs(data.qpos[0] - first[i, 2]), rel=1e-6)
            assert not ended[i]
    assert info["angle"][0] != info["angle"][1]
    assert steps[-1][3].all()
    assert (many.step(actions[0])[4]["angle"] == 0.6).all()


@pytest.mark.parametrize(
    ("argument", "changes"),
    [
        ("model", {"model": "arm.xml"}),
        ("drives", {"drives": []}),
        ("drives", {"drives": [None]}),
        ("num_envs", {"num_envs": 0}),
        ("begin", {"begin": lambda _: (np.zeros(1), np.zeros(1))}),
        ("begin", {"begin": lambda _: (np.zeros(3), np.zeros(1), 0.0)}),
        ("observe", {"observe": lambda e: e.data.qpos[0]}),
        ("reward", {"reward": lambda e, _: e.data.qpos}),
    ],
)
def test_a_vector_environments_mistakes_are_refused(elbow, argument, changes):
    model, _, drive = elbow()
    arguments = {
        "model": model,
        "drives": drive,
        "num_envs": 2,
        "begin": lambda _: (np.zeros(1), np.zeros(1), np.float64(0.1)),
        "observe": lambda e: e.data.qpos,
        "reward": lambda e, _: e.data.qpos[0],
    }
    with pytest.raises(InvalidInputError) as error:
        VectorEnvironment(**(arguments | changes)).step(np.zeros((2, 2)))
    assert error.value.argument == argument and "\n" not in str(error.value)


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
