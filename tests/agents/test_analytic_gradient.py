"""Training through the walker: exact gradients, fewer strides, policies that can be kept."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from agents.gradient_learner import ALGO, GradientLearner, Settings
from agents.own_training import read_settings, train
from agents.segments import Segment, segment_loss, walk_segment
from powered_walker_env import StrideMap
from powered_walker_env.controllers import (
    OpenLoop,
    evaluate,
    load_controller,
    load_network,
    policy_of,
    save_network,
)
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.envs.task import Task
from powered_walker_env.torch import differentiable_strides

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"
COST = torch.tensor([0.4, 0.1, 1.0, 0.1], dtype=torch.float64)
TRUST = 0.3
SMALL = Settings(ROUND_FOOT, n_timesteps=320, n_envs=8, n_steps=4, n_epochs=4, episodes=3)


def round_foot(**kwargs: Any) -> Task:
    return task_of(ROUND_FOOT, **kwargs)


def a_policy(seed: int = 0, size: float = 0.1) -> torch.nn.Module:
    rng = np.random.default_rng(seed)
    policy = torch.nn.Linear(4, 2, dtype=torch.float64)
    with torch.no_grad():
        policy.weight.copy_(torch.from_numpy(rng.normal(0.0, size, (2, 4))))
        policy.bias.zero_()
    return policy


def a_segment(task: Task, policy: torch.nn.Module, count: int = 6, strides: int = 3) -> Segment:
    rng = np.random.default_rng(1)
    start = torch.from_numpy(rng.normal(0.0, 0.03, (count, 4)))
    pushes = torch.from_numpy(rng.normal(0.0, 0.03, (strides, count, 4)))
    return walk_segment(task, policy, start, pushes)


def through_the_walker(task: Task, policy: torch.nn.Module, segment: Segment) -> torch.Tensor:
    """The loss of the same walk by backpropagation through the strides themselves."""
    gait, scale, nominal, reach = map(
        torch.from_numpy, (task.gait[0], task.scale, task.nominal, task.half_range)
    )
    total = torch.zeros((), dtype=torch.float64)
    observation = segment.observations[0]
    for k in range(len(segment.walking)):
        found = differentiable_strides(
            gait + observation * scale, nominal + policy(observation) * reach, task.params,
            rtol=1e-8,
        )  # fmt: skip
        push = segment.landed[k] - (found.state.detach() - gait) / scale
        observation = (found.state - gait) / scale + push
        total = total + (torch.sqrt(1 + (COST * observation**2).sum(1)) - 1).mean()
    return total


def test_a_segment_has_the_loss_and_the_gradient_of_the_walk_itself() -> None:
    task, policy = round_foot(), a_policy()
    segment = a_segment(task, policy)
    assert segment.walking.all() and segment.actions.abs().max() < 1
    parameters = list(policy.parameters())
    by_models = segment_loss(policy, segment, COST, TRUST)
    exact = through_the_walker(task, policy, segment)
    torch.testing.assert_close(by_models, exact, rtol=1e-12, atol=0)
    for one, other in zip(
        torch.autograd.grad(by_models, parameters),
        torch.autograd.grad(exact, parameters),
        strict=True,
    ):
        torch.testing.assert_close(one, other, rtol=1e-9, atol=1e-12)


def test_another_policy_on_an_old_segment_is_right_to_first_order() -> None:
    task, policy = round_foot(), a_policy()
    segment = a_segment(task, policy)
    gaps = []
    for size in (1e-2, 1e-3):
        other = a_policy()
        with torch.no_grad():
            other.weight += size * torch.from_numpy(np.random.default_rng(2).normal(size=(2, 4)))
        fresh = a_segment(task, other)
        change = segment_loss(other, segment, COST, TRUST) - segment_loss(other, fresh, COST, TRUST)
        gaps.append(abs(change.item()))
    assert gaps[1] < 0.03 * gaps[0]  # the error is of second order: a hundredth


def test_a_fall_drops_out_of_the_loss_from_there_on() -> None:
    task, policy = round_foot(), a_policy(size=0.0)
    start = torch.zeros((2, 4), dtype=torch.float64)
    start[1, 2] = -15.0  # it falls backward
    segment = walk_segment(task, policy, start, torch.zeros((3, 2, 4), dtype=torch.float64))
    assert segment.walking.tolist() == [[True, False]] * 3
    assert segment.strides == 6
    loss = segment_loss(policy, segment, COST, TRUST)
    alone = segment_loss(policy, Segment(*(part[:, :1] for part in segment)), COST, TRUST)
    assert loss.item() == pytest.approx(alone.item() / 2)
    (gradient,) = torch.autograd.grad(loss, policy.weight)
    assert gradient.isfinite().all()


def test_walkers_whose_actions_changed_too_much_do_not_count() -> None:
    task, policy = round_foot(), a_policy(size=0.0)
    segment = a_segment(task, policy)
    with torch.no_grad():
        policy.bias += 0.5
    assert segment_loss(policy, segment, COST, TRUST).item() == 0.0


def test_a_short_training_walks_much_longer_than_the_open_loop(tmp_path: Path) -> None:
    settings = read_settings(Settings, ALGO, ROUND_FOOT)
    learner = GradientLearner(replace(settings, n_timesteps=1600, n_envs=8, episodes=5))
    history = train(learner, tmp_path / "run", quiet=True)
    assert learner.strides <= 1600
    assert history[0]["steps"] == 0 and history[-1]["steps"] == learner.strides
    name, controller = load_controller(tmp_path / "run", round_foot(), ROUND_FOOT)
    assert name == "analytic gradient run"
    learnt = evaluate(controller, ROUND_FOOT, 60).strides.mean()
    baseline = evaluate(OpenLoop(), ROUND_FOOT, 60).strides.mean()
    assert learnt > baseline + 20  # 8 and over 50 in most


def test_it_begins_as_the_open_loop_and_walks_no_stride_too_many() -> None:
    learner = GradientLearner(SMALL)
    observations = np.random.default_rng(0).normal(size=(5, 4))
    assert not learner.network().predict(observations)[0].any()
    learner.update()
    assert learner.strides == 8 * 4
    assert learner.network().predict(observations)[0].any()


def test_the_network_is_the_policy_and_knows_its_derivative(tmp_path: Path) -> None:
    learner = GradientLearner(replace(SMALL, seed=1))
    for _ in range(3):
        learner.update()
    save_network(learner.network(), tmp_path / "kept.npz")
    network = load_network(tmp_path / "kept.npz")
    assert network.settings["env_id"] == ROUND_FOOT
    observations = torch.from_numpy(np.random.default_rng(0).normal(0, 0.3, (7, 4)))
    wanted = learner.policy(observations).clamp(-1, 1).detach().numpy()
    np.testing.assert_allclose(network.predict(observations.numpy())[0], wanted, rtol=1e-12)
    jacobian = torch.autograd.functional.jacobian(
        lambda x: learner.policy(x).sum(0), observations, vectorize=True
    )
    np.testing.assert_allclose(
        network.derivative(observations.numpy()), jacobian.permute(1, 0, 2), rtol=1e-12
    )


def test_the_laboratory_takes_the_policy_as_it_is() -> None:
    learner = GradientLearner(SMALL)
    learner.update()
    task = round_foot()
    closed = StrideMap(task.params, policy_of(task, learner.network()))
    point, h = closed.differentiate(task.gait[0]), 1e-6
    moved = [task.gait[0] + sign * h * np.eye(4)[2] for sign in (1, -1)]
    ahead, back = closed(np.array(moved))
    np.testing.assert_allclose(point.by_state[:, 2], (ahead - back) / (2 * h), atol=1e-4)
