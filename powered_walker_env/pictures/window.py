"""A walk on the screen, in real time."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from typing import Any, ClassVar

import numpy as np

from powered_walker_env.pictures.canvas import Frame, import_pygame
from powered_walker_env.pictures.renderer import check_rate


class Window:
    """Shows frames on the screen in real time (`render_mode="human"`).

    It opens with the first frame. Once the user has closed it, it stays closed. pygame has one
    display for a process, so several of these share it, one below the other; the last of them to
    close closes it, unless another program (CartPole, say) had opened it, and a display that
    another program quits is opened again. A copy is a window not yet opened.

    Raises:
        ImportError: pygame is not installed.
    """

    _open: ClassVar[list[Window]] = []  # all windows on the display, from the top
    _borrowed: ClassVar[bool] = False  # whether another program had opened the display

    def __init__(self, fps: float = 25.0, caption: str = "Powered walker") -> None:
        self.fps = check_rate("fps", fps)
        self.caption = caption
        self.closed = False
        self._pygame = import_pygame()
        self._clock = self._pygame.time.Clock()
        self._picture: Any = None

    def __reduce__(self) -> Any:
        return Window, (self.fps, self.caption)

    def show(self, frames: Iterable[Frame]) -> None:
        """Show frames one after another, `fps` of them a second, until the user closes it."""
        for frame in frames:
            if self.closed:
                return
            self._show_one(frame)

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
        self._clock.tick(self.fps)
        if any(event.type == pygame.QUIT for event in pygame.event.get()):
            for window in [*Window._open]:
                window.close()

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
