"""A controller at its environment, as the measures meet it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from agents.study.budgets import Budget
from agents.study.cells import Cell
from powered_walker_env.controllers import Controller, TaskPolicy, policy_of
from powered_walker_env.envs.task import Task
from powered_walker_env.poincare import Gait, find_gait


@dataclass(frozen=True)
class Subject:
    """What is measured, and how much of it."""

    cell: Cell
    task: Task
    controller: Controller
    budget: Budget

    @property
    def env_kwargs(self) -> dict[str, Any]:
        """Of the environment."""
        return dict(self.cell.env_kwargs)

    @cached_property
    def policy(self) -> TaskPolicy:
        """Its closed loop, for the laboratory."""
        return policy_of(self.task, self.controller)

    @cached_property
    def gait(self) -> Gait:
        """Of the closed loop, undisturbed: the one near the gait that the task is about.

        Raises:
            GaitNotFoundError: there is none of one stride there.
        """
        return find_gait(self.task.params, self.policy, self.task.gait[0].tolist())

    @cached_property
    def nominal(self) -> Gait:
        """The task's own gait, of the open loop."""
        return find_gait(self.task.params, self.task.control, self.task.gait[0].tolist())
