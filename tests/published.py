"""Numbers that others, or this project's independent codes, have found: one place for tests.

`data/limit_cycles.json`: the thesis's walker (Camp 1997, figure 6) in both physics, by an
independent high-order code. `data/round_foot.json`: the round-foot walker's gait.
`data/published.json`: passive walkers of other authors, in this project's parameters,
each with its source.

    from tests.published import LIMIT_CYCLES, PASSIVE_GAITS, ROUND_FOOT, limit_cycle
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from powered_walker_env.params import (
    AS_PUBLISHED,
    CONSERVING,
    Control,
    PostStrikeState,
    WalkerParams,
)

DATA = Path(__file__).parent / "data"


def load(name: str) -> Any:
    """A data file as it is."""
    return json.loads((DATA / name).read_text(encoding="utf-8"))


@dataclass(frozen=True)
class LimitCycle:
    """A period-one gait of the thesis's walker; relative angles q1, q2, q3 and their rates."""

    params: WalkerParams
    control: Control
    section_state: tuple[float, ...]  # q1, u1, u3 where the motor starts; u2 = 0
    multipliers: tuple[complex, ...]  # of the stride map on that section, largest first
    spectral_radius: float
    period: float  # s
    pre_heelstrike: tuple[float, ...]  # q1, q2, q3, u1, u2, u3
    post_heelstrike: tuple[float, ...]  # the same; its q3 is modulo 2π
    step_length: float  # m, foot to foot

    def __str__(self) -> str:
        return f"{self.params.physics}-{self.control.stall_torque:g}"

    @property
    def post_strike_state(self) -> PostStrikeState:
        """The state on the package's section: α = q1 + q2, s = β − π with s after α."""
        q1, q2, q3, u1, u2, u3 = self.post_heelstrike
        stance = q1 + q2
        return PostStrikeState(stance, stance + q3 + math.pi, u1 + u2, u1 + u2 + u3)


@dataclass(frozen=True)
class PassiveGait:
    """A gait without motor: feet locked for the whole stride."""

    walker: str
    params: WalkerParams
    toe_off_impulse: float  # along the trailing leg, with the heel strike; 0 for none
    state: PostStrikeState
    step_duration: float  # s, in the source's units as everything here
    step_length: float
    multipliers: tuple[complex, ...]  # the three that are not zero by construction
    source: str

    def __str__(self) -> str:
        return self.walker


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


def _complex(pairs: list[list[float]]) -> tuple[complex, ...]:
    return tuple(complex(real, imaginary) for real, imaginary in pairs)


def _limit_cycles() -> tuple[LimitCycle, ...]:
    data = load("limit_cycles.json")
    return tuple(
        LimitCycle(
            params=WalkerParams(physics=physics, no_load_speed=data[physics]["no_load_speed"]),
            control=Control(data[physics]["switch_angle"], float(stall_torque)),
            section_state=tuple(cycle["section_state"]),
            multipliers=_complex(cycle["multipliers"]),
            spectral_radius=cycle["spectral_radius"],
            period=cycle["period"],
            pre_heelstrike=tuple(cycle["pre_heelstrike"]),
            post_heelstrike=tuple(cycle["post_heelstrike"]),
            step_length=cycle["step_length"],
        )
        for physics in (AS_PUBLISHED, CONSERVING)
        for stall_torque, cycle in data[physics]["stall_torque"].items()
    )


def _gaits(toe_off: bool) -> tuple[PassiveGait, ...]:
    return tuple(
        PassiveGait(
            walker=gait["walker"],
            params=WalkerParams(**gait["params"]),
            toe_off_impulse=gait["toe_off_impulse"],
            state=PostStrikeState(*gait["post_strike_state"]),
            step_duration=gait["step_duration"],
            step_length=gait["step_length"],
            multipliers=_complex(gait["multipliers"]),
            source=gait["source"],
        )
        for gait in load("published.json")["general"]
        if (gait["toe_off_impulse"] != 0) == toe_off
    )


def _round_foot() -> RoundFootGait:
    data = load("round_foot.json")
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


#: All gaits of `limit_cycles.json`, as published first, by growing stall torque.
LIMIT_CYCLES = _limit_cycles()

#: Gaits of other authors' passive walkers (round feet, compass, Ranger, nearly the simplest).
PASSIVE_GAITS = _gaits(toe_off=False)

#: The same with an impulse along the trailing leg at heel strike.
TOE_OFF_GAITS = _gaits(toe_off=True)

#: The round-foot walker's gait, by this project.
ROUND_FOOT = _round_foot()


def limit_cycle(physics: str, stall_torque: float) -> LimitCycle:
    """The gait of one physics (`"conserving"`, `"as_published"`) and stall torque."""
    for cycle in LIMIT_CYCLES:
        if (cycle.params.physics, cycle.control.stall_torque) == (physics, stall_torque):
            return cycle
    known = ", ".join(str(cycle) for cycle in LIMIT_CYCLES)
    raise KeyError(f"no gait {physics}-{stall_torque:g}; there are {known}")
