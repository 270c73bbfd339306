"""A controller at its environment, as the measures meet it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from agents.study.budgets import Budget
from agents.study.cells import Cell
from powered_walker_env.controllers import Controller, TaskPolicy, policy_of
from powered_walker_env.envs.task import Task
from powered_walker_env.poincare import Gait, GaitNotFoundError, StrideMap, find_gait

SETTLED = 200  # strides walked without a push
PERIODS = (1, 2, 4)  # strides of a gait that is looked for where it has settled


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
        """Of the closed loop, undisturbed: where it settles, else near the task's own gait.

        Raises:
            GaitNotFoundError: there is none of so few strides there.
        """
        params, start = self.task.params, self.task.gait[0]
        settled = StrideMap(params, self.policy)(start[np.newaxis], SETTLED)[0]
        tries = [(start, 1)]
        if np.isfinite(settled).all():
            tries = [*((settled, period) for period in PERIODS), *tries]
        for guess, period in tries:
            try:
                return find_gait(params, self.policy, guess.tolist(), period=period)
            except GaitNotFoundError as error:
                reason = error
        raise reason

    @cached_property
    def nominal(self) -> Gait:
        """The task's own gait, of the open loop."""
        return find_gait(self.task.params, self.task.control, self.task.gait[0].tolist())
