"""Gaits: fixed points of the stride map by damped Newton (Camp 1997, section 7)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.powering import MOTOR, PASSIVE, AnyControl, Scheme, scheme_of
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.model.state import PostStrikeState, check_state
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.maps import Policy, StrideMap, natural_units, switch_section
from powered_walker_env.simulation import record
from powered_walker_env.simulation.strides import Array

SECTIONS = ("switch", "post-strike")
CONVERGED = 1e-11  # residual of a fixed point, in natural units
NEWTON_STEPS = 40
HALVINGS = 8  # of a Newton step that does not bring the residual down
STARTS = 512  # random states tried when no guess is given
TRIES = 12  # of them, the nearest to periodic ones, from which Newton starts


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
    control_jacobian: Array = field(repr=False)  # (4, 2) by switch angle and strength, as
    # stall torque (under a policy: by what is added to its controls)
    duration: float  # s, of the whole period
    step_length: float  # m, of the whole period
    positive_work: float  # J, of motor, hip or push over the whole period
    electrical_energy: float = 0.0  # J, into the ankle motor, if any, over the whole period

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
        """Positive work over the walker's weight times the distance."""
        weight = 2.0 * self.params.leg_mass * self.params.gravity
        return self.positive_work / (weight * self.step_length)


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
        period: strides after which the gait closes, at least 1.

    Raises:
        GaitNotFoundError: with the reason, when no start led to a gait.
        ValueError: a bad argument.
    """
    stride_map = StrideMap(params, control)
    section = _check_section(section, stride_map.scheme)
    if period < 1:
        raise ValueError(f"period must be at least 1, got {period!r}")
    starts = _starts(stride_map, period) if guess is None else np.array([check_state(guess)])
    reasons = []
    for start in starts:
        state, reason = newton(stride_map, start, period)
        if state is not None:
            return describe(stride_map, state, section, period)
        reasons.append(reason)
    raise GaitNotFoundError(
        f"no gait of period {period} found for {control or 'a passive walker'} "
        f"from {len(starts)} start(s): "
        f"{reasons[0] if reasons else 'no start survives a stride'}; "
        "give a guess near one, or change the control"
    )


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
    stance = -rng.uniform(0.05, 0.45, STARTS)
    swing = -stance + rng.normal(0.0, 0.1, STARTS)
    rates = rng.uniform([0.05, -0.2], [0.6, 0.5], (STARTS, 2))
    scattered = np.column_stack([stance, swing, rates]) * units
    states = np.concatenate([_of_presets(stride_map), scattered])
    residuals = residuals_of(stride_map, states, period)
    order = np.argsort(residuals, kind="stable")
    return states[order[: min(TRIES, int(np.isfinite(residuals).sum()))]]


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


def residuals_of(stride_map: StrideMap, states: Array, period: int) -> Array:
    """Distance of each state (N, 4) from its image, in natural units; inf after a fall."""
    moved = (stride_map(states, period) - states) / natural_units(stride_map.params)
    distance = np.linalg.norm(moved, axis=1)
    return np.where(np.isfinite(distance), distance, np.inf)


def newton(
    stride_map: StrideMap, state: Array, period: int, converged: float = CONVERGED
) -> tuple[Array | None, str]:
    """A fixed point near `state` by damped Newton, or None and why not."""
    point, residual = stride_map.differentiate(state, period), np.inf
    if point.outcome == Outcome.WALKED:
        residual = float(np.linalg.norm((point.state - state) / natural_units(stride_map.params)))
    for _ in range(NEWTON_STEPS):
        if not np.isfinite(point.by_state).all():
            return None, f"from {state.round(4).tolist()} the walker {point.outcome.label}"
        change = np.linalg.lstsq(np.eye(4) - point.by_state, point.state - state)[0]
        trials = state + change * 0.5 ** np.arange(HALVINGS)[:, np.newaxis]
        residuals = residuals_of(stride_map, trials, period)
        better = np.flatnonzero(residuals < residual)
        if not len(better):
            break
        state, residual = trials[better[0]], float(residuals[better[0]])
        point = stride_map.differentiate(state, period)
    if residual <= converged:
        return state, ""
    return None, f"Newton stopped at a residual of {residual:.2g} near {state.round(4).tolist()}"


def describe(stride_map: StrideMap, state: Array, section: str, period: int) -> Gait:
    """The gait at a fixed point, with its multipliers and its strides' quantities."""
    point = stride_map.differentiate(state, period)
    multipliers = np.linalg.eigvals(point.by_state).astype(complex)
    multipliers = multipliers[np.argsort(-abs(multipliers), kind="stable")]
    states, work, electrical = [state], [], []
    for _ in range(period):
        batch = stride_map.strides(states[-1][np.newaxis])
        work.append(float(batch.results[0, record.POSITIVE_WORK]))
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
