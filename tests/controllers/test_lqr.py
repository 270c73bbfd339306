"""The baselines: open loop, and the linear-quadratic regulator of every walker."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from powered_walker_env import ENVIRONMENTS
from powered_walker_env.controllers import LQR, OpenLoop, evaluate, paired_difference
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.controllers.lqr import TUNED, UNTUNED, tuned_costs
from powered_walker_env.model.powering import SCHEMES
from tests.helpers.derivation import Array

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"
PRESETS = ["toe-off", "hip-torque", "motor-with-stop"]


def linear_map(env: Any, h: float = 1e-4) -> tuple[Array, Array]:
    """(4, 4) and (4, k) of the environment's own steps near the gait, by central differences."""
    task, k = env.task, env.action_space.shape[0]

    def landed(x: Array, a: Array) -> Array:
        env.reset(options={"state": task.gait[0] + task.scale * x})
        *_, info = env.step(a)
        return (np.asarray(info["state"]) - task.gait[0]) / task.scale

    def column(x: Array, a: Array) -> Array:
        return (landed(h * x, h * a) - landed(-h * x, -h * a)) / (2 * h)

    A = [column(x, np.zeros(k)) for x in np.eye(4)]
    return np.array(A).T, np.array([column(np.zeros(4), a) for a in np.eye(k)]).T


def test_open_loop_does_nothing() -> None:
    actions, state = OpenLoop().predict(np.ones((3, 4), np.float32))
    assert state is None
    np.testing.assert_array_equal(actions, np.zeros((3, 2), np.float32))
    assert OpenLoop().predict(np.ones(4))[0].shape == (2,)


@pytest.mark.parametrize("walker", [*ENVIRONMENTS, *PRESETS])
def test_lqr_is_the_best_linear_feedback_of_what_the_environment_does(walker: str) -> None:
    given = {"id": walker} if walker in ENVIRONMENTS else {"id": ROUND_FOOT, "preset": walker}
    env: Any = gym.make(**given, disturbance="none").unwrapped
    A, B = linear_map(env)
    lqr = LQR(env.task, state_cost=1.0, action_cost=0.1)

    def cost(gain: Array) -> float:
        closed, x, total = A - B @ gain, np.eye(4), 0.0
        for _ in range(300):
            total += float(np.sum(x**2) + 0.1 * np.sum((gain @ x) ** 2))
            x = closed @ x
        return total

    assert abs(np.linalg.eigvals(A - B @ lqr.gain)).max() < 1
    rng, least = np.random.default_rng(1), cost(lqr.gain)
    for _ in range(20):
        assert least < cost(lqr.gain + 0.01 * rng.normal(size=lqr.gain.shape))


def test_lqr_acts_linearly_and_clips() -> None:
    lqr = LQR(task_of(ROUND_FOOT))
    x = np.array([[0.1, -0.2, 0.05, 0.1]])
    np.testing.assert_allclose(lqr.predict(x)[0], -x @ lqr.gain.T, rtol=1e-14)
    assert abs(lqr.predict(1e3 * x)[0]).max() == 1.0


def test_lqr_takes_weights_of_every_form() -> None:
    task = task_of(ROUND_FOOT)
    gains = [
        LQR(task, 2.0, 0.5).gain,
        LQR(task, [2.0] * 4, [0.5, 0.5]).gain,
        LQR(task, 2 * np.eye(4), 0.5 * np.eye(2)).gain,
        LQR(task, 4.0, 1.0).gain,  # only the ratio counts
    ]
    for gain in gains[1:]:
        np.testing.assert_allclose(gain, gains[0], rtol=1e-6)


@pytest.mark.parametrize(
    ("weights", "message"),
    [
        ((1.0, 0.0), "action_cost must be positive"),
        ((-1.0, 1.0), "state_cost must not be negative"),
        (([1.0, 2.0], 1.0), "state_cost must be a number, 4 weights or a symmetric 4x4"),
        ((1.0, [[1.0, 2.0], [0.0, 1.0]]), "action_cost must be a number, 2 weights"),
        ((1.0, float("nan")), "action_cost must be a number"),
    ],
)
def test_lqr_refuses_bad_weights(weights: tuple[Any, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        LQR(task_of(ROUND_FOOT), *weights)


def test_lqr_refuses_a_gait_of_two_strides() -> None:
    point = task_of(ROUND_FOOT).gait[0].tolist()
    with pytest.raises(ValueError, match="a gait of one stride, got one of 2"):
        LQR(task_of(ROUND_FOOT, gait=[point, point]))


@pytest.mark.parametrize(
    ("env_id", "margin"),
    [
        (ROUND_FOOT, 50),
        ("PoweredWalker-v0", 15),
        ("PoweredWalkerAsPublished-v1", 1),
        ("PoweredWalkerKneed-v0", 20),
    ],
)
def test_lqr_beats_the_open_loop_under_the_same_pushes(env_id: str, margin: float) -> None:
    first = evaluate(OpenLoop(), env_id, 80)
    second = evaluate(LQR(task_of(env_id)), env_id, 80)
    assert paired_difference(second.strides, first.strides).low > margin


def test_every_registered_walker_has_weights_that_were_tuned() -> None:
    for env_id, (name, _) in ENVIRONMENTS.items():
        assert tuned_costs(task_of(env_id)) == TUNED[name]
    for name in ("toe-off", "hip-torque"):
        task = task_of(ROUND_FOOT, preset=name)
        assert tuned_costs(task) == UNTUNED
        assert LQR(task).gain.shape == (len(SCHEMES[name].numbers), 4)
