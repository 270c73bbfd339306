"""Numbers that others, or this project's independent codes, have found: the one place for them.

`published.json`: passive walkers of other authors in this project's parameters (`general`; with
knees `kneed`), the simplest walker by an independent code, and single values as they were printed
(`printed`), each with its source. `limit_cycles.json`: the thesis's walker (Camp 1997,
figure 6) in both physics, by an independent high-order code.
"""

from __future__ import annotations

import enum
import functools
import json
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from powered_walker_env.model.powering.motor import Control
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.model.walker import AS_PUBLISHED, CONSERVING, WalkerParams

DATA = Path(__file__).parent
_NUMBER = re.compile(r"[-+]?\d+(?:\.(\d*))?(?:[eE]([-+]?\d+))?")


class Kind(enum.StrEnum):
    """Where a value comes from, which says what its agreement proves."""

    PRINTED = "values that others printed"
    PROGRAM = "runs of other people's programs"
    OWN = "this project's independent code"


@functools.cache
def load(name: str) -> Any:
    """A data file of this package as it is (not to be changed)."""
    return json.loads((DATA / name).read_text(encoding="utf-8"))


@dataclass(frozen=True)
class Origin:
    """Who has a value, and of which walker."""

    kind: Kind
    family: str
    walker: str
    source: str


@dataclass(frozen=True)
class Printed:
    """One value as its source has it."""

    origin: Origin
    name: str  # of the check that computes it
    quantity: str
    printed: str  # digit by digit
    within: float = math.nan  # how near ours must come; half a unit of the last digit, if not said
    differs: str = ""  # why it does not come out; empty if it should
    remark: str = ""
    long: bool = False  # takes long to compute

    @property
    def value(self) -> complex:
        """The number."""
        return complex(self.printed)

    @property
    def allowed(self) -> float:
        """How near ours must come."""
        return half_unit(self.printed) if math.isnan(self.within) else self.within


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

    kind: Kind
    walker: str
    source: str
    params: WalkerParams
    toe_off_impulse: float  # along the trailing leg, with the heel strike; 0 for none
    state: PostStrikeState
    step_duration: float  # s, in the source's units as everything here
    step_length: float
    multipliers: tuple[complex, ...]  # the three that are not zero by construction

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


def _complex(pairs: Sequence[Sequence[float]]) -> tuple[complex, ...]:
    """[re, im] pairs as complex numbers."""
    return tuple(complex(*pair) for pair in pairs)


def _printed(group: dict[str, Any]) -> list[Printed]:
    kind = Kind[group.get("kind", "PRINTED")]
    origin = Origin(kind, group["family"], group["walker"], group["source"])
    return [Printed(origin, **value) for value in group["values"]]


def _limit_cycle(physics: str, stall_torque: str) -> LimitCycle:
    data = load("limit_cycles.json")[physics]
    cycle = data["stall_torque"][stall_torque]
    return LimitCycle(
        WalkerParams(physics=physics, no_load_speed=data["no_load_speed"]),
        Control(data["switch_angle"], float(stall_torque)),
        tuple(cycle["section_state"]),
        _complex(cycle["multipliers"]),
        cycle["spectral_radius"],
        cycle["period"],
        tuple(cycle["pre_heelstrike"]),
        tuple(cycle["post_heelstrike"]),
        cycle["step_length"],
    )


def _passive(gait: dict[str, Any]) -> PassiveGait:
    return PassiveGait(
        Kind[gait["kind"]],
        gait["walker"],
        gait["source"],
        WalkerParams.from_dict(gait["params"]),
        gait["toe_off_impulse"],
        PostStrikeState(*gait["post_strike_state"]),
        gait["step_duration"],
        gait["step_length"],
        _complex(gait["multipliers"]),
    )


#: Single values as printed.
PRINTED = tuple(value for group in load("published.json")["printed"] for value in _printed(group))

#: All gaits of `limit_cycles.json`, as published first, by growing stall torque.
LIMIT_CYCLES = tuple(
    _limit_cycle(physics, stall_torque)
    for physics in (AS_PUBLISHED, CONSERVING)
    for stall_torque in load("limit_cycles.json")[physics]["stall_torque"]
)

_GAITS = tuple(_passive(gait) for gait in load("published.json")["general"])

#: Gaits of other authors' passive walkers (round feet, compass, Ranger, nearly the simplest).
PASSIVE_GAITS = tuple(gait for gait in _GAITS if not gait.toe_off_impulse)

#: The same with an impulse along the trailing leg at heel strike.
TOE_OFF_GAITS = tuple(gait for gait in _GAITS if gait.toe_off_impulse)

#: Gaits of other authors' passive walkers with knees.
KNEED_GAITS = tuple(_passive(gait) for gait in load("published.json")["kneed"]["gaits"])


def limit_cycle(physics: str, stall_torque: float) -> LimitCycle:
    """The gait of one physics (`"conserving"`, `"as_published"`) and stall torque.

    Raises:
        KeyError: there is none; the message names those there are.
    """
    for cycle in LIMIT_CYCLES:
        if (cycle.params.physics, cycle.control.stall_torque) == (physics, stall_torque):
            return cycle
    known = ", ".join(map(str, LIMIT_CYCLES))
    raise KeyError(f"no gait {physics}-{stall_torque:g}; there are {known}")
