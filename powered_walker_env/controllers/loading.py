"""A controller by name: what one writes on a command line, or has saved."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from powered_walker_env.controllers.controller import Controller, OpenLoop, as_controller
from powered_walker_env.controllers.deadbeat import Deadbeat
from powered_walker_env.controllers.few_numbers import FewNumbers
from powered_walker_env.controllers.look_ahead import LookAhead
from powered_walker_env.controllers.lqr import LQR
from powered_walker_env.controllers.network import load_network
from powered_walker_env.controllers.one_number import OneNumber
from powered_walker_env.controllers.optimal import OPTIMUM_NAME, Optimal
from powered_walker_env.controllers.scores import OPEN_LOOP_NAME
from powered_walker_env.controllers.shipped import LEARNERS, shipped_policy
from powered_walker_env.controllers.tuned_open_loop import TunedOpenLoop
from powered_walker_env.envs.paths import imported
from powered_walker_env.envs.task import Task
from powered_walker_env.poincare import Optimum
from powered_walker_env.results import holds_result, load_result

OPEN_LOOP, LQR_NAME, OPTIMAL = "open-loop", "lqr", "optimal"
#: Controllers by name: the label in tables, and how to make one for a task.
NAMED: dict[str, tuple[str, Callable[[Task], Controller]]] = {
    OPEN_LOOP: (OPEN_LOOP_NAME, lambda task: OpenLoop(len(task.nominal))),
    LQR_NAME: ("LQR", LQR),
    "tuned-open-loop": ("tuned open loop", TunedOpenLoop),
    "trial-open-loop": ("open loop by trials", lambda task: TunedOpenLoop(task, "strides")),
    "one-number": ("one number", OneNumber),
    **{
        f"numbers-{count}": (f"{count} numbers", partial(FewNumbers, count=count))
        for count in (1, 2, 3, 4)
    },
    "deadbeat": ("deadbeat", Deadbeat),
    **{
        f"look-ahead-{strides}": (f"look-ahead {strides}", partial(LookAhead, strides=strides))
        for strides in (1, 2, 3)
    },
    OPTIMAL: (OPTIMUM_NAME, Optimal),
}
POLICY, BEST_MODEL = "policy.npz", "best_model.zip"  # in the folder of a training
KINDS = (
    f"{', '.join(map(repr, NAMED))}, a trained policy that comes with the package "
    f"({', '.join(map(repr, LEARNERS))}), a policy or an optimum (.npz), a model of "
    "Stable-Baselines3 (.zip), the folder of a training, or module:function"
)


def load_controller(source: Any, task: Task, env_id: str | None = None) -> tuple[str, Controller]:
    """The controller that something means at a task, and its name for tables.

    Args:
        source: a controller; a function from (N, 4) observations to (N, k) actions; or, as a
            text or path: a name in `NAMED` ("optimal" where the optimum comes with the
            package) or `LEARNERS` ("ppo", ...: the trained policy that comes with the package
            for this environment), a policy or an optimum (.npz), a model of Stable-Baselines3
            (.zip, a pickle: a warning says so), the folder of a training, or
            "module:function", which is imported.
        task: of the environment that it will meet.
        env_id: its id; a warning says so if a policy was trained on another.

    Raises:
        FileNotFoundError, ImportError: nothing there.
        ValueError, TypeError: a damaged file, another kind of task, a name of which nothing is
            shipped for this task, or no controller at all.
    """
    if not isinstance(source, str | Path):
        controller = as_controller(source)
        return str(getattr(source, "__name__", type(source).__name__)), controller
    if source in NAMED:
        label, make = NAMED[str(source)]
        controller = make(task)
        return controller.name if isinstance(controller, Optimal) else label, controller
    if source in LEARNERS:
        return LEARNERS[str(source)], shipped_policy(str(source), task, env_id)
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
        optimal = Optimal(task, _optimum_in(path))
        return optimal.name, optimal
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
