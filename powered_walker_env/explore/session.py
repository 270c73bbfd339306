"""A walk in real time: stride by stride, pushed, fallen, started again. Knows no browser."""

from __future__ import annotations

import collections
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from powered_walker_env.explore.choice import Choice
from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.powering import AnyControl, Policy
from powered_walker_env.model.state import PostStrikeState, check_state
from powered_walker_env.pictures.canvas import Frame
from powered_walker_env.pictures.renderer import Renderer
from powered_walker_env.simulation.strides import Array
from powered_walker_env.simulation.trajectory import walk

REMEMBERED = 100  # strides
REST = 1.5  # s, how long a walker lies where it fell
LONGEST = 0.25  # s that pass at once at most: a sleeping browser does not run up a bill
SLOW = 0.25  # of real time, in slow motion


class Status(NamedTuple):
    """What one reads beside the picture."""

    stride: int  # the number of the one under way, since it was started
    falls: int  # since the choice was made
    lies: str  # how it fell, while it lies there
    fell: str  # how it fell last, in a sentence; "" before the first fall
    pushed: bool  # whether a push waits for the next heel strike


class Session:
    """One walker walking.

    A change of the walker, its control or its controller, and a push, are felt from the next
    heel strike on. After a fall the walker lies there for a while, says how it fell, and starts
    again where it was started last.

    Args:
        choice: the walker; it starts at the preset's state.
        size: (width, height) of the pictures, px.
    """

    def __init__(self, choice: Choice, size: tuple[int, int] = (640, 360)) -> None:
        width, height = size
        self._renderer = Renderer(choice.params, width=width, height=height)
        self.paused, self.speed = False, 1.0  # of real time
        self.falls, self.strides = 0, 0  # since the choice was made; begun since the start
        self.fell = ""  # how, and after how many strides; "" before the first fall
        self.begin(choice, choice.control, choice.known.state)

    def begin(
        self,
        choice: Choice,
        policy: AnyControl | Policy | None,
        start: Sequence[float] | PostStrikeState,
    ) -> None:
        """Another walk: stand at a state, with nothing remembered."""
        self.change(choice, policy)
        self.falls, self.fell = 0, ""
        self.start(start)

    def change(self, choice: Choice, policy: AnyControl | Policy | None) -> None:
        """Walk on under other numbers or another controller; forget the strides of the old."""
        self.choice, self.policy = choice, policy
        self.recent: collections.deque[PostStrikeState] = collections.deque(maxlen=REMEMBERED)

    def start(self, state: Sequence[float] | PostStrikeState) -> None:
        """Start at a post-strike state, and after every fall again.

        Raises:
            ValueError: no four finite numbers.
        """
        self.home = self.state = check_state(state)
        self._stand()

    def _stand(self) -> None:
        self.state, self.strides, self.verdict = self.home, 0, ""
        self._push = np.zeros(2)
        self._lying = 0.0  # s since it fell
        self._renderer.reset(self.state, params=self.choice.params)
        self.time = self._end = 0.0

    def restart(self) -> None:
        """Start again where it was started last."""
        self._stand()

    def push(self, stance: float, swing: float) -> None:
        """Add to the leg rates, rad/s, just after the next heel strike; pushes add up."""
        self._push += (stance, swing)

    def advance(self, seconds: float) -> bool:
        """Let time pass; whether a stride began, a fall ended one, or the walk began anew."""
        if self.paused or not seconds > 0:
            return False
        passing = min(seconds, LONGEST)
        if self.verdict and self.time >= self._end:
            self._lying += passing
            if self._lying < REST:
                return False
            self._stand()
            return True
        self.time += passing * self.speed
        happened = False
        while self.time >= self._end and not self.verdict:
            self._stride()
            happened = True
        if self.verdict and self.time >= self._end:
            self.time, self._lying = self._end, 0.0
            self._note_fall()
            happened = True
        return happened

    def _stride(self) -> None:
        """One more stride from the state, with the push that waits."""
        stance, swing = self._push.tolist()
        self._push[:] = 0.0
        state = self.state._replace(
            stance_rate=self.state.stance_rate + stance, swing_rate=self.state.swing_rate + swing
        )
        self.recent.append(state)
        params = self.choice.params
        interval = 0.02 * math.sqrt(params.leg_length / params.gravity)
        walked = walk(state, self.policy, params, 1, sample_interval=interval)
        self._renderer.follow(walked)
        self._end = self._renderer.span[1]
        self.strides += 1
        if walked.outcome == Outcome.WALKED:
            self.state = PostStrikeState(*walked.states[-1].tolist())
        else:
            self.outcome, self.verdict = walked.outcome, walked.outcome.label

    def _note_fall(self) -> None:
        self.falls += 1
        walked = self.strides - 1
        strides = f"{walked} stride{'s' * (walked != 1)}"
        self.fell = f"{self.verdict} after {strides}: {self.outcome.description}"

    def picture(self) -> Frame:
        """The walker now."""
        return self._renderer.frame(self.time)

    def section(self) -> Array:
        """(n, 4) the last post-strike states, pushes included, the newest last."""
        return np.array(self.recent).reshape(-1, 4)

    def status(self) -> Status:
        """What one reads beside the picture."""
        lies = self.verdict if self.time >= self._end else ""
        return Status(max(self.strides, 1), self.falls, lies, self.fell, bool(self._push.any()))
