"""Which legs, at which speed and step length, and the gait of each scheme there."""

from __future__ import annotations

from typing import NamedTuple

from powered_walker_env import PRESETS, Gait, GaitNotFoundError, find_gait
from powered_walker_env.poincare.energy import gait_at, passive_gaits

#: In the order of the tables.
SCHEMES = (
    "passive", "motor", "motor-with-stop", "toe-off", "toe-off-at-strike", "late-toe-off",
    "hip-torque",
)  # fmt: skip


class Case(NamedTuple):
    """Legs, and the gait that is asked of them."""

    legs: str  # a preset's
    speed: float | None = None  # m/s; None: the preset's gait's

    @property
    def name(self) -> str:
        """Of the case."""
        return self.legs if self.speed is None else f"{self.legs} at {self.speed:g} m/s"


#: Legs with a motor, at their own speed and, if that is not passive legs', at one that is.
CASES = (
    Case("camp1997"),
    Case("camp1997", 0.15),
    Case("camp1997-as-published"),
    Case("round-foot"),
    Case("round-foot", 0.75),
    Case("kneed"),
    Case("kneed", 0.85),
    Case("compass"),
    Case("mcgeer1990"),
    Case("bhounsule-round-feet"),
    Case("ranger-locked"),
)


class Found(NamedTuple):
    """A scheme's gait, or why there is none."""

    scheme: str
    gait: Gait | None
    reason: str = ""


def wanted(case: Case) -> tuple[float, float]:
    """Speed, m/s, and step length, m: of the preset's gait, or of the passive one."""
    params, control, state, _ = PRESETS[case.legs]
    if case.speed is None:
        own = find_gait(params, control, state)
        return own.speed, own.step_length
    passive = passive_gaits(params.replace(slope=0.0), case.speed)
    if not passive:
        raise ValueError(f"speed must be one of passive legs {case.legs!r}, got {case.speed!r}")
    return case.speed, passive[0].step_length


def gaits(case: Case) -> list[Found]:
    """Under every scheme: at the speed, and at the step length where two numbers can have both."""
    speed, step_length = wanted(case)
    found = []
    for scheme in SCHEMES:
        try:
            found.append(Found(scheme, _nearest(case.legs, scheme, speed, step_length)))
        except ValueError as problem:
            found.append(Found(scheme, None, str(problem)))
    return found


def _nearest(legs: str, scheme: str, speed: float, step_length: float) -> Gait:
    """With both, or else with the speed alone."""
    try:
        return gait_at(legs, scheme, speed, step_length)
    except GaitNotFoundError:
        return gait_at(legs, scheme, speed)
