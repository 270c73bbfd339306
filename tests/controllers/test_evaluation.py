"""Evaluations: seeded, paired, with confidence intervals that cover."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.wrappers import TransformReward

from powered_walker_env import ENVIRONMENTS, Outcome, PoweredWalkerEnv, PoweredWalkerVectorEnv
from powered_walker_env.controllers import (
    Evaluation,
    OpenLoop,
    comparison,
    comparison_text,
    evaluate,
    mean_estimate,
    paired_difference,
    share_estimate,
)
from powered_walker_env.controllers.evaluation import task_of, walk_episodes, walkers_of

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"
OWN = "OwnWalker-v0"


class Wobble:
    """A controller with a memory: its actions depend on how often it was asked."""

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, **_: Any
    ) -> tuple[Any, Any]:
        count = 0 if state is None else state
        assert episode_start.all() == (count == 0)
        return np.full((len(observation), 2), 0.1 * (-1) ** count), count + 1


class Stubborn(PoweredWalkerEnv):
    """An environment of one's own that walks in its own way."""

    def step(self, action: Any) -> Any:
        return super().step(0 * action)


@pytest.fixture
def own_id() -> Iterator[str]:
    """README's example: a registration with arguments, and without a vector entry point."""
    gym.register(
        id=OWN,
        entry_point="powered_walker_env:PoweredWalkerEnv",
        max_episode_steps=30,
        kwargs={"preset": "round-foot", "disturbance": {"push": 0.05}, "reward": "contraction"},
    )
    yield OWN
    gym.registry.pop(OWN)


def same(first: Evaluation, second: Evaluation) -> bool:
    names = ("strides", "returns", "outcomes")
    return all(np.array_equal(getattr(first, n), getattr(second, n)) for n in names)


def by_hand(env: gym.Env[Any, Any], seed: int) -> tuple[int, float, int, list[float]]:
    """Strides, return, last outcome and rewards of one open-loop episode, stride by stride."""
    env.reset(seed=seed)
    rewards, strides = [], 0
    while True:
        action = np.zeros(env.action_space.shape or (), np.float32)
        _, reward, terminated, truncated, info = env.step(action)
        rewards.append(float(reward))
        strides += not terminated
        if terminated or truncated:
            return strides, sum(rewards), int(info["outcome"]), rewards


@pytest.mark.parametrize("env_id", ENVIRONMENTS)
def test_episode_i_is_the_single_environment_with_that_seed(env_id: str) -> None:
    result = evaluate(OpenLoop(), env_id, episodes=8, seed=40)
    for i in range(8):
        strides, total, outcome, _ = by_hand(gym.make(env_id), 40 + i)
        assert (result.strides[i], result.outcomes[i]) == (strides, outcome)
        assert result.returns[i] == pytest.approx(total, rel=1e-12)


@pytest.mark.parametrize("reward", ["contraction", "deviation"])
def test_the_reward_of_the_last_stride_counts(reward: str) -> None:
    """A fall costs −10 in `contraction`; a walk to the limit earns its last 1 in `deviation`."""
    level = "rough" if reward == "contraction" else "none"
    arguments: dict[str, Any] = {"reward": reward, "disturbance": level}
    result = evaluate(OpenLoop(), ROUND_FOOT, 6, 7, **arguments)
    for i in range(6):
        *_, outcome, rewards = by_hand(gym.make(ROUND_FOOT, **arguments), 7 + i)
        assert abs(rewards[-1]) > 0.9
        assert (outcome == Outcome.WALKED) == (level == "none")
        assert result.returns[i] == pytest.approx(sum(rewards), rel=1e-12)
        assert result.returns[i] != pytest.approx(sum(rewards[:-1]), rel=1e-6)


def test_the_same_call_gives_the_same_numbers() -> None:
    assert same(evaluate(OpenLoop(), ROUND_FOOT, 20, 1), evaluate(OpenLoop(), ROUND_FOOT, 20, 1))
    assert not same(evaluate(OpenLoop(), ROUND_FOOT, 20, 1), evaluate(OpenLoop(), ROUND_FOOT, 20))


def test_an_episode_does_not_depend_on_the_others() -> None:
    many, few = evaluate(OpenLoop(), ROUND_FOOT, 30, 7), evaluate(OpenLoop(), ROUND_FOOT, 1, 20)
    assert (many.strides[13], many.returns[13]) == (few.strides[0], few.returns[0])


def test_a_walker_that_never_falls_walks_to_the_limit() -> None:
    result = evaluate(OpenLoop(), ROUND_FOOT, 3, disturbance="none")
    assert result.limit == 100
    assert result.survived == 3
    assert result.strides.tolist() == [100] * 3
    assert result.ends() == {"walked": 3}
    assert result.disturbance == {}
    np.testing.assert_allclose(result.returns, 100, atol=1e-3)


def test_walkers_with_the_same_seed_walk_the_same_episode() -> None:
    envs, _ = walkers_of(ROUND_FOOT, 4)
    walked = walk_episodes(OpenLoop(), envs, [7, 8, 7, 8])
    assert walked.strides[:2].tolist() == walked.strides[2:].tolist()
    assert walked.returns[:2].tolist() == walked.returns[2:].tolist()
    alone = evaluate(OpenLoop(), ROUND_FOOT, 2, 7)
    np.testing.assert_array_equal(walked.strides[:2], alone.strides)
    with pytest.raises(ValueError, match="must have max_episode_steps, or episodes never end"):
        walk_episodes(OpenLoop(), PoweredWalkerVectorEnv(2), 0)


def test_every_episode_ends_somehow() -> None:
    result = evaluate(Wobble(), "PoweredWalker-v0", 40, disturbance="rough")
    assert sum(result.ends().values()) == 40
    assert set(result.ends()) <= {outcome.label for outcome in Outcome}
    assert ((result.strides == 100) == (result.outcomes == Outcome.WALKED)).all()


def test_an_environment_of_ones_own_is_walked_as_it_is_registered(own_id: str) -> None:
    result = evaluate(OpenLoop(), own_id, 6, 3)
    assert (result.limit, result.disturbance) == (30, {"push": 0.05})
    for i in range(6):
        strides, total, outcome, _ = by_hand(gym.make(own_id), 3 + i)
        assert (result.strides[i], result.outcomes[i]) == (strides, outcome)
        assert result.returns[i] == pytest.approx(total, rel=1e-12)
    given = evaluate(OpenLoop(), gym.make(own_id), 6, 3)
    assert same(result, given)
    milder = evaluate(OpenLoop(), own_id, 6, 3, disturbance="light")
    assert milder.mean_strides.mean > result.mean_strides.mean


@pytest.mark.parametrize(
    ("preset", "arguments"),
    [
        ("toe-off", {}),
        ("hip-torque", {"disturbance": "rough"}),
        ("camp1997", {"action_range": (0.1, 0.02), "effort_weight": 0.5}),
        ("round-foot", {"control": (2.704, 3371.8), "disturbance": {"slope": 0.01, "push": 0.01}}),
    ],
)
def test_a_batch_has_the_task_of_the_environment_it_is_made_of(
    preset: str, arguments: dict[str, Any]
) -> None:
    single = gym.make(ROUND_FOOT, preset=preset, **arguments)
    batch, _ = walkers_of(single, 3)
    assert isinstance(batch, PoweredWalkerVectorEnv)
    ours, theirs = batch.task, single.unwrapped.task  # type: ignore[attr-defined]
    assert (ours.params, ours.control, ours.disturbance) == (
        theirs.params, theirs.control, theirs.disturbance,
    )  # fmt: skip
    assert (ours.action_range, ours.effort_weight) == (theirs.action_range, theirs.effort_weight)
    np.testing.assert_array_equal(ours.gait, theirs.gait)


def test_environments_that_a_batch_cannot_stand_for_are_refused() -> None:
    with pytest.raises(ValueError, match="no wrapper, got TransformReward around"):
        evaluate(OpenLoop(), TransformReward(gym.make(ROUND_FOOT), abs), 1)
    gym.register(id="Stubborn-v0", entry_point=Stubborn, max_episode_steps=3)
    try:
        with pytest.raises(ValueError, match="Stubborn-v0"):
            evaluate(OpenLoop(), "Stubborn-v0", 1)
        with pytest.raises(ValueError, match="env must be a PoweredWalkerEnv itself"):
            evaluate(OpenLoop(), gym.make("Stubborn-v0"), 1)
    finally:
        gym.registry.pop("Stubborn-v0")
    with pytest.raises(ValueError, match=r"PoweredWalkerEnv.* must have max_episode_steps"):
        evaluate(OpenLoop(), PoweredWalkerEnv(), 1)
    with pytest.raises(ValueError, match="arguments go with an id"):
        evaluate(OpenLoop(), gym.make(ROUND_FOOT), 1, reward="contraction")
    for wrong in ("CartPole-v1", "PoweredWalker-v7"):
        with pytest.raises(ValueError, match=wrong):
            task_of(wrong)
    with pytest.raises(ValueError, match=r"'PoweredWalkerRoundFoot-v0' with .*speed"):
        task_of(ROUND_FOOT, speed=3)
    for count in (0, 1.5):
        with pytest.raises(ValueError, match="episodes must be a positive integer"):
            evaluate(OpenLoop(), ROUND_FOOT, count)  # type: ignore[arg-type]


@pytest.mark.parametrize("answer", [lambda x: np.full((len(x), 2), np.nan), lambda x: x])
def test_a_controller_that_breaks_is_named(answer: Any) -> None:
    with pytest.raises(ValueError, match=r"must give \(2, 2\) finite actions"):
        evaluate(answer, ROUND_FOOT, 2)


def test_intervals_cover_the_mean_as_often_as_they_say() -> None:
    rng = np.random.default_rng(0)
    covered = 0
    for _ in range(120):
        low, high = mean_estimate(np.minimum(rng.exponential(11.0, 100), 100))[1:]
        covered += low <= 11.0 * (1 - np.exp(-100 / 11.0)) <= high
    assert 0.88 <= covered / 120 <= 0.99


def test_intervals_are_those_of_the_resampled_means() -> None:
    """Written out: the numbers that this package printed before scipy drew them."""
    sample = np.minimum(np.random.default_rng(5).exponential(30, 70), 100).round()
    drawn = np.random.default_rng(0).integers(0, 70, (10_000, 70))
    low, high = np.percentile(sample[drawn].mean(1), [2.5, 97.5])
    assert mean_estimate(sample) == pytest.approx((sample.mean(), low, high), rel=1e-14)


def test_intervals_of_special_samples() -> None:
    assert mean_estimate([100.0] * 50) == (100.0, 100.0, 100.0)
    assert mean_estimate([3.0]) == (3.0, 3.0, 3.0)
    assert mean_estimate([1.0, 2.0, 4.0]) == mean_estimate([1.0, 2.0, 4.0])
    for bad in ([], [1.0, np.nan], [[1.0]]):
        with pytest.raises(ValueError, match="values must be a row of finite numbers"):
            mean_estimate(bad)


def test_shares_have_width_at_the_ends() -> None:
    """Wilson (1927), worked out by hand."""
    assert share_estimate(0, 100) == pytest.approx((0, 0, 0.0370), abs=1e-4)
    assert share_estimate(100, 100) == pytest.approx((1, 0.9630, 1), abs=1e-4)
    assert share_estimate(50, 100) == pytest.approx((0.5, 0.4038, 0.5962), abs=1e-4)
    with pytest.raises(ValueError, match=r"count must lie in \[0, 10\] .* got 11"):
        share_estimate(11, 10)


def test_pairing_cancels_what_is_common() -> None:
    rng = np.random.default_rng(0)
    luck = rng.exponential(50, 200)
    paired = paired_difference(luck + 2 + 0.1 * rng.normal(size=200), luck)
    assert 1.9 < paired.low < paired.mean < paired.high < 2.1
    with pytest.raises(ValueError, match="pairs need as many values"):
        paired_difference([1.0], [1.0, 2.0])


def test_the_comparison_as_json_and_as_text() -> None:
    results = {
        "open loop": evaluate(OpenLoop(), ROUND_FOOT, 10),
        "wobble [b]": evaluate(Wobble(), ROUND_FOOT, 10),
    }
    content = json.loads(json.dumps(comparison(results), allow_nan=False))
    entry = content["controllers"]["wobble [b]"]
    assert entry["difference"]["against"] == "open loop"
    assert entry["by_episode"]["strides"] == results["wobble [b]"].strides.tolist()
    assert entry["strides"]["low"] <= entry["strides"]["mean"] <= entry["strides"]["high"]
    assert "difference" not in content["controllers"]["open loop"]
    text = comparison_text(results, "title [of] it")
    assert "wobble [b]" in text
    assert "title [of] it" in text
    assert f"{results['open loop'].strides.mean():.1f} [" in text
