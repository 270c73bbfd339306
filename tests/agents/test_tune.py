"""The search for good settings: on seeds of its own, resumable, and written in the zoo's format."""

from __future__ import annotations

import dataclasses
import itertools
from pathlib import Path
from typing import Any

import filelock
import pytest
import yaml

pytest.importorskip("optuna")
import optuna

import agents.tune
from agents.command import exit_status
from agents.configuration import Settings, read_settings, study_seeds
from agents.search_space import SPACES, chosen, literal_text
from agents.trials import Search, score
from agents.tune import main, open_study, search_on
from agents.zoo import python_literal
from powered_walker_env.controllers import EPISODE_SEED

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"
OFF_POLICY = """\
  n_envs: 4
  buffer_size: 300
  learning_starts: 40
  policy_kwargs: "dict(net_arch=[8])"
"""
CONFIG = {
    "ppo": '  n_envs: 4\n  policy_kwargs: "dict(net_arch=[8], activation_fn=nn.ReLU)"\n',
    "sac": OFF_POLICY, "tqc": OFF_POLICY, "crossq": OFF_POLICY,
}  # fmt: skip


def command(folder: Path, algo: str = "ppo", *more: str) -> list[str]:
    """A search of seconds."""
    config = folder / f"{algo}.yml"
    config.write_text(f"{ROUND_FOOT}:\n{CONFIG[algo]}")
    words = ["--algo", algo, "--env", ROUND_FOOT, "--config", str(config), "--steps", "64"]
    words += ["--episodes", "3", "--runs", str(folder), "--name", "search"]
    return [*words, "--out", str(folder / "best.yml"), *more]


@pytest.mark.parametrize("algo", SPACES)
def test_the_winner_can_be_trained(
    algo: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main(command(tmp_path, algo, "--trials", "2", "--env-kwargs", "disturbance:rough"))
    said = capsys.readouterr().out
    assert "present settings: " in said and "trial 2 of 2: " in said
    text = (tmp_path / "best.yml").read_text()
    assert "# end) of 1 x 64 strides, 0 minutes; python -m agents.tune --seed 0" in text
    settings = read_settings(algo, ROUND_FOOT, tmp_path / "best.yml")
    assert (settings.n_timesteps, settings.n_envs) == (64, 4)
    assert settings.env_kwargs == {"disturbance": "rough"}
    assert settings.model_kwargs(2)["policy_kwargs"]["net_arch"] != [8]
    if algo == "ppo":  # what is not searched stays
        assert settings.model_kwargs(2)["policy_kwargs"]["activation_fn"].__name__ == "ReLU"
    value = float(text.split("return ")[1].split(";")[0])
    search = Search(read_settings(algo, ROUND_FOOT, tmp_path / "best.yml", episodes=3))
    assert score(search, settings.hyperparameters) == pytest.approx(value, abs=0.051)


def test_strides_can_be_what_is_to_be_greatest(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main(command(tmp_path, "ppo", "--trials", "1", "--objective", "strides"))
    assert "present settings: strides " in capsys.readouterr().out
    text = (tmp_path / "best.yml").read_text()
    search = Search(read_settings("ppo", ROUND_FOOT, tmp_path / "best.yml", episodes=3))
    values = search.settings.hyperparameters
    walked = score(dataclasses.replace(search, objective="strides"), values)
    assert text.startswith(f"# ppo: strides {walked:.1f}; ")
    assert walked > score(search, values)  # a stride earns less than 1


def test_a_stopped_search_goes_on_as_if_it_had_not_been(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    whole.mkdir()
    parts.mkdir()
    main(command(whole, "ppo", "--trials", "4"))
    calls = itertools.count()

    def interrupted(*args: Any) -> float:
        if next(calls) == 3:  # the present settings, two trials, and here
            raise KeyboardInterrupt
        return score(*args)

    monkeypatch.setattr(agents.tune, "score", interrupted)
    assert exit_status(lambda: main(command(parts, "ppo", "--trials", "4"))) == 130
    assert "interrupted; go on: python -m agents.tune --algo ppo" in capsys.readouterr().err
    assert not (parts / "best.yml").exists()
    monkeypatch.undo()
    main(command(parts, "ppo", "--trials", "4"))
    assert "trial 3 of 4" in capsys.readouterr().out
    sections = [yaml.safe_load((folder / "best.yml").read_text()) for folder in (whole, parts)]
    assert sections[0] == sections[1]


def test_a_trial_that_lags_behind_is_broken_off(tmp_path: Path) -> None:
    settings = Settings("ppo", ROUND_FOOT, n_envs=4, n_timesteps=64, episodes=3,
                        hyperparameters={"n_steps": 4, "batch_size": 16})  # fmt: skip
    study = open_study(Search(settings), f"sqlite:///{tmp_path / 'study.db'}")
    for _ in range(agents.tune.STARTUP):  # those before were better than anyone can be
        study.add_trial(optuna.trial.create_trial(
            value=101.0, intermediate_values=dict.fromkeys(range(5), 101.0),
        ))  # fmt: skip
    search_on(Search(settings), study, agents.tune.STARTUP + 1)
    last = study.get_trials()[-1]
    assert last.state is optuna.trial.TrialState.PRUNED
    assert len(last.intermediate_values) < 5


def test_what_was_killed_counts_as_no_trial(tmp_path: Path) -> None:
    search = Search(Settings("ppo", ROUND_FOOT, n_envs=4, n_timesteps=64, episodes=3,
                             hyperparameters={"n_steps": 4, "batch_size": 16}))  # fmt: skip
    storage = str(tmp_path / "trials.log")
    open_study(search, storage).ask()
    study = open_study(search, storage)
    search_on(search, study, 1)
    states = [each.state.name for each in study.get_trials()]
    assert states == ["FAIL", "COMPLETE"]


def test_no_study_and_no_evaluation_has_its_seeds() -> None:
    """Walkers of a batch are seeded s, s + 1, ..."""
    mine = [seed for s in range(5) for k in range(3)
            for seed in Search(Settings(), s, 3).trained_with(k)]  # fmt: skip
    others = [seed for s in range(1000) for seed in study_seeds(s)]
    others += [0, EPISODE_SEED, 50_000]
    assert len(set(mine)) == len(mine)
    assert min(abs(a - b) for a in mine for b in others) > 20_000


def test_what_is_searched_is_known_to_its_algorithm() -> None:
    for algo in SPACES:
        study = optuna.create_study(sampler=optuna.samplers.RandomSampler(seed=0))
        for _ in range(20):
            section = chosen(algo, study.ask(), 8, {"policy_kwargs": "dict(log_std_init=-1)"})
            settings = Settings(algo, ROUND_FOOT, hyperparameters=section)
            assert 0.8 <= settings.model_kwargs(2)["gamma"] <= 0.995


def test_literals_there_and_back() -> None:
    text = "dict(net_arch=dict(pi=[8], qf=[16, 16]), activation_fn=nn.ReLU, log_std_init=-1.5)"
    assert literal_text(python_literal("policy_kwargs", text)) == text


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["--env", "Nowhere-v0"], "Nowhere"),
        (["--env-kwargs", "disturbance:hurricane"], "disturbance must be one of"),
        (["--out", "no/such/folder/best.yml"], "does not exist"),
        (["--storage", "nosql://here"], "the storage 'nosql://here' cannot be opened"),
        (["--name", "../away"], "name must be letters"),
    ],
)
def test_silly_arguments_are_named(
    more: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert exit_status(lambda: main(command(tmp_path, "ppo", "--trials", "1", *more))) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "best.yml").exists()


def test_two_processes_do_not_go_on_with_one_search(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "search").mkdir()
    with filelock.FileLock(tmp_path / "search" / "trials.log.busy"):
        assert exit_status(lambda: main(command(tmp_path, "ppo", "--trials", "1"))) == 2
    assert "a search goes on in" in capsys.readouterr().err
    main(command(tmp_path, "ppo", "--trials", "1"))


def test_another_search_in_the_storage_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main(command(tmp_path, "ppo", "--trials", "1"))
    again = command(tmp_path, "ppo", "--trials", "1")
    assert exit_status(lambda: main(again)) == 2
    assert "exists" in capsys.readouterr().err
    assert exit_status(lambda: main([*again, "--overwrite", "--repeats", "2"])) == 2
    assert "holds a search with other settings" in capsys.readouterr().err
