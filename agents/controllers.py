"""Controllers of the walker: open loop, a linear-quadratic regulator, and learnt policies.

All have the `predict` of Stable-Baselines3, on batches of observations.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import scipy.linalg
import yaml
from numpy.typing import NDArray

from agents.command import CONFIGS, UserError
from agents.networks import SUFFIX, load_network
from powered_walker_env import find_gait
from powered_walker_env.envs.task import Task

OPEN_LOOP, LQR_NAME = "open-loop", "lqr"
#: Weights where `configs/lqr.yml` has none: the stance leg, and a little of the actions.
STATE_COST, ACTION_COST = (1.0, 0.0, 1.0, 0.0), 0.03

Floats = NDArray[np.floating[Any]]


class Controller(Protocol):
    """Anything that turns observations (N, 4) into actions (N, k), as SB3's models do."""

    def predict(
        self,
        observation: Any,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[Any, Any]:
        """The actions, and the controller's own state for the next call (None if it has none)."""
        ...


class OpenLoop:
    """The nominal control whatever happens: the stability of the gait itself.

    Args:
        actions: how many numbers the control has.
    """

    def __init__(self, actions: int = 2) -> None:
        self.actions = actions

    def predict(
        self,
        observation: Any,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[Floats, None]:
        """Zero actions."""
        return np.zeros((*np.shape(observation)[:-1], self.actions), np.float32), None


class LQR:
    """A discrete linear-quadratic regulator on the step map, linearised at the gait.

    It minimises the sum over strides of x'Qx + a'Ra, where x is the observation (the
    deviation from the gait over its scale) and a the action (1 is the full range).

    Args:
        task: of the environment (`env.unwrapped.task`).
        state_cost: Q: a number, the diagonal (4), or a matrix (4, 4).
        action_cost: R: a number, the diagonal (k), or a matrix (k, k), positive definite.

    Raises:
        ValueError: a gait of more than one stride, or weights that will not do.
    """

    def __init__(
        self,
        task: Task,
        state_cost: float | Sequence[Any] = STATE_COST,
        action_cost: float | Sequence[Any] = ACTION_COST,
    ) -> None:
        if len(task.gait) != 1:
            raise ValueError(f"LQR needs a gait of one stride, got one of {len(task.gait)} strides")
        self.Q = Q = _weight("state_cost", state_cost, 4)
        self.R = R = _weight("action_cost", action_cost, len(task.nominal))
        self.A, self.B = linear_step_map(task)
        try:
            P = scipy.linalg.solve_discrete_are(self.A, self.B, Q, R)
        except np.linalg.LinAlgError as error:
            raise ValueError(f"no regulator for these weights: {error}") from error
        gain = np.linalg.solve(R + self.B.T @ P @ self.B, self.B.T @ P @ self.A)
        self.gain: NDArray[np.float64] = gain  # (k, 4): action = −gain · observation

    def predict(
        self,
        observation: Any,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[Floats, None]:
        """Actions −K x, clipped to their range."""
        actions = -np.asarray(observation, np.float64) @ self.gain.T
        return np.clip(actions, -1.0, 1.0).astype(np.float32), None


def linear_step_map(task: Task) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A (4, 4) and B (4, k) of the step map in observations and actions."""
    gait = find_gait(task.params, task.control, task.gait[0].tolist())
    scale = task.scale[:, np.newaxis]
    by_control = gait.control_jacobian * task.half_range / scale
    return gait.jacobian * task.scale / scale, by_control


def _weight(name: str, value: float | Sequence[Any], size: int) -> NDArray[np.float64]:
    """A weight as a symmetric matrix."""
    given = np.asarray(value, np.float64)
    if given.ndim < 2 and given.size in (1, size):
        given = np.diag(np.broadcast_to(given, (size,)))
    if given.shape != (size, size) or not np.isfinite(given).all() or (given != given.T).any():
        raise ValueError(
            f"{name} must be a number, {size} numbers or a symmetric {size}x{size} matrix, "
            f"got {value!r}"
        )
    lowest = float(np.linalg.eigvalsh(given)[0])
    if lowest < 0 or (name == "action_cost" and lowest == 0):
        raise ValueError(f"{name} must be positive, got {value!r}")
    return np.array(given)


def lqr_for(env_id: str, task: Task) -> LQR:
    """The regulator with the weights that `configs/lqr.yml` has for an environment.

    Raises:
        ValueError: a gait of more than one stride, or weights that will not do.
    """
    weights = yaml.safe_load((CONFIGS / "lqr.yml").read_text(encoding="utf-8"))
    return LQR(task, **weights.get(env_id.rpartition(":")[2], {}))


def make_controller(text: str, task: Task, env_id: str) -> tuple[str, Controller]:
    """The controller that a word of the command line means, and its name for tables.

    Args:
        text: "open-loop", "lqr", a saved model or a run folder.
        task, env_id: of the environment it will meet.

    Raises:
        UserError: a file that is missing, damaged, or of another kind of environment.
    """
    if text == OPEN_LOOP:
        return "open loop", OpenLoop(len(task.nominal))
    if text == LQR_NAME:
        try:
            return "LQR", lqr_for(env_id, task)
        except ValueError as error:
            raise UserError(str(error)) from error
    return load_controller(Path(text), env_id)


def load_controller(path: Path, env_id: str | None = None) -> tuple[str, Controller]:
    """A saved model, or the best one of a run folder, and its name for tables.

    Raises:
        UserError: a file that is missing, damaged, or of another kind of environment.
    """
    from agents.algorithms import algorithm_of, limit_threads, load_model  # needs torch
    from agents.runs import BEST_MODEL, POLICY

    if path.suffix == SUFFIX or (path / POLICY).is_file():
        return _load_policy(path / POLICY if path.is_dir() else path, env_id)
    if not path.exists() and path.suffix != ".zip" and len(path.parts) == 1:
        raise UserError(
            f"controllers are {OPEN_LOOP!r}, {LQR_NAME!r}, a model file or a run folder, "
            f"got {str(path)!r}"
        )
    file = path / BEST_MODEL if path.is_dir() else path
    kind = algorithm_of(file)
    limit_threads()
    model = load_model(file)
    spaces = model.observation_space.shape, model.action_space.shape
    if spaces != ((4,), (2,)):
        raise UserError(
            f"{str(file)!r} was trained on another task: observations and actions of shape "
            f"{spaces[0]} and {spaces[1]}, not (4,) and (2,)"
        )
    _warn_of_other_training(file, env_id)
    label = file.parent.name if file.name == BEST_MODEL else f"{file.parent.name}/{file.stem}"
    return f"{kind.upper()} {label.lstrip('/')}".rstrip(), model


def _load_policy(file: Path, env_id: str | None) -> tuple[str, Controller]:
    """A policy of `agents.analytic_gradient`, and its name for tables."""
    network = load_network(file)
    _warn_of_another(file, network.env_id, env_id)
    label = file.parent.name if file.stem == "policy" else file.stem
    return f"analytic gradient {label}".rstrip(), network


def _warn_of_other_training(file: Path, env_id: str | None) -> None:
    """Say so if a model comes from another environment: the shapes alone do not tell."""
    from agents.runs import CONFIG, read_run

    if (file.parent / CONFIG).is_file():
        _warn_of_another(file, read_run(file.parent).env_id, env_id)


def _warn_of_another(file: Path, trained_on: str, env_id: str | None) -> None:
    trained = trained_on.rpartition(":")[2]
    if env_id is not None and trained != env_id.rpartition(":")[2]:
        print(f"note: {str(file)!r} was trained on {trained}, not on {env_id}", file=sys.stderr)
