"""A walk as a GIF or as an MP4; several walks one above the other."""

from __future__ import annotations

import contextlib
import importlib
import itertools
import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from powered_walker_env.files import written_aside
from powered_walker_env.model.phases import Outcome
from powered_walker_env.pictures.canvas import Frame, import_pygame
from powered_walker_env.pictures.renderer import Renderer, check_rate
from powered_walker_env.simulation.trajectory import Trajectory

FALL_HOLD = 1.0  # s, how long an animation rests on the last picture of a fall
SUFFIXES = (".gif", ".mp4")
GIF_COLOURS = 96  # flat colours and their blends: with fewer, small letters suffer
GIF_SAMPLES = 12  # pictures that the palette is taken from


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
    return save_side_by_side(
        {"": trajectory}, path, fps=fps, speed=speed, width=width, height=height
    )


def save_side_by_side(
    walks: Mapping[str, Trajectory],
    path: str | os.PathLike[str],
    *,
    fps: float = 20.0,
    speed: float = 1.0,
    width: int = 560,
    height: int = 240,
) -> Path:
    """Write walks one above the other, each with its name, in real time.

    What is over stands still. Feet have the same soles in all pictures.

    Args:
        walks: name to walk, from the top. Others, and errors, as in `save_animation`; width and
            height are of one walk's picture.
    """
    if not walks:
        raise ValueError("walks must hold at least one walk, got none")
    check_film(path, fps=fps, speed=speed, width=width, height=height * len(walks))
    renderers = [
        Renderer(walk.params, width=width, height=height, name=name) for name, walk in walks.items()
    ]
    frames = []
    for renderer, walk in zip(renderers, walks.values(), strict=True):
        frames.append(renderer.frames(walk, fps, speed=speed))
        for other in walks.values():
            renderer.widen_sole(other)
    fell = any(walk.outcome != Outcome.WALKED for walk in walks.values())
    film = _rest_on_last(_stacked(frames), round(FALL_HOLD * fps) if fell else 0)
    samples = (
        np.concatenate([renderer.frame(begin + share * (end - begin)) for renderer, (begin, end) in
                        ((r, r.span) for r in renderers)])
        for share in np.linspace(0.0, 1.0, GIF_SAMPLES).tolist()
    )  # fmt: skip
    return save_frames(film, path, fps, samples=samples)


def save_frames(
    frames: Iterable[Frame],
    path: str | os.PathLike[str],
    fps: float,
    *,
    samples: Iterable[Frame] | None = None,
) -> Path:
    """Write pictures of one size as a GIF or an MP4, complete or not at all; return the path.

    Args:
        frames: (height, width, 3) RGB each.
        fps: pictures a second.
        samples: pictures that have all the colours of a GIF; if left out, the frames are all
            kept in memory to find them.

    Raises:
        ValueError, FileNotFoundError, ImportError: as `save_animation`.
    """
    target = Path(path)
    check_film(target, fps=fps)
    gif = target.suffix.lower() == ".gif"
    if gif and samples is None:
        frames = list(frames)
        samples = frames[:: max(1, len(frames) // GIF_SAMPLES)]
    with written_aside(target) as aside:
        if gif:
            _write_gif(aside, iter(frames), fps, samples or ())
        else:
            _write_mp4(aside, iter(frames), fps)
    return target


def check_film(
    path: str | os.PathLike[str],
    *,
    fps: float = 25.0,
    speed: float = 1.0,
    width: int = 2,
    height: int = 2,
) -> None:
    """Find out whether a film can be written before anything is drawn.

    Raises:
        ValueError, FileNotFoundError, ImportError: as `save_animation`.
    """
    target = Path(path)
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
    import_pygame()
    _import_pillow() if suffix == ".gif" else _import_ffmpeg()


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


def _stacked(films: list[Iterator[Frame]]) -> Iterator[Frame]:
    """Pictures one above the other until the last film ends; those over before stand still."""
    last: list[Frame | None] = [None] * len(films)
    for pictures in itertools.zip_longest(*films):
        last = [old if new is None else new for old, new in zip(last, pictures, strict=True)]
        yield np.concatenate([picture for picture in last if picture is not None])


def _rest_on_last(frames: Iterator[Frame], count: int) -> Iterator[Frame]:
    """The frames, the last one `count` times more."""
    last = None
    for last in frames:
        yield last
    if last is not None:
        yield from itertools.repeat(last, count)


def _write_gif(path: Path, frames: Iterator[Frame], fps: float, samples: Iterable[Frame]) -> None:
    """One palette for all pictures and no dithering: only what moves is stored again."""
    pillow = _import_pillow()
    palette = pillow.fromarray(np.concatenate([*samples])).quantize(GIF_COLOURS)

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


def _write_mp4(path: Path, frames: Iterator[Frame], fps: float) -> None:
    first = next(frames)
    size = (first.shape[1], first.shape[0])
    with contextlib.closing(
        _import_ffmpeg().write_frames(
            str(path), size, fps=fps, macro_block_size=2, ffmpeg_log_level="error"
        )
    ) as writer:
        writer.send(None)  # starts ffmpeg
        for frame in itertools.chain([first], frames):
            writer.send(np.ascontiguousarray(frame))
