"""How far ahead a foot lands, and up to where two feet count as standing together."""

from __future__ import annotations

import math

import numpy as np

from powered_walker_env.model.walker import WalkerParams
from tests.helpers.derivation import Array


def room_ahead(final: Array, params: WalkerParams) -> Array:
    """Foot to foot, over L, of poses (N, 6) of a walker; 0 where the legs have not passed."""
    phi, alpha, beta = final[:, 0], final[:, 1], final[:, 2]
    L, D, lock = params.leg_length, params.foot_length, params.locked_ankle_angle
    feet = D * (np.sin(phi) + np.sin(beta - lock)) + L * (np.sin(alpha) + np.sin(beta))
    return np.where(alpha - beta + math.pi > 0.0, feet / L, 0.0)


def together(rtol: float) -> float:
    """Up to which room ahead a touch of the floor is no landing."""
    return min(1e-4, math.sqrt(rtol))


def clear_of_together(final: Array, params: WalkerParams, rtol: float) -> Array:
    """(N,) whether landings at these poses, which are known to `rtol`, are landings at it, too."""
    return np.asarray(room_ahead(final, params) > together(rtol) + rtol)
