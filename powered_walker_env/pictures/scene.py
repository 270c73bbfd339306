"""What one picture shows, as data: the walker's pose, the floor, the labels.

Points are complex numbers, up + i·forward, in metres along the floor's axes (as in
`physics/swing.py`), so a limb of length a at angle θ ends at a·e^{iθ} from its start.
"""

from __future__ import annotations

import bisect
import cmath
import math
from collections.abc import Sequence
from typing import NamedTuple

from powered_walker_env.model.walker import WalkerParams


class Pose(NamedTuple):
    """Where the walker's parts are at one instant, m and rad."""

    foot: complex  # centre of the stance foot
    ankle: complex
    hip: complex
    swing_ankle: complex
    swing_foot: complex  # centre of the swing foot
    foot_angle: float  # φ: centre to ankle, from the floor's normal
    swing_foot_angle: float

    @classmethod
    def of(cls, foot: complex, q: Sequence[float], params: WalkerParams) -> Pose:
        """The pose with the stance foot's centre at `foot` and relative angles q1, q2, q3."""
        D, L, lock = params.foot_length, params.leg_length, params.locked_ankle_angle
        phi, alpha, beta = q[0], q[0] + q[1], q[0] + q[1] + q[2]
        ankle = foot + cmath.rect(D, phi)
        hip = ankle + cmath.rect(L, alpha)
        swing_ankle = hip + cmath.rect(L, beta)
        swing_foot = swing_ankle + cmath.rect(D, beta - lock)
        return cls(foot, ankle, hip, swing_ankle, swing_foot, phi, beta - lock - math.pi)


class Floor:
    """The ground walked over so far: level pieces, and between them steps."""

    def __init__(self, height: float = 0.0) -> None:
        self.edges: list[float] = []  # m, forward position of each step, increasing
        self.heights = [height]  # m, one more than edges

    def extend(self, edge: float, height: float) -> None:
        """Continue at `height` beyond `edge`; nothing to do where the floor goes on level."""
        rise = abs(height - self.heights[-1])
        if rise > 1e-9 and (not self.edges or edge > self.edges[-1]):
            self.edges.append(edge)
            self.heights.append(height)

    def height(self, forward: float) -> float:
        """Height of the floor at a forward position, m."""
        return self.heights[bisect.bisect_right(self.edges, forward)]

    def outline(self, begin: float, end: float) -> list[complex]:
        """Corners of the surface from one forward position to another."""
        first, last = bisect.bisect_right(self.edges, begin), bisect.bisect_left(self.edges, end)
        corners = [complex(self.heights[first], begin)]
        for k in range(first, last):
            corners += [
                complex(self.heights[k], self.edges[k]),
                complex(self.heights[k + 1], self.edges[k]),
            ]
        return [*corners, complex(self.heights[max(first, last)], end)]


class Scene(NamedTuple):
    """All that one picture shows."""

    params: WalkerParams
    pose: Pose
    floor: Floor
    focus: complex  # the point of the floor under the middle of the picture
    sector: tuple[float, float]  # foot angles φ between which the foot has a sole, rad
    stride: int  # strides begun before this one
    time: float  # s
    motor_on: bool
    verdict: str = ""  # how the walk ended, if it has
