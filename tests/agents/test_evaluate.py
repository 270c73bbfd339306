"""The commands that measure: evaluate, severity, tune_lqr."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import gymnasium as gym
import pytest

from agents.command import exit_status, pairs
from agents.evaluate import main
from agents.severity import main as measure_severity
from agents.severity import severities, severity_text, size_for
from agents.tune_lqr import TUNING_SEED, search
from powered_walker_env.controllers import LQR, evaluate
from powered_walker_env.controllers.evaluation import task_of

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"
ROOT = Path(__file__).parents[2]
OWN = "EvaluatedWalker-v0"


@pytest.fixture
def own_id() -> Iterator[str]:
    gym.register(
        id=OWN,
        entry_point="powered_walker_env:PoweredWalkerEnv",
        max_episode_steps=40,
        kwargs={"preset": "round-foot", "disturbance": {"push": 0.06}},
    )
    yield OWN
    gym.registry.pop(OWN)


def stiffer(observations: object) -> list[list[float]]:
    """A controller for the command line."""
    return [[0.0, 0.05]] * len(observations)  # type: ignore[arg-type]


def test_a_size_as_severe_as_a_push_is_found() -> None:
    size = size_for(5.0, lambda x: 100 * math.exp(-x / 0.01), 0.5)
    assert size == pytest.approx(0.01 * math.log(20), rel=0.005)
    assert size_for(50.0, lambda _: 100.0, 0.5) == pytest.approx(0.5, rel=0.005)
    rows = {(row.kind, row.level): row for row in severities(ROUND_FOOT, 6)}
    push = rows["push", "light"]
    assert push.strides == pytest.approx(push.target, rel=0.2)
    assert 0.014 < push.size < 0.028
    assert rows["sensor", "light"].controller == "LQR"
    text = severity_text(ROUND_FOOT, 6, list(rows.values()))
    assert "rough-ground" in text and f"{push.strides:.1f}" in text


def test_severity_of_one_environment(capsys: pytest.CaptureFixture[str]) -> None:
    measure_severity(["--env", "PoweredWalkerKneed-v0", "--episodes", "3"])
    printed = capsys.readouterr().out
    assert printed.count("episodes each") == 1
    assert printed.startswith("PoweredWalkerKneed-v0, 3") and "rough-parameters" in printed


def test_a_search_does_not_lose_what_it_starts_from() -> None:
    weights, strides = search(ROUND_FOOT, trials=2, episodes=20, seed=0)
    start = evaluate(LQR(task_of(ROUND_FOOT)), ROUND_FOOT, 20, TUNING_SEED)
    assert len(weights) == 6
    assert max(weights[:4]) == pytest.approx(1.0)
    assert strides >= start.strides.mean() - 0.5  # it starts from weights of at least 0.001
    assert search(ROUND_FOOT, trials=2, episodes=20, seed=0) == (weights, strides)


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
    assert (light["disturbance"], rough["disturbance"]) == ({"push": 0.02}, {"push": 0.05})
    assert list(light["controllers"]) == ["open loop", "LQR"]
    with pytest.raises(FileExistsError, match=r"results\.json' exists already; choose another"):
        main([*arguments, "--out", str(out)])


def test_an_environment_of_ones_own_keeps_its_disturbance(
    own_id: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "results.json"
    mine = f"{__name__}:stiffer"
    main(["open-loop", mine, "--env", own_id, "--episodes", "5", "--out", str(out)])
    (result,) = json.loads(out.read_text())
    assert (result["disturbance"], result["stride_limit"]) == ({"push": 0.06}, 40)
    assert f"{own_id}, disturbance as registered" in capsys.readouterr().out
    assert list(result["controllers"]) == ["open loop", mine]


def test_disturbances_and_arguments_of_the_environment_can_be_given(
    capsys: pytest.CaptureFixture[str],
) -> None:
    main(["open-loop", "--episodes", "2", "--env-kwargs", "disturbance:{push: 0.001}"])
    assert "push" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nothing.zip"], "there is no model file 'nothing.zip'"),
        (["pid"], "controllers are 'open-loop', 'lqr'"),
        (["no_module:f"], "the controller 'no_module:f' cannot be imported"),
        (["lqr", "--env", "PoweredWalker-v7"], "PoweredWalker-v7"),
        (["lqr", "--env", "CartPole-v1"], "CartPole-v1"),
        (["lqr", "--env", "no_package:X-v0"], "no_package"),
        (["lqr", "--disturbance", "hard"], "disturbance must be one of none, light, medium, rough"),
        (["lqr", "--env-kwargs", "speed:3"], "speed"),
        (["lqr", "--env-kwargs", "speed"], "arguments must look like key:value, got 'speed'"),
        (["lqr", "--out", "nowhere/x.json"], "the folder 'nowhere' does not exist"),
        (["lqr", "--out", "/proc/x.json"], "nothing can be written in the folder '/proc'"),
        (["lqr", "--out", "FOLDER"], "is a folder; choose another"),
        (["lqr", "--disturbance", "light", "--env-kwargs", "disturbance:none"], "not by both"),
    ],
)
def test_user_errors_say_what_is_wrong_and_end_with_2(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("agents.evaluate.evaluate", lambda *_, **__: pytest.fail("work began"))
    given = [str(tmp_path) if word == "FOLDER" else word for word in arguments]
    assert exit_status(lambda: main(given)) == 2
    printed = capsys.readouterr().err
    assert printed.startswith("error: ") and printed.count("\n") == 1
    assert message in printed


def test_a_full_disk_is_one_line_and_leaves_nothing_half_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    out = tmp_path / "results.json"
    assert exit_status(lambda: main(["open-loop", "--episodes", "2", "--out", str(out)])) == 2
    assert "No space left on device" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


SLOW = """
import sys, agents.{module} as command
from agents.command import exit_status
once = command.evaluate
def slow(*arguments, **kwargs):
    print("working", flush=True)
    sys.stdin.readline()  # nobody writes: until the signal
    return once(*arguments, **kwargs)
command.evaluate = slow
sys.exit(exit_status(lambda: command.main({arguments!r})))
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_stopped_evaluation_leaves_nothing_and_can_be_made_again(
    number: int, tmp_path: Path
) -> None:
    arguments = ["open-loop", "--episodes", "3", "--out", str(tmp_path / "x.json")]
    assert stopped(SLOW.format(module="evaluate", arguments=arguments), number) == 128 + number
    assert not list(tmp_path.iterdir())
    main(arguments)
    first = (tmp_path / "x.json").read_bytes()
    main([*arguments, "--overwrite"])
    assert (tmp_path / "x.json").read_bytes() == first


def test_a_stopped_search_says_so() -> None:
    assert (
        stopped(SLOW.format(module="tune_lqr", arguments=["--trials", "1"]), signal.SIGTERM) == 143
    )


def stopped(program: str, number: int) -> int:
    """The exit status of a program that gets a signal once it says that it works."""
    with subprocess.Popen(
        [sys.executable, "-c", program], cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        assert process.stdout is not None and process.stderr is not None
        assert process.stdout.readline() == "working\n"
        process.send_signal(number)
        complaint = process.stderr.read()
    assert "interrupted" in complaint and "Traceback" not in complaint
    return process.returncode


@pytest.mark.parametrize("option", [["--episodes", "0"], ["--episodes", "x"], ["--seed", "-1"]])
def test_bad_numbers_are_refused(option: list[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(["open-loop", *option])
    assert stopped.value.code == 2


def test_pairs_are_yaml() -> None:
    assert pairs(["a:1", "b:x", "c:[1, 2]", "d:", "e:a:b"]) == {
        "a": 1, "b": "x", "c": [1, 2], "d": None, "e": "a:b",
    }  # fmt: skip
    with pytest.raises(ValueError, match="the value of 'a' must be YAML"):
        pairs(["a:[1"])
