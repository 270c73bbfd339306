"""Three numbers of a walker whose landings have no section: with knees, and a foot that moves.

Two things make three numbers enough. A stride under a constant control has a map of rank three:
along one direction n nothing that follows changes. And landings lie near a plane, both feet on
the floor but for how far the trailing one is extended: α + s as on the gait. So a state is moved
along n onto that plane, where (α, α', β') say the rest. To first order this is exact; the second
order is small as landings are near the plane (with knees α + s stays within a hundredth of its
unit of an observation), and walks, which are whole, tell what is lost.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from powered_walker_env.model.state import natural_units
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.poincare.sections import STATE
from powered_walker_env.poincare.tolerances import ORBIT_RTOL
from powered_walker_env.simulation.strides import Array

RANK = 1e-3  # of the least singular value against the greatest: what counts as none
COLUMNS = [0, 2, 3]


@dataclass(frozen=True, eq=False)
class LandingPlane:
    """States with α + s as on a gait, to which others are moved along what changes nothing."""

    params: WalkerParams
    angle_sum: float  # rad, α + s
    along: Array = field(repr=False)  # (4,) n, with n_α + n_s = 1
    hip_angle: None = None  # it is at heel strike

    def __str__(self) -> str:
        return f"landings, the leg angles' sum {self.angle_sum:.5g} rad"

    @property
    def coordinates(self) -> tuple[str, ...]:
        """What is free on it, by the names of the state."""
        return tuple(STATE[column] for column in COLUMNS)

    @property
    def columns(self) -> list[int]:
        """Where its coordinates stand in a state."""
        return list(COLUMNS)

    def states(self, points: ArrayLike) -> Array:
        """(N, 4) the post-strike states at points (N, 3)."""
        given = np.asarray(points, np.float64)
        states = np.empty((len(given), len(STATE)))
        states[:, COLUMNS] = given
        states[:, 1] = self.angle_sum - states[:, 0]
        return states

    def points(self, states: ArrayLike, rtol: float = ORBIT_RTOL) -> Array:
        """(N, 3) where states (N, 4) are, moved onto it. `rtol` is a section's: of no use here."""
        given = np.asarray(states, np.float64)
        off = given[:, 0] + given[:, 1] - self.angle_sum
        moved: Array = (given - off[:, np.newaxis] * self.along)[:, COLUMNS]
        return moved


def landing_plane(gait: Gait) -> LandingPlane:
    """The plane of a gait of one stride.

    Raises:
        ValueError: a stride whose map has rank four, or one that forgets the leg angles' sum.
    """
    units = natural_units(gait.params)
    jacobian = gait.jacobian * units / units[:, np.newaxis]
    _, sizes, directions = np.linalg.svd(jacobian)
    along = directions[-1] * units
    across = along[0] + along[1]
    if sizes[-1] > RANK * sizes[0] or abs(across) < RANK:
        raise ValueError(
            "gait must have a stride of rank three for an optimum on three numbers, got singular "
            f"values {sizes.tolist()} in natural units"
        )
    return LandingPlane(gait.params, float(gait.state[0] + gait.state[1]), along / across)
