"""Numbers that others, or this project's independent codes, have found: one place for tests.

Those that users can compare with, too, are the package's (`powered_walker_env.literature.values`);
`data/round_foot.json` is this project's own round-foot gait, to the digits in the file.

    from tests.helpers.published import LIMIT_CYCLES, PASSIVE_GAITS, ROUND_FOOT, limit_cycle
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path

from powered_walker_env.literature.values.published import (
    LIMIT_CYCLES,
    PASSIVE_GAITS,
    TOE_OFF_GAITS,
    LimitCycle,
    PassiveGait,
    limit_cycle,
    load,
)
from powered_walker_env.model.powering.motor import Control
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.model.walker import WalkerParams

DATA = Path(__file__).parent.parent / "data"


@dataclass(frozen=True)
class RoundFootGait:
    """A gait of the round-foot walker, known to the four or five digits in the file."""

    params: WalkerParams
    control: Control
    state: PostStrikeState
    spectral_radius: float
    period: float  # s
    step_length: float  # m, how far the contact point travels in a stride
    foot_to_foot: float  # m, of which is the distance between the feet; the rest is rolling


def _round_foot() -> RoundFootGait:
    data = json.loads((DATA / "round_foot.json").read_text(encoding="utf-8"))
    stance_angle, stance_rate = data["stance_angle_and_rate"]
    beta, swing_rate = data["swing_leg_hip_to_ankle_angle_and_rate"]
    return RoundFootGait(
        params=WalkerParams.from_composite_leg(**data["composite_leg"]),
        control=Control(data["switch_angle"], data["stall_torque"]),
        state=PostStrikeState(stance_angle, beta - math.pi, stance_rate, swing_rate),
        spectral_radius=data["spectral_radius"],
        period=data["period"],
        step_length=data["step_length"],
        foot_to_foot=data["foot_to_foot"],
    )


#: The round-foot walker's gait, by this project.
ROUND_FOOT = _round_foot()

__all__ = [
    "LIMIT_CYCLES",
    "PASSIVE_GAITS",
    "ROUND_FOOT",
    "TOE_OFF_GAITS",
    "LimitCycle",
    "PassiveGait",
    "RoundFootGait",
    "limit_cycle",
    "load",
]
