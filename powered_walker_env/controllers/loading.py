"""A controller by name: what one writes on a command line, or has saved."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

from powered_walker_env.controllers.controller import Controller, OpenLoop, as_controller
from powered_walker_env.controllers.lqr import LQR
from powered_walker_env.controllers.network import load_network
from powered_walker_env.controllers.optimal import Optimal
from powered_walker_env.controllers.scores import OPEN_LOOP_NAME, OPTIMUM_NAME
from powered_walker_env.envs.paths import imported
from powered_walker_env.envs.task import Task
from powered_walker_env.poincare import Optimum
from powered_walker_env.results import holds_result, load_result

OPEN_LOOP, LQR_NAME, OPTIMAL = "open-loop", "lqr", "optimal"
POLICY, BEST_MODEL = "policy.npz", "best_model.zip"  # in the folder of a training
KINDS = (
    f"{OPEN_LOOP!r}, {LQR_NAME!r}, {OPTIMAL!r}, a policy or an optimum (.npz), a model of "
    "Stable-Baselines3 (.zip), the folder of a training, or module:function"
)


def load_controller(source: Any, task: Task, env_id: str | None = None) -> tuple[str, Controller]:
    """The controller that something means at a task, and its name for tables.

    Args:
        source: a controller; a function from (N, 4) observations to (N, k) actions; or, as a
            text or path: "open-loop", "lqr", "optimal" (where the optimum comes with the
            package), a policy or an optimum (.npz), a model of Stable-Baselines3
            (.zip, a pickle: a warning says so), the folder of a training, or
            "module:function", which is imported.
        task: of the environment that it will meet.
        env_id: its id; a warning says so if a policy was trained on another.

    Raises:
        FileNotFoundError, ImportError: nothing there.
        ValueError, TypeError: a damaged file, another kind of task, or no controller at all.
    """
    if not isinstance(source, str | Path):
        controller = as_controller(source)
        return str(getattr(source, "__name__", type(source).__name__)), controller
    if source == OPEN_LOOP:
        return OPEN_LOOP_NAME, OpenLoop(len(task.nominal))
    if source == OPTIMAL:
        return OPTIMUM_NAME, Optimal(task)
    if source == LQR_NAME:
        return "LQR", LQR(task)
    if re.fullmatch(r"[A-Za-z_][\w.]*:[A-Za-z_][\w.]*", str(source)):
        return str(source), _controller_at(str(source))
    return _saved(Path(source), task, env_id)


def _controller_at(source: str) -> Controller:
    try:
        return as_controller(imported(source))
    except ImportError as error:
        raise ImportError(f"the controller {error}") from error


def _saved(path: Path, task: Task, env_id: str | None) -> tuple[str, Controller]:
    if path.is_dir():
        without_code = (path / POLICY).is_file()
        return _saved(path / (POLICY if without_code else BEST_MODEL), task, env_id)
    if not path.exists() and path.suffix not in (".npz", ".zip"):
        raise FileNotFoundError(f"controllers are {KINDS}, got {str(path)!r}")
    folder = path.absolute().parent.name
    label = folder if path.name in (POLICY, BEST_MODEL) else f"{folder}/{path.stem}"
    if path.suffix == ".npz" and holds_result(path):
        return OPTIMUM_NAME, Optimal(task, _optimum_in(path))
    if path.suffix == ".npz":
        network = load_network(path)
        _check_spaces(path, (4,), (network.actions,), task)
        trained_on = str(network.settings.get("env_id", env_id)).rpartition(":")[2]
        if env_id is not None and trained_on != env_id.rpartition(":")[2]:
            warnings.warn(
                f"{str(path)!r} was trained on {trained_on}, not on {env_id}", stacklevel=3
            )
        return f"{network.settings.get('algo', 'network')} {label}", network
    from powered_walker_env.controllers.stable_baselines import load_sb3_policy  # needs torch

    policy = load_sb3_policy(path)
    _check_spaces(path, policy.observation_space.shape, policy.action_space.shape, task)
    return f"SB3 {label}", policy


def _optimum_in(path: Path) -> Optimum:
    found = load_result(path)
    if not isinstance(found, Optimum):
        raise ValueError(
            f"{str(path)!r} must hold an optimum to be a controller, got a {type(found).__name__}"
        )
    return found


def _check_spaces(path: Path, observations: Any, actions: Any, task: Task) -> None:
    wanted = ((4,), (len(task.nominal),))
    if (observations, actions) != wanted:
        raise ValueError(
            f"{str(path)!r} was trained on another task: observations and actions of shape "
            f"{observations} and {actions}, not {wanted[0]} and {wanted[1]}"
        )
