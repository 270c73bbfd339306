"""A trial of `agents.tune`: trainings on seeds of their own, broken off where they lag behind."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from stable_baselines3.common.callbacks import BaseCallback

from agents.configuration import Settings, study_seeds
from agents.train import new_model
from powered_walker_env.controllers import evaluate
from powered_walker_env.controllers.stable_baselines import double_precision
from powered_walker_env.sb3 import PoweredWalkerVecEnv

try:
    import optuna
except ImportError as error:
    raise ImportError(
        "agents.tune needs Optuna; install it: pip install 'powered-walker-env[study]'"
    ) from error

__all__ = ["Search", "optuna", "score"]
FIRST_SEED, SEEDS_APART = 1_000_000, 1000  # of studies that no one else makes
EVALUATIONS = 5  # of a training


@dataclass(frozen=True)
class Search:
    """What a search is: the same for all its trials, and for those that go on with it."""

    settings: Settings  # where it begins; a trial changes the hyperparameters
    seed: int = 0
    repeats: int = 1  # trainings of a trial, each with a seed of its own
    objective: str = "return"  # or "strides": what is to be greatest

    def trained_with(self, repeat: int) -> tuple[int, int]:
        """Seeds of the training and of its evaluations."""
        return study_seeds(FIRST_SEED + SEEDS_APART * self.seed + repeat)


class _Watch(BaseCallback):
    """Evaluates on the way, and says how it stands."""

    def __init__(self, search: Search, seed: int, report: Any) -> None:
        super().__init__()
        self.search, self.seed, self.report = search, seed, report
        self.told = 0

    def _on_rollout_start(self) -> None:
        run = self.search.settings
        if self.num_timesteps >= (self.told + 1) * run.n_timesteps / EVALUATIONS:
            self.tell()

    def _on_step(self) -> bool:
        return True

    def tell(self) -> float:
        """Evaluate the policy as it is, always on the same disturbances."""
        run = self.search.settings
        policy = double_precision(self.model)
        walks = evaluate(policy, run.env_id, run.episodes, self.seed, **run.env_kwargs)
        means = {"return": walks.mean_return.mean, "strides": walks.mean_strides.mean}
        found = means[self.search.objective]
        self.report(self.told, found)
        self.told += 1
        return found


def score(search: Search, values: dict[str, Any], trial: optuna.Trial | None = None) -> float:
    """What a learner's policies walk at the end of their trainings, in the mean.

    Args:
        values: hyperparameters, as a file has them.
        trial: to tell how it goes.

    Returns:
        The search's objective: return or strides of an episode.

    Raises:
        optuna.TrialPruned: it lags behind, or its network came to be no number.
    """
    results = []
    settings = replace(search.settings, hyperparameters=values)
    for repeat in range(search.repeats):
        training, evaluation = search.trained_with(repeat)

        def report(count: int, found: float, first: int = repeat * EVALUATIONS) -> None:
            if trial is not None:
                trial.report(found, first + count)
                if trial.should_prune():
                    raise optuna.TrialPruned

        env = PoweredWalkerVecEnv(settings.env_id, settings.n_envs, **settings.env_kwargs)
        try:
            model, watch = new_model(settings, env, training), _Watch(search, evaluation, report)
            try:
                model.learn(settings.n_timesteps, watch)
                results.append(watch.tell())
            except ValueError as error:  # torch: a distribution of NaN
                raise optuna.TrialPruned(str(error)) from error
        finally:
            env.close()
    return sum(results) / len(results)
