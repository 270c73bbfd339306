"""What the environments add to a stride: one, a thousand and a hundred thousand walkers.

Gymnasium's BipedalWalker and MuJoCo's Walker2d are timed beside them for orientation only:
one of their steps is 1/50 s and 1/125 s, one of ours a whole stride.
"""

from __future__ import annotations

import contextlib
import importlib.util
import time
import tracemalloc
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode

from benchmarks.timing import Case, check_seconds, measure, median_of_calls
from powered_walker_env.envs.contract import STRIDE_RTOL
from powered_walker_env.envs.registration import ENVIRONMENTS
from powered_walker_env.envs.walker import PoweredWalkerEnv
from powered_walker_env.simulation.strides import stride, stride_batch

VECTOR, CROWD = 1024, 100_000  # walkers
PREFIX = "powered_walker_env:"
OTHERS = {  # id to what it needs
    "BipedalWalker-v3": 'pip install "gymnasium[box2d]"',
    "Walker2d-v5": 'pip install "gymnasium[mujoco]"',
}
MOST_CALLS = 20_000
WARM_UP = 5  # first vector steps unseen: buffers, and walkers leaving the gait


@dataclass(frozen=True)
class Environments:
    """Wall times; medians."""

    env_id: str
    stride_us: float  # one call of `stride`
    step_us: float  # one `env.step` as gym.make gives it
    bare_step_us: float  # the same without gym.make's wrappers
    vector_us: float  # one step of VECTOR walkers
    batch_us: float  # the same strides by `stride_batch`
    vector_overhead: float  # of the first over the second, as a share, within the rounds
    sb3_us: float | None  # one step of VECTOR walkers for Stable-Baselines3
    crowd: int  # walkers in the largest batch
    crowd_ms: float  # one step of them
    crowd_reset_s: float  # their first reset, seeds and all
    crowd_bytes: float  # held by each, and while they step
    crowd_peak_bytes: float
    others_us: dict[str, float]  # one step of other people's walkers
    missing: dict[str, str]


def environments(
    preset: str = "camp1997", seconds: float = 1.0, crowd: int = CROWD
) -> Environments:
    """Measure the environment of a preset.

    Args:
        seconds: for each measurement.
        crowd: walkers in the largest batch.

    Raises:
        ValueError: a preset without an environment, or seconds that are not positive.
    """
    check_seconds(seconds)
    env_id = PREFIX + environment_of(preset)
    single = gym.make(env_id)
    bare = single.unwrapped
    assert isinstance(bare, PoweredWalkerEnv)
    nominal = np.zeros(2, np.float32)
    params, control, state = bare.task.params, bare.control(nominal), bare.task.gait[0].tolist()

    def one_stride() -> None:
        stride(state, control, params, rtol=STRIDE_RTOL)

    missing: dict[str, str] = {}
    others = {}
    for name, remedy in OTHERS.items():
        try:
            others[name] = _step_us(_made(name), seconds)
        except (gym.error.Error, ImportError):
            missing[name] = f"not installed: {remedy}"
    return Environments(
        env_id.removeprefix(PREFIX),
        1e6 * median_of_calls(one_stride, _nothing, _calls(one_stride, seconds)),
        _step_us(single, seconds),
        _step_us(bare, seconds),
        *_vector(env_id, seconds),
        _sb3_us(env_id, seconds, missing),
        crowd,
        *_crowd(env_id, crowd),
        others,
        missing,
    )


def environment_of(preset: str) -> str:
    """The id of the environment that walks a preset.

    Raises:
        ValueError: there is none.
    """
    for env_id, (walker, _) in ENVIRONMENTS.items():
        if walker == preset:
            return env_id
    raise ValueError(f"preset must have an environment, got {preset!r}")


def _nothing() -> None:
    pass


def _calls(work: Callable[[], Any], seconds: float) -> int:
    """How many calls fill the time, by the second of two."""
    work()
    begun = time.perf_counter()
    work()
    return min(MOST_CALLS, max(2, int(seconds / max(time.perf_counter() - begun, 1e-9))))


def _made(name: str) -> gym.Env[Any, Any]:
    with warnings.catch_warnings():  # other people's deprecations
        warnings.simplefilter("ignore")
        return gym.make(name)


def _step_us(env: gym.Env[Any, Any], seconds: float) -> float:
    """Median of one step under random actions near nothing, resets untimed, µs."""
    env.action_space.seed(0)
    env.reset(seed=0)
    over = False
    action: Any = None

    def between() -> None:
        nonlocal action
        action = (0.2 * env.action_space.sample()).astype(np.float32)
        if over:
            env.reset()

    def work() -> None:
        nonlocal over
        _, _, terminated, truncated, _ = env.step(action)
        over = terminated or truncated

    def both() -> None:
        between()
        work()

    calls = _calls(both, seconds)
    median = median_of_calls(work, between, calls)
    return 1e6 * median


def _vector(env_id: str, seconds: float) -> tuple[float, float, float]:
    """One vector step, the same strides by `stride_batch` (both µs), and the overhead.

    With Gymnasium's default autoreset, in which a walker that is over starts anew in its
    next step and walks none: the batch leaves these out, too.
    """
    envs = _batch_of(env_id, VECTOR, AutoresetMode.NEXT_STEP)
    task = envs.unwrapped.task
    _, info = envs.reset(seed=0)
    actions = np.zeros((VECTOR, 2), np.float32)
    active = np.ones(VECTOR, np.bool_)
    taken: list[tuple[float, float]] = []
    until = time.perf_counter() + 2 * seconds
    while len(taken) <= WARM_UP or time.perf_counter() < until:
        starts = info["state"][active]
        begun = time.perf_counter()
        _, _, terminated, truncated, info = envs.step(actions)
        stepped = time.perf_counter()
        stride_batch(starts, task.nominal, task.params, rtol=STRIDE_RTOL)
        taken.append((stepped - begun, time.perf_counter() - stepped))
        active = ~(terminated | truncated)
    steps, batches = 1e6 * np.array(taken[WARM_UP:]).T
    overhead = float(np.median(steps / batches)) - 1.0
    return float(np.median(steps)), float(np.median(batches)), overhead


def _batch_of(env_id: str, count: int, mode: AutoresetMode = AutoresetMode.SAME_STEP) -> Any:
    """A batch of environments; by default one in which every step is a stride of every walker."""
    return gym.make_vec(
        env_id,
        num_envs=count,
        vectorization_mode="vector_entry_point",
        autoreset_mode=mode.value,
    )


def _sb3_us(env_id: str, seconds: float, missing: dict[str, str]) -> float | None:
    """One step of the adapter for Stable-Baselines3, µs; None if that is not there."""
    if importlib.util.find_spec("stable_baselines3") is None:
        missing["Stable-Baselines3"] = "not installed: pip install stable-baselines3"
        return None
    from powered_walker_env.sb3 import PoweredWalkerVecEnv

    envs = PoweredWalkerVecEnv(env_id, VECTOR, seed=0)
    envs.reset()
    actions = np.zeros((VECTOR, 2), np.float32)
    (timing,) = measure([Case(lambda: envs.step(actions), 1)], seconds)
    return 1e6 / timing.rate


def _crowd(env_id: str, count: int) -> tuple[float, float, float, float]:
    """A large batch: ms of a step, s of the reset, bytes of a walker held and at the peak."""
    actions = np.zeros((count, 2), np.float32)
    with _traced():
        envs = _batch_of(env_id, count)
        held, _ = tracemalloc.get_traced_memory()
    begun = time.perf_counter()
    envs.reset(seed=0)
    reset = time.perf_counter() - begun
    with _traced():  # some ten arrays are followed: that takes no time
        begun = time.perf_counter()
        envs.step(actions)
        taken = time.perf_counter() - begun
        _, more = tracemalloc.get_traced_memory()
    return 1e3 * taken, reset, held / count, (held + more) / count


@contextlib.contextmanager
def _traced() -> Iterator[None]:
    """Follow what is allocated inside."""
    tracemalloc.start()
    try:
        yield
    finally:
        tracemalloc.stop()
