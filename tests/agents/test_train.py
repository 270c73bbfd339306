"""Training: reproducible, resumable bit for bit, and proof against kills."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
import yaml
from stable_baselines3.common.vec_env import VecMonitor

import agents.progress
from agents.algorithms import load_model
from agents.command import UserError, exit_status
from agents.runs import create_run, load_checkpoint, read_run, run_folder
from agents.settings import Settings
from agents.train import main, train
from powered_walker_env.sb3 import PoweredWalkerVecEnv

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"
ROOT = Path(__file__).parents[2]
PPO: dict[str, Any] = {
    "policy_kwargs": "dict(net_arch=[8])", "n_steps": 8, "batch_size": 32, "n_epochs": 2,
    "n_envs": 4, "learning_rate": "lin_1e-2",
}  # fmt: skip
SAC: dict[str, Any] = {
    "policy_kwargs": "dict(net_arch=[8])", "buffer_size": 500, "learning_starts": 16,
    "batch_size": 16, "n_envs": 2,
}  # fmt: skip
A2C: dict[str, Any] = {"policy_kwargs": "dict(net_arch=[8])", "n_steps": 4, "n_envs": 2}
LSTM: dict[str, Any] = PPO | {"policy_kwargs": "dict(net_arch=[8], lstm_hidden_size=4)"}
SETTINGS = {"ppo": PPO, "sac": SAC, "ppo_lstm": LSTM}


def settings_for(algo: str = "ppo", steps: int = 128, seed: int = 0, **kwargs: Any) -> Settings:
    """A training of a second; SB3's settings alone, not those that are shipped."""
    empty = {"n_envs": 1} | SETTINGS.get(algo, A2C)
    settings = Settings(algo, ROUND_FOOT, seed, int(empty.pop("n_envs")), steps)
    return replace(settings, hyperparameters=empty, every=32, episodes=3, **kwargs)


def weights(path: Path) -> dict[str, torch.Tensor]:
    return load_model(path).policy.state_dict()


def assert_same_run(first: Path, second: Path) -> None:
    """Same evaluations, same weights, same best model, bit for bit."""
    assert (first / "evaluations.csv").read_text() == (second / "evaluations.csv").read_text()
    for name in ("checkpoint.zip", "best_model.zip"):
        a, b = weights(first / name), weights(second / name)
        assert all(torch.equal(a[key], b[key]) for key in a), name


def interrupt_at(monkeypatch: pytest.MonkeyPatch, evaluation: int) -> None:
    """Ctrl-C during that evaluation."""
    calls = 0
    evaluate: Callable[..., Any] = agents.progress.evaluate

    def interrupted(*args: Any, **kwargs: Any) -> Any:
        nonlocal calls
        calls += 1
        if calls == evaluation:
            signal.raise_signal(signal.SIGINT)
        return evaluate(*args, **kwargs)

    monkeypatch.setattr(agents.progress, "evaluate", interrupted)


@pytest.mark.parametrize("algo", ["ppo", "sac"])
def test_the_same_seed_gives_the_same_run(algo: str, tmp_path: Path) -> None:
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        train(settings_for(algo, seed=seed), tmp_path / name, quiet=True)
    assert_same_run(tmp_path / "a", tmp_path / "b")
    a, c = weights(tmp_path / "a" / "checkpoint.zip"), weights(tmp_path / "c" / "checkpoint.zip")
    assert any(not torch.equal(a[key], c[key]) for key in a)


@pytest.mark.parametrize("algo", ["ppo", "sac", "ppo_lstm"])
def test_a_stopped_and_resumed_run_is_the_whole_run_bit_for_bit(
    algo: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole, parts, settings = tmp_path / "whole", tmp_path / "parts", settings_for(algo)
    done = train(settings, whole, quiet=True)
    interrupt_at(monkeypatch, 3)
    stopped = train(settings, parts, quiet=True)
    assert stopped.stopped and 0 < stopped.num_timesteps < done.num_timesteps
    np.random.seed(99)  # noqa: NPY002 (whatever happened in between)
    torch.manual_seed(99)
    resumed = train(read_run(parts), parts, resume=True, quiet=True)
    assert not resumed.stopped
    assert resumed.num_timesteps == done.num_timesteps >= 128
    assert_same_run(whole, parts)


def test_a_finished_run_can_be_extended(tmp_path: Path) -> None:
    main_arguments = ["--runs", str(tmp_path), "--name", "a"]
    train(settings_for(), tmp_path / "a", quiet=True)
    main([*main_arguments, "--resume"])  # nothing left to do
    assert load_model(tmp_path / "a" / "checkpoint.zip").num_timesteps == 128
    main([*main_arguments, "--resume", "--steps", "160"])
    assert load_model(tmp_path / "a" / "checkpoint.zip").num_timesteps == 160
    assert read_run(tmp_path / "a").n_timesteps == 160


def test_the_folder_tells_where_the_results_come_from(tmp_path: Path) -> None:
    settings = settings_for(env_kwargs={"disturbance": {"push": 0.01}}, seed=4)
    train(settings, tmp_path / "a", quiet=True)
    assert read_run(tmp_path / "a") == settings
    assert yaml.safe_load((tmp_path / "a" / "config.yml").read_text())["seed"] == 4
    versions = json.loads((tmp_path / "a" / "versions.json").read_text())
    assert versions["seed"] == 4
    assert {"numpy", "torch", "stable-baselines3"} <= set(versions["packages"])
    with (tmp_path / "a" / "evaluations.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [int(row["steps"]) for row in rows] == [0, 32, 64, 96, 128]
    for row in rows:
        assert float(row["strides_low"]) <= float(row["strides"]) <= float(row["strides_high"])
    assert not list((tmp_path / "a").glob(".*"))  # nothing half written


def test_the_best_model_is_the_one_that_scored_best(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = []
    save_model: Callable[..., None] = agents.progress.save_model

    def noted(model: Any, target: Path) -> None:
        kept.append(model.num_timesteps)
        save_model(model, target)

    monkeypatch.setattr(agents.progress, "save_model", noted)
    history = train(settings_for(steps=256), tmp_path / "a", quiet=True).history
    returns = [row["return"] for row in history]
    assert kept[-1] == history[int(np.argmax(returns))]["steps"]
    assert load_model(tmp_path / "a" / "best_model.zip").num_timesteps == kept[-1]


def test_an_existing_run_is_not_overwritten_unasked(tmp_path: Path) -> None:
    folder = tmp_path / "a"
    train(settings_for(), folder, quiet=True)
    before = (folder / "checkpoint.zip").read_bytes()
    with pytest.raises(UserError, match=r"a' exists; .*--overwrite"):
        train(settings_for(seed=1), folder, quiet=True)
    assert (folder / "checkpoint.zip").read_bytes() == before
    train(settings_for(seed=1), folder, overwrite=True, quiet=True)
    assert read_run(folder).seed == 1


def test_what_is_no_run_is_never_removed(tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("years of work")
    with pytest.raises(UserError, match="is no run, so --overwrite leaves it alone"):
        create_run(tmp_path, settings_for(), overwrite=True)
    assert (tmp_path / "thesis.txt").exists()


def test_settings_that_will_not_do_leave_an_old_run_in_place(tmp_path: Path) -> None:
    train(settings_for(), tmp_path / "a", quiet=True)
    bad = replace(settings_for(), hyperparameters={"policy": "NoSuchPolicy"})
    with pytest.raises(UserError, match=r"ppo does not take these settings: .*NoSuchPolicy"):
        train(bad, tmp_path / "a", overwrite=True, quiet=True)
    assert (tmp_path / "a" / "checkpoint.zip").exists()


@pytest.mark.parametrize("name", ["", "..", "a/b", "-a", ".hidden", "a b"])
def test_a_run_has_a_plain_name(name: str) -> None:
    with pytest.raises(UserError, match="name must be letters, digits"):
        run_folder(name)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--hyperparams", "gama:0.9"], "unknown key 'gama'"),
        (["--env", "PoweredWalker-v7", "--config", "CONFIG"], "no section for 'PoweredWalker-v7'"),
        (["--env-kwargs", "speed:3"], "speed"),
        (["--config", "nowhere.yml"], "'nowhere.yml' cannot be read"),
        (["--resume"], "--resume needs the --name"),
        (["--resume", "--name", "nothing"], "there is no run"),
        (["--resume", "--name", "x", "--seed", "1"], "leave --seed away"),
        (["--name", "../x"], "name must be letters"),
        (["--gpu", "yes"], "no GPU was found"),
        (["--hyperparams", "policy:NoSuchPolicy"], "NoSuchPolicy"),
    ],
)
def test_user_errors_say_what_is_wrong_and_end_with_2(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    config = str(ROOT / "configs" / "ppo.yml")
    given = [config if word == "CONFIG" else word for word in arguments]
    assert exit_status(lambda: main([*given, "--runs", str(tmp_path)])) == 2
    assert message in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_damaged_checkpoint_is_named(tmp_path: Path) -> None:
    folder = tmp_path / "a"
    train(settings_for(), folder, quiet=True)
    content = (folder / "checkpoint.zip").read_bytes()
    (folder / "checkpoint.zip").write_bytes(content[:1000])
    with pytest.raises(UserError, match=r"checkpoint\.zip' is not a saved model"):
        train(read_run(folder), folder, resume=True, quiet=True)
    (folder / "checkpoint.zip").write_bytes((folder / "best_model.zip").read_bytes())
    with pytest.raises(UserError, match="a model but no checkpoint"):
        train(read_run(folder), folder, resume=True, quiet=True)
    (folder / "config.yml").write_text("seed: 0")
    with pytest.raises(UserError, match=r"config\.yml' is damaged"):
        read_run(folder)


def test_the_command_trains_and_says_how_to_go_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    small = [f"{key}:{value}" for key, value in PPO.items()]
    arguments = ["--runs", str(tmp_path), "--name", "a", "--episodes", "3"]
    interrupt_at(monkeypatch, 2)
    with pytest.raises(SystemExit) as stopped:
        main([*arguments, "--steps", "2e2", "--every", "50", "--hyperparams", *small])
    assert stopped.value.code == 130
    printed = capsys.readouterr().out
    assert f"go on: python -m agents.train --resume --name a --runs {tmp_path}" in printed
    main(["--resume", "--name", "a", "--runs", str(tmp_path)])
    assert "python -m agents.evaluate open-loop lqr" in capsys.readouterr().out


SAVE_FOREVER = """
    import os, sys
    from pathlib import Path
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecMonitor
    from agents.runs import save_checkpoint
    from powered_walker_env.sb3 import PoweredWalkerVecEnv

    target = Path(sys.argv[1])
    env = VecMonitor(PoweredWalkerVecEnv("PoweredWalkerRoundFoot-v0", 8, seed=0, monitor=False))
    network = dict(net_arch=[256, 256])
    model = PPO("MlpPolicy", env, seed=0, device="cpu", policy_kwargs=network)
    env.reset()
    for _ in sys.stdin:  # a child for each line, to be killed
        child = os.fork()
        if child == 0:
            while True:
                model.num_timesteps += 1
                save_checkpoint(model, target, [{"steps": model.num_timesteps}])
        print(child, flush=True)
        os.waitpid(child, 0)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs os.fork")
def test_a_kill_in_the_middle_of_saving_leaves_a_good_checkpoint(tmp_path: Path) -> None:
    target = tmp_path / "checkpoint.zip"
    command = [sys.executable, "-c", textwrap.dedent(SAVE_FOREVER), str(target)]
    with subprocess.Popen(
        command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as parent:
        assert parent.stdin is not None and parent.stdout is not None
        cut = 0
        for _ in range(8):
            print("save", file=parent.stdin, flush=True)
            child = int(parent.stdout.readline())
            cut += kill_while_writing(child, tmp_path)
            env = VecMonitor(PoweredWalkerVecEnv(ROUND_FOOT, 8, monitor=False))
            model, history = load_checkpoint(target, env)
            assert model.num_timesteps == history[-1]["steps"] > 0
        parent.stdin.close()
    assert cut > 0  # at least one kill left a half-written file behind


def kill_while_writing(child: int, folder: Path) -> bool:
    """SIGKILL as soon as a file is being written; whether it is left half written."""
    for part in folder.glob(".*.part*"):
        part.unlink()
    deadline = time.monotonic() + 10
    while not ((folder / "checkpoint.zip").exists() and list(folder.glob(".*.part*"))):
        assert time.monotonic() < deadline, "the child does not save"
    os.kill(child, signal.SIGKILL)
    return bool(list(folder.glob(".*.part*")))
