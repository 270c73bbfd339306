"""Trained policies that come with the package: found by name, as good as they say, no better."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from agents.evaluate import main as evaluate_command
from agents.study.cells import LEARNERS as STUDIED
from agents.study.policies import MOST
from powered_walker_env.controllers import (
    Optimal,
    evaluate,
    load_controller,
    load_network,
    shipped_learners,
    shipped_policies,
    shipped_policy,
)
from powered_walker_env.controllers import shipped as room
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.controllers.shipped import FOLDER, LEARNERS, environment_of
from powered_walker_env.envs.registration import ENVIRONMENTS

ROUND_FOOT, THESIS = "PoweredWalkerRoundFoot-v0", "PoweredWalker-v0"
THERE = shipped_policies()
CHANCE = 0.05  # share of the walks that another processor's rounding may make other ones


def test_the_files_are_those_declared() -> None:
    assert [path.name for path in sorted(FOLDER.glob("*"))] == sorted([*THERE, room.DECLARED])
    assert sum(path.stat().st_size for path in FOLDER.glob("*")) < MOST
    assert set(shipped_learners()) <= set(STUDIED)
    for env_id in ENVIRONMENTS:
        assert "ppo" in shipped_learners(env_id)


@pytest.mark.parametrize("name", THERE)
def test_a_policy_walks_the_episodes_that_it_says(name: str) -> None:
    about = THERE[name]
    env_id, learner, first = (about[each] for each in ("env_id", "learner", "first"))
    assert name == room.policy_name(env_id, learner)
    network = load_network(FOLDER / name)
    assert network.settings["env_id"] == env_id
    assert all(weights.astype(np.float32).astype(float).tolist() == weights.tolist()
               for weights, _ in network.layers)  # fmt: skip
    label, controller = load_controller(learner, task_of(env_id), env_id)
    assert label == LEARNERS[learner]
    found = evaluate(controller, env_id, len(first["strides"]), about["episode_seed"])
    same = (found.strides == first["strides"]) & (np.abs(found.returns - first["returns"]) <= 1e-3)
    assert np.mean(~same) <= CHANCE


@pytest.mark.slow
@pytest.mark.parametrize("name", THERE)
def test_a_policy_scores_what_it_says(name: str) -> None:
    about = THERE[name]
    network = load_network(FOLDER / name)
    found = evaluate(network, about["env_id"], about["episodes"], about["episode_seed"])
    for what, ours in (("strides", found.mean_strides), ("return", found.mean_return)):
        mean, low, high = about[what]
        assert ours.mean == pytest.approx(mean, abs=CHANCE * (high - low) + 0.01)


@pytest.mark.parametrize("name", THERE)
def test_no_policy_beats_the_optimum_by_more_than_its_error(name: str) -> None:
    """Where it is resolved; elsewhere the table is a lower bound, which may be beaten."""
    about = THERE[name]
    found = Optimal(task_of(about["env_id"])).found
    mean, low, high = about["return"]
    assert low <= mean <= high and about["episodes"] >= 1000
    if found.resolved:
        assert low < found.value + found.error
    assert low < found.upper


def test_the_optimum_is_resolved_where_pages_say_so() -> None:
    for env_id in ENVIRONMENTS:
        assert Optimal(task_of(env_id)).found.resolved, env_id
        rough = Optimal(task_of(env_id, disturbance="rough")).found
        assert rough.resolved == (env_id != "PoweredWalkerAsPublished-v1"), env_id


def test_the_environment_is_found_by_its_id_and_by_the_task() -> None:
    own = load_network(FOLDER / room.policy_name(ROUND_FOOT, "ppo"))
    seen = np.random.default_rng(0).normal(size=(20, 4))
    for env_id in (ROUND_FOOT, f"powered_walker_env:{ROUND_FOOT}", "Mine-v0", None):
        for disturbance in ("none", "rough", "medium-ground"):
            task = task_of(ROUND_FOOT, disturbance=disturbance)
            found = shipped_policy("ppo", task, env_id)
            np.testing.assert_array_equal(found.predict(seen)[0], own.predict(seen)[0])
    for env_id in ENVIRONMENTS:
        assert environment_of(task_of(env_id)) == env_id


@pytest.mark.parametrize(
    ("env_id", "kwargs", "message"),
    [
        (ROUND_FOOT, {"preset": "toe-off"}, "got another walker: train one with agents.train"),
        (ROUND_FOOT, {"control": (2.8, 3000.0)}, "got another control: "),
        (ROUND_FOOT, {"action_range": (0.1, 0.1)}, r"another range of actions, \[0.1, "),
        (
            None,
            {"preset": "toe-off"},
            "no trained 'ppo' comes with the package for this task, only ",
        ),
        ("Mine-v0", {"preset": "hip-torque"}, "no trained 'ppo' .* for Mine-v0, only for Pow"),
    ],
)
def test_a_task_without_a_policy_says_what_to_do(
    env_id: str | None, kwargs: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        load_controller("ppo", task_of(ROUND_FOOT, **kwargs), env_id)


def test_a_learner_without_a_policy_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ValueError, match=r"learner must be one of ppo, .*, got 'td3'"):
        shipped_policy("td3", task_of(ROUND_FOOT))
    monkeypatch.setattr(room, "shipped_policies", dict)
    with pytest.raises(ValueError, match=f"for {ROUND_FOOT}, nor for any other environment"):
        shipped_policy("sac", task_of(ROUND_FOOT), ROUND_FOOT)
    assert shipped_learners() == []


def test_the_command_takes_them_by_name(capsys: pytest.CaptureFixture[str]) -> None:
    names = ["open-loop", "lqr", "ppo", "optimal"]
    evaluate_command([*names, "--env", ROUND_FOOT, "--episodes", "20"])
    said = capsys.readouterr().out
    assert all(label in said for label in ("open loop", "LQR", "PPO", "optimum", "score"))


def test_they_need_no_learning_library() -> None:
    program = (
        "import sys, powered_walker_env.controllers as room\n"
        "task = room.evaluation.task_of('PoweredWalker-v0')\n"
        "room.load_controller('ppo', task, 'PoweredWalker-v0')\n"
        "print([name for name in ('torch', 'stable_baselines3', 'agents') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.stdout, done.returncode) == ("[]\n", 0)
