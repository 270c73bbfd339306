"""What the study compares: environments, levels, controllers and learners, seeds.

A cell is one controller at one environment and level; a learner has one for each seed of its
training. What is left out to fit the time is declared in `LEFT_OUT`, each with its reason.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from agents.study.budgets import Budget
from powered_walker_env import ENVIRONMENTS
from powered_walker_env.controllers.shipped import LEARNERS as SHIPPED_LEARNERS

LIGHT, ROUGH = "light", "rough"
OPEN_LOOP, OPTIMAL = "open-loop", "optimal"  # what counts 0, and what counts 1
LEVELS = (LIGHT, ROUGH)  # light is what the ids register
#: Without training, by the names that `load_controller` knows, from the least to the most.
CONTROLLERS = (
    OPEN_LOOP, "tuned-open-loop", "trial-open-loop", "one-number", "numbers-1", "numbers-2",
    "numbers-3", "lqr", "deadbeat", "look-ahead-1", "look-ahead-2", "look-ahead-3", OPTIMAL,
)  # fmt: skip
DEFAULT = "ppo-default"  # PPO as SB3 has it
OFF_POLICY = ("sac", "tqc", "crossq")
#: Trained by `agents.train`, `agents.analytic_gradient` and `agents.evolution`.
LEARNERS = tuple(SHIPPED_LEARNERS)


@dataclass(frozen=True, order=True)
class Cell:
    """One controller, or one training of a learner, at one environment and level.

    Raises:
        ValueError: an unknown level or controller, a seed that is none.
    """

    env_id: str
    level: str
    controller: str
    seed: int = 0  # of the training; 0 without one

    def __post_init__(self) -> None:
        if self.level not in LEVELS:
            raise ValueError(f"level must be one of {', '.join(LEVELS)}, got {self.level!r}")
        if self.controller not in (*CONTROLLERS, *LEARNERS):
            known = ", ".join((*CONTROLLERS, *LEARNERS))
            raise ValueError(f"controller must be one of {known}, got {self.controller!r}")
        if not isinstance(self.seed, int) or self.seed < 0:
            raise ValueError(f"seed must be an integer of at least 0, got {self.seed!r}")

    @property
    def name(self) -> str:
        """Of its file, and of its run."""
        walker = self.env_id.rpartition(":")[2]
        return f"{walker}-{self.level}-{self.controller}-{self.seed}"

    @property
    def learns(self) -> bool:
        """Whether it is trained."""
        return self.controller in LEARNERS

    @property
    def algo(self) -> str:
        """Of its training, by the name that `agents.train` knows."""
        return "ppo" if self.controller == DEFAULT else self.controller

    @property
    def config(self) -> str | None:
        """Of its training: the file in `configs/`, where it is not that of the algorithm."""
        if self.controller == DEFAULT:
            return "ppo-default.yml"
        return "ppo-rough.yml" if (self.controller, self.level) == ("ppo", ROUGH) else None

    @property
    def env_kwargs(self) -> dict[str, str]:
        """Of the environment: none at the level that its id registers."""
        return {} if self.level == LIGHT else {"disturbance": self.level}


@dataclass(frozen=True)
class LeftOut:
    """Cells that the study does without."""

    controllers: Sequence[str]
    env_ids: Sequence[str]
    levels: Sequence[str]
    reason: str

    def holds(self, cell: Cell) -> bool:
        """Whether it is one of them."""
        return (
            cell.controller in self.controllers
            and cell.env_id in self.env_ids
            and cell.level in self.levels
        )


EVERYWHERE = tuple(ENVIRONMENTS)
LEFT_OUT = (
    LeftOut(
        OFF_POLICY, EVERYWHERE, (ROUGH,),
        "an off-policy training takes minutes of a core, and five of three learners on four "
        "walkers more than the two hours; at this level PPO and CMA-ES stand for the learners",
    ),
    LeftOut(
        ("tqc",), ("PoweredWalkerAsPublished-v1",), (LIGHT,),
        "a search of its settings found no more there than SAC has; a minute of a core each",
    ),
    LeftOut(
        ("cmaes",), ("PoweredWalker-v0", "PoweredWalkerAsPublished-v1"), (ROUGH,),
        "where hardly any walk is long a training takes three minutes of a core: there is little "
        "to win as published, and PPO leaves little on the thesis's walker",
    ),
    LeftOut(
        ("apg",), EVERYWHERE, (ROUGH,),
        "its first-order models of walks hold for pushes as small as the light ones",
    ),
    LeftOut(
        (DEFAULT,), EVERYWHERE, (ROUGH,),
        "what defaults reach is asked beside every other learner, at the level of the ids",
    ),
)  # fmt: skip

#: Cheap and telling ones first, should the study be stopped.
_STAGES: tuple[tuple[Sequence[str], Sequence[str]], ...] = (
    (CONTROLLERS, LEVELS),
    (("ppo",), (LIGHT,)),
    (("apg",), (LIGHT,)),
    (("sac",), (LIGHT,)),
    (("ppo",), (ROUGH,)),
    (("cmaes",), LEVELS),
    (("crossq", "tqc"), (LIGHT,)),
    ((DEFAULT,), (LIGHT,)),
)


def cells(budget: Budget) -> list[Cell]:
    """All cells of a study, in the order in which they are best done."""
    found = []
    for controllers, levels in _STAGES:
        for seed in range(budget.seeds):
            for controller in controllers:
                left = budget.controllers is not None and controller not in budget.controllers
                if left or (seed and controller in CONTROLLERS):
                    continue
                found += [
                    Cell(env_id, level, controller, seed)
                    for level in levels
                    for env_id in budget.env_ids
                ]
    return [cell for cell in found if not left_out(cell)]


def left_out(cell: Cell) -> str:
    """Why the study does without a cell; "" if it does not."""
    return next((group.reason for group in LEFT_OUT if group.holds(cell)), "")


def chosen(every: Sequence[Cell], only: Sequence[str] | None) -> list[Cell]:
    """The cells whose names have one of these texts in them; all, if there are none.

    Raises:
        ValueError: a text that no cell's name has.
    """
    if not only:
        return list(every)
    for text in only:
        if not any(text in cell.name for cell in every):
            raise ValueError(
                f"--only must be part of a cell's name, as {every[0].name!r}, got {text!r}"
            )
    return [cell for cell in every if any(text in cell.name for text in only)]
