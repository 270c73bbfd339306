"""A walk as pictures: frames in real time, drawn offscreen.

`Renderer` follows a walk stride by stride. What one picture shows is in `scene` and `painter`;
a window, GIF and MP4 are in `film`. Needs pygame
(`pip install "powered-walker-env[render]"`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.state import PostStrikeState, check_state
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.pictures.camera import Camera, follow, hip_forward
from powered_walker_env.pictures.canvas import Frame
from powered_walker_env.pictures.painter import Painter
from powered_walker_env.pictures.scene import Floor, Pose, Scene, Stretch

if TYPE_CHECKING:
    from powered_walker_env.simulation.trajectory import Trajectory

Array = npt.NDArray[np.float64]

CAMERA_RATE = 0.25  # of √(g/L): slow enough to smooth the lurch of each stride away
SOLE = 0.45  # rad, the least that the sole reaches either way from the locked, upright leg
SOLE_MARGIN = 0.12  # rad, of sole beyond the outermost contact points


class Renderer:
    """Draws a walk that grows stride by stride; pygame, offscreen, no display needed.

    Each trajectory given to `follow` or `frames` goes on where the last one ended:
    position, ground, time and count of strides are shifted to meet, whichever frame
    it was computed in. `reset` forgets the walk.

    Args:
        params: the walker; a trajectory brings its own.
        width, height: of the frames, px.
        name: shown in the corner, where there are several walks.
        painter: to share one of that size with other renderers; its own if left out.

    It can be copied and pickled, with the walk that it has followed.

    Raises:
        ImportError: pygame is not installed.
        ValueError: a size that is not a positive integer.
    """

    def __init__(
        self,
        params: WalkerParams,
        *,
        width: int = 640,
        height: int = 360,
        name: str = "",
        painter: Painter | None = None,
    ) -> None:
        self.params, self.name = params, name
        self._painter = painter or Painter(width, height)
        self.width, self.height = self._painter.width, self._painter.height
        self.reset()

    def reset(
        self,
        state: PostStrikeState | Sequence[float] | None = None,
        *,
        params: WalkerParams | None = None,
    ) -> None:
        """Forget the walk; with a post-strike state, stand there, ready for `frame`.

        Args:
            state: rad and rad/s, as `stride` takes it.
            params: the walker from now on; the same as before if left out.
        """
        self.params = self.params if params is None else params
        self._floor = Floor()
        self._stretch: Stretch | None = None
        self._camera: Camera | None = None
        self._strides, self._landing = 0, 0.0  # completed; m, the last contact point
        self._motor = False  # whether an ankle motor has been seen at work
        lock = self.params.locked_ankle_angle
        self._sector = (-lock - SOLE, -lock + SOLE)
        if state is not None:
            self._stand(check_state(state))

    @property
    def painter(self) -> Painter:
        """What draws the frames; renderers of one thread may share it."""
        return self._painter

    def follow(self, trajectory: Trajectory) -> None:
        """Go on along a trajectory; draws nothing yet.

        Raises:
            ValueError: the last trajectory ended in a fall; `reset` first.
        """
        self._follow(trajectory)

    def frame(self, time: float | None = None) -> Frame:
        """The picture at a time of the trajectory followed last, (height, width, 3) RGB.

        Args:
            time: s since the walk began; the end of the trajectory if left out.

        Raises:
            ValueError: there is no walk yet.
        """
        return self._painter.paint(self.scene(time))

    def frames(
        self, trajectory: Trajectory, fps: float = 25.0, *, speed: float = 1.0
    ) -> Iterator[Frame]:
        """Follow a trajectory and draw it, `fps` frames for each second of it over `speed`.

        The frames of consecutive trajectories keep one clock, so that a walk given
        stride by stride plays like one given whole. A fall ends with its last instant.

        Args:
            trajectory: one stride or many.
            fps: frames per second shown.
            speed: of the playback; 0.5 is slow motion.
        """
        rate = check_rate("fps", fps) / check_rate("speed", speed)
        fresh = self._stretch is None
        stretch = self._follow(trajectory)
        times = stretch.picture_times(rate, fresh)
        return (self._painter.paint(self._scene_of(stretch, time)) for time in times)

    def scene(self, time: float | None = None) -> Scene:
        """What `frame` draws, as data: the pose in the world, the floor, the labels."""
        if self._stretch is None:
            raise ValueError("there is nothing to draw yet; call follow(trajectory) first")
        return self._scene_of(self._stretch, float(self._stretch.t[-1]) if time is None else time)

    @property
    def span(self) -> tuple[float, float]:
        """First and last time of the trajectory followed last, s."""
        if self._stretch is None:
            raise ValueError("there is no walk yet; call follow(trajectory) first")
        return float(self._stretch.t[0]), float(self._stretch.t[-1])

    def to_pixels(self, scene: Scene, forward: float, up: float) -> tuple[float, float]:
        """Where (column, row) a point of the world, m, lands in a scene's picture, px."""
        return self._painter.to_pixels(scene, complex(up, forward))

    def _follow(self, trajectory: Trajectory) -> Stretch:
        if self._stretch is not None and self._stretch.verdict:
            raise ValueError(f"the walk is over ({self._stretch.verdict}); call reset() first")
        self.params = trajectory.params
        shift = (
            0.0 if self._stretch is None else float(self._stretch.t[-1] - trajectory.t[0]),
            self._landing - float(trajectory.landings[0]),
            self._floor.heights[-1] - float(trajectory.ground[0]),
        )
        self._extend_floor(trajectory, shift[1], shift[2])
        self.widen_sole(trajectory)
        standing = self._stretch is not None and len(self._stretch.t) == 1
        self._motor = bool(trajectory.motor_on.any()) or (self._motor and not standing)
        t, foot = trajectory.t + shift[0], trajectory.foot + shift[1:]
        walked = trajectory.outcome == Outcome.WALKED
        stretch = self._stretch = Stretch(
            params=trajectory.params,
            t=t,
            q=np.column_stack([trajectory.q, trajectory.knee[:, 0]]),
            foot=foot,
            motor_on=trajectory.motor_on,
            stride=trajectory.stride - int(trajectory.stride[0]) + self._strides,
            camera=self._film(t, trajectory.q, foot, trajectory.stride),
            verdict="" if walked else trajectory.outcome.label,
        )
        self._strides = int(stretch.stride[-1]) + 1
        self._landing = float(trajectory.landings[-1]) + shift[1]
        return stretch

    def _stand(self, state: PostStrikeState) -> None:
        lock, stance = self.params.locked_ankle_angle, state.stance_angle
        q = np.array([[stance - lock, lock, state.swing_angle + math.pi - stance, 0.0]])
        t, foot = np.zeros(1), np.array([[0.0, self.params.foot_radius]])
        nothing, first = np.zeros(1, bool), np.zeros(1, np.int64)
        camera = self._film(t, q, foot, first)
        self._motor = self.params.foot_length > 0  # one could be there; the walk will show it
        self._stretch = Stretch(self.params, t, q, foot, nothing, first, camera, "")

    def _scene_of(self, stretch: Stretch, time: float) -> Scene:
        i, q, foot, camera = stretch.at(time)
        return Scene(
            params=stretch.params,
            pose=Pose.of(complex(foot[1], foot[0]), q.tolist(), stretch.params),
            floor=self._floor,
            focus=complex(camera[1], camera[0]),
            sector=self._sector,
            stride=int(stretch.stride[i]),
            time=time,
            motor_on=bool(stretch.motor_on[i]) if self._motor else None,
            name=self.name,
            verdict=stretch.verdict if time >= stretch.t[-1] else "",
        )

    def _extend_floor(self, trajectory: Trajectory, forward: float, up: float) -> None:
        """Set each step midway between the last contact of a stride and the next landing."""
        numbers = trajectory.stride[0] + np.arange(len(trajectory.landings) - 1)
        last = np.searchsorted(trajectory.stride, numbers, side="right") - 1
        contacts, landings = trajectory.foot[last, 0], trajectory.landings[1:]
        ahead = landings > contacts  # not after a fall
        edges = 0.5 * (contacts + landings) + forward
        for edge, height in zip(edges[ahead], trajectory.ground[1:][ahead] + up, strict=True):
            self._floor.extend(float(edge), float(height))

    def widen_sole(self, trajectory: Trajectory) -> None:
        """Give the foot a sole wherever it touches the floor in a stride that is walked."""
        walked = trajectory.outcome == Outcome.WALKED
        angles = trajectory.q[(trajectory.stride < trajectory.stride[-1]) | walked, 0]
        if len(angles):
            low, high = self._sector
            self._sector = (
                min(low, float(angles.min()) - SOLE_MARGIN),
                max(high, float(angles.max()) + SOLE_MARGIN),
            )

    def _film(self, t: Array, q: Array, foot: Array, stride: npt.NDArray[np.int64]) -> Array:
        """Where the camera is at each sample, (n, 2) m: it follows the hip and the floor."""
        hips, floor = hip_forward(q, foot, self.params), foot[:, 1] - self.params.foot_radius
        camera = self._camera or Camera(float(hips[0]), float(floor[0]), 0.0)
        if self._strides == 0:  # begin at the mean speed of the first stride
            last = int(np.flatnonzero(stride == stride[0])[-1])
            duration = float(t[last] - t[0])
            speed = float(hips[last] - hips[0]) / duration if duration > 0 else 0.0
            camera = camera._replace(speed=speed)
        rate = CAMERA_RATE * math.sqrt(self.params.gravity / self.params.leg_length)
        self._camera, track = follow(camera, t, hips, floor, rate)
        return track


def check_rate(name: str, value: float) -> float:
    """`value` as a positive, finite float.

    Raises:
        ValueError: it is not.
    """
    if not (math.isfinite(value) and value > 0):
        raise ValueError(f"{name} must be positive and finite, got {value!r}")
    return float(value)
