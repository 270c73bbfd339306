"""How much of everything the study takes: seeds, episodes, walks, strides of a training."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from powered_walker_env import ENVIRONMENTS


@dataclass(frozen=True)
class Budget:
    """Sizes; results of different ones are not put side by side."""

    env_ids: tuple[str, ...] = tuple(ENVIRONMENTS)
    controllers: tuple[str, ...] | None = None  # names, learners' too; None: all
    seeds: int = 5  # of each learner
    episodes: int = 1000  # of the evaluation
    sweep_episodes: int = 200  # at each size of the pushes
    walks: int = 1000  # without the limit of an episode
    limit: int = 2000  # strides of these
    starts: int = 10_000  # of the basin
    nodes: int = 24  # along each axis, of the table of first passages
    decisions: int = 2000  # timed
    slice_points: int = 31  # along each axis, of the decisions kept
    resamples: int = 2000  # of the bootstrap
    #: Strides of a training in place of its configuration's, by learner.
    strides: Mapping[str, int] = field(default_factory=dict)
    training_episodes: int = 50  # of an evaluation of a training
    #: Walks, starts, pushes and decisions are fewer by these factors for controllers that walk
    #: the map to decide; episodes are not. They would take minutes else.
    slow: Mapping[str, int] = field(
        default_factory=lambda: {
            "look-ahead-1": 8,
            "look-ahead-2": 16,
            "look-ahead-3": 25,
            "optimal": 8,
        }
    )

    def of(self, controller: str) -> Budget:
        """The sizes for a controller."""
        factor = self.slow.get(controller, 1)
        fewer = {name: max(1, getattr(self, name) // factor) for name in _FEWER}
        return replace(self, **fewer) if factor > 1 else self

    def plain(self) -> dict[str, Any]:
        """The sizes as JSON has them; further environments, controllers and seeds may join."""
        return {name: value for name, value in asdict(self).items() if name not in _MORE}


_FEWER = ("sweep_episodes", "walks", "starts", "decisions")
_MORE = ("env_ids", "controllers", "seeds")


FULL = Budget()
#: The same code in half a minute, for tests: no result of it means anything.
SMALL = Budget(
    env_ids=("PoweredWalkerRoundFoot-v0", "PoweredWalkerKneed-v0"),
    controllers=("open-loop", "lqr", "optimal", "ppo", "apg", "sac", "cmaes"),
    seeds=2,
    episodes=40,
    sweep_episodes=10,
    walks=150,
    limit=60,
    starts=200,
    nodes=8,
    decisions=50,
    slice_points=7,
    resamples=100,
    strides={"ppo": 2048, "apg": 160, "sac": 1152, "ppo-default": 2048, "tqc": 1152,
             "crossq": 1152, "cmaes": 20_000},
    training_episodes=5,
)  # fmt: skip
