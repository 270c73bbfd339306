"""What a controller is: anything that turns observations into actions, as SB3's models do.

Observations are deviations from the gait over their scale, actions fractions of the range
about the nominal control; `policy_of` makes a policy of the stride map of one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np


class Controller(Protocol):
    """Anything with the `predict` of Stable-Baselines3, on batches of observations.

    With a method `derivative(observations)`, (N, 4) to (N, k, 4), its closed loop need not
    be differenced.
    """

    def predict(self, observation: Any, *args: Any, **kwargs: Any) -> tuple[Any, Any]:
        """`predict(observations, memory, episode_start, deterministic=True)`.

        Args of the call: (N, 4) observations; what the last call returned second, None at
        first; (N,) whether an episode begins.

        Returns:
            (N, k) actions, and the controller's own memory for the next call, or None.
        """


class OpenLoop:
    """The nominal control whatever happens: the stability of the gait itself.

    Args:
        actions: k, how many numbers the control has.
    """

    on_section = True  # whatever is seen

    def __init__(self, actions: int = 2) -> None:
        self.actions = actions

    def predict(
        self, observation: Any, *_: Any, deterministic: bool = True
    ) -> tuple[np.ndarray, None]:
        """Zero actions."""
        return np.zeros((*np.shape(observation)[:-1], self.actions), np.float32), None


class FunctionController:
    """A function from (N, 4) observations to (N, k) actions as a controller."""

    def __init__(self, function: Callable[[Any], Any]) -> None:
        self.function = function

    def predict(self, observation: Any, *_: Any, deterministic: bool = True) -> tuple[Any, None]:
        """What the function says."""
        return self.function(observation), None


def as_controller(given: Any) -> Controller:
    """A controller as it is, or a function as one.

    Raises:
        TypeError: neither.
    """
    if callable(getattr(given, "predict", None)):
        controller: Controller = given
        return controller
    if callable(given) and not isinstance(given, type):
        return FunctionController(given)
    raise TypeError(
        "controller must have a method predict, or be a function from (N, 4) observations to "
        f"(N, k) actions, got {given!r}"
    )
