"""The numbers a kernel needs, from `WalkerParams`, as one row of floats and as named values."""

from __future__ import annotations

import cmath
import dataclasses
import math
from typing import NamedTuple

import numpy as np

from powered_walker_env.compiled.decorators import internal, kernel
from powered_walker_env.compiled.lanes import load
from powered_walker_env.model.walker import AS_PUBLISHED, CONSERVING, WalkerParams

# Order of a packed row; `unpack` reads it by number. The physics comes last.
_FIELDS = tuple(f.name for f in dataclasses.fields(WalkerParams) if f.name != "physics")
PACKED = len(_FIELDS) + 1
LEG_LENGTH, LEG_MASS, GRAVITY = (_FIELDS.index(f) for f in ("leg_length", "leg_mass", "gravity"))


class Constants(NamedTuple):
    """The walker as the kernels see it; symbols as in Camp 1997, Appendix A."""

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
    landing_angle: float  # rad, arg(L + D e^{−i·lock}), of `ground.locked_landing`
    hip_stiffness: float  # N m/rad
    no_load_speed: float  # rad/s
    torque_limit: float  # N m, of the motor; infinite for none
    as_published: bool  # the thesis's listing instead of its text


LANE_ROWS = 22  # of the table that `write_lane` fills
NO_LOAD_SPEED = 19  # one of them


def pack(params: WalkerParams) -> np.ndarray:
    """The parameters as a row of floats, so that a batch can carry one walker per row."""
    return np.array(
        [getattr(params, field) for field in _FIELDS] + [float(params.physics == AS_PUBLISHED)]
    )


def params_of(row: np.ndarray) -> WalkerParams:
    """The inverse of `pack`."""
    *numbers, as_published = row.tolist()
    return WalkerParams(
        **dict(zip(_FIELDS, numbers, strict=True)),
        physics=AS_PUBLISHED if as_published else CONSERVING,
    )


def constants_of(params: WalkerParams) -> Constants:
    """The walker as the functions of `physics` take it."""
    constants: Constants = unpack(pack(params)[np.newaxis])
    return constants


@kernel
def unpack(rows, i=0):
    """The named constants of row i of packed walkers, (n, PACKED)."""
    length, foot, lock, mass, inertia = rows[i, 0], rows[i, 1], rows[i, 3], rows[i, 4], rows[i, 5]
    x, y, gravity, slope = rows[i, 6], rows[i, 7], rows[i, 8], rows[i, 9]
    massless = inertia == 0.0 and x == length and y == 0.0
    retracted = foot * complex(math.cos(lock), -math.sin(lock))
    return Constants(
        length,
        foot,
        rows[i, 2],
        lock,
        mass,
        inertia,
        complex(x, y),
        complex(length, 0.0) if massless else complex(length - x, -y),
        1.0 if massless else mass,
        inertia,
        0.0 if massless else 1.0,
        complex(gravity * math.cos(slope), -gravity * math.sin(slope)),
        retracted,
        cmath.phase(length + retracted),
        rows[i, 11],
        rows[i, 10],
        rows[i, 12] if rows[i, 12] > 0.0 else math.inf,
        rows[i, 13] != 0.0,
    )


@internal
def write_lane(c, table, lane):
    """Write the constants of one walker into its column of a table (LANE_ROWS, 8)."""
    table[0, lane] = c.L
    table[1, lane] = c.D
    table[2, lane] = c.R
    table[3, lane] = c.lock
    table[4, lane] = c.M
    table[5, lane] = c.I
    table[6, lane] = c.ankle_to_com.real
    table[7, lane] = c.ankle_to_com.imag
    table[8, lane] = c.hip_to_com.real
    table[9, lane] = c.hip_to_com.imag
    table[10, lane] = c.swing_mass
    table[11, lane] = c.swing_inertia
    table[12, lane] = c.reaction
    table[13, lane] = c.g.real
    table[14, lane] = c.g.imag
    table[15, lane] = c.retracted.real
    table[16, lane] = c.retracted.imag
    table[17, lane] = c.landing_angle
    table[18, lane] = c.hip_stiffness
    table[19, lane] = c.no_load_speed
    table[20, lane] = c.torque_limit
    table[21, lane] = 1.0 if c.as_published else 0.0


@internal
def lane_of(table, lane):
    """The constants of one of the eight walkers, from such a table."""
    return Constants(
        table[0, lane],
        table[1, lane],
        table[2, lane],
        table[3, lane],
        table[4, lane],
        table[5, lane],
        complex(table[6, lane], table[7, lane]),
        complex(table[8, lane], table[9, lane]),
        table[10, lane],
        table[11, lane],
        table[12, lane],
        complex(table[13, lane], table[14, lane]),
        complex(table[15, lane], table[16, lane]),
        table[17, lane],
        table[18, lane],
        table[19, lane],
        table[20, lane],
        table[21, lane] > 0.0,
    )


@internal
def lanes_of(table):
    """The constants of eight walkers, from such a table."""
    return Constants(
        load(table, 0),
        load(table, 1),
        load(table, 2),
        load(table, 3),
        load(table, 4),
        load(table, 5),
        complex(load(table, 6), load(table, 7)),
        complex(load(table, 8), load(table, 9)),
        load(table, 10),
        load(table, 11),
        load(table, 12),
        complex(load(table, 13), load(table, 14)),
        complex(load(table, 15), load(table, 16)),
        load(table, 17),
        load(table, 18),
        load(table, 19),
        load(table, 20),
        load(table, 21) > 0.0,
    )
