"""How much is a better body worth? Geometry and a constant control, chosen together once.

`tune_walker` looks for the feet, masses and control whose gait feels pushes least; then the walker
is pushed like the one it came from, without any feedback, and walks as long as it can.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from typing import Any

from agents.command import exit_status
from agents.study.asking import answered, parser
from powered_walker_env import find_gait
from powered_walker_env.controllers import tune_walker
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.controllers.linear import push_of
from powered_walker_env.controllers.tuned_walker import GEOMETRY
from powered_walker_env.envs.task import Task
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare import StepNoise, disturbed_walks

FILE = "geometry.json"
WALKS, LIMIT, EPISODE, SEED = 1000, 2000, 100, 71_000


def body(env_id: str) -> dict[str, Any]:
    """The walker as it is and as it is best, both in the open loop under the same pushes."""
    task, began = task_of(env_id), time.process_time()
    found = tune_walker(task)
    seconds = time.process_time() - began
    noise = StepNoise(push=push_of(task))
    walked = {}
    for name, params, control, start in (
        ("own", task.params, task.control, task.gait[0].tolist()),
        ("tuned", found.params, found.control, list(found.gait.state)),
    ):
        walks = disturbed_walks(
            params, control, noise, start, strides=LIMIT, walks=WALKS, seed=SEED
        )
        falls = int(walks.fell.sum())
        walked[name] = {
            "strides": float(walks.strides.clip(max=EPISODE).mean()),
            "to_the_end": float((walks.strides >= EPISODE).mean()),
            "mean_first_passage": float(walks.strides.sum()) / falls if falls else None,
            "walked": int(walks.strides.sum()),
            "falls": falls,
        }
    return {
        "push": noise.push,
        "norm": {"own": found.nominal_sensitivity, "tuned": found.sensitivity},
        "spectral_radius": found.gait.spectral_radius,
        "speed": {"own": _speed(task), "tuned": found.gait.speed},
        "changed": {name: [_number(task.params, name), _number(found.params, name)]
                    for name in GEOMETRY},
        "walked": walked,
        "seconds": round(seconds, 1),
    }  # fmt: skip


def _speed(task: Task) -> float:
    return find_gait(task.params, task.control, task.gait[0].tolist()).speed


def _number(params: WalkerParams, name: str) -> float:
    return round(float(params.number(name)), 5)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command."""
    options = parser("geometry", __doc__).parse_args(arguments)
    answered(options.out, FILE, options.env, body)


if __name__ == "__main__":
    sys.exit(exit_status(main))
