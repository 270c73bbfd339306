"""What a search for good settings may choose: rl-baselines3-zoo's ranges, fit to this environment.

The rollouts of PPO are as short here as its batches are wide, and exploration (`log_std_init`)
matters more than elsewhere. How often an off-policy learner updates stays as the configuration has
it: that is its budget.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from agents.zoo import python_literal
from powered_walker_env.controllers.stable_baselines import StrideMetric

if TYPE_CHECKING:
    import optuna

_NETWORKS = {"small": [64, 64], "medium": [128, 128]}


def _common(trial: optuna.Trial) -> tuple[dict[str, Any], dict[str, Any]]:
    rate = trial.suggest_float("learning_rate", 1e-4, 5e-3, log=True)
    schedule = trial.suggest_categorical("schedule", ["lin_", ""])
    values: dict[str, Any] = {
        "gamma": _rounded(1.0 - trial.suggest_float("one_minus_gamma", 0.005, 0.2, log=True)),
        "learning_rate": f"{schedule}{rate:.2g}" if schedule else _rounded(rate),
    }
    size = trial.suggest_categorical("net_arch", list(_NETWORKS))
    return values, {"net_arch": _NETWORKS[size]}


def _on_policy(trial: optuna.Trial, n_envs: int) -> tuple[dict[str, Any], dict[str, Any]]:
    values, policy = _common(trial)
    steps = trial.suggest_categorical("n_steps", [8, 16, 32, 64])
    batches = trial.suggest_categorical("batches", [4, 8, 16])
    lam = 1.0 - trial.suggest_float("one_minus_gae_lambda", 0.005, 0.3, log=True)
    values |= {
        "n_steps": steps,
        "batch_size": max(2, steps * n_envs // batches),
        "n_epochs": trial.suggest_categorical("n_epochs", [5, 10, 20]),
        "gae_lambda": _rounded(lam),
        "clip_range": trial.suggest_categorical("clip_range", [0.1, 0.2, 0.3]),
        "ent_coef": _rounded(trial.suggest_float("ent_coef", 1e-8, 0.01, log=True)),
    }
    policy["log_std_init"] = round(trial.suggest_float("log_std_init", -4.0, 0.0), 2)
    return values, policy


def _off_policy(trial: optuna.Trial, n_envs: int) -> tuple[dict[str, Any], dict[str, Any]]:
    values, policy = _common(trial)
    values["batch_size"] = trial.suggest_categorical("batch_size", [128, 256, 512])
    values["target_entropy"] = _rounded(-trial.suggest_float("less_entropy", 1.0, 8.0, log=True))
    return values, policy


def _sac(trial: optuna.Trial, n_envs: int) -> tuple[dict[str, Any], dict[str, Any]]:
    values, policy = _off_policy(trial, n_envs)
    values["tau"] = trial.suggest_categorical("tau", [0.005, 0.01, 0.02, 0.05])
    return values, policy


def _tqc(trial: optuna.Trial, n_envs: int) -> tuple[dict[str, Any], dict[str, Any]]:
    values, policy = _sac(trial, n_envs)
    values["top_quantiles_to_drop_per_net"] = trial.suggest_int("dropped_quantiles", 0, 5)
    return values, policy


def _crossq(trial: optuna.Trial, n_envs: int) -> tuple[dict[str, Any], dict[str, Any]]:
    values, policy = _off_policy(trial, n_envs)
    values["policy_delay"] = trial.suggest_categorical("policy_delay", [1, 2, 3])
    critic = trial.suggest_categorical("critic", [64, 128, 256])
    policy["net_arch"] = {"pi": policy["net_arch"], "qf": [critic, critic]}
    return values, policy


_Sampler = Callable[["optuna.Trial", int], tuple[dict[str, Any], dict[str, Any]]]
#: Algorithms that can be tuned.
SPACES: dict[str, _Sampler] = {"ppo": _on_policy, "sac": _sac, "tqc": _tqc, "crossq": _crossq}


def chosen(
    algo: str, trial: optuna.Trial, n_envs: int, section: Mapping[str, Any]
) -> dict[str, Any]:
    """The section of a configuration with what a trial chooses in the place of its own.

    Args:
        section: hyperparameters as a file has them; what the search does not choose stays.
    """
    values, policy = SPACES[algo](trial, n_envs)
    before = section.get("policy_kwargs") or {}
    if isinstance(before, str):
        before = python_literal("policy_kwargs", before)
    return {**section, **values, "policy_kwargs": literal_text({**before, **policy})}


def literal_text(value: Any) -> str:
    """What `zoo.python_literal` reads: `dict(net_arch=[64, 64], activation_fn=nn.ReLU)`."""
    if isinstance(value, Mapping):
        return f"dict({', '.join(f'{key}={literal_text(one)}' for key, one in value.items())})"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(literal_text, value))}]"
    if inspect.isclass(value):
        return value.__name__ if value is StrideMetric else f"nn.{value.__name__}"
    return repr(value)


def _rounded(number: float) -> float:
    """Four digits: more say nothing, and a file with fewer is read more easily."""
    return float(f"{number:.4g}")
