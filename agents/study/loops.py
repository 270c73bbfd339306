"""Measured on the closed loop, undisturbed: its gait, multipliers, costs, sensitivity, basin."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import scipy.stats
from numpy.typing import NDArray

from agents.study.subject import Subject
from powered_walker_env.poincare import (
    Gait,
    GaitNotFoundError,
    basin,
    costs,
    gait_sensitivity,
)
from powered_walker_env.poincare.regions.slices import box_around

STRIDES = 100  # of a start, until it is on the gait or counts as not
BASIN_SEED = 0


def gait(subject: Subject) -> dict[str, Any]:
    """The closed loop's gait: multipliers and costs of transport."""
    found = subject.gait
    spent = costs(found)
    return {
        "multipliers": [[float(value.real), float(value.imag)] for value in found.multipliers],
        "spectral_radius": found.spectral_radius,
        "speed": found.speed,
        "step_length": found.step_length,
        "cost_of_transport": found.cost_of_transport,
        "electrical_cost": None if math.isnan(spent.electrical) else spent.electrical,
        "moved": float(np.linalg.norm((found.states[0] - subject.task.gait[0])
                                      / subject.task.scale)),
    }  # fmt: skip


def sensitivity(subject: Subject) -> dict[str, Any]:
    """Gait sensitivity norms: a stride's duration by steps, the landed state by pushes."""
    push = {"stance_rate": 1.0, "swing_rate": 1.0}
    by_push = gait_sensitivity(
        subject.gait, push, dict.fromkeys(("stance_rate", "swing_rate"), 1.0)
    )
    return {"push": by_push.norm, "step": gait_sensitivity(subject.gait).norm}


def basin_share(subject: Subject) -> dict[str, Any]:
    """The share of a box of starts that the closed loop's gait attracts, and that walk on at all.

    `share` is None where there is no stable gait to attract them.

    The box is the same for all controllers of a walker: 0.1 (0.1 √(g/L) of a rate) around the
    task's gait, in the three numbers α, α', β' of the plane that its landings fill to first
    order (`landing_plane`). It crosses the orbits of the swing at heel strike, where controllers
    decide; the laboratory's section, further on, would show them states that they never meet.
    """
    around, count = subject.nominal, subject.budget.starts
    low, high = box_around(around, around.states[0])
    starts = np.random.default_rng(BASIN_SEED).uniform(low, high, (count, 4))
    starts[:, 1] = around.states[0][1] + (starts - around.states[0]) @ landing_plane(around)
    stable = _stable(subject)
    found = basin(
        subject.task.params, subject.policy, starts, strides=STRIDES, gaits=stable,
        backend="threading", jobs=1,
    )  # fmt: skip
    hits = int(np.count_nonzero(found.attractor >= 0))
    bounds = scipy.stats.binomtest(hits, count).proportion_ci(0.95)
    size = float(np.prod((high - low)[[0, 2, 3]]))
    attracted = {
        "share": hits / count,
        "low": float(bounds.low),
        "high": float(bounds.high),
        "volume": size * hits / count,
    }
    return {**(attracted if stable else {"share": None}), "walking": found.walking_share}


def landing_plane(gait: Gait) -> NDArray[np.float64]:
    """(4,) how s follows from the deviations of the others where strides land, to first order.

    The stride map under a constant control has rank three: its image at the gait is the plane
    n·x = 0, with n the left singular vector of the singular value 0.
    """
    left, _, _ = np.linalg.svd(gait.jacobian)
    normal = left[:, -1]
    slope: NDArray[np.float64] = -normal / normal[1]
    slope[1] = 0.0
    return slope


def _stable(subject: Subject) -> list[Gait]:
    """The closed loop's gait, if there is one and it is stable."""
    try:
        return [subject.gait] if subject.gait.stable else []
    except GaitNotFoundError:
        return []
