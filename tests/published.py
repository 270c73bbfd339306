"""Numbers that others, or this project's independent codes, have found: one place for tests.

Those that users can compare with, too, are the package's (`powered_walker_env.validation`);
`data/round_foot.json` is this project's own round-foot gait, to the digits in the file.

    from tests.published import LIMIT_CYCLES, PASSIVE_GAITS, ROUND_FOOT, limit_cycle
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path

from powered_walker_env.params import Control, PostStrikeState, WalkerParams
from powered_walker_env.validation.published import (
    LIMIT_CYCLES,
    PASSIVE_GAITS,
    TOE_OFF_GAITS,
    LimitCycle,
    PassiveGait,
    limit_cycle,
    load,
)

DATA = Path(__file__).parent / "data"


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
