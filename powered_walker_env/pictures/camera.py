"""The camera: follows the hip at the walker's mean speed, and the floor."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from powered_walker_env.model.walker import WalkerParams

Array = npt.NDArray[np.float64]


class Camera(NamedTuple):
    """The point of the floor that the picture is centred on, and how fast it moves."""

    forward: float  # m
    up: float  # m
    speed: float  # m/s, forward


def follow(
    camera: Camera, t: Array, hips: Array, floor: Array, rate: float
) -> tuple[Camera, Array]:
    """Move the camera along a trajectory; the camera at its end, and its track (n, 2) m.

    Forward it is a critically damped observer of the hip, which settles on the walker's
    mean speed and so keeps up without lagging; up it lags.

    Args:
        t: (n,) s; hips: (n,) m, forward; floor: (n,) m, height under the stance foot.
        rate: 1/s, how fast it settles.
    """
    track = [(camera.forward, camera.up)]
    for i in range(1, len(t)):
        span = (float(hips[i - 1]), float(hips[i]))
        camera = _pan(camera, span, float(floor[i]), float(t[i] - t[i - 1]), rate)
        track.append((camera.forward, camera.up))
    return camera, np.array(track)


def _pan(camera: Camera, hips: tuple[float, float], floor: float, dt: float, rate: float) -> Camera:
    """Move the camera over `dt` while the hip goes evenly between two positions.

    Exact solution of x' = v + 2 rate (hip − x), v' = rate² (hip − x).
    """
    if dt <= 0:
        return camera
    hip_speed = (hips[1] - hips[0]) / dt
    behind, slower = hips[0] - camera.forward, hip_speed - camera.speed
    decay, k = math.exp(-rate * dt), slower - rate * behind
    return Camera(
        forward=hips[1] - (behind + k * dt) * decay,
        up=floor + (camera.up - floor) * decay,
        speed=hip_speed - (slower + rate * k * dt) * decay,
    )


def hip_forward(q: Array, foot: Array, params: WalkerParams) -> Array:
    """Forward position of the hip at each sample, (n,) m."""
    phi, alpha = q[:, 0], q[:, 0] + q[:, 1]
    along: Array = foot[:, 0] + params.foot_length * np.sin(phi) + params.leg_length * np.sin(alpha)
    return along
