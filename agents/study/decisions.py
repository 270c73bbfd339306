"""What a decision costs, and which one is made where.

Floating-point operations are counted by formula, additions and multiplications alike:

- the same whatever is seen, an open loop: none;
- a gain: 2 for each of its numbers that are not zero, the clipping not counted;
- a network: 2·in·out + out of every layer but the last's activation (a multiplication and an
  addition for each weight, the bias among them; one for each activation, tanh counted as one);
- the optimum's table: linear interpolation over the 2³ corners, 2·8·k and 7 of their weights, and
  the locked swing to the section, less than a whole stride: `STRIDE` is an upper bound; where its
  policy looks ahead, for each control tried a stride more and its swings, pushed and not;
- look-ahead by n strides: at most the 1 + 7ᵏ plans that it begins with, each walked twice but for
  its last stride, and in each iteration n strides with derivatives, each as much as `DERIVATIVES`
  without, and the halvings of n more; the algebra between them is not counted;
- any other controller says it itself, by an attribute `flops`, or nobody knows.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from agents.study.loops import landing_plane
from agents.study.subject import Subject
from powered_walker_env.controllers import Network, Optimal
from powered_walker_env.controllers.look_ahead import HALVINGS, ITERATIONS, LEVELS
from powered_walker_env.poincare.stochastic.tables import NEAR

DERIVATIVES = 5  # strides that one with derivatives costs (docs/results.md)
STRIDE = 73_000  # of a stride by the kernel: 248 evaluations, 20 steps (docs/results.md)
SWINGS = 7  # to the section, pushed and not, after a stride of the optimum that looks ahead
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


def flops(controller: Any) -> int | None:
    """Floating-point operations of a decision; None where nobody knows."""
    for kind in type(controller).__mro__:
        if kind.__name__ in FORMULAS:
            return int(FORMULAS[kind.__name__](controller))
    own = getattr(controller, "flops", None)
    return None if own is None else int(own)


def _of_gain(controller: Any) -> int:
    return 2 * int(np.count_nonzero(controller.gain))


def _of_network(network: Network) -> int:
    return int(sum(2 * weights.size + len(weights) for weights, _ in network.layers))


def _of_table(controller: Optimal) -> int:
    found = controller.found
    table = STRIDE + 2 * 8 * len(found.high) + 7
    if not found.looks_ahead:
        return table
    tried = len(NEAR) ** len(found.high) + math.prod((n + 1) // 2 for n in found.counts)
    return int(table + tried * (1 + SWINGS) * STRIDE)


def _of_look_ahead(controller: Any) -> int:
    n, k = int(controller.strides), len(controller.lqr.gain)
    plans: int = 1 + LEVELS**k
    begin = plans * (2 * n - 1)
    return STRIDE * (begin + ITERATIONS * (DERIVATIVES + HALVINGS) * n)


#: By the names of classes.
FORMULAS: dict[str, Callable[[Any], int]] = {
    "OpenLoop": lambda _: 0,
    "TunedOpenLoop": lambda _: 0,
    "LQR": _of_gain,
    "LinearFeedback": _of_gain,
    "Network": _of_network,
    "Optimal": _of_table,
    "LookAhead": _of_look_ahead,
}


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
