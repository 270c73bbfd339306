"""A walk on the screen, as a GIF or as an MP4."""

from __future__ import annotations

import contextlib
import importlib
import itertools
import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from powered_walker_env.files import written_aside
from powered_walker_env.model.phases import Outcome
from powered_walker_env.pictures.painter import Frame, import_pygame
from powered_walker_env.pictures.renderer import Renderer, check_rate
from powered_walker_env.simulation.trajectory import Trajectory

FALL_HOLD = 1.0  # s, how long an animation rests on the last picture of a fall
SUFFIXES = (".gif", ".mp4")
GIF_COLOURS = 96  # flat colours and their blends: with fewer, small letters suffer
GIF_SAMPLES = 12  # pictures that the palette is taken from


class Window:
    """Shows frames on the screen in real time (`render_mode="human"`).

    It opens with the first frame. Once the user has closed it, it stays closed.

    Raises:
        ImportError: pygame is not installed.
    """

    def __init__(self, fps: float = 25.0, caption: str = "Powered walker") -> None:
        self.fps = check_rate("fps", fps)
        self.caption = caption
        self.closed = False
        self._pygame = import_pygame()
        self._screen: Any = None
        self._clock: Any = None

    def show(self, frames: Iterable[Frame]) -> None:
        """Show frames one after another, `fps` of them a second, until the user closes it."""
        for frame in frames:
            if self.closed:
                return
            self._show_one(frame)

    def close(self) -> None:
        """Close the window; nothing happens if it is closed already."""
        if self._screen is not None:
            self._pygame.display.quit()
        self._screen, self.closed = None, True

    def _show_one(self, frame: Frame) -> None:
        pygame = self._pygame
        size = (frame.shape[1], frame.shape[0])
        if self._screen is None:
            pygame.display.init()
            pygame.display.set_caption(self.caption)
            self._clock = pygame.time.Clock()
        if self._screen is None or self._screen.get_size() != size:
            self._screen = pygame.display.set_mode(size)
        image = pygame.image.frombuffer(np.ascontiguousarray(frame).tobytes(), size, "RGB")
        self._screen.blit(image, (0, 0))
        pygame.display.flip()
        self._clock.tick(self.fps)
        if any(event.type == pygame.QUIT for event in pygame.event.get()):
            self.close()


def save_animation(
    trajectory: Trajectory,
    path: str | os.PathLike[str],
    *,
    fps: float = 25.0,
    speed: float = 1.0,
    width: int = 640,
    height: int = 360,
) -> Path:
    """Write a walk as a GIF or an MP4, by the suffix of `path`; return the path.

    The file appears complete or not at all. A walk that ends in a fall rests a second
    on its last picture.

    Args:
        trajectory: the walk.
        path: ends in .gif (needs Pillow) or .mp4 (needs imageio-ffmpeg).
        fps: frames per second; a GIF counts in hundredths of a second, so at most 50.
        speed: of the playback; 0.5 is slow motion.
        width, height: of the pictures, px; even numbers for an MP4.

    Raises:
        ValueError: a suffix, rate or size that will not do.
        FileNotFoundError: the folder does not exist.
        ImportError: pygame, or what the format needs, is not installed.
    """
    target = Path(path)
    _check_animation(target, fps, speed, width, height)
    write = _write_gif if target.suffix.lower() == ".gif" else _write_mp4
    codec = _import_pillow() if write is _write_gif else _import_ffmpeg()
    renderer = Renderer(trajectory.params, width=width, height=height)
    frames = renderer.frames(trajectory, fps, speed=speed)
    rest = 0 if trajectory.outcome == Outcome.WALKED else round(FALL_HOLD * fps)
    with written_aside(target) as aside:
        write(codec, aside, _rest_on_last(frames, rest), fps, renderer)
    return target


def _check_animation(target: Path, fps: float, speed: float, width: int, height: int) -> None:
    suffix = target.suffix.lower()
    if suffix not in SUFFIXES:
        supported = " or ".join(SUFFIXES)
        raise ValueError(f"path must end in {supported}, got {str(target)!r}")
    check_rate("fps", fps)
    check_rate("speed", speed)
    if suffix == ".gif" and fps > 50:
        raise ValueError(f"fps must be at most 50 for a GIF, got {fps!r}; write an .mp4 for more")
    if suffix == ".mp4" and (width % 2 or height % 2):
        raise ValueError(f"width and height must be even for an MP4, got {width!r} and {height!r}")
    if not target.parent.is_dir():
        raise FileNotFoundError(f"the folder {str(target.parent)!r} does not exist; make it first")


def _import_pillow() -> Any:
    try:
        import PIL.Image
    except ImportError as error:
        raise ImportError(
            'a GIF needs Pillow, which is not installed; pip install "powered-walker-env[render]"'
        ) from error
    return PIL.Image


def _import_ffmpeg() -> Any:
    try:
        return importlib.import_module("imageio_ffmpeg")
    except ImportError as error:
        raise ImportError(
            "an MP4 needs imageio-ffmpeg, which is not installed; "
            "pip install imageio-ffmpeg, or save a .gif"
        ) from error


def _rest_on_last(frames: Iterator[Frame], count: int) -> Iterator[Frame]:
    """The frames, the last one `count` times more."""
    last = None
    for last in frames:
        yield last
    if last is not None:
        yield from itertools.repeat(last, count)


def _write_gif(
    pillow: Any, path: Path, frames: Iterator[Frame], fps: float, renderer: Renderer
) -> None:
    """One palette for all pictures and no dithering: only what moves is stored again."""
    begin, end = renderer.span
    samples = [renderer.frame(t) for t in np.linspace(begin, end, GIF_SAMPLES).tolist()]
    palette = pillow.fromarray(np.concatenate(samples)).quantize(GIF_COLOURS)

    def picture(number: int, frame: Frame) -> Any:
        image = pillow.fromarray(frame).quantize(palette=palette, dither=pillow.Dither.NONE)
        hundredths = round(100 * (number + 1) / fps) - round(100 * number / fps)
        image.info["duration"] = 10 * hundredths  # ms; rounded so that no error adds up
        return image

    pictures = itertools.starmap(picture, enumerate(frames))
    first = next(pictures)
    shared = bytes(palette.getpalette())
    with path.open("wb") as file:
        first.save(
            file, format="GIF", save_all=True, append_images=pictures, palette=shared, loop=0
        )


def _write_mp4(
    ffmpeg: Any, path: Path, frames: Iterator[Frame], fps: float, renderer: Renderer
) -> None:
    size = (renderer.width, renderer.height)
    with contextlib.closing(
        ffmpeg.write_frames(str(path), size, fps=fps, macro_block_size=2, ffmpeg_log_level="error")
    ) as writer:
        writer.send(None)  # starts ffmpeg
        for frame in frames:
            writer.send(frame)
