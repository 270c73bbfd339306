"""A walk on the screen and in files: real time, whole files or none, clear refusals."""

from __future__ import annotations

import importlib
import itertools
import math
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("pygame", reason='needs pip install "powered-walker-env[render]"')

from PIL import Image

from powered_walker_env.model.presets import PRESETS
from powered_walker_env.pictures import film as animation
from powered_walker_env.pictures import painter as drawing
from powered_walker_env.pictures.canvas import Frame
from powered_walker_env.pictures.film import save_animation
from powered_walker_env.pictures.painter import LEGS, MOTOR
from powered_walker_env.pictures.renderer import Renderer
from powered_walker_env.pictures.window import Window
from tests.pictures.test_rendering import fall, following, gait, near


def gif_frames(path: Path) -> tuple[int, int]:
    """Number of frames and their duration in all, ms."""
    with Image.open(path) as image:
        durations = []
        for number in range(image.n_frames):
            image.seek(number)
            durations.append(image.info["duration"])
        return image.n_frames, sum(durations)


@pytest.mark.parametrize("fps", [25.0, 30.0])
def test_a_gif_has_all_frames_and_plays_in_real_time(tmp_path: Path, fps: float) -> None:
    trajectory = gait("round-foot", strides=1)
    path = save_animation(trajectory, tmp_path / "walk.gif", fps=fps, width=320, height=180)
    number, duration = gif_frames(path)
    assert number == 1 + math.floor(float(trajectory.t[-1]) * fps)
    assert duration == pytest.approx(1000 * number / fps, abs=5.1)
    assert path.stat().st_size < 4000 * number
    assert [p.name for p in tmp_path.iterdir()] == ["walk.gif"]


def test_a_gif_keeps_the_colours_that_carry_meaning(tmp_path: Path) -> None:
    trajectory = gait("round-foot", strides=1)
    path = save_animation(trajectory, tmp_path / "walk.gif", fps=10.0)
    with Image.open(path) as image:
        image.seek(0)
        dark = np.asarray(image.convert("RGB"))
        image.seek(image.n_frames - 1)
        lit = np.asarray(image.convert("RGB"))
    assert near(lit, MOTOR, 16).sum() > 500 > near(dark, MOTOR, 16).sum()
    assert near(lit, LEGS[0], 16).sum() > 500


def test_an_animation_rests_on_a_fall(tmp_path: Path) -> None:
    trajectory = fall()
    path = save_animation(trajectory, tmp_path / "fall.GIF", fps=10.0, width=160, height=90)
    duration = gif_frames(path)[1] / 1000
    assert duration == pytest.approx(float(trajectory.t[-1]) + animation.FALL_HOLD, abs=0.21)


def no_drawing(monkeypatch: pytest.MonkeyPatch) -> None:
    def paint(*_: object) -> None:
        pytest.fail("drew a picture before refusing")

    monkeypatch.setattr(drawing.Painter, "paint", paint)


@pytest.mark.parametrize("name", ["walk.avi", "walk", "walk.gif.txt"])
def test_an_unknown_suffix_is_refused_before_anything_is_drawn(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    no_drawing(monkeypatch)
    with pytest.raises(ValueError, match=r"path must end in \.gif or \.mp4"):
        save_animation(gait("camp1997", strides=1), tmp_path / name)


def test_what_a_format_cannot_do_is_refused_before_anything_is_drawn(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    no_drawing(monkeypatch)
    trajectory = gait("camp1997", strides=1)
    with pytest.raises(ValueError, match="at most 50 for a GIF, got 60"):
        save_animation(trajectory, tmp_path / "walk.gif", fps=60)
    with pytest.raises(ValueError, match="must be even for an MP4"):
        save_animation(trajectory, tmp_path / "walk.mp4", width=641)
    with pytest.raises(ValueError, match="speed must be positive"):
        save_animation(trajectory, tmp_path / "walk.gif", speed=0)
    with pytest.raises(FileNotFoundError, match="make it first"):
        save_animation(trajectory, tmp_path / "nowhere" / "walk.gif")
    assert not list(tmp_path.iterdir())


def broken_frames(good: int) -> Iterator[int]:
    """Counts pictures, and fails after `good` of them."""
    yield from range(good)
    raise RuntimeError("the disk is full")


@pytest.mark.parametrize("good", [0, 3, 15])  # while sampling colours, and while writing
def test_a_failure_leaves_the_old_file_and_no_other(
    good: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    trajectory, path = gait("camp1997", strides=1), tmp_path / "walk.gif"
    path.write_bytes(b"the old one")
    paint, counter = drawing.Painter.paint, broken_frames(good)

    def failing(painter: drawing.Painter, scene: drawing.Scene) -> Frame:
        next(counter)
        return paint(painter, scene)

    monkeypatch.setattr(drawing.Painter, "paint", failing)
    with pytest.raises(RuntimeError, match="disk is full"):
        save_animation(trajectory, path)
    assert path.read_bytes() == b"the old one"
    assert [p.name for p in tmp_path.iterdir()] == ["walk.gif"]


def test_an_mp4_has_all_frames(tmp_path: Path) -> None:
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    trajectory = gait("round-foot", strides=1)
    path = save_animation(trajectory, tmp_path / "walk.mp4", width=322, height=178)
    number, seconds = ffmpeg.count_frames_and_secs(str(path))
    assert number == 1 + math.floor(float(trajectory.t[-1]) * 25)
    assert seconds == pytest.approx(number / 25, abs=0.02)
    assert [p.name for p in tmp_path.iterdir()] == ["walk.mp4"]


# What is not installed ------------------------------------------------------------------


def test_missing_pygame_is_named_with_its_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pygame", None)
    for make in (lambda: Renderer(PRESETS["camp1997"].params), Window):
        with pytest.raises(ImportError, match=r'pip install "powered-walker-env\[render\]"'):
            make()


@pytest.mark.parametrize(
    ("suffix", "module", "remedy"),
    [
        (".gif", "PIL", r"powered-walker-env\[render\]"),
        (".mp4", "imageio_ffmpeg", "pip install imageio-ffmpeg"),
    ],
)
def test_a_missing_codec_is_named_with_its_remedy(
    suffix: str, module: str, remedy: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    no_drawing(monkeypatch)
    monkeypatch.setitem(sys.modules, module, None)
    if module == "PIL":
        monkeypatch.setitem(sys.modules, "PIL.Image", None)
    with pytest.raises(ImportError, match=remedy):
        save_animation(gait("camp1997", strides=1), tmp_path / f"walk{suffix}")
    assert not list(tmp_path.iterdir())


def test_pygame_is_imported_only_when_something_is_drawn() -> None:
    code = "import sys, powered_walker_env.pictures.renderer; sys.exit('pygame' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


# The window -----------------------------------------------------------------------------


@pytest.fixture
def window() -> Iterator[Window]:
    window = Window(fps=500.0)
    yield window
    window.close()


def test_the_window_shows_frames_and_closes_cleanly(window: Window) -> None:
    pygame = importlib.import_module("pygame")
    trajectory = gait("round-foot", strides=1)
    renderer = Renderer(trajectory.params)
    window.show(renderer.frames(trajectory, 10.0))
    assert not window.closed
    shown = pygame.surfarray.array3d(pygame.display.get_surface()).swapaxes(0, 1)
    last = renderer.frame(math.floor(float(trajectory.t[-1]) * 10.0) / 10.0)
    np.testing.assert_array_equal(shown, last)
    window.close()
    window.close()
    assert not pygame.display.get_init()


def test_a_window_closed_by_the_user_stays_closed_and_draws_no_more(window: Window) -> None:
    pygame = importlib.import_module("pygame")
    frame = following(gait("round-foot", strides=1)).frame()
    window.show([frame])
    pygame.event.post(pygame.event.Event(pygame.QUIT))
    counted = itertools.count()
    window.show(frame for _ in range(5) if next(counted) >= 0)
    assert window.closed
    assert next(counted) <= 2  # the frame that met the event, and the one after it
    window.show([frame])
    assert not pygame.display.get_init()


def test_the_rate_of_a_window_must_be_positive() -> None:
    with pytest.raises(ValueError, match="fps must be positive"):
        Window(-1.0)


def test_the_window_keeps_real_time(monkeypatch: pytest.MonkeyPatch) -> None:
    frame = following(gait("round-foot", strides=1)).frame()
    ticks: list[float] = []
    window = Window(fps=50.0)
    monkeypatch.setattr(window, "_clock", SimpleNamespace(tick=ticks.append))
    window.show([frame] * 10)
    assert ticks == [50.0] * 10  # pygame's clock waits for its tick after every frame
    window.close()
