"""Controllers of an environment as closed loops of the stride map."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from powered_walker_env import PoweredWalkerVectorEnv, find_gait
from powered_walker_env.controllers.policies import policy_of
from powered_walker_env.poincare import Gait, StrideMap
from powered_walker_env.poincare.regions.basins import basin
from powered_walker_env.poincare.stability.robustness import gait_sensitivity
from tests.helpers.derivation import Array

ENV: Any = gym.make("PoweredWalkerRoundFoot-v0", disturbance="none")
TASK = ENV.unwrapped.task
GAIN = np.array([[0.03, -0.05, 0.02, 0.04], [0.05, -0.03, 0.06, 0.02]])


class Linear:
    """a = G observation, in the precision asked for."""

    def __init__(self, precision: type, gain: Array = GAIN) -> None:
        self.precision, self.gain = precision, gain

    def predict(self, observation: Any, *, deterministic: bool = True) -> tuple[Any, None]:
        assert deterministic
        return (np.asarray(observation) @ self.gain.T).astype(self.precision), None


def by_differences(gait: Gait, h: float) -> Array:
    """(4, 4) Jacobian of the closed loop by central differences of whole strides."""
    closed, x = StrideMap(gait.params, gait.control), np.array(gait.state)
    ends = closed(np.concatenate([x + h * np.eye(4), x - h * np.eye(4)]))
    return ((ends[:4] - ends[4:]) / (2 * h)).T


@pytest.mark.parametrize(("precision", "close"), [(np.float64, 1e-8), (np.float32, 1e-4)])
def test_a_linear_controller_closes_the_loop_with_a_plus_b_k(precision: type, close: float) -> None:
    policy = policy_of(ENV, Linear(precision))
    gait = find_gait(TASK.params, policy, TASK.gait[0])
    nominal = find_gait(TASK.params, TASK.control, TASK.gait[0])
    K = TASK.half_range[:, np.newaxis] * GAIN / TASK.scale
    expected = nominal.jacobian + nominal.control_jacobian @ K
    np.testing.assert_allclose(gait.jacobian, expected, atol=close)


def test_a_controller_meets_what_the_environment_would_show_it() -> None:
    policy, state = policy_of(ENV, Linear(np.float64)), TASK.gait[0] + 0.01
    observation, _ = ENV.reset(options={"state": state})
    action, _ = Linear(np.float64).predict(observation)
    control = ENV.unwrapped.control(action)
    np.testing.assert_allclose(
        policy(state[np.newaxis])[0], [control.switch_angle, control.stall_torque], rtol=1e-6
    )
    _, _, _, _, info = ENV.step(action)
    ours = StrideMap(TASK.params, policy, 1e-8)(state[np.newaxis])[0]
    np.testing.assert_allclose(ours, info["state"], atol=1e-5)


def test_clipped_actions_and_observations_have_no_derivative() -> None:
    strong = policy_of(TASK, Linear(np.float64, 100.0 * GAIN))
    away = TASK.gait[:1] + TASK.scale
    assert not strong.derivative(away).any()
    np.testing.assert_allclose(np.abs(strong(away) - TASK.nominal), [TASK.half_range])
    weak = policy_of(TASK, Linear(np.float64, 1e-3 * GAIN))
    beyond = TASK.gait[:1] + TASK.scale * [30.0, 0.0, 0.0, 0.0]
    assert not weak.derivative(beyond)[0, :, 0].any() and weak.derivative(beyond)[0, :, 1].all()


def test_any_environment_of_the_package_or_its_task_will_do() -> None:
    batch = PoweredWalkerVectorEnv(2, preset="round-foot")
    for env in (ENV, ENV.unwrapped, batch, TASK):
        assert policy_of(env, Linear(np.float64)).task.params == TASK.params
    with pytest.raises(TypeError, match="env must be an environment of this package"):
        policy_of(object(), Linear(np.float64))
    assert policy_of(ENV, lambda x: 0.1 * x[:, :2])(TASK.gait[:1]).shape == (1, 2)
    with pytest.raises(TypeError, match="controller must have a method predict"):
        policy_of(ENV, "lqr")


def test_controllers_with_a_memory_or_of_another_task_are_refused() -> None:
    class Remembers(Linear):
        def predict(self, observation: Any, *, deterministic: bool = True) -> tuple[Any, Any]:
            return super().predict(observation)[0], (np.zeros(2),)

    states = TASK.gait[:1]
    with pytest.raises(ValueError, match="controller must have no memory"):
        policy_of(ENV, Remembers(np.float64))(states)
    with pytest.raises(ValueError, match=r"actions of shape \(1, 2\)"):
        policy_of(ENV, Linear(np.float64, np.ones((3, 4))))(states)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize("name", ["PPO", "SAC", "TD3"])
def test_a_network_in_double_precision_has_exact_multipliers(name: str) -> None:
    sb3 = pytest.importorskip("stable_baselines3")
    from powered_walker_env.controllers.stable_baselines import double_precision

    size = {"net_arch": [8, 8]}
    model = getattr(sb3, name)("MlpPolicy", ENV, policy_kwargs=size, seed=3, device="cpu")
    _quieten(model.policy)
    observations = np.random.default_rng(0).normal(0, 0.5, (5, 4))
    controller = double_precision(model)
    ours, _ = controller.predict(observations)
    theirs, _ = model.predict(observations.astype(np.float32), deterministic=True)
    assert ours.dtype == np.float64
    np.testing.assert_allclose(ours, theirs, atol=1e-6)
    gait = find_gait(TASK.params, policy_of(ENV, controller), TASK.gait[0])
    expected = np.linalg.eigvals(by_differences(gait, 1e-6))
    expected = expected[np.argsort(-abs(expected))][:3]
    np.testing.assert_allclose(abs(gait.multipliers), abs(expected), atol=1e-6)
    plain = policy_of(ENV, model)  # single precision, by differences
    np.testing.assert_allclose(
        plain.derivative(TASK.gait[:1]),
        policy_of(ENV, controller).derivative(TASK.gait[:1]),
        atol=2e-4 * TASK.half_range[1] / TASK.scale[0],
    )


def _quieten(policy: Any) -> None:
    """Scale an untrained actor's last layer down: it would throw the walker over."""
    import torch

    actor = policy.action_net if hasattr(policy, "action_net") else policy.actor.mu
    last = [layer for layer in actor.modules() if isinstance(layer, torch.nn.Linear)][-1]
    with torch.no_grad():
        last.weight *= 0.05
        last.bias *= 0.0


def test_closed_loops_have_basins_and_sensitivity_norms() -> None:
    policy = policy_of(ENV, Linear(np.float64))
    gait = find_gait(TASK.params, policy, TASK.gait[0])
    assert gait.stable
    norm = gait_sensitivity(gait, {"stance_rate": 0.02, "swing_rate": 0.02}).norm
    assert 0 < norm < 1
    starts = np.random.default_rng(1).normal(gait.state, 0.01, (20, 4))
    found = basin(TASK.params, policy, starts, gaits=[gait], backend="threading")
    assert found.attracted_share > 0
