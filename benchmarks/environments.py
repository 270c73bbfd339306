"""What the environments add to a stride: one, a thousand and a hundred thousand walkers."""

from __future__ import annotations

import contextlib
import time
import tracemalloc
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode

from benchmarks.timing import Case, Section, measure
from powered_walker_env.envs.contract import STRIDE_RTOL
from powered_walker_env.model.knees import encode
from powered_walker_env.model.mechanics.packing import packed
from powered_walker_env.model.powering import scheme_of
from powered_walker_env.model.presets import preset
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.simulation.arguments import LEVEL
from powered_walker_env.simulation.record import RESULTS
from powered_walker_env.simulation.strides import run_rows, stride, stride_batch
from powered_walker_env.tabular import aligned

VECTOR, CROWD = 1024, 100_000  # walkers
KERNEL, STRIDE, STEP = "the kernel, one stride", "one call of stride", "env.unwrapped.step"
NATIVE = f"{VECTOR} walkers: vector step, with its resets"
ADAPTED = f"{VECTOR} walkers: step for SB3"
#: Environments of presets.
IDS = {"camp1997": "PoweredWalker-v0", "round-foot": "PoweredWalkerRoundFoot-v0"}


def environments(walker: str, seconds: float = 1.0, crowd: int = CROWD) -> Section:
    """Measure the environment of a preset; wall time, medians of rounds in turn.

    Args:
        seconds: for each measurement.
        crowd: walkers in the largest batch.
    """
    env_id = f"powered_walker_env:{IDS[walker]}"
    params, control, state, _ = preset(walker)
    single, states = gym.make(env_id), np.tile(state, (VECTOR, 1))
    cases = {
        KERNEL: _kernel_alone(state, control, params),
        STRIDE: lambda: stride(state, control, params, rtol=STRIDE_RTOL),
        "env.step, with its resets": _steps(single),
        STEP: _steps(single.unwrapped),
        f"{VECTOR} walkers: stride_batch": lambda: stride_batch(
            states, np.array(list(vars(control).values())), params, rtol=STRIDE_RTOL
        ),
        NATIVE: _batch_steps(env_id, VECTOR),
    }
    with contextlib.suppress(ImportError):
        cases[ADAPTED] = _sb3_steps(env_id)
    timings = measure([Case(work) for work in cases.values()], seconds)
    found = {name: 1.0 / timing.rate for name, timing in zip(cases, timings, strict=True)}
    step, reset, held, peak = _crowd(env_id, crowd)
    lines = [
        *((name, f"{1e6 * taken:,.1f} µs") for name, taken in found.items()),
        *(
            (f"{name}, to {base}", f"{found[name] / found[base]:.2f}")
            for name, base in ((STRIDE, KERNEL), (STEP, KERNEL), (ADAPTED, NATIVE))
            if name in found
        ),
        (f"{crowd:,} walkers: vector step", f"{1e3 * step:,.0f} ms"),
        (f"{crowd:,} walkers: first reset", f"{reset:.1f} s"),
        (f"{crowd:,} walkers: memory", f"{held:.0f} bytes each, {peak:.0f} while they step"),
    ]
    text = [f"Environments: {IDS[walker]}, wall time, medians", "", *aligned(lines, left=2)]
    numbers = {"step_s": step, "reset_s": reset, "bytes": held, "peak_bytes": peak}
    return Section("\n".join(text), {"seconds": found, "crowd": {"walkers": crowd, **numbers}})


def _kernel_alone(state: PostStrikeState, control: Any, params: WalkerParams) -> Callable[[], None]:
    """What `stride` leaves to machine code, with its workspace."""
    powered, results = scheme_of(control), np.empty((1, RESULTS))
    code, start, row = encode(powered.cycle), np.array([state]), np.array([powered.row(control)])
    own = packed(params)
    return lambda: run_rows(code, start, row, own, LEVEL, STRIDE_RTOL, results)


def _steps(env: gym.Env[Any, Any]) -> Callable[[], None]:
    """Steps under zero action, with a reset where an episode is over."""
    action = np.zeros(2, np.float32)
    env.reset(seed=0)

    def step() -> None:
        _, _, terminated, truncated, _ = env.step(action)
        if terminated or truncated:
            env.reset()

    return step


def _batch_of(env_id: str, count: int) -> Any:
    """A batch in which every step is a stride of every walker."""
    return gym.make_vec(
        env_id,
        num_envs=count,
        vectorization_mode="vector_entry_point",
        autoreset_mode=AutoresetMode.SAME_STEP.value,
    )


def _batch_steps(env_id: str, count: int) -> Callable[[], Any]:
    envs, actions = _batch_of(env_id, count), np.zeros((count, 2), np.float32)
    envs.reset(seed=0)
    return lambda: envs.step(actions)


def _sb3_steps(env_id: str) -> Callable[[], Any]:
    from powered_walker_env.sb3 import PoweredWalkerVecEnv

    envs, actions = PoweredWalkerVecEnv(env_id, VECTOR, seed=0), np.zeros((VECTOR, 2), np.float32)
    envs.reset()
    return lambda: envs.step(actions)


def _crowd(env_id: str, count: int) -> tuple[float, float, float, float]:
    """A large batch: a step and the reset, s; bytes of a walker held, and at the peak of a step."""
    actions, marks = np.zeros((count, 2), np.float32), []
    tracemalloc.start()  # some ten arrays are followed: that takes no time
    envs = _batch_of(env_id, count)
    held = tracemalloc.get_traced_memory()[0]
    for work in (lambda: envs.reset(seed=0), lambda: envs.step(actions)):
        tracemalloc.reset_peak()
        begun = time.perf_counter()
        work()
        marks.append((time.perf_counter() - begun, tracemalloc.get_traced_memory()[1]))
    tracemalloc.stop()
    (reset, _), (step, peak) = marks
    return step, reset, held / count, peak / count
