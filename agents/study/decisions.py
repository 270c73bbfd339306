"""What a decision costs, and which one is made where.

Floating-point operations are counted by formula, additions and multiplications alike:

- the open loop: none;
- a gain of k actions by m observations: 2·k·m, the clipping not counted;
- a network: 2·in·out + out of every layer but the last's activation (a multiplication and an
  addition for each weight, the bias among them; one for each activation, tanh counted as one);
- the optimum's table: linear interpolation over the 2³ corners, 2·8·k and 7 of their weights, and
  the locked swing to the section, less than a whole stride: `STRIDE` is an upper bound;
- any other controller says it itself, by an attribute `flops`.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from agents.study.loops import landing_plane
from agents.study.subject import Subject
from powered_walker_env.controllers import LQR, Controller, Network, OpenLoop, Optimal

STRIDE = 73_000  # of a stride by the kernel: 248 evaluations, 20 steps (docs/results.md)
SEED = 60_000  # of the observations
REACH = 3.0  # observations, of the slice on either side of the gait


def decision(subject: Subject) -> dict[str, Any]:
    """Microseconds of a decision, one observation at a time, and its operations."""
    count = subject.budget.decisions
    observations = np.random.default_rng(SEED).normal(size=(count, 1, 4)).astype(np.float32)
    predict = subject.controller.predict
    predict(observations[0], deterministic=True)
    taken = []
    for observation in observations:
        began = time.perf_counter_ns()
        predict(observation, deterministic=True)
        taken.append(time.perf_counter_ns() - began)
    return {"microseconds": float(np.median(taken)) / 1e3, "flops": flops(subject.controller)}


def flops(controller: Controller) -> int | None:
    """Floating-point operations of a decision; None where nobody knows."""
    if isinstance(controller, OpenLoop):
        return 0
    if isinstance(controller, Network):
        shapes = [weights.shape for weights, _ in controller.layers]
        return int(sum(2 * wide * high + high for high, wide in shapes))
    if isinstance(controller, LQR):
        return int(2 * controller.gain.size)
    if isinstance(controller, Optimal):
        return STRIDE + 2 * 8 * len(controller.found.high) + 7
    own = getattr(controller, "flops", None)
    return None if own is None else int(own)


def decided(subject: Subject) -> dict[str, Any]:
    """Actions over a slice of what is met: stance angle and rate, on the plane of landings.

    Returns:
        `numbers`: (k,) what is decided; `axis`: (n,) both coordinates, as observations;
        `actions`: (k, n, n), the rate first.
    """
    axis = np.linspace(-REACH, REACH, subject.budget.slice_points)
    angle, rate = np.meshgrid(axis, axis)
    seen = np.zeros((angle.size, 4))
    scale = subject.task.scale
    seen[:, 0], seen[:, 2] = angle.ravel(), rate.ravel()
    seen[:, 1] = (seen * scale) @ landing_plane(subject.nominal) / scale[1]
    actions = np.asarray(subject.controller.predict(seen, deterministic=True)[0], np.float64)
    kept = np.clip(actions, -1.0, 1.0).T.reshape(-1, *angle.shape)
    numbers = [name.replace("_", " ") for name in subject.task.scheme.numbers]
    return {"numbers": numbers, "axis": axis.round(6).tolist(), "actions": kept.round(4).tolist()}
