"""Training settings in rl-baselines3-zoo's format: read, checked, and nothing run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import torch

from agents.command import CONFIGS
from agents.configuration import Settings, read_settings, study_seeds
from agents.zoo import linear_schedule, python_literal
from powered_walker_env import ENVIRONMENTS
from powered_walker_env.controllers.stable_baselines import StrideMetric

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"


def write(folder: Path, section: str) -> Path:
    path = folder / "config.yml"
    lines = "".join(f"  {line}\n" for line in section.split("\n"))
    path.write_text(f"{ROUND_FOOT}:\n{lines}", encoding="utf-8")
    return path


@pytest.mark.parametrize("algo", ["ppo", "sac", "tqc", "crossq"])
@pytest.mark.parametrize("env_id", ENVIRONMENTS)
def test_the_shipped_configurations_cover_every_environment(algo: str, env_id: str) -> None:
    settings = read_settings(algo, f"powered_walker_env:{env_id}")
    assert settings.n_timesteps > 1000
    assert settings.every == settings.n_timesteps // 10
    assert settings.model_kwargs(2)["policy"] == "MlpPolicy"


@pytest.mark.parametrize("env_id", list(ENVIRONMENTS))
def test_rough_pushes_have_a_file_of_their_own(env_id: str) -> None:
    settings = read_settings("ppo", env_id, CONFIGS / "ppo-rough.yml")
    assert settings.env_kwargs == {"disturbance": "rough"}


def test_the_zoo_format(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        "n_envs: 8\nn_timesteps: !!float 2e4\npolicy: 'MlpPolicy'\nlearning_rate: lin_1e-3\n"
        "clip_range: 0.1\nnormalize: false\nenv_kwargs: {disturbance: rough}\n"
        'policy_kwargs: "dict(net_arch=dict(pi=[8], vf=[16]), activation_fn=nn.ReLU)"',
    )
    settings = read_settings("ppo", ROUND_FOOT, path, env_kwargs={"reward": "periodicity"})
    assert (settings.n_envs, settings.n_timesteps) == (8, 20000)
    assert settings.env_kwargs == {"disturbance": "rough", "reward": "periodicity"}
    kwargs = settings.model_kwargs(2)
    assert kwargs["learning_rate"](0.5) == 5e-4
    assert kwargs["policy_kwargs"] == {
        "net_arch": {"pi": [8], "vf": [16]},
        "activation_fn": torch.nn.ReLU,
    }
    assert set(kwargs) == {"policy", "policy_kwargs", "learning_rate", "clip_range"}


def test_what_is_given_takes_the_place_of_the_file() -> None:
    settings = read_settings(
        "ppo",
        ROUND_FOOT,
        seed=7,
        n_timesteps=5,
        hyperparameters={"gamma": 0.5},
        every=2,
        episodes=3,
    )
    assert (settings.seed, settings.n_timesteps) == (7, 5)
    assert (settings.every, settings.episodes) == (2, 3)
    assert settings.model_kwargs(2)["gamma"] == 0.5


def test_an_algorithm_without_a_file_has_the_defaults_of_its_library() -> None:
    settings = read_settings("a2c", "PoweredWalker-v0", n_timesteps=100)
    assert settings.model_kwargs(2) == {"policy": "MlpPolicy"}


def test_noise_and_train_frequency_of_the_zoo(tmp_path: Path) -> None:
    path = write(tmp_path, "noise_type: normal\nnoise_std: 0.2\ntrain_freq: [1, episode]")
    kwargs = read_settings("td3", ROUND_FOOT, path).model_kwargs(2)
    assert kwargs["train_freq"] == (1, "episode")
    assert "sigma=[0.2 0.2]" in repr(kwargs["action_noise"])


@pytest.mark.parametrize(
    ("section", "message"),
    [
        (
            "gama: 0.9",
            r"unknown key 'gama'; known for ppo: batch_size, .*gamma.*\(in .*config\.yml",
        ),
        ("seed: 3", "unknown key 'seed'"),
        ("normalize: true", "normalize must be false"),
        ("n_envs: 0", "n_envs must be a positive integer, got 0"),
        ("n_timesteps: 1.5", r"n_timesteps must be a positive integer, got 1\.5"),
        ("learning_rate: fast", "learning_rate must be a number or like 'lin_1e-3', got 'fast'"),
        ("gamma: .nan", "gamma must be a finite number, got nan"),
        ("gamma: 5", r"gamma must lie in \[0, 1\], got 5"),
        ("gae_lambda: -0.1", r"gae_lambda must lie in \[0, 1\], got -0\.1"),
        ("gamma: high", "gamma must be a finite number, got 'high'"),
        ("learning_rate: .inf", "learning_rate must be a finite number, got inf"),
        ("learning_rate: -1e-3", "learning_rate must be a number or like 'lin_1e-3', got '-1e-3'"),
        ("learning_rate: lin_nan", "learning_rate must be a number or like"),
        ("batch_size: 2.5", r"batch_size must be a positive integer, got 2\.5"),
        ("n_steps: 0", "n_steps must be a positive integer, got 0"),
        ("n_envs: many", "n_envs must be a positive integer, got 'many'"),
        ("env_kwargs: 3", "env_kwargs must be a mapping of names to values, got 3"),
        ("env_kwargs: [1]", "env_kwargs must be a mapping"),
        ("policy_kwargs: dict(a=open('x'))", "policy_kwargs must be a dictionary of plain values"),
        ("policy_kwargs: '[1, 2]'", "policy_kwargs must be a dictionary, got"),
        ("policy_kwargs: dict(activation_fn=nn.Linear)", "plain values"),
        ("policy_kwargs: \"dict(**{'a': 1})\"", "plain values"),
        ("policy_kwargs: 'dict('", "plain values"),
    ],
)
def test_bad_settings_are_named(section: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=message):
        read_settings("ppo", ROUND_FOOT, write(tmp_path, section))


@pytest.mark.parametrize(
    ("name", "value"),
    [("every", "soon"), ("episodes", 0), ("seed", -1), ("seed", 1.5), ("n_timesteps", True)],
)
def test_bad_fields_are_named(name: str, value: object) -> None:
    given: dict[str, Any] = {name: value}
    with pytest.raises(ValueError, match=f"{name} must be .*, got {value!r}"):
        Settings(**given)


def test_every_file_is_utf_8(tmp_path: Path) -> None:
    path = tmp_path / "config.yml"
    path.write_bytes("# größer, γ\nMäh-v0: {gamma: 0.5}\n".encode())
    assert read_settings("ppo", "Mäh-v0", path).hyperparameters == {"gamma": 0.5}


def test_seeds_of_a_study_share_no_walker() -> None:
    """Walkers of a batch are seeded s, s + 1, ...: 0 and 1 as they are would share all but one."""
    walkers = [seed + i for s in range(20) for seed in study_seeds(s) for i in range(100)]
    assert len(set(walkers)) == len(walkers)
    assert study_seeds(3) == study_seeds(3)
    assert Settings(seed=3).seeds == study_seeds(3)


def test_bad_noise_is_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="noise_type must be 'normal'"):
        read_settings("td3", ROUND_FOOT, write(tmp_path, "noise_type: pink\nnoise_std: 0.1"))


def test_bad_files_are_named(tmp_path: Path) -> None:
    path = write(tmp_path, "gamma: 0.9")
    with pytest.raises(ValueError, match=r"no section for 'PoweredWalker-v0', only for: Powered"):
        read_settings("ppo", "PoweredWalker-v0", path)
    with pytest.raises(ValueError, match=r"'nowhere\.yml' cannot be read"):
        read_settings("ppo", ROUND_FOOT, Path("nowhere.yml"))
    path.write_text("a: [1")
    with pytest.raises(ValueError, match=r"config\.yml' is not YAML"):
        read_settings("ppo", ROUND_FOOT, path)
    path.write_text("just words")
    with pytest.raises(ValueError, match="no section"):
        read_settings("ppo", ROUND_FOOT, path)
    with pytest.raises(ValueError, match=r"algo must be one of ppo, .*, got 'dqn'"):
        read_settings("dqn", ROUND_FOOT)


def test_schedules() -> None:
    assert linear_schedule("learning_rate", "lin_2e-3")(0.25) == 5e-4
    assert linear_schedule("learning_rate", "1e-3")(0.25) == 1e-3  # YAML reads 1e-3 as a text
    with pytest.raises(ValueError, match="got 'lin_'"):
        linear_schedule("learning_rate", "lin_")


def test_the_extractor_has_its_name() -> None:
    read = python_literal("policy_kwargs", "dict(features_extractor_class=StrideMetric)")
    assert read == {"features_extractor_class": StrideMetric}


def test_literals_run_nothing() -> None:
    assert python_literal("x", "{'a': (1, -2.5), 'b': None}") == {"a": (1, -2.5), "b": None}
    for text in ("__import__('os').getcwd()", "dict(a=[].append)", "{**{}}", "dict(a=b)"):
        with pytest.raises(ValueError):
            python_literal("x", text)
