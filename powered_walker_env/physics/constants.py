"""The numbers a kernel needs, from `WalkerParams`, as one row of floats and as named values."""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from powered_walker_env.compilation import kernel
from powered_walker_env.params import AS_PUBLISHED, CONSERVING, WalkerParams

# Order of a packed row; `unpack` reads it by number. The physics comes last.
_FIELDS = tuple(f.name for f in dataclasses.fields(WalkerParams) if f.name != "physics")


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
    g: complex  # m/s², gravity·e^{−i·slope}: minus the gravitational acceleration
    no_load_speed: float  # rad/s
    as_published: bool  # the thesis's listing instead of its text


def pack(params: WalkerParams) -> np.ndarray:
    """The parameters as a row of 12 floats, so that a batch can carry one walker per row."""
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


@kernel
def unpack(row):
    """The named constants of one packed row."""
    length, x, y = row[0], row[6], row[7]
    gravity, slope = row[8], row[9]
    return Constants(
        length,
        row[1],
        row[2],
        row[3],
        row[4],
        row[5],
        complex(x, y),
        complex(length - x, -y),
        complex(gravity * math.cos(slope), -gravity * math.sin(slope)),
        row[10],
        row[11] != 0.0,
    )
