"""Cold start: what a new process waits for before its first stride.

Each time is measured inside a fresh interpreter that finds the kernels compiled on disk
(a first one, unmeasured, sees to that).
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

PROCESSES = 3  # of which the medians are told
PATIENCE = 300.0  # s: the first process may have kernels to compile

_CLOCK = """
import json, time
marks, begun = {}, time.perf_counter()
def mark(name):
    global begun
    now = time.perf_counter()
    marks[name] = now - begun
    begun = time.perf_counter()
"""
_ENVIRONMENT = f"""{_CLOCK}
import gymnasium, numpy
mark("import gymnasium and numpy")
import powered_walker_env
mark("import powered_walker_env")
env = gymnasium.make("powered_walker_env:PoweredWalker-v0")
mark("gymnasium.make")
env.reset(seed=0)
mark("first reset")
action = numpy.zeros(2, numpy.float32)
env.step(action)
mark("first env.step")
env.step(action)
mark("second env.step")
print(json.dumps(marks))
"""
_STRIDE = f"""{_CLOCK}
from powered_walker_env import stride
from powered_walker_env import (PRESETS)
mark("import powered_walker_env (with all it needs)")
params, control, state, _ = PRESETS["camp1997"]
stride(state, control, params)
mark("first stride")
stride(state, control, params)
mark("second stride")
print(json.dumps(marks))
"""


@dataclass(frozen=True)
class Startup:
    """Seconds, medians over processes; in the order in which they pass."""

    environment: dict[str, float]
    stride: dict[str, float]
    first_process: float  # s: the very first, which compiles if nobody has before


def startup(processes: int = PROCESSES) -> Startup:
    """Start processes and ask them how long they took.

    Raises:
        RuntimeError: one that failed, with what it said.
    """
    begun = time.perf_counter()
    _marks(_ENVIRONMENT)
    first = time.perf_counter() - begun
    _marks(_STRIDE)
    runs = [(_marks(_ENVIRONMENT), _marks(_STRIDE)) for _ in range(processes)]
    environment, stride = (_medians([run[i] for run in runs]) for i in range(2))
    return Startup(environment, stride, first)


def _marks(script: str) -> dict[str, float]:
    """The times that a script prints."""
    package = str(Path(__file__).resolve().parents[1])
    path = os.pathsep.join(filter(None, [package, os.environ.get("PYTHONPATH")]))
    finished = subprocess.run(
        [sys.executable, "-c", script],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    if finished.returncode:
        raise RuntimeError(f"a new process failed to walk: {finished.stderr.strip()[-500:]}")
    marks: dict[str, float] = json.loads(finished.stdout.splitlines()[-1])
    return marks


def _medians(runs: list[dict[str, float]]) -> dict[str, float]:
    return {name: float(np.median([run[name] for run in runs])) for name in runs[0]}
