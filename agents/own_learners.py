"""The learners that are not of SB3, by the names that the study and its tables use."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from agents import evolution_learner, gradient_learner
from agents.own_training import OwnLearner


class Own(NamedTuple):
    """A learner and its command."""

    module: str  # of `agents`, to be run
    settings: Callable[..., Any]
    learner: Callable[[Any], OwnLearner]


OWN_LEARNERS = {
    gradient_learner.ALGO: Own(
        "analytic_gradient", gradient_learner.Settings, gradient_learner.GradientLearner
    ),
    evolution_learner.ALGO: Own(
        "evolution", evolution_learner.Settings, evolution_learner.EvolutionLearner
    ),
}
