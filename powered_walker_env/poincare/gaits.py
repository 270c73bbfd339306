"""Gaits: the limit cycles near a guess, and what they are like (Camp 1997, section 7)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.checks import whole_number
from powered_walker_env.model.powering import (
    MOTOR,
    PASSIVE,
    AnyControl,
    Policy,
    Scheme,
    scheme_of,
)
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.model.state import PostStrikeState, check_state, natural_units
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.fixed_points import newton, refusal, relative_residuals, short
from powered_walker_env.poincare.maps import StrideMap, switch_section
from powered_walker_env.poincare.tolerances import LONGEST_PERIOD, SETTLING
from powered_walker_env.simulation.strides import Array

SECTIONS = ("switch", "post-strike")
RANDOM_STARTS = 512  # states tried when no guess is given
NEAREST = 12  # of them, the nearest to periodic ones, from which Newton starts
NUDGE = np.array([0.0, 0.0, 1e-4, 1e-4])  # natural units: a push off a gait of a shorter period
LONGEST_WALK = 20_000  # strides of the walk from there, however long the period


class GaitNotFoundError(ValueError):
    """No gait was found; the message gives the reason."""


@dataclass(frozen=True, eq=False)
class Gait:
    """A limit cycle of the walker: a fixed point of its stride map over `period` strides."""

    params: WalkerParams
    control: AnyControl | Policy | None
    period: int  # strides
    section: str  # "switch" (the thesis's) or "post-strike"
    state: PostStrikeState  # post-strike, rad and rad/s
    states: Array = field(repr=False)  # (period, 4) the post-strike states of the cycle
    section_state: tuple[float, float, float] | None  # (q1, u1, u3) at the switch
    multipliers: NDArray[np.complex128]  # Floquet multipliers, largest first
    jacobian: Array = field(repr=False)  # (4, 4) of the post-strike map over the period
    control_jacobian: Array = field(repr=False)  # (4, k) by the control's numbers, as switch angle
    # and stall torque (under a policy: by what is added to them)
    duration: float  # s, of the whole period
    step_length: float  # m, of the whole period
    positive_work: float  # J, of motor, hip or push over the whole period
    electrical_energy: float = 0.0  # J, into the ankle motor, if any, over the whole period

    def __repr__(self) -> str:
        stable = "stable" if self.stable else "unstable"
        return (
            f"Gait({self.control!r}, period {self.period}, {stable} at {self.spectral_radius:.4f}, "
            f"{self.step_length:.4f} m in {self.duration:.4f} s, from {short(self.state)})"
        )

    @property
    def spectral_radius(self) -> float:
        """The largest multiplier's modulus; below 1 the gait is stable."""
        return float(abs(self.multipliers[0]))

    @property
    def stable(self) -> bool:
        """Whether small deviations die out."""
        return self.spectral_radius < 1.0

    @property
    def speed(self) -> float:
        """Mean walking speed, m/s."""
        return self.step_length / self.duration

    @property
    def cost_of_transport(self) -> float:
        """Work put in over the walker's weight times the distance along the floor.

        Counted are the positive work of motor, hip or push, and gravity's on a downhill
        slope, the slope's sine: all that a passive walker has, and pays for in height.
        """
        weight = 2.0 * self.params.leg_mass * self.params.gravity
        gravity = max(math.sin(self.params.slope), 0.0)
        return self.positive_work / (weight * self.step_length) + gravity


def find_gait(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    guess: PostStrikeState | Sequence[float] | None = None,
    *,
    section: str | None = None,
    period: int = 1,
) -> Gait:
    """Find a limit cycle by damped Newton on the stride map.

    Args:
        params: the walker.
        control: a constant control, None for a passive walker, or a policy (see `Policy`).
        guess: a post-strike state near the gait. Without one, the presets and a seeded
            random search supply the starts.
        section: "switch" lists the 3 multipliers of the thesis's section, "post-strike"
            all 4 (the fourth is zero). Left out: the switch, where there is one.
        period: strides after which the gait closes for the first time, 1 to 1024. Where
            Newton's method leads to a gait of a shorter period, the walker is left to walk
            away from it, and the search goes on from where it settles.

    Raises:
        GaitNotFoundError: with the reason, when no start led to a gait; standing on the spot
            is none.
        ValueError, TypeError: a bad argument.
    """
    stride_map = StrideMap(params, control)
    section = _check_section(section, stride_map.scheme)
    period = whole_number("period", period, 1, LONGEST_PERIOD)
    starts = _starts(stride_map, period) if guess is None else np.array([check_state(guess)])
    reasons: list[str] = []
    for start in starts:
        state, reason = _gait_near(stride_map, start, period, settle=not reasons)
        if state is not None:
            return describe(stride_map, state, section, period)
        reasons.append(reason)
    raise GaitNotFoundError(
        f"no gait of period {period} found for {control or 'a passive walker'} "
        f"from {len(starts)} start(s): "
        f"{reasons[0] if reasons else 'no start survives a stride'}; "
        "give a guess near one, or change the control"
    )


def _gait_near(
    stride_map: StrideMap, start: Array, period: int, settle: bool
) -> tuple[Array | None, str]:
    """A fixed point near `start` of that least period, or None and why not."""
    state, reason = newton(stride_map, start, period)
    if state is None:
        return None, reason
    reason = refusal(stride_map, state, period)
    if not reason:
        return state, ""
    if period == 1 or not settle:
        return None, reason
    walked = start + NUDGE * natural_units(stride_map.params)
    for _ in range(min(SETTLING, LONGEST_WALK // period)):
        walked = stride_map(walked[np.newaxis], period)[0]
        if not np.isfinite(walked).all():
            return None, f"{reason}; walking on from there it falls"
    settled, _ = newton(stride_map, walked, period)
    if settled is None or refusal(stride_map, settled, period):
        return None, f"{reason}; walking on from there it does not settle on one of {period}"
    return settled, ""


def _check_section(section: str | None, powered: Scheme) -> str:
    if section is None:
        return natural_section(powered)
    if section not in SECTIONS:
        raise ValueError(f"section must be one of {SECTIONS}, got {section!r}")
    if section == "switch" and not powered.switches:
        whose = "a passive walker" if powered.control is None else f"scheme {powered.name!r}"
        raise ValueError(f"section must be 'post-strike' for {whose}, which has no switch")
    return section


def natural_section(powered: Scheme) -> str:
    """The thesis's section where a stride has a switch."""
    return "switch" if powered.switches else "post-strike"


def _starts(stride_map: StrideMap, period: int) -> Array:
    """Likely starts: the random and preset states that the map brings back nearest."""
    units = natural_units(stride_map.params)
    rng = np.random.default_rng(0)
    stance = -rng.uniform(0.05, 0.45, RANDOM_STARTS)
    swing = -stance + rng.normal(0.0, 0.1, RANDOM_STARTS)
    rates = rng.uniform([0.05, -0.2], [0.6, 0.5], (RANDOM_STARTS, 2))
    scattered = np.column_stack([stance, swing, rates]) * units
    states = np.concatenate([_of_presets(stride_map), scattered])
    residuals = relative_residuals(stride_map, states, period)
    order = np.argsort(residuals, kind="stable")
    return states[order[: min(NEAREST, int(np.isfinite(residuals).sum()))]]


def _of_presets(stride_map: StrideMap) -> Array:
    """The gaits, to this walker's scale, of the presets that are powered like it.

    And of those with the plainest scheme of the same joints: the motor, or none.
    """
    plain = MOTOR if stride_map.scheme.moves_ankle else PASSIVE
    known = (stride_map.scheme, plain)
    alike = [preset for preset in PRESETS.values() if scheme_of(preset.control) in known]
    scaled = np.array([np.array(p.state) / natural_units(p.params) for p in alike])
    states: Array = scaled * natural_units(stride_map.params)
    return states


def describe(stride_map: StrideMap, state: Array, section: str, period: int) -> Gait:
    """The gait at a fixed point, with its multipliers and its strides' quantities."""
    point = stride_map.differentiate(state, period)
    multipliers = np.linalg.eigvals(point.by_state).astype(complex)
    multipliers = multipliers[np.argsort(-abs(multipliers), kind="stable")]
    states, work, electrical = [state], [], []
    for _ in range(period):
        batch = stride_map.strides(states[-1][np.newaxis])
        work.append(float(batch.positive_work[0]))
        electrical.append(float(batch.electrical_energy[0]))
        states.append(batch.state[0])
    first = PostStrikeState(*state.tolist())
    at_switch = None
    if stride_map.control is not None:
        control = stride_map.scheme.control_of(stride_map.controls(state[np.newaxis])[0])
        at_switch = switch_section(first, control, stride_map.params)
    return Gait(
        params=stride_map.params,
        control=stride_map.control,
        period=period,
        section=section,
        state=first,
        states=np.array(states[:-1]),
        section_state=at_switch,
        multipliers=multipliers[:3] if section == "switch" else multipliers,
        jacobian=point.by_state,
        control_jacobian=point.by_control,
        duration=point.duration,
        step_length=point.step_length,
        positive_work=math.fsum(work),
        electrical_energy=math.fsum(electrical),
    )
