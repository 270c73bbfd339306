"""Training: reproducible, resumable bit for bit, and proof against kills."""

from __future__ import annotations

import csv
import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import textwrap
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
import yaml

import agents.supervisor
from agents.command import exit_status
from agents.configuration import Settings
from agents.resume import read_run
from agents.runs import create_run, run_folder
from agents.train import go_on, main, train
from powered_walker_env import PRESETS
from powered_walker_env.controllers import evaluate, load_controller, load_network
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.controllers.stable_baselines import load_sb3_policy
from powered_walker_env.sb3 import PoweredWalkerVecEnv

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"
ROOT = Path(__file__).parents[2]
PPO: dict[str, Any] = {
    "policy_kwargs": "dict(net_arch=[8])", "n_steps": 8, "batch_size": 32, "n_epochs": 2,
    "n_envs": 4, "learning_rate": "lin_1e-2",
}  # fmt: skip
pytestmark = pytest.mark.filterwarnings("ignore:.*is a pickle of Stable-Baselines3")
SAC: dict[str, Any] = {
    "policy_kwargs": "dict(net_arch=[8])", "buffer_size": 500, "learning_starts": 16,
    "batch_size": 16, "n_envs": 2,
}  # fmt: skip
A2C: dict[str, Any] = {"policy_kwargs": "dict(net_arch=[8])", "n_steps": 4, "n_envs": 2}
LSTM: dict[str, Any] = PPO | {"policy_kwargs": "dict(net_arch=[8], lstm_hidden_size=4)"}
TD3: dict[str, Any] = SAC | {"noise_type": "normal", "noise_std": 0.1}
SETTINGS = {"ppo": PPO, "sac": SAC, "ppo_lstm": LSTM, "td3": TD3, "tqc": SAC, "trpo": PPO | {}}
SETTINGS["crossq"] = SAC
SETTINGS["trpo"].pop("n_epochs")
SDE: dict[str, Any] = {"use_sde": True}
METRIC: dict[str, Any] = {
    "policy_kwargs": "dict(features_extractor_class=StrideMetric, net_arch=[8])"
}


def settings_for(
    algo: str = "ppo", steps: int = 128, more: dict[str, Any] | None = None, **kwargs: Any
) -> Settings:
    """A training of a second; SB3's settings alone, not those that are shipped."""
    hyperparameters = {"n_envs": 1} | SETTINGS.get(algo, A2C) | (more or {})
    n_envs = int(hyperparameters.pop("n_envs"))
    given = {"n_envs": n_envs, "n_timesteps": steps, "every": 32, "episodes": 3} | kwargs
    return Settings(algo, ROUND_FOOT, hyperparameters=hyperparameters, **given)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run; copy it to change it."""
    folder = tmp_path_factory.mktemp("runs") / "a"
    train(settings_for(seed=4, env_kwargs={"disturbance": {"push": 0.01}}), folder, quiet=True)
    return folder


@pytest.fixture
def folder(finished: Path, tmp_path: Path) -> Path:
    """A copy of the finished run."""
    return Path(shutil.copytree(finished, tmp_path / "a"))


def weights(path: Path) -> dict[str, torch.Tensor]:
    return load_sb3_policy(path).state_dict()


def steps_of(folder: Path) -> int:
    """Strides of the checkpoint."""
    with zipfile.ZipFile(folder / "checkpoint.zip") as archive:
        return int(json.loads(archive.read("data"))["num_timesteps"])


def assert_same_run(first: Path, second: Path) -> None:
    """Same evaluations, same weights, same best model, bit for bit."""
    assert (first / "evaluations.csv").read_text() == (second / "evaluations.csv").read_text()
    for name in ("checkpoint.zip", "best_model.zip"):
        a, b = weights(first / name), weights(second / name)
        assert all(torch.equal(a[key], b[key]) for key in a), name


def interrupt_at(monkeypatch: pytest.MonkeyPatch, evaluation: int, number: int) -> None:
    """A signal during that evaluation."""
    calls = 0
    evaluate_once: Callable[..., Any] = agents.supervisor.evaluate

    def interrupted(*args: Any, **kwargs: Any) -> Any:
        nonlocal calls
        calls += 1
        if calls == evaluation:
            signal.raise_signal(number)
        return evaluate_once(*args, **kwargs)

    monkeypatch.setattr(agents.supervisor, "evaluate", interrupted)


@pytest.mark.parametrize("algo", ["ppo", "sac"])
def test_the_same_seed_gives_the_same_run(algo: str, tmp_path: Path) -> None:
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        train(settings_for(algo, seed=seed), tmp_path / name, quiet=True)
    assert_same_run(tmp_path / "a", tmp_path / "b")
    a, c = weights(tmp_path / "a" / "checkpoint.zip"), weights(tmp_path / "c" / "checkpoint.zip")
    assert any(not torch.equal(a[key], c[key]) for key in a)


def test_trainings_with_seeds_0_and_1_share_no_walkers_stream(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Seeds taken as they are would share all but one: walker i is seeded s + i."""
    begun: dict[int, list[int]] = {}
    walk = PoweredWalkerVecEnv.step_wait

    def noted(env: Any) -> Any:
        begun.setdefault(id(env), []).extend(env.envs.walkers.words.tolist())
        return walk(env)

    monkeypatch.setattr(PoweredWalkerVecEnv, "step_wait", noted)
    for seed in (0, 1):
        settings = settings_for(steps=64, seed=seed, n_envs=32, more={"n_steps": 1})
        train(settings, tmp_path / str(seed), quiet=True)
    first, second = (set(words) for words in begun.values())
    assert len(first) >= 64 and not first & second


@pytest.mark.parametrize(
    ("algo", "more"),
    [
        ("ppo", {}), ("sac", {}), ("ppo_lstm", {}), ("td3", {}), ("tqc", {}), ("trpo", {}),
        ("crossq", {}), ("ppo", METRIC),
        ("ppo", SDE), ("ppo", SDE | {"sde_sample_freq": 3}), ("a2c", SDE),
        ("sac", SDE), ("tqc", SDE), ("ppo_lstm", SDE),
    ],
)  # fmt: skip
def test_a_stopped_and_resumed_run_is_the_whole_run_bit_for_bit(
    algo: str, more: dict[str, Any], tmp_path: Path
) -> None:
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    settings = settings_for(algo, 128, more)  # `lin_` leaves the last update of PPO without effect
    done = train(settings, whole, quiet=True)
    stopped = train(settings, parts, stop_at=40, quiet=True)
    assert stopped.stopped and 40 <= stopped.saved_steps < done.num_timesteps
    assert stopped.saved_steps == steps_of(parts)
    np.random.seed(99)  # noqa: NPY002 (whatever happened in between)
    torch.manual_seed(99)
    resumed = train(read_run(parts), parts, resume=True, quiet=True)
    assert not resumed.stopped
    assert resumed.num_timesteps == done.num_timesteps >= 128
    assert_same_run(whole, parts)


def test_a_run_is_as_long_as_its_settings_say(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its schedules end there: going on would begin them anew, and config.yml would lie."""
    command = ["--runs", str(folder.parent), "--name", "a", "--resume"]
    before = (folder / "config.yml").read_bytes()
    main(command)  # nothing left to do
    assert exit_status(lambda: main([*command, "--steps", "160"])) == 2
    assert "--steps must be at most 128 with --resume, got 160" in capsys.readouterr().err
    main([*command, "--steps", "100"])
    assert steps_of(folder) == 128
    assert (folder / "config.yml").read_bytes() == before


def test_a_resumed_run_stops_where_it_is_told_and_keeps_its_settings(tmp_path: Path) -> None:
    settings = settings_for()
    train(settings, tmp_path / "whole", quiet=True)
    train(settings, tmp_path / "a", stop_at=32, quiet=True)
    before = (tmp_path / "a" / "config.yml").read_bytes()
    command = ["--runs", str(tmp_path), "--name", "a", "--resume"]
    with pytest.raises(KeyboardInterrupt, match="stopped at 64 of 128 strides; go on: python -m"):
        main([*command, "--steps", "64"])
    assert steps_of(tmp_path / "a") == 64
    assert (tmp_path / "a" / "config.yml").read_bytes() == before
    main(command)
    assert_same_run(tmp_path / "whole", tmp_path / "a")


def test_the_folder_tells_where_the_results_come_from(finished: Path) -> None:
    assert read_run(finished) == settings_for(seed=4, env_kwargs={"disturbance": {"push": 0.01}})
    assert yaml.safe_load((finished / "config.yml").read_text(encoding="utf-8"))["seed"] == 4
    content = json.loads((finished / "versions.json").read_text(encoding="utf-8"))
    assert {"numpy", "torch", "stable-baselines3", "python"} <= set(content["versions"])
    with (finished / "evaluations.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [int(row["steps"]) for row in rows] == [0, 32, 64, 96, 128]
    for row in rows:
        assert float(row["strides_low"]) <= float(row["strides"]) <= float(row["strides_high"])
    assert not list(finished.glob(".*"))  # nothing half written


def test_the_best_policy_is_the_one_that_scored_best(finished: Path) -> None:
    with (finished / "evaluations.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    merits = [(float(row["strides"]), float(row["return"])) for row in rows]
    best = int(rows[merits.index(max(merits))]["steps"])
    network = load_network(finished / "policy.npz")
    assert network.settings == {"algo": "PPO", "env_id": ROUND_FOOT, "seed": 4, "steps": best}
    x = np.random.default_rng(0).normal(size=(20, 4)).astype(np.float32)
    wanted, _ = load_sb3_policy(finished / "best_model.zip").predict(x, deterministic=True)
    np.testing.assert_allclose(network.predict(x)[0], wanted, atol=1e-6)


def test_an_environment_of_ones_own_is_trained_as_it_is_registered(tmp_path: Path) -> None:
    gym.register(
        id="TrainedWalker-v0",
        entry_point="powered_walker_env:PoweredWalkerEnv",
        max_episode_steps=10,
        kwargs={"preset": "toe-off", "disturbance": "none", "reward": "contraction"},
    )
    try:
        settings = replace(settings_for(), env_id="TrainedWalker-v0")
        history = train(settings, tmp_path / "a", quiet=True).history
        assert history[0]["strides"] == 10.0
        task = task_of("TrainedWalker-v0")
        name, controller = load_controller(tmp_path / "a", task, "TrainedWalker-v0")
        assert name == "PPO a"
        assert evaluate(controller, "TrainedWalker-v0", 2).limit == 10
        with pytest.raises(ValueError, match=r"of shape \(4,\) and \(1,\), not \(4,\) and \(2,\)"):
            load_controller(tmp_path / "a", task_of(ROUND_FOOT))
    finally:
        gym.registry.pop("TrainedWalker-v0")


def test_an_existing_run_is_not_overwritten_unasked(folder: Path) -> None:
    before = (folder / "checkpoint.zip").read_bytes()
    with pytest.raises(ValueError, match=r"a' exists; .*--overwrite"):
        train(settings_for(seed=1), folder, quiet=True)
    assert (folder / "checkpoint.zip").read_bytes() == before
    train(settings_for(seed=1, steps=32), folder, overwrite=True, quiet=True)
    assert read_run(folder).seed == 1


def test_what_is_no_run_is_never_removed(tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("years of work")
    with pytest.raises(ValueError, match="is no run, so --overwrite leaves it alone"):
        create_run(tmp_path, settings_for(), overwrite=True)
    assert (tmp_path / "thesis.txt").exists()


@pytest.mark.parametrize("name", ["a", "new"])
def test_a_full_disk_is_met_before_the_work_and_costs_no_old_run(
    name: str, folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    monkeypatch.setattr("agents.supervisor.evaluate", lambda *_, **__: pytest.fail("work began"))
    command = ["--runs", str(folder.parent), "--name", name, "--overwrite", "--steps", "64"]
    assert exit_status(lambda: main(command)) == 2
    assert "cannot be made (No space left on device)" in capsys.readouterr().err
    assert [path.name for path in folder.parent.iterdir()] == ["a"]
    assert steps_of(folder) == 128


def test_settings_that_will_not_do_leave_an_old_run_in_place(folder: Path) -> None:
    bad = replace(settings_for(), hyperparameters={"policy": "NoSuchPolicy"})
    with pytest.raises(ValueError, match=r"ppo does not take these settings: .*NoSuchPolicy"):
        train(bad, folder, overwrite=True, quiet=True)
    assert (folder / "checkpoint.zip").exists()


@pytest.mark.parametrize("name", ["", "..", "a/b", "-a", ".hidden", "a b"])
def test_a_run_has_a_plain_name(name: str) -> None:
    with pytest.raises(ValueError, match="name must be letters, digits"):
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
        (["--hyperparams", "gamma:.nan"], "gamma must be a finite number, got nan"),
        (["--hyperparams", "gamma:5"], "gamma must lie in [0, 1], got 5"),
        (["--hyperparams", "n_envs:0"], "n_envs must be a positive integer, got 0"),
        (["--runs", "FILE"], "cannot be made (Not a directory)"),
        (["--runs", "/proc"], "cannot be made (No such file or directory)"),
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
    monkeypatch.setattr("agents.supervisor.evaluate", lambda *_, **__: pytest.fail("work began"))
    (tmp_path / "runs").mkdir()
    words = {"CONFIG": str(ROOT / "configs" / "ppo.yml"), "FILE": str(tmp_path / "file")}
    (tmp_path / "file").touch()
    given = ["--runs", str(tmp_path / "runs"), *(words.get(word, word) for word in arguments)]
    assert exit_status(lambda: main(given)) == 2
    printed = capsys.readouterr().err
    assert message in printed and printed.count("\n") == 1
    assert not list((tmp_path / "runs").iterdir())


@pytest.mark.parametrize("member", ["run_state.pkl", "data", "policy.pth"])
def test_a_damaged_checkpoint_is_named(member: str, folder: Path) -> None:
    with zipfile.ZipFile(folder / "checkpoint.zip") as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    for damaged in (b"", b"nonsense", members[member][: len(members[member]) // 2]):
        with zipfile.ZipFile(folder / "checkpoint.zip", "w") as archive:
            for name, content in members.items():
                archive.writestr(name, damaged if name == member else content)
        with pytest.raises(ValueError, match=r"checkpoint\.zip' is damaged, or no checkpoint"):
            train(read_run(folder), folder, resume=True, quiet=True)


def test_what_is_no_checkpoint_is_named(folder: Path) -> None:
    content = (folder / "checkpoint.zip").read_bytes()
    (folder / "checkpoint.zip").write_bytes(content[:1000])
    with pytest.raises(ValueError, match=r"checkpoint\.zip' is damaged"):
        train(read_run(folder), folder, resume=True, quiet=True)
    (folder / "checkpoint.zip").write_bytes((folder / "best_model.zip").read_bytes())
    with pytest.raises(ValueError, match="a model but no checkpoint"):
        train(read_run(folder), folder, resume=True, quiet=True)
    (folder / "checkpoint.zip").unlink()
    with pytest.raises(ValueError, match="there is no checkpoint"):
        train(read_run(folder), folder, resume=True, quiet=True)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("n_envs", 8, "n_envs is 8 and was 4; put it back"),
        ("seed", 5, "seed is 5 and was 4; put it back"),
        ("every", "soon", r"config\.yml' is damaged: every must be .*, got 'soon'"),
        ("env_kwargs", 3, r"config\.yml' is damaged: env_kwargs must be a mapping"),
        ("speed", 3, r"config\.yml' is damaged: .*speed"),
    ],
)
def test_a_run_whose_settings_were_changed_does_not_go_on(
    name: str, value: Any, message: str, folder: Path
) -> None:
    content = yaml.safe_load((folder / "config.yml").read_text(encoding="utf-8"))
    text = yaml.safe_dump({**content, name: value})
    (folder / "config.yml").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=message):
        train(read_run(folder), folder, resume=True, quiet=True)


def test_a_run_of_the_python_interface_goes_on_and_bad_settings_leave_no_folder(
    tmp_path: Path,
) -> None:
    """A tuple is a list in a file, and no change."""
    kwargs: dict[str, Any] = {"preset": "round-foot", "control": (2.704, 3371.8)}
    train(settings_for(env_kwargs=kwargs), tmp_path / "a", stop_at=32, quiet=True)
    done = train(read_run(tmp_path / "a"), tmp_path / "a", resume=True, quiet=True)
    assert done.num_timesteps == 128
    kwargs = {"preset": "round-foot", "control": PRESETS["round-foot"].control}
    with pytest.raises(ValueError, match=r"settings must be plain .*Control\("):
        train(settings_for(env_kwargs=kwargs), tmp_path / "b", quiet=True)
    assert not (tmp_path / "b").exists()


def test_to_resume_says_that_a_checkpoint_is_a_pickle(folder: Path) -> None:
    with pytest.warns(UserWarning, match=r"checkpoint\.zip' is a pickle of Stable-Baselines3"):
        train(read_run(folder), folder, resume=True, quiet=True)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_the_command_and_it_says_how_to_go_on(
    number: int,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    small = [f"{key}:{value}" for key, value in PPO.items()]
    runs = tmp_path / "my runs"
    arguments = ["--runs", str(runs), "--name", "a", "--episodes", "3"]
    interrupt_at(monkeypatch, 2, number)
    command = [*arguments, "--steps", "2e2", "--every", "50", "--hyperparams", *small]
    assert exit_status(lambda: main(command)) == 128 + number
    printed = capsys.readouterr().err
    assert f"stopped at {steps_of(runs / 'a')} of 200 strides; go on: " in printed
    words = shlex.split(printed.rpartition("go on: ")[2])
    assert words == ["python", "-m", "agents.train", "--resume", "--name", "a", "--runs", str(runs)]
    main(words[3:])
    assert "python -m agents.evaluate open-loop lqr" in capsys.readouterr().out


def test_a_second_signal_stops_at_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    evaluate_once: Callable[..., Any] = agents.supervisor.evaluate

    def interrupted(*args: Any, **kwargs: Any) -> Any:
        if (tmp_path / "a" / "checkpoint.zip").exists():
            signal.raise_signal(signal.SIGTERM)
            signal.raise_signal(signal.SIGTERM)
        return evaluate_once(*args, **kwargs)

    monkeypatch.setattr(agents.supervisor, "evaluate", interrupted)
    with pytest.raises(KeyboardInterrupt, match="interrupted; go on from stride 0: python"):
        train(settings_for(), tmp_path / "a")
    capsys.readouterr()


def test_the_command_to_go_on_can_be_pasted(tmp_path: Path) -> None:
    assert go_on(Path("runs") / "a") == "python -m agents.train --resume --name a"
    odd = tmp_path / "it's $HOME; ls"
    assert shlex.split(go_on(odd / "a"))[-1] == str(odd)


DIE_WHILE_SAVING = """
    import os, signal, sys
    from pathlib import Path
    import agents.supervisor
    from agents.configuration import Settings
    from agents.train import train

    def die(*_):
        os.kill(os.getpid(), signal.SIGKILL)

    save, saved = agents.supervisor.save_checkpoint, []

    def save_twice(model, target, history, settings):
        saved.append(model.num_timesteps)
        if len(saved) == 3 and sys.argv[2] == "half":
            Path.write_bytes = lambda path, content: (path.open("wb").write(content[:9999]), die())
        elif len(saved) == 3:
            os.replace = die
        save(model, target, history, settings)

    agents.supervisor.save_checkpoint = save_twice
    kwargs = dict(every=32, episodes=3, n_envs=4, hyperparameters=eval(sys.argv[3]))
    settings = Settings(n_timesteps=128, **kwargs)
    train(settings, Path(sys.argv[1]), quiet=True)
"""


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="needs SIGKILL")
@pytest.mark.parametrize("moment", ["half", "whole"])
def test_a_kill_in_the_middle_of_saving_leaves_a_good_checkpoint(
    moment: str, tmp_path: Path
) -> None:
    """Half written, and written but not in its place yet; then it goes on bit for bit."""
    settings = settings_for()
    program, arguments = textwrap.dedent(DIE_WHILE_SAVING), repr(settings.hyperparameters)
    killed = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path / "a"), moment, arguments], cwd=ROOT
    )
    assert killed.returncode == -signal.SIGKILL
    assert list((tmp_path / "a").glob(".checkpoint.*.part.zip"))
    assert steps_of(tmp_path / "a") == 32
    train(read_run(tmp_path / "a"), tmp_path / "a", resume=True, quiet=True)
    assert not list((tmp_path / "a").glob(".*"))
    train(settings, tmp_path / "whole", quiet=True)
    assert_same_run(tmp_path / "whole", tmp_path / "a")
