"""What an environment shows of its strides: they are kept as numbers, and drawn when asked for."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from powered_walker_env.envs.task import Task
from powered_walker_env.envs.walkers import WALKED, Walkers
from powered_walker_env.model.mechanics.packing import params_of
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.pictures.canvas import Frame
from powered_walker_env.pictures.renderer import Renderer
from powered_walker_env.pictures.window import Window, Wishes
from powered_walker_env.simulation.strides import Array, stride
from powered_walker_env.simulation.trajectory import TrajectoryBuilder, log_stride

KEPT = 100  # strides that nobody has asked to see: about 1 kB each, where pictures take 17 MB


class Walked(NamedTuple):
    """One stride, with all that it takes to walk it again and look at it."""

    start: PostStrikeState
    numbers: tuple[float, ...]  # of its control
    row: Array  # the walker, packed
    height: float  # m, step of the ground

    @classmethod
    def of(cls, walkers: Walkers, i: int, start: PostStrikeState) -> Walked:
        """The stride that led walker i from `start` to where it is now."""
        numbers = tuple(walkers.controls[i].tolist())
        return cls(start, numbers, walkers.row(i).copy(), float(walkers.heights[i]))

    def add_to(self, builder: TrajectoryBuilder, task: Task, rtol: float, interval: float) -> None:
        """Walk it again, sampled at multiples of `interval`, s."""
        control, params = task.scheme.of_numbers(self.numbers), params_of(self.row)
        logged = log_stride(self.start, control, params, self.height, rtol, interval)
        builder.add(logged, task.scheme.cycle, self.height)


def strides_per_second(task: Task) -> float:
    """Of the nominal gait: the rate at which a picture for each stride plays in real time."""
    points = task.gait.tolist()
    durations = [stride(point, task.control, task.params).duration for point in points]
    return len(points) / sum(durations)


class StrideShow:
    """Draws the strides of one walker.

    Args:
        walkers: whose walker `index` is shown.
        mode: "rgb_array", the end of the last stride; "rgb_array_list", every picture since
            the last look, `fps` for each second of the walk, of the last KEPT strides at most;
            "human", a window that shows each stride at once.
        painter: to share with other shows; its own if left out.
    """

    def __init__(
        self, walkers: Walkers, index: int, mode: str, fps: int, painter: Any = None
    ) -> None:
        self.walkers, self.index, self.mode, self.fps = walkers, index, mode, fps
        self._renderer = Renderer(walkers.task.params, painter=painter)
        self._window = Window(fps) if mode == "human" else None
        self._kept: deque[Walked] = deque()
        self._standing = False  # at a start that has not been drawn
        self._next = 0.0  # s, of the walk: when a window has its next picture

    @property
    def painter(self) -> Any:
        """What draws: shows of many walkers share it."""
        return self._renderer.painter

    def begin(self) -> None:
        """Stand at the start of an episode, or where the environment has been put."""
        params = params_of(self.walkers.row(self.index))
        self._renderer.reset(self.walkers.states[self.index].tolist(), params=params)
        self._kept.clear()
        self._standing = True
        if self._window is not None:
            self._next = 1.0 / self.fps
            self._window.show([self._renderer.frame()])

    def add(self, start: PostStrikeState) -> None:
        """Note the stride that led from `start` to here; a window shows it."""
        walked = Walked.of(self.walkers, self.index, start)
        if self._window is not None:
            self._follow(walked)
            self._window.show(self._paced(self._window))
            return
        self._kept.append(walked)
        if len(self._kept) > KEPT:
            self._standing = False
            self._follow(self._kept.popleft())

    def picture(self) -> Frame | list[Frame] | None:
        """The last frame; all frames since the last call for "rgb_array_list"."""
        if self.mode == "human":
            return None
        frames: list[Frame] = []
        if self.mode == "rgb_array_list":
            frames += [self._renderer.frame()] if self._standing else []
            self._standing = False
        while self._kept:
            walked = self._kept.popleft()
            if self.mode == "rgb_array_list":
                frames += self._pictures(walked)
            else:
                self._follow(walked)
        return frames if self.mode == "rgb_array_list" else self._renderer.frame()

    def take_wishes(self) -> Wishes:
        """What the keys of the window have asked for since the last stride."""
        return Wishes() if self._window is None else self._window.take_wishes()

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.close()

    def _follow(self, walked: Walked) -> None:
        self._renderer.follow(self._trajectory(walked))

    def _pictures(self, walked: Walked) -> Iterable[Frame]:
        return self._renderer.frames(self._trajectory(walked), self.fps)

    def _paced(self, window: Window) -> Iterator[Frame]:
        """Pictures of the stride at the window's pace, which its keys change; a fall's end, too."""
        end = self._renderer.span[1]
        while self._next <= end:
            yield self._renderer.frame(self._next)
            self._next += window.speed / self.fps
        if self.walkers.outcomes[self.index] != WALKED:
            yield self._renderer.frame()

    def _trajectory(self, walked: Walked) -> Any:
        builder = TrajectoryBuilder(params_of(walked.row), walked.start)
        walked.add_to(builder, self.walkers.task, self.walkers.rtol, 1.0 / self.fps)
        return builder.build()
