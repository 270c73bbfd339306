"""Cold start: what a new process waits for, part by part, with and without kernels on disk.

The parts follow one another in one fresh interpreter, first over an empty cache, then over what
that has left there. Processor time is told beside wall time: it is the one to compare.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from benchmarks.timing import Section
from powered_walker_env.tabular import aligned

RUNS, CLOCKS = ("empty cache", "kernels on disk"), ("CPU s", "wall s")
PATIENCE = 600.0  # s, of one process
PARTS = """
import json, time
found = {}
def part(name, work):
    cpu, wall = time.process_time(), time.perf_counter()
    work()
    found[name] = time.process_time() - cpu, time.perf_counter() - wall

def load():
    global gymnasium, numpy, stride, find_gait
    import gymnasium, numpy
    from powered_walker_env import PRESETS, find_gait, stride
    globals().update(zip(("params", "control", "state"), PRESETS["camp1997"]))

def first_step():
    global env
    env = gymnasium.make("powered_walker_env:PoweredWalker-v0")
    env.reset(seed=0)
    step()

def step():
    env.step(numpy.zeros(2, numpy.float32))

part("imports", load)
part("first stride", lambda: stride(state, control, params))
part("second stride", lambda: stride(state, control, params))
part("first env.step, with make and reset", first_step)
part("second env.step", step)
part("first find_gait", lambda: find_gait(params, control, state))
part("second find_gait", lambda: find_gait(params, control, state))
print(json.dumps(found))
"""


def startup() -> Section:
    """Start two processes and ask them how long they took.

    Raises:
        RuntimeError: one that failed, with what it said.
    """
    with tempfile.TemporaryDirectory() as cache:
        cold, warm = (times({"NUMBA_CACHE_DIR": cache}) for _ in RUNS)
    rows: list[tuple[str, ...]] = [
        ("part", *(f"{run}, {clock}" for run in RUNS for clock in CLOCKS))
    ]
    for name in cold:
        rows.append((name, *(f"{x:.3f}" for x in (*cold[name], *warm[name]))))
    sums = [sum(x) for run in (cold, warm) for x in zip(*run.values(), strict=True)]
    rows.append(("in all", *(f"{x:.3f}" for x in sums)))
    text = "\n".join(["Cold start: new processes", "", *aligned(rows)])
    return Section(text, dict(zip(RUNS, (cold, warm), strict=True)))


def times(environment: Mapping[str, str]) -> dict[str, tuple[float, float]]:
    """CPU and wall time of each part in a new process, s.

    Args:
        environment: its variables, beside ours.
    """
    found: dict[str, tuple[float, float]] = in_new_process(PARTS, environment)
    return found


def in_new_process(script: str, environment: Mapping[str, str]) -> Any:
    """What a script prints last in a new process, as JSON.

    Args:
        environment: its variables, beside ours.

    Raises:
        RuntimeError: it failed, with what it said.
    """
    package = str(Path(__file__).resolve().parents[1])
    path = os.pathsep.join(filter(None, [package, os.environ.get("PYTHONPATH")]))
    finished = subprocess.run(
        [sys.executable, "-c", script],
        env={**os.environ, "PYTHONPATH": path, **environment},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    if finished.returncode:
        raise RuntimeError(f"a new process failed to walk: {finished.stderr.strip()[-500:]}")
    return json.loads(finished.stdout.splitlines()[-1])
