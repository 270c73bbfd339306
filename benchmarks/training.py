"""Where the seconds of a training go: PPO as `agents.quickstart` trains it, part by part."""

from __future__ import annotations

import contextlib
import functools
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from unittest.mock import patch

from benchmarks.environments import IDS
from benchmarks.timing import Section
from powered_walker_env.tabular import aligned

STEP, ROLLOUT, UPDATE = "environment", "network, in rollouts", "network, in updates"
EVALUATION, REST = "evaluations, checkpoints", "the rest: Stable-Baselines3's Python"


def training(walker: str, strides: int | None = None) -> Section:
    """Train on the environment of a preset with the configuration of this repository.

    Args:
        strides: how many, the configuration's if left out.
    """
    try:
        from agents.configuration import read_settings
        from agents.supervisor import Supervisor
        from agents.train import train
        from powered_walker_env.sb3 import PoweredWalkerVecEnv
    except ImportError as missing:
        return Section(f"Training: not measured, {missing}", {})
    from stable_baselines3 import PPO
    from stable_baselines3.common.policies import ActorCriticPolicy

    parts: dict[str, tuple[type, str]] = {
        STEP: (PoweredWalkerVecEnv, "step_wait"),
        ROLLOUT: (ActorCriticPolicy, "forward"),
        UPDATE: (PPO, "train"),
        EVALUATION: (Supervisor, "_evaluate"),
    }
    settings = read_settings("ppo", IDS[walker], n_timesteps=strides)
    taken = dict.fromkeys(parts, 0.0)
    with tempfile.TemporaryDirectory() as folder, _timed(parts, taken):
        train(read_settings("ppo", IDS[walker], n_timesteps=1024), Path(folder) / "0", quiet=True)
        taken.update(dict.fromkeys(parts, 0.0))  # what was loaded and compiled is not counted
        begun = time.process_time()
        train(settings, Path(folder) / "1", quiet=True)
        whole = time.process_time() - begun
    taken[REST] = whole - sum(taken.values())
    rows = [("part", "s", "share")]
    rows += [(name, f"{taken[name]:.2f}", f"{taken[name] / whole:.1%}") for name in (*parts, REST)]
    rows.append(("in all", f"{whole:.2f}", f"{settings.n_timesteps / whole:,.0f} strides a second"))
    title = f"Training: PPO on {IDS[walker]}, {settings.n_timesteps:,} strides, processor time"
    text = [title, "", *aligned(rows)]
    return Section("\n".join(text), {"strides": settings.n_timesteps, "seconds": taken})


@contextlib.contextmanager
def _timed(parts: dict[str, tuple[type, str]], taken: dict[str, float]) -> Iterator[None]:
    """Add up the seconds spent in these methods."""
    with contextlib.ExitStack() as stack:
        for name, (owner, method) in parts.items():
            timed = _timing(name, getattr(owner, method), taken)
            stack.enter_context(patch.object(owner, method, timed))
        yield


def _timing(name: str, method: Callable[..., Any], taken: dict[str, float]) -> Callable[..., Any]:
    @functools.wraps(method)
    def timed(*arguments: Any, **options: Any) -> Any:
        begun = time.process_time()
        try:
            return method(*arguments, **options)
        finally:
            taken[name] += time.process_time() - begun

    return timed
