"""What one picture shows, as data: the walker's pose, the floor, the labels.

Points are complex numbers, up + i·forward, in metres along the floor's axes (as in
`mechanics/chain.py`), so a limb of length a at angle θ ends at a·e^{iθ} from its start.
"""

from __future__ import annotations

import bisect
import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from powered_walker_env.model.walker import WalkerParams

Array = npt.NDArray[np.float64]


class Pose(NamedTuple):
    """Where the walker's parts are at one instant, m and rad."""

    foot: complex  # centre of the stance foot
    ankle: complex
    knee: complex  # where there is none, the ankle, as below
    hip: complex
    swing_knee: complex
    swing_ankle: complex
    swing_foot: complex  # centre of the swing foot
    foot_angle: float  # φ: centre to ankle, from the floor's normal
    swing_foot_angle: float

    @classmethod
    def of(cls, foot: complex, q: Sequence[float], params: WalkerParams) -> Pose:
        """The pose with the stance foot's centre at `foot`.

        Args:
            q: relative angles q1, q2, q3, and the flexion of the swing knee.
        """
        D, L, lock = params.foot_length, params.leg_length, params.locked_ankle_angle
        shank = 0.0 if params.knee is None else params.knee.shank_length
        phi, alpha, theta = q[0], q[0] + q[1], q[0] + q[1] + q[2]
        beta = theta + q[3]
        ankle = foot + cmath.rect(D, phi)
        hip = ankle + cmath.rect(L, alpha)
        knee, swing_knee = ankle + cmath.rect(shank, alpha), hip + cmath.rect(L - shank, theta)
        swing_ankle = swing_knee + cmath.rect(shank, beta)
        swing_foot = swing_ankle + cmath.rect(D, beta - lock)
        return cls(
            foot, ankle, knee, hip, swing_knee, swing_ankle, swing_foot, phi, beta - lock - math.pi
        )


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
    motor_on: bool | None  # None: the walker has no ankle motor
    name: str = ""  # of the walk, where there are several
    verdict: str = ""  # how the walk ended, if it has


@dataclass(frozen=True, eq=False)
class Stretch:
    """A trajectory set in the renderer's world: shifted to begin where the last one ended."""

    params: WalkerParams
    t: Array  # (n,) s
    q: Array  # (n, 4) rad, as `Pose.of` takes them
    foot: Array  # (n, 2) m, forward and up
    motor_on: npt.NDArray[np.bool_]  # (n,)
    stride: npt.NDArray[np.int64]  # (n,)
    camera: Array  # (n, 2) m, forward and up
    verdict: str  # how the walk ended, "" if it goes on

    def at(self, time: float) -> tuple[int, Array, Array, Array]:
        """The sample at or before `time`, and q, foot and camera interpolated to it.

        Both sides of an event are samples, so no interpolation crosses one; at the
        event itself the later side counts.
        """
        i = int(np.searchsorted(self.t, time, side="right")) - 1
        i = min(max(i, 0), len(self.t) - 1)
        j = min(i + 1, len(self.t) - 1)
        span = self.t[j] - self.t[i]
        share = min(max((time - self.t[i]) / span, 0.0), 1.0) if span > 0 else 0.0
        q, foot, camera = (a[i] + share * (a[j] - a[i]) for a in (self.q, self.foot, self.camera))
        return i, q, foot, camera

    def picture_times(self, rate: float, fresh: bool) -> list[float]:
        """The multiples of 1/rate after the begin and up to the end, s.

        A fresh walk shows its first instant, too, and a fall its last.
        """
        begin, end = float(self.t[0]), float(self.t[-1])
        tiny = 1e-9  # of a picture: a time on the edge belongs to the trajectory that ends there
        first = math.floor(begin * rate + tiny) + 1
        times = [k / rate for k in range(first, math.floor(end * rate + tiny) + 1)]
        if fresh:
            times = [begin, *times]
        if self.verdict and times[-1:] != [end]:
            times.append(end)
        return times
