"""When legs and foot move within a stride, and what the switch would be as a clock."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from powered_walker_env import Gait, walk
from powered_walker_env.model.phases import Torque
from powered_walker_env.model.powering import scheme_of
from powered_walker_env.simulation.differences import CENTRAL, differences
from powered_walker_env.simulation.trajectory import log_stride

SAMPLES = 1000  # of a stride
RTOL = 1e-12
STEP = 1e-5  # of a state, for differences
STARTED = 0.01  # of its whole extension: the foot has begun to extend


def timing(gait: Gait) -> dict[str, Any]:
    """Phases of a stride and events in it, as shares of its duration from heel strike on.

    Of the foot: when it has made 1 % of its extension for good, and when it turns fastest.
    """
    walked = walk(
        gait.state, gait.control, gait.params, 1, sample_interval=gait.duration / SAMPLES, rtol=RTOL
    )
    scheme, share = scheme_of(gait.control), walked.t / gait.duration
    torque = {phase.name: phase.torque != Torque.NONE for phase in scheme.phases}
    phases: list[dict[str, Any]] = []
    start = 0.0
    for event in walked.events:
        end = min(event.t / gait.duration, 1.0)
        phases.append(
            {"name": event.phase, "from": start, "to": end, "torque": torque[event.phase]}
        )
        start = end
    passed = int(np.argmax(walked.q[:, 2] < math.pi))
    found: dict[str, Any] = {
        "phases": phases,
        "acting": sum(each["to"] - each["from"] for each in phases if each["torque"]),
        "legs_pass": float(share[passed]),
        "foot": None,
    }
    if scheme.moves_ankle:
        found["foot"] = _foot(share, gait.params.locked_ankle_angle - walked.q[:, 1])
        found["switch"] = next(each["from"] for each in phases if each["torque"])
    return found


def _foot(share: NDArray[np.float64], extended: NDArray[np.float64]) -> dict[str, float]:
    """The foot's motion from its stop, rad, extension positive."""
    late = np.flatnonzero(extended < STARTED * extended[-1])
    return {
        "falls_back": float(max(0.0, -extended.min())),
        "extension": float(extended[-1]),
        "extends_from": float(share[late[-1]]),
        "lowest_at": float(share[np.argmin(extended)]),
    }


def clocked(gait: Gait) -> NDArray[np.complex128] | None:
    """Multipliers if the motor began so long after heel strike, whatever the hip angle then.

    The switch angle that a clock gives is that of the locked swing at the time: q₃(t_s; x). So
    A + b ∂q₃/∂x, with b the stride map's derivative by the switch angle; None without a switch
    that matters, or with knees that bend, where the swing has other phases.
    """
    scheme = scheme_of(gait.control)
    if not scheme.moves_ankle or gait.params.knee is not None:
        return None
    at = timing(gait)["switch"] * gait.duration

    def hip_angle(states: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.array([[_hip_angle(gait, state, at)] for state in states])

    by = differences(hip_angle, np.array([gait.state]), STEP, CENTRAL)[0]
    place = scheme.numbers.index("switch_angle")
    loop = gait.jacobian + np.outer(gait.control_jacobian[:, place], by.ravel())
    values = np.linalg.eigvals(loop).astype(complex)
    return values[np.argsort(-abs(values), kind="stable")]


def _hip_angle(gait: Gait, state: NDArray[np.float64], at: float) -> float:
    """q₃ of the locked swing from a state at a time, s."""
    log = log_stride(state.tolist(), None, gait.params, 0.0, RTOL, at).log
    row = int(np.argmin(abs(log[:, 0] - at)))
    _, alpha, beta = log[row, 1:4]
    return float(beta - alpha)
