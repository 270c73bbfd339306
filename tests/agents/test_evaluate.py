"""Evaluations: seeded, paired, with confidence intervals that cover."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from agents.command import UserError, exit_status, pairs
from agents.controllers import OpenLoop
from agents.evaluate import Evaluation, evaluate, main
from agents.severity import severities, size_for
from agents.statistics import mean_estimate, paired_difference, share_estimate
from agents.tables import comparison, comparison_text
from powered_walker_env import ENVIRONMENTS, Outcome

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"


class Wobble:
    """A controller with a memory: its actions depend on how often it was asked."""

    def predict(
        self,
        observation: Any,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[Any, Any]:
        assert deterministic
        count = 0 if state is None else state
        assert episode_start.all() == (count == 0)
        return np.full((len(observation), 2), 0.1 * (-1) ** count), count + 1


def same(first: Evaluation, second: Evaluation) -> bool:
    names = ("strides", "returns", "outcomes")
    return all(np.array_equal(getattr(first, n), getattr(second, n)) for n in names)


def by_hand(env_id: str, seed: int) -> tuple[int, float, int]:
    """Strides, return and last outcome of one open-loop episode in the single environment."""
    env = gym.make(env_id)
    env.reset(seed=seed)
    strides, total = 0, 0.0
    while True:
        _, reward, terminated, truncated, info = env.step(np.zeros(2, np.float32))
        total += float(reward)
        strides += not terminated
        if terminated or truncated:
            return strides, total, info["outcome"]


@pytest.mark.parametrize("env_id", ENVIRONMENTS)
def test_episode_i_is_the_single_environment_with_that_seed(env_id: str) -> None:
    result = evaluate(OpenLoop(), env_id, episodes=8, seed=40)
    for i in range(8):
        strides, total, outcome = by_hand(env_id, 40 + i)
        assert (result.strides[i], result.outcomes[i]) == (strides, outcome)
        assert result.returns[i] == pytest.approx(total, rel=1e-12)


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
    np.testing.assert_allclose(result.returns, 100, atol=1e-3)


def test_every_episode_ends_somehow() -> None:
    result = evaluate(Wobble(), "PoweredWalker-v0", 40, disturbance="rough")
    assert sum(result.ends().values()) == 40
    assert set(result.ends()) <= {outcome.label for outcome in Outcome}
    assert ((result.strides == 100) == (result.outcomes == Outcome.WALKED)).all()


def test_a_controller_that_breaks_is_named() -> None:
    class Broken(OpenLoop):
        def predict(self, observation: Any, *args: Any, **kwargs: Any) -> tuple[Any, None]:
            return np.full((len(observation), 2), np.nan), None

    with pytest.raises(ValueError, match=r"must give \(2, 2\) finite actions"):
        evaluate(Broken(), ROUND_FOOT, 2)


def test_intervals_cover_the_mean_as_often_as_they_say() -> None:
    rng = np.random.default_rng(0)
    covered = 0
    for _ in range(120):
        low, high = mean_estimate(np.minimum(rng.exponential(11.0, 100), 100))[1:]
        covered += low <= 11.0 * (1 - np.exp(-100 / 11.0)) <= high
    assert 0.88 <= covered / 120 <= 0.99


def test_intervals_of_special_samples() -> None:
    assert mean_estimate([100.0] * 50) == (100.0, 100.0, 100.0)
    assert mean_estimate([3.0]) == (3.0, 3.0, 3.0)
    assert mean_estimate([1.0, 2.0, 4.0]) == mean_estimate([1.0, 2.0, 4.0])
    for bad in ([], [1.0, np.nan], [[1.0]]):
        with pytest.raises(ValueError, match="values must be a row of finite numbers"):
            mean_estimate(bad)


def test_shares_have_width_at_the_ends() -> None:
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


def test_a_size_as_severe_as_a_push_is_found() -> None:
    size = size_for(5.0, lambda x: 100 * math.exp(-x / 0.01), 0.5)
    assert size == pytest.approx(0.01 * math.log(20), rel=0.005)
    assert size_for(50.0, lambda _: 100.0, 0.5) == pytest.approx(0.5, rel=0.005)
    rows = {(row.kind, row.level): row for row in severities(ROUND_FOOT, 6)}
    push = rows["push", "light"]
    assert push.strides == pytest.approx(push.target, rel=0.2)
    assert 0.014 < push.size < 0.028
    assert rows["sensor", "light"].controller == "LQR"


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


def test_the_command_compares_levels_and_writes_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "results.json"
    arguments = ["open-loop", "lqr", "--episodes", "5", "--disturbance", "light", "rough"]
    main([*arguments, "--seed", "3", "--out", str(out)])
    printed = capsys.readouterr().out
    assert "open loop" in printed and "LQR" in printed and "disturbance rough" in printed
    light, rough = json.loads(out.read_text())
    assert (light["seed"], light["episodes"]) == (3, 5)
    assert rough["env_kwargs"] == {"disturbance": "rough"}
    assert list(light["controllers"]) == ["open loop", "LQR"]
    with pytest.raises(UserError, match=r"results\.json' exists; choose another file"):
        main([*arguments, "--out", str(out)])


def test_disturbances_and_arguments_of_the_environment_can_be_given(
    capsys: pytest.CaptureFixture[str],
) -> None:
    main(["open-loop", "--episodes", "2", "--env-kwargs", "disturbance:{push: 0.001}"])
    assert "push" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nothing.zip"], "there is no model file 'nothing.zip'"),
        (["lqr", "--env", "PoweredWalker-v7"], "PoweredWalker-v7"),
        (["lqr", "--env", "CartPole-v1"], "CartPole-v1"),
        (["lqr", "--disturbance", "hard"], "disturbance must be one of none, light, medium, rough"),
        (["lqr", "--env-kwargs", "speed:3"], "speed"),
        (["lqr", "--env-kwargs", "speed"], "arguments must look like key:value, got 'speed'"),
        (["lqr", "--out", "nowhere/x.json"], "the folder 'nowhere' does not exist"),
        (["lqr", "--disturbance", "light", "--env-kwargs", "disturbance:none"], "not by both"),
    ],
)
def test_user_errors_say_what_is_wrong_and_end_with_2(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert exit_status(lambda: main(arguments)) == 2
    printed = capsys.readouterr().err
    assert printed.startswith("error: ")
    assert message in printed


@pytest.mark.parametrize("option", [["--episodes", "0"], ["--episodes", "x"], ["--seed", "-1"]])
def test_bad_numbers_are_refused(option: list[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(["open-loop", *option])
    assert stopped.value.code == 2


def test_pairs_are_yaml() -> None:
    assert pairs(["a:1", "b:x", "c:[1, 2]", "d:", "e:a:b"]) == {
        "a": 1, "b": "x", "c": [1, 2], "d": None, "e": "a:b",
    }  # fmt: skip
    with pytest.raises(UserError, match="the value of 'a' must be YAML"):
        pairs(["a:[1"])
