"""A walk on the screen, in real time."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from typing import Any, ClassVar, NamedTuple

import numpy as np

from powered_walker_env.pictures.canvas import Frame, import_pygame
from powered_walker_env.pictures.renderer import check_rate

CAPTION = "Powered walker    → ← push    space: pause    s: slow motion    r: start again"
SLOW = 0.25  # of real time, in slow motion


class Wishes(NamedTuple):
    """What the keys of a window have asked for since the last look."""

    pushes: int = 0  # forwards less backwards
    restart: bool = False


class Window:
    """Shows frames on the screen in real time (`render_mode="human"`).

    It opens with the first frame. Once the user has closed it, it stays closed. pygame has one
    display for a process, so several of these share it, one below the other; the last of them to
    close closes it, unless another program (CartPole, say) had opened it, and a display that
    another program quits is opened again. A copy is a window not yet opened.

    Keys act on all of them: → and ← ask for a push forwards or backwards, r for a new start (both
    are for the caller to grant, see `take_wishes`), space stops and goes on, s is for slow motion.

    Attributes:
        speed: of time; who makes the frames heeds it.

    Raises:
        ImportError: pygame is not installed.
    """

    _open: ClassVar[list[Window]] = []  # all windows on the display, from the top
    _borrowed: ClassVar[bool] = False  # whether another program had opened the display

    def __init__(self, fps: float = 25.0, caption: str = CAPTION) -> None:
        self.fps = check_rate("fps", fps)
        self.caption = caption
        self.closed, self.paused, self.speed = False, False, 1.0
        self._wishes = Wishes()
        self._pygame = import_pygame()
        self._clock = self._pygame.time.Clock()
        self._picture: Any = None

    def __reduce__(self) -> Any:
        return Window, (self.fps, self.caption)

    def show(self, frames: Iterable[Frame]) -> None:
        """Show frames one after another, `fps` of them a second, until the user closes it.

        While the user has it paused, it stands still, and does not return.
        """
        for frame in frames:
            if self.closed:
                return
            self._show_one(frame)
            while self.paused and not self.closed:
                self._wait()

    def take_wishes(self) -> Wishes:
        """What the keys have asked for since this was called last."""
        wishes, self._wishes = self._wishes, Wishes()
        return wishes

    def close(self) -> None:
        """Close the window; nothing happens if it is closed already."""
        self.closed = True
        if self in Window._open:
            Window._open.remove(self)
            if Window._open:
                self._lay_out()
            elif not Window._borrowed:
                self._pygame.display.quit()

    def _show_one(self, frame: Frame) -> None:
        pygame, size = self._pygame, (frame.shape[1], frame.shape[0])
        self._picture = pygame.image.frombuffer(np.ascontiguousarray(frame).tobytes(), size, "RGB")
        if not Window._open:
            Window._borrowed = pygame.display.get_surface() is not None
        if self not in Window._open:
            Window._open.append(self)
        self._lay_out()
        self._wait()

    def _wait(self) -> None:
        """Until it is time for the next frame; then hear what the user wants."""
        pygame = self._pygame
        self._clock.tick(self.fps)
        for event in pygame.event.get():
            for window in [*Window._open]:
                if event.type == pygame.QUIT:
                    window.close()
                elif event.type == pygame.KEYDOWN:
                    window._press(event.key)

    def _press(self, key: int) -> None:
        pygame, (pushes, restart) = self._pygame, self._wishes
        if key == pygame.K_SPACE:
            self.paused = not self.paused
        elif key == pygame.K_s:
            self.speed = SLOW if self.speed == 1.0 else 1.0
        elif key in (pygame.K_RIGHT, pygame.K_LEFT):
            self._wishes = Wishes(pushes + (1 if key == pygame.K_RIGHT else -1), restart)
        elif key == pygame.K_r:
            self._wishes, self.paused = Wishes(pushes, True), False

    def _lay_out(self) -> None:
        """All windows' pictures on the display, which is opened if it is not there."""
        display, pictures = self._pygame.display, [window._picture for window in Window._open]
        sizes = [picture.get_size() for picture in pictures]
        size = (max(width for width, _ in sizes), sum(height for _, height in sizes))
        display.init()
        screen = display.get_surface()
        if screen is None or screen.get_size() != size:
            display.set_caption(self.caption)
            screen = display.set_mode(size)
        tops = itertools.accumulate((height for _, height in sizes), initial=0)
        for picture, top in zip(pictures, tops, strict=False):
            screen.blit(picture, (0, top))
        display.flip()
