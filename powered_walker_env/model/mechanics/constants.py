"""The walker as the formulas see it: what follows from its own numbers (Camp 1997, Appendix A)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from powered_walker_env.model.mechanics.dual import (
    choose,
    conjugate,
    length,
    unit,
    value_of,
)


class Constants(NamedTuple):
    """The walker as the formulas see it; symbols as in Camp 1997, Appendix A."""

    L: float  # m, ankle to hip
    D: float  # m, ankle to the centre of the foot
    R: float  # m, radius of the foot
    lock: float  # rad, ankle angle q2 at the stop
    M: float  # kg, one leg
    I: float  # kg m², one leg about its centre of mass
    ankle_to_com: complex  # m, X + iY: leg's centre of mass from the ankle, leg frame
    hip_to_com: complex  # m, L − X − iY: the same from the hip, on the swing leg
    swing_mass: float  # kg, M; in the limit of a massless foot 1
    swing_inertia: float  # kg m², I; in that limit 0
    reaction: float  # 1; in that limit 0: the swing leg does not pull at the rest
    g: complex  # m/s², gravity·e^{−i·slope}: minus the gravitational acceleration
    retracted: complex  # m, D e^{−i·lock}: the foot's centre from the ankle, swing leg's frame
    reach: float  # m, |K| with K = L + D e^{−i·lock}: from the hip to the foot's centre
    lean: complex  # K/|K|
    kneed: bool  # whether the swing leg has a knee
    thigh: float  # m, from the hip to the knee; without a knee the whole leg, L
    shank: complex  # m, from the knee to the swing foot's centre, on the swing leg
    hip_stiffness: float  # N m/rad
    no_load_speed: float  # rad/s
    droop: float  # s/rad, of the motor's torque with the ankle's rate u2: ±1/ω_noload
    torque_limit: float  # N m, of the motor; infinite for none
    as_published: bool  # the thesis's listing instead of its text


def constants_from(own: Any) -> Constants:
    """What follows from a walker's own numbers, given by name: floats, arrays or `Dual`s."""
    L, D, M, I = own.leg_length, own.foot_length, own.leg_mass, own.leg_inertia
    X, Y, lock = own.com_along, own.com_across, own.locked_ankle_angle
    inertia, x, y = value_of(I), value_of(X), value_of(Y)
    massless = (inertia == 0.0) & (x == value_of(L)) & (y == 0.0)
    as_published = value_of(own.as_published) != 0.0
    com = X + 1j * Y
    retracted = D * conjugate(unit(lock))
    arm = L + retracted
    size = length(arm)
    point = value_of(size) == 0.0  # the foot's centre at the hip: no lean
    limit = value_of(own.torque_limit)
    kneed = value_of(own.shank_length) > 0.0
    return Constants(
        L=L,
        D=D,
        R=own.foot_radius,
        lock=lock,
        M=M,
        I=I,
        ankle_to_com=com,
        hip_to_com=choose(massless, L + 0j, L - com),
        swing_mass=choose(massless, 1.0, M),
        swing_inertia=I,
        reaction=choose(massless, 0.0, 1.0),
        g=own.gravity * unit(-own.slope),
        retracted=retracted,
        reach=size,
        lean=choose(point, 1.0 + 0j, arm / choose(point, 1.0, size)),
        kneed=kneed,
        thigh=L - own.shank_length,
        shank=own.shank_length + retracted,
        hip_stiffness=own.hip_stiffness,
        no_load_speed=own.no_load_speed,
        # The listing (`pow_qddt.m`) has a motor that pushes harder the faster it turns.
        droop=np.where(as_published, -1.0, 1.0) / own.no_load_speed,
        torque_limit=choose(limit > 0.0, own.torque_limit, np.inf),
        as_published=as_published,
    )
