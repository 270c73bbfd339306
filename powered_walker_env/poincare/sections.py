"""Three-number sections: where one more number of the post-strike state is no decision of its own.

A post-strike state has four numbers, (α, s, α', β'), but the swing that follows is autonomous as
long as the foot is locked and no torque acts: all states on one of its orbits are the same start.
A stride under a constant control therefore has a map of rank three, and regions, volumes and
decisions live on a section across the orbits, three numbers (α, α', β'), on which s follows:

- *both feet on the floor*, where the foot stays locked all stride. The legs are mirrored: with
  K = L + D e^{−i·q2_lock} from hip to floor along either foot, s = −α − 2 arg K (for a foot in
  line with its leg s = −α). With massless point feet two numbers are free, since the trailing
  foot is at rest as its leg begins to swing: β' = α' cos(α − s). Strides on level ground, sloping
  or not, end on it, and pushes that change rates stay on it, but for that walker's.
- *a hip angle*, for every walker: the swing as its hip angle falls to q3, s = α + q3 − π. This is
  the thesis's section (Camp 1997, section 7: q1 = α − q2_lock, u1 = α', u3 = β' − α') with q3 the
  switch angle, or, where that is decided stride by stride, one ahead of all that may be chosen.
  A post-strike state, push included, is carried there by the locked swing. What it leaves out is
  how long ago the heel strike was, how far the foot has rolled since, and starts that begin
  beyond q3 (after any landing the legs are apart, q3 > π): those are not on it.

A swing leg with a knee takes two numbers more until the knee strikes: such walkers have the first
section only.

What is lost: after a step up or down the feet are not level, so on uneven ground only a hip angle
will do, with the rise of each step independent of the one before; a controller that sees the state
through a noisy sensor decides on less than the section, so that what is found on it is a bound.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from powered_walker_env.model.checks import real_number
from powered_walker_env.model.mechanics.packing import pack
from powered_walker_env.model.phases import (
    Cycle,
    Exit,
    Guard,
    Joints,
    Outcome,
    Phase,
    Reset,
    Torque,
)
from powered_walker_env.model.powering import ANGLE, AnyControl, Policy, scheme_of
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.tolerances import ORBIT_RTOL
from powered_walker_env.simulation.strides import Array, run_batch

STATE = PostStrikeState._fields
#: The locked swing alone, down to a hip angle.
SWING: Cycle = (
    Phase(
        "swing",
        Joints.ANKLE_LOCKED,
        Torque.NONE,
        (
            Exit(Guard.SWITCH_ANGLE, Reset.CONTINUE, Outcome.WALKED),
            Exit(Guard.LANDING, Reset.CONTINUE, Outcome.NO_SWITCH),
        ),
    ),
)
LEGS_PASS = math.pi  # rad, the hip angle: every post-strike state is ahead of it
AHEAD = 1e-13  # rad, ahead of the hip angle, so that a switch there is still to come
KNEES = (
    "its leg swings bent, which takes two numbers more until the knee strikes; look at raw boxes "
    "of post-strike states, or keep the feet locked on level ground"
)
ON_SECTION = 1e-9  # rad: nearer to the hip angle is on it


@dataclass(frozen=True)
class Section:
    """Both feet on the floor, or a hip angle of the locked swing.

    Raises:
        ValueError: a hip angle outside (0, 2π).
    """

    params: WalkerParams
    hip_angle: float | None = None  # rad, q3; None: both feet on the floor

    def __post_init__(self) -> None:
        if self.hip_angle is None:
            return
        if self.params.knee is not None:
            raise ValueError(f"hip_angle must be left out for a walker with knees: {KNEES}")
        angle = real_number("hip_angle", self.hip_angle)
        if not 0.0 < angle < 2.0 * math.pi:
            raise ValueError(f"hip_angle must lie in (0, 2*pi), got {angle!r}; radians")
        object.__setattr__(self, "hip_angle", angle)

    def __str__(self) -> str:
        if self.hip_angle is None:
            return "both feet on the floor"
        return f"hip angle {self.hip_angle:.5g} rad"

    @property
    def coordinates(self) -> tuple[str, ...]:
        """What is free on it, by the names of the state: three numbers, or two."""
        rates = ("stance_rate",) if self._follows else ("stance_rate", "swing_rate")
        return ("stance_angle", *rates)

    @property
    def columns(self) -> list[int]:
        """Where its coordinates stand in a state."""
        return [STATE.index(name) for name in self.coordinates]

    @property
    def _follows(self) -> bool:
        """Whether the swing rate follows from the others: massless point feet, both down."""
        params = self.params
        pointed = params.foot_length == params.foot_radius == 0.0
        return self.hip_angle is None and params.massless_foot and pointed

    def swing_angles(self, stance: Array) -> Array:
        """s of points with these α, rad."""
        if self.hip_angle is None:
            return angle_sum(self.params) - stance
        return stance + (self.hip_angle - math.pi + AHEAD)

    def stance_angles(self, swing: Array) -> Array:
        """α of points with these s, rad: the inverse of `swing_angles`."""
        if self.hip_angle is None:
            return angle_sum(self.params) - swing
        return swing - (self.hip_angle - math.pi + AHEAD)

    def laid(self, states: Array) -> Array:
        """(N, 4) states with the coordinates of these, on the section: s, and β', follow."""
        states = states.copy()
        states[:, 1] = self.swing_angles(states[:, 0])
        if self._follows:
            states[:, 3] = states[:, 2] * np.cos(states[:, 0] - states[:, 1])
        return states

    def states(self, points: ArrayLike) -> Array:
        """(N, 4) the states at points (N, k) of the section, from which a stride begins.

        On a hip angle they are in mid-swing: the stride from there ends as the whole one does,
        but its duration and step length count from there.

        Raises:
            ValueError: a wrong shape.
        """
        given = np.asarray(points, np.float64)
        if given.ndim != 2 or given.shape[1] != len(self.coordinates):
            raise ValueError(
                f"points must have shape (N, {len(self.coordinates)}): "
                f"{', '.join(self.coordinates)}, got {given.shape}"
            )
        states = np.zeros((len(given), len(STATE)))
        states[:, self.columns] = given
        return self.laid(states)

    def points(self, states: ArrayLike, rtol: float = ORBIT_RTOL) -> Array:
        """(N, k) where the orbits of states (N, 4) meet the section; NaN where they do not.

        With both feet on the floor the coordinates are read off as they stand. Otherwise the
        locked swing carries the states on; NaN are those that fall or land before the hip angle
        is reached, those that began beyond it, and those that were NaN.
        """
        given = np.asarray(states, np.float64)
        if self.hip_angle is None:
            return given[:, self.columns]
        there = self._carried(given, self.hip_angle, rtol)
        return there[:, self.columns]

    def _carried(self, states: Array, angle: float, rtol: float) -> Array:
        """(N, 4) the states as the hip angle falls to this; NaN where it does not."""
        there, row = np.full(states.shape, np.nan), pack(self.params)[np.newaxis]
        ahead = states[:, 1] - states[:, 0] + (math.pi - angle)
        near = np.abs(ahead) < ON_SECTION
        there[near] = states[near]
        going = np.flatnonzero(ahead >= ON_SECTION)
        if len(going):
            controls = np.tile([angle, 0.0], (len(going), 1))
            batch = run_batch(SWING, states[going], controls, row, np.zeros(1), rtol)
            _, alpha, beta, _, d_alpha, d_beta = batch.final.T
            found = np.column_stack([alpha, beta - math.pi, d_alpha, d_beta])
            there[going[batch.walked]] = found[batch.walked]
        return there


def angle_sum(params: WalkerParams) -> float:
    """α + s of a walker with locked feet, both on the floor: −2 arg K, rad."""
    lever = params.foot_length * cmath.exp(-1j * params.locked_ankle_angle)
    return -2.0 * cmath.phase(params.leg_length + lever)


def section_of(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    high: ArrayLike | None = None,
    *,
    level: bool = True,
) -> Section:
    """The section that a walker's strides are looked at on.

    Both feet on the floor where the foot stays locked all stride and the ground is level; else
    a hip angle: the switch angle of a constant control or, where that is decided, the largest.

    Args:
        params: the walker.
        control: constant, None for a passive walker, or a policy.
        high: (k,) upper bounds of the control's numbers where they are decided; left out, the
            policy's own (`high`), if it says so. Without bounds the section is where the legs
            pass, ahead of every switch angle below π.
        level: whether the ground is; if not, the feet are not a section.

    Raises:
        ValueError: no such section: a torque acts from heel strike on, and the ground is not
            level or the foot moves.
    """
    scheme = scheme_of(control)
    if level and not scheme.moves_ankle:
        return Section(params)
    if params.knee is not None:
        raise ValueError(f"params must have no knee for a section at a hip angle: {KNEES}")
    if not swings_freely(control):
        raise ValueError(
            "control must leave the swing alone after heel strike for a section at a hip angle, "
            f"got scheme {scheme.name!r}; take level ground and a foot that stays locked"
        )
    if not scheme.switches:
        return Section(params, LEGS_PASS)
    place = scheme.columns.index(ANGLE)
    bounds = getattr(control, "high", None) if high is None else high
    if bounds is not None:
        return Section(params, float(np.asarray(bounds, np.float64)[place]))
    if callable(control):
        return Section(params, LEGS_PASS)
    return Section(params, float(getattr(control, scheme.numbers[place])))


def swings_freely(control: AnyControl | Policy | None) -> bool:
    """Whether a stride begins with a swing in which the foot is locked and no torque acts."""
    first = scheme_of(control).cycle[0]
    return bool(first.joints == Joints.ANKLE_LOCKED and first.torque == Torque.NONE)


def known_section(params: WalkerParams, control: AnyControl | Policy | None) -> Section | None:
    """`section_of` on level ground, None where there is none."""
    bent = params.knee is not None
    if scheme_of(control).moves_ankle and (bent or not swings_freely(control)):
        return None
    return section_of(params, control)
