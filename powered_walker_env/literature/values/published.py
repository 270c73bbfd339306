"""Numbers that others, or this project's independent codes, have found: the one place for them.

`published.json`: passive walkers of other authors in this project's parameters (`general`),
the simplest walker by an independent code, and single values as they were printed
(`printed`), each with its source. `limit_cycles.json`: the thesis's walker (Camp 1997,
figure 6) in both physics, by an independent high-order code.
"""

from __future__ import annotations

import functools
import json
import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from powered_walker_env.model.powering.motor import Control
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.model.walker import AS_PUBLISHED, CONSERVING, WalkerParams

DATA = Path(__file__).parent
_NUMBER = re.compile(r"[-+]?\d+(?:\.(\d*))?(?:[eE]([-+]?\d+))?")


@functools.cache
def load(name: str) -> Any:
    """A data file of this package as it is (not to be changed)."""
    return json.loads((DATA / name).read_text(encoding="utf-8"))


@dataclass(frozen=True)
class Printed:
    """One value as its source has it."""

    family: str
    walker: str
    source: str
    name: str  # of the check that computes it
    quantity: str
    printed: str  # digit by digit
    within: float  # how near ours must come: half a unit of the last digit, if not stated
    differs: str  # why it does not come out; empty if it should
    remark: str
    long: bool  # takes long to compute

    @property
    def value(self) -> complex:
        """The number."""
        return complex(self.printed)


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


def half_unit(printed: str) -> float:
    """Half a unit of the last digit printed; of the coarser part, if the number is complex.

    Raises:
        ValueError: no number in the text.
    """
    units = [
        10.0 ** (int(found[2] or 0) - len(found[1] or "")) for found in _NUMBER.finditer(printed)
    ]
    if not units:
        raise ValueError(f"printed must hold a number, got {printed!r}")
    return 0.5 * max(units)


def complex_numbers(pairs: list[list[float]]) -> tuple[complex, ...]:
    """[re, im] pairs as complex numbers."""
    return tuple(complex(real, imaginary) for real, imaginary in pairs)


def _printed() -> tuple[Printed, ...]:
    return tuple(
        Printed(
            family=group["family"],
            walker=group["walker"],
            source=group["source"],
            name=value["name"],
            quantity=value["quantity"],
            printed=value["printed"],
            within=float(value.get("within", half_unit(value["printed"]))),
            differs=value.get("differs", ""),
            remark=value.get("remark", ""),
            long=value.get("long", False),
        )
        for group in load("published.json")["printed"]
        for value in group["values"]
    )


def _limit_cycles() -> tuple[LimitCycle, ...]:
    data = load("limit_cycles.json")
    return tuple(
        LimitCycle(
            params=WalkerParams(physics=physics, no_load_speed=data[physics]["no_load_speed"]),
            control=Control(data[physics]["switch_angle"], float(stall_torque)),
            section_state=tuple(cycle["section_state"]),
            multipliers=complex_numbers(cycle["multipliers"]),
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
            multipliers=complex_numbers(gait["multipliers"]),
            source=gait["source"],
        )
        for gait in load("published.json")["general"]
        if (gait["toe_off_impulse"] != 0) == toe_off
    )


#: Single values as printed.
PRINTED = _printed()

#: All gaits of `limit_cycles.json`, as published first, by growing stall torque.
LIMIT_CYCLES = _limit_cycles()

#: Gaits of other authors' passive walkers (round feet, compass, Ranger, nearly the simplest).
PASSIVE_GAITS = _gaits(toe_off=False)

#: The same with an impulse along the trailing leg at heel strike.
TOE_OFF_GAITS = _gaits(toe_off=True)


def limit_cycle(physics: str, stall_torque: float) -> LimitCycle:
    """The gait of one physics (`"conserving"`, `"as_published"`) and stall torque.

    Raises:
        KeyError: there is none; the message names those there are.
    """
    for cycle in LIMIT_CYCLES:
        if (cycle.params.physics, cycle.control.stall_torque) == (physics, stall_torque):
            return cycle
    known = ", ".join(str(cycle) for cycle in LIMIT_CYCLES)
    raise KeyError(f"no gait {physics}-{stall_torque:g}; there are {known}")
