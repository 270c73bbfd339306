"""Open loop, the linear-quadratic regulator, and saved models."""

from __future__ import annotations

import shutil
import zipfile
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from stable_baselines3 import A2C, PPO, SAC, TD3

from agents.algorithms import algorithm_of
from agents.command import UserError, make_walkers
from agents.controllers import (
    LQR,
    OpenLoop,
    linear_step_map,
    load_controller,
    lqr_for,
    make_controller,
)
from agents.evaluate import evaluate
from agents.statistics import paired_difference
from agents.tune_lqr import TUNING_SEED, search
from powered_walker_env import ENVIRONMENTS
from powered_walker_env.envs.task import Task
from powered_walker_env.sb3 import PoweredWalkerVecEnv

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"


def small() -> dict[str, Any]:
    """Policy arguments; SB3 adds to the dictionary that it is given."""
    return {"net_arch": [8]}


def task_of(env_id: str = ROUND_FOOT, **kwargs: object) -> Task:
    return make_walkers(env_id, 1, **kwargs).task


def save_ppo(path: Path) -> PPO:
    env = PoweredWalkerVecEnv(ROUND_FOOT, 1)
    model = PPO("MlpPolicy", env, seed=0, policy_kwargs=small(), device="cpu")
    model.save(path)
    return model


def test_open_loop_does_nothing() -> None:
    actions, state = OpenLoop().predict(np.ones((3, 4), np.float32))
    assert state is None
    np.testing.assert_array_equal(actions, np.zeros((3, 2), np.float32))
    assert OpenLoop().predict(np.ones(4))[0].shape == (2,)


@pytest.mark.parametrize("env_id", ENVIRONMENTS)
def test_linear_map_is_what_the_environment_does_near_the_gait(env_id: str) -> None:
    env = gym.make(env_id, disturbance="none").unwrapped
    task: Task = env.task
    A, B = linear_step_map(task)
    rng = np.random.default_rng(0)
    for size in (1e-3, 1e-4):
        x, a = size * rng.normal(size=4), size * rng.normal(size=2)
        env.reset(options={"state": task.gait[0] + task.scale * x})
        *_, info = env.step(a)
        landed = (info["state"] - task.gait[0]) / task.scale
        np.testing.assert_allclose(landed, A @ x + B @ a, atol=50 * 100 * size**2 + 1e-7)


@pytest.mark.parametrize("env_id", ENVIRONMENTS)
def test_lqr_is_the_best_linear_feedback(env_id: str) -> None:
    lqr = LQR(task_of(env_id), state_cost=1.0, action_cost=0.1)

    def cost(gain: np.ndarray) -> float:
        closed, x, total = lqr.A - lqr.B @ gain, np.eye(4), 0.0
        for _ in range(300):
            total += float(np.sum(x**2) + 0.1 * np.sum((gain @ x) ** 2))
            x = closed @ x
        return total

    assert abs(np.linalg.eigvals(lqr.A - lqr.B @ lqr.gain)).max() < 1
    rng = np.random.default_rng(1)
    for _ in range(20):
        assert cost(lqr.gain) < cost(lqr.gain + 0.01 * rng.normal(size=(2, 4)))


def test_lqr_acts_linearly_and_clips() -> None:
    lqr = LQR(task_of())
    x = np.array([[0.1, -0.2, 0.05, 0.1]], np.float32)
    np.testing.assert_allclose(lqr.predict(x)[0], -x @ lqr.gain.T, atol=1e-6)
    assert abs(lqr.predict(1e3 * x)[0]).max() == 1.0
    assert lqr.predict(x)[0].dtype == np.float32


def test_lqr_takes_weights_of_every_form() -> None:
    gains = [
        LQR(task_of(), 2.0, 0.5).gain,
        LQR(task_of(), [2.0] * 4, [0.5, 0.5]).gain,
        LQR(task_of(), 2 * np.eye(4), 0.5 * np.eye(2)).gain,
        LQR(task_of(), 4.0, 1.0).gain,  # only the ratio counts
    ]
    for gain in gains[1:]:
        np.testing.assert_allclose(gain, gains[0], rtol=1e-6)


@pytest.mark.parametrize(
    ("weights", "message"),
    [
        ((1.0, 0.0), "action_cost must be positive"),
        ((-1.0, 1.0), "state_cost must be positive"),
        (([1.0, 2.0], 1.0), "state_cost must be a number, 4 numbers or a symmetric 4x4"),
        ((1.0, [[1.0, 2.0], [0.0, 1.0]]), "action_cost must be a number, 2 numbers"),
        ((1.0, float("nan")), "action_cost must be a number"),
    ],
)
def test_lqr_refuses_bad_weights(weights: tuple[object, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        LQR(task_of(), *weights)


def test_lqr_refuses_a_gait_of_two_strides() -> None:
    point = task_of().gait[0].tolist()
    with pytest.raises(ValueError, match="a gait of one stride, got one of 2"):
        LQR(task_of(gait=[point, point]))


@pytest.mark.parametrize(
    ("env_id", "margin"),
    [(ROUND_FOOT, 50), ("PoweredWalker-v0", 15), ("PoweredWalkerAsPublished-v0", 1)],
)
def test_lqr_beats_the_open_loop_under_the_same_pushes(env_id: str, margin: float) -> None:
    first = evaluate(OpenLoop(), env_id, 80)
    second = evaluate(lqr_for(env_id, task_of(env_id)), env_id, 80)
    assert paired_difference(second.strides, first.strides).low > margin


def test_the_weights_come_from_the_configuration() -> None:
    known = lqr_for(f"powered_walker_env:{ROUND_FOOT}", task_of())
    assert known.Q[2, 2] == 1.0
    assert (known.gain != LQR(task_of()).gain).any()
    np.testing.assert_array_equal(lqr_for("Mine-v0", task_of()).gain, LQR(task_of()).gain)


def test_a_search_does_not_lose_what_it_starts_from() -> None:
    weights, strides = search(ROUND_FOOT, trials=2, episodes=20, seed=0)
    start = evaluate(lqr_for(ROUND_FOOT, task_of()), ROUND_FOOT, 20, TUNING_SEED)
    assert len(weights) == 6
    assert max(weights[:4]) == pytest.approx(1.0)
    assert strides >= start.strides.mean() - 0.5  # it starts from weights of at least 0.001


def test_a_saved_model_acts_as_before_it_was_saved(tmp_path: Path) -> None:
    model = save_ppo(tmp_path / "model.zip")
    name, loaded = load_controller(tmp_path / "model.zip", ROUND_FOOT)
    assert name.startswith("PPO")
    x = np.random.default_rng(0).normal(size=(5, 4)).astype(np.float32)
    actions, _ = loaded.predict(x, deterministic=True)
    np.testing.assert_array_equal(actions, model.predict(x, deterministic=True)[0])


@pytest.mark.parametrize(("model_class", "name"), [(A2C, "a2c"), (SAC, "sac"), (TD3, "td3")])
def test_the_algorithm_of_a_model_is_recognised(
    model_class: type[A2C | SAC | TD3], name: str, tmp_path: Path
) -> None:
    env = PoweredWalkerVecEnv(ROUND_FOOT, 1)
    kwargs = {} if model_class is A2C else {"buffer_size": 10}
    model = model_class("MlpPolicy", env, policy_kwargs=small(), device="cpu", **kwargs)
    model.save(tmp_path / "model.zip")
    assert algorithm_of(tmp_path / "model.zip") == name
    assert type(load_controller(tmp_path / "model.zip")[1]) is model_class


def test_a_missing_model_is_named() -> None:
    with pytest.raises(UserError, match=r"no model file 'nowhere/model\.zip'; train one"):
        load_controller(Path("nowhere/model.zip"))
    with pytest.raises(UserError, match=r"controllers are 'open-loop', 'lqr', .* got 'pid'"):
        make_controller("pid", task_of(), ROUND_FOOT)


def test_a_folder_without_a_model_is_named(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"no model file .*best_model\.zip"):
        load_controller(tmp_path)


def test_damaged_models_are_named(tmp_path: Path) -> None:
    save_ppo(tmp_path / "good.zip")
    content = (tmp_path / "good.zip").read_bytes()
    bad = tmp_path / "bad.zip"
    for damaged in (b"", b"no zip at all", content[: len(content) // 2]):
        bad.write_bytes(damaged)
        with pytest.raises(UserError, match=r"bad\.zip' is not a saved model .* or is damaged"):
            load_controller(bad)


def test_a_model_without_its_weights_is_named(tmp_path: Path) -> None:
    save_ppo(tmp_path / "good.zip")
    with (
        zipfile.ZipFile(tmp_path / "good.zip") as good,
        zipfile.ZipFile(tmp_path / "bad.zip", "w") as bad,
    ):
        bad.writestr("data", good.read("data"))
    with pytest.raises(UserError, match=r"bad\.zip' cannot be loaded"):
        load_controller(tmp_path / "bad.zip")


def test_a_zip_of_something_else_is_named(tmp_path: Path) -> None:
    (tmp_path / "notes").mkdir()
    (tmp_path / "notes" / "a.txt").write_text("no model")
    shutil.make_archive(str(tmp_path / "notes"), "zip", tmp_path / "notes")
    with pytest.raises(UserError, match="is not a saved model"):
        load_controller(tmp_path / "notes.zip")


def test_a_model_of_another_task_is_refused(tmp_path: Path) -> None:
    model = PPO("MlpPolicy", "Pendulum-v1", policy_kwargs=small(), device="cpu")
    model.save(tmp_path / "pendulum.zip")
    with pytest.raises(UserError, match=r"trained on another task: .* \(3,\) and \(1,\)"):
        load_controller(tmp_path / "pendulum.zip")
