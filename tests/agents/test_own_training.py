"""What learners that are not of SB3 have in common: their loop and their command line."""

from __future__ import annotations

import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents import analytic_gradient, evolution
from agents.command import exit_status
from agents.own_learners import OWN_LEARNERS
from powered_walker_env.controllers import load_network

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"
MAINS = {"apg": analytic_gradient.main, "cmaes": evolution.main}
#: A training of a moment.
SHORT = {
    "apg": ["--steps", "320", "--hyperparams", "n_envs:8", "n_steps:4", "n_epochs:4", "episodes:3"],
    "cmaes": ["--steps", "4000", "--hyperparams", "population:4", "walks:8", "episodes:3"],
}
EACH = pytest.mark.parametrize("algo", OWN_LEARNERS)


@EACH
def test_the_same_seed_gives_the_same_policy(algo: str, tmp_path: Path) -> None:
    for name, seed in (("a", 3), ("b", 3), ("c", 4)):
        words = ["--runs", str(tmp_path), "--name", name, "--seed", str(seed)]
        MAINS[algo]([*words, *SHORT[algo]])
        np.random.seed(ord(name))  # noqa: NPY002 # whoever else draws numbers changes nothing
    first, second, other = (load_network(tmp_path / name / "policy.npz") for name in "abc")
    for k, (weights, biases) in enumerate(first.layers):
        np.testing.assert_array_equal(weights, second.layers[k][0])
        np.testing.assert_array_equal(biases, second.layers[k][1])
    assert (first.layers[0][0] != other.layers[0][0]).any()
    rows = [(tmp_path / name / "evaluations.csv").read_text() for name in "ab"]
    assert rows[0] == rows[1]


@EACH
def test_ctrl_c_keeps_what_there_is(
    algo: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    learner: Any = OWN_LEARNERS[algo].learner
    update = learner.update

    def interrupted(self: Any) -> float:
        signal.raise_signal(signal.SIGINT)
        return float(update(self))

    monkeypatch.setattr(learner, "update", interrupted)
    words = ["--runs", str(tmp_path), "--name", "cut", *SHORT[algo], "--steps", "1e5"]
    assert exit_status(lambda: MAINS[algo](words)) == 130
    assert "stopped early" in capsys.readouterr().err
    assert load_network(tmp_path / "cut" / "policy.npz").predict(np.ones((1, 4)))[0].any()


@EACH
def test_the_command_trains_and_says_what_it_did(
    algo: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--runs", str(tmp_path), *SHORT[algo]]
    MAINS[algo](words)
    printed = capsys.readouterr().out
    assert f"{algo} on {ROUND_FOOT}, seed 0" in printed and " falls, " in printed
    folder = tmp_path / f"{algo}-{ROUND_FOOT}-0"
    written = {"config.yml", "versions.json", "evaluations.csv", "policy.npz"}
    kept = {"updates.npy"} if algo == "cmaes" else set()
    assert {path.name for path in folder.iterdir()} == written | kept
    with pytest.raises(ValueError, match="exists; choose another name, replace it"):
        MAINS[algo](words)
    MAINS[algo]([*words, "--overwrite"])


SILLY = [
    *((algo, words, message) for algo in MAINS for words, message in [
        (["--env", "CartPole-v1"], "env must be a PoweredWalkerEnv|environment 'CartPole-v1'"),
        (["--name", "../x"], "name must be letters"),
        (["--hyperparams", "walkers:3"], "unknown key 'walkers'; known are n_timesteps"),
        (["--hyperparams", "hidden:0"], "hidden must be a positive integer, got 0"),
        (["--hyperparams", "hidden:2.5"], "hidden must be a positive integer, got 2.5"),
        (["--hyperparams", "seed:3"], "unknown key 'seed'"),
        (["--hyperparams", "spread:.nan"], "spread must be a positive number"),
        (["--env-kwargs", "disturbance:hurricane"], "disturbance must be one of"),
    ]),
    ("apg", ["--hyperparams", "state_cost:[1, 2]"], "state_cost must be four numbers"),
    ("apg", ["--steps", "10"], "n_timesteps must be at least n_envs times n_steps"),
    ("apg", ["--env-kwargs", "disturbance:light-ground"], "pushes alone, got .* of ground"),
    ("cmaes", ["--hyperparams", "population:3"], "population must be at least 4, got 3"),
    ("cmaes", ["--hyperparams", "metric:maybe"], "metric must be true or false, got 'maybe'"),
]  # fmt: skip


@pytest.mark.parametrize(("algo", "arguments", "message"), SILLY)
def test_silly_arguments_are_named(
    algo: str, arguments: list[str], message: str, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    words = [*arguments, "--runs", str(tmp_path)]
    with pytest.raises(ValueError, match=message):
        MAINS[algo](words)
    assert not any(tmp_path.iterdir())
    assert exit_status(lambda: MAINS[algo](words)) == 2
