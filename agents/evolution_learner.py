"""The learner behind `agents.evolution`: candidates, the episodes they all walk, and CMA-ES.

N. Hansen & A. Ostermeier, Completely derandomized self-adaptation in evolution strategies,
Evolutionary Computation 9 (2001); its author's implementation, `cma`. The numbers of a network
with one hidden layer are drawn from a normal distribution whose mean and covariance follow the
best. Candidates of a generation meet the same disturbances, or luck would choose among them; the
next generation meets others.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.configuration import check_numbers
from powered_walker_env.controllers import Network
from powered_walker_env.controllers.evaluation import WALKED, walk_episodes, walkers_of
from powered_walker_env.controllers.metric import stride_metric
from powered_walker_env.simulation.strides import Array

ALGO = "cmaes"
INPUTS = 4  # observations


@dataclass(frozen=True)
class Settings:
    """What a training needs."""

    env_id: str
    seed: int = 0
    n_timesteps: int = 20_000_000  # strides, of all candidates together
    population: int = 32  # candidates of a generation
    walks: int = 128  # episodes that each of them walks
    hidden: int = 8  # units of the one hidden layer
    spread: float = 0.3  # of the first candidates' numbers about those of the start
    metric: bool = True  # whether observations come in the metric of the stride map
    episodes: int = 50  # of an evaluation
    env_kwargs: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_numbers(self, seed=0)
        if self.population < 4:
            raise ValueError(f"population must be at least 4, got {self.population}")
        if not isinstance(self.metric, bool):
            raise ValueError(f"metric must be true or false, got {self.metric!r}")


class Crowd:
    """Candidates as one controller: (n·m, 4) observations, m walkers of each, in this order."""

    def __init__(self, layers: Sequence[tuple[Array, Array]], metric: Array) -> None:
        (first, self._inner), (second, self._outer) = layers
        self._first, self._second = (first @ metric).swapaxes(1, 2), second.swapaxes(1, 2)

    def predict(self, observation: Any, *_: Any, deterministic: bool = True) -> tuple[Array, None]:
        """(n·m, k) actions, each by its own candidate."""
        seen = np.asarray(observation, np.float64).reshape(len(self._first), -1, INPUTS)
        hidden = np.tanh(seen @ self._first + self._inner[:, np.newaxis])
        actions = np.clip(hidden @ self._second + self._outer[:, np.newaxis], -1.0, 1.0)
        return actions.reshape(-1, actions.shape[-1]), None


class EvolutionLearner:
    """Candidates, their walkers, and the strategy that draws them.

    Raises:
        ValueError: an environment that does not exist, or, in the stride metric, a gait of
            several strides.
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        count = settings.population * settings.walks
        self._walkers, _ = walkers_of(settings.env_id, count, **settings.env_kwargs)
        task = self._walkers.task
        self._metric = stride_metric(task) if settings.metric else np.eye(INPUTS)
        self._actions = len(task.nominal)
        self.strides = self.falls = 0
        self._rng = np.random.default_rng(settings.seed)
        size = settings.hidden * (INPUTS + 1) + self._actions * (settings.hidden + 1)
        # Here, since it loads pyplot, which takes seconds and chooses a backend for all.
        import cma

        # Its own random numbers: numpy's global ones belong to nobody.
        options = {"popsize": settings.population, "randn": self._draw, "seed": math.nan,
                   "verbose": -9}  # fmt: skip
        self._strategy = cma.CMAEvolutionStrategy(np.zeros(size), settings.spread, options)
        self._kept: list[Array] = []  # of each generation: returns, strides, falls
        self._recalled: list[Array] = []  # of those to come, of a training that was stopped

    @property
    def finished(self) -> bool:
        """Whether the strides are walked."""
        return self.strides >= self.settings.n_timesteps

    def update(self) -> float:
        """One generation; the mean return of its candidates."""
        run = self.settings
        candidates = self._strategy.ask()
        first = int(self._rng.integers(2**31))
        found = self._recalled.pop(0) if self._recalled else self._walked(candidates, first)
        self._kept.append(found)
        returns, (strides, falls) = found[: run.population], found[run.population :]
        self.strides += int(strides)
        self.falls += int(falls)
        self._strategy.tell(candidates, (-returns).tolist())
        return float(returns.mean())

    def kept(self) -> Array:
        """(generations, population + 2) of each the returns, and strides and falls in all."""
        return np.array(self._kept).reshape(len(self._kept), self.settings.population + 2)

    def recall(self, kept: Array) -> None:
        """Take these for the walks of the generations to come: drawn alike, they are the same."""
        if kept.ndim != 2 or kept.shape[1] != self.settings.population + 2:
            raise ValueError(f"the returns kept have the shape {kept.shape}: of another training")
        if not np.isfinite(kept).all():
            raise ValueError("the returns kept must be finite: the file is damaged; begin again")
        self._recalled = list(kept)

    def network(self) -> Network:
        """The policy as it is now: the mean of the distribution."""
        run = self.settings
        layers = [tuple(part[0] for part in layer) for layer in
                  self._layers(self._strategy.mean[np.newaxis])]  # fmt: skip
        (weights, biases), last = layers
        about = {"algo": "CMA-ES", "env_id": run.env_id, "seed": run.seed, "steps": self.strides}
        return Network([(weights @ self._metric, biases), last], settings=about)

    def _walked(self, candidates: list[Array], first: int) -> Array:
        """The mean return of each candidate; strides and falls of all of them."""
        run = self.settings
        crowd = Crowd(self._layers(np.array(candidates)), self._metric)
        seeds = [first + i for i in range(run.walks)] * run.population
        walked = walk_episodes(crowd, self._walkers, seeds)
        falls = (walked.outcomes != WALKED).sum()
        returns = walked.returns.reshape(run.population, run.walks).mean(axis=1)
        return np.array([*returns, walked.strides.sum() + falls, falls])

    def _layers(self, numbers: Array) -> list[tuple[Array, Array]]:
        """Weights and biases of candidates (n, size), in the stride metric."""
        hidden, actions, n = self.settings.hidden, self._actions, len(numbers)
        shapes = [(hidden, INPUTS), (hidden,), (actions, hidden), (actions,)]
        ends = np.cumsum([math.prod(shape) for shape in shapes])[:-1]
        parts = np.split(numbers, ends, axis=1)
        first, second, third, fourth = (
            part.reshape(n, *shape) for part, shape in zip(parts, shapes, strict=True)
        )
        return [(first, second), (third, fourth)]

    def _draw(self, *shape: int) -> NDArray[np.float64]:
        return self._rng.standard_normal(shape)
