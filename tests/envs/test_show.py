"""Rendering modes of the environment; what one picture shows is tested with the renderer."""

from __future__ import annotations

import sys
import types
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from powered_walker_env import Outcome
from powered_walker_env.envs.walker import RENDER_FPS
from tests.helpers.episodes import EVERYTHING, FORWARD_FALL, ROUND_FOOT, assert_same, make, record

pygame = pytest.importorskip("pygame")
ZERO = np.zeros(2, np.float32)


def is_picture(frame: Any) -> bool:
    return isinstance(frame, np.ndarray) and frame.dtype == np.uint8 and frame.shape[2:] == (3,)


def test_rgb_array_is_the_end_of_the_last_stride() -> None:
    env = gym.make(ROUND_FOOT, render_mode="rgb_array")
    env.reset(seed=0)
    start = env.render()
    assert is_picture(start)
    np.testing.assert_array_equal(env.render(), start)  # looking changes nothing
    env.step(ZERO)
    assert is_picture(env.render())
    assert (env.render() != start).any()


def test_rgb_array_list_has_all_pictures_of_the_stride_at_its_rate() -> None:
    env = gym.make(ROUND_FOOT, render_mode="rgb_array_list")
    env.reset(seed=0)
    assert len(env.render()) == 1  # standing at the start
    assert env.render() == []
    walked, pictures = 0.0, 0
    for strides in (1, 3):  # between one look and the next
        for _ in range(strides):
            walked += env.step(ZERO)[4]["duration"]
        frames = env.render()
        assert all(is_picture(frame) for frame in frames)
        pictures += len(frames)
        assert pictures == pytest.approx(walked * RENDER_FPS, abs=1.5)
    assert env.metadata["render_fps"] == RENDER_FPS


def test_a_reset_forgets_pictures_that_nobody_took() -> None:
    env = make(render_mode="rgb_array_list")
    env.reset(seed=0)
    env.step(ZERO)
    env.reset()
    assert len(env.render()) == 1


@pytest.mark.parametrize("mode", ["rgb_array", "rgb_array_list"])
def test_rendering_changes_nothing_in_the_walk(mode: str) -> None:
    drawn = make(render_mode=mode, disturbance=EVERYTHING)
    assert_same(record(drawn, 8, seed=0), record(make(disturbance=EVERYTHING), 8, seed=0))


def test_a_fall_is_drawn_and_another_walk_begins() -> None:
    env = make(render_mode="rgb_array_list")
    env.reset(options={"state": FORWARD_FALL})
    assert env.step(ZERO)[4]["outcome"] == Outcome.FELL_FORWARD
    assert len(env.render()) > 2
    env.reset()
    env.step(ZERO)
    assert len(env.render()) > 10


def test_the_picture_follows_a_restored_state() -> None:
    env = make(render_mode="rgb_array")
    env.reset(seed=0)
    start, saved = env.render(), env.get_state()
    env.step(ZERO)
    env.set_state(saved)
    np.testing.assert_array_equal(env.render(), start)
    env.step(ZERO)
    assert is_picture(env.render())


def test_the_window_shows_every_stride_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    shown: list[Any] = []
    monkeypatch.setattr(
        "powered_walker_env.pictures.window.Window.show", lambda window, frames: shown.extend(frames)
    )
    env = gym.make(ROUND_FOOT, render_mode="human")
    env.reset(seed=0)
    assert len(shown) == 1
    duration = env.step(ZERO)[4]["duration"]
    assert len(shown) == pytest.approx(1 + duration * RENDER_FPS, abs=1.5)
    assert env.render() is None
    env.close()


def test_a_window_opens_and_closes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env = gym.make(ROUND_FOOT, render_mode="human")
    env.reset(seed=0)
    assert pygame.display.get_surface() is not None
    env.close()
    assert not pygame.display.get_init()
    env.close()


def test_render_without_a_mode_says_what_to_do() -> None:
    env = make()
    env.reset(seed=0)
    with pytest.warns(UserWarning, match='render_mode="rgb_array"'):
        assert env.render() is None


@pytest.fixture
def clips(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Stands in for moviepy: the frames and the rate of every clip written."""
    written: list[Any] = []

    class ImageSequenceClip:
        def __init__(self, frames: list[np.ndarray], fps: float) -> None:
            self.frames, self.fps = list(frames), fps

        def write_videofile(self, path: str, **_: Any) -> None:
            written.append((self.frames, self.fps))

    last = types.ModuleType("moviepy.video.io.ImageSequenceClip")
    last.ImageSequenceClip = ImageSequenceClip  # type: ignore[attr-defined]
    names = ("moviepy", "moviepy.video", "moviepy.video.io")
    for module in (*map(types.ModuleType, names), last):
        monkeypatch.setitem(sys.modules, module.__name__, module)
    return written


@pytest.mark.parametrize("mode", ["rgb_array", "rgb_array_list"])
def test_gymnasiums_recorder_takes_one_picture_of_each_stride(
    mode: str, tmp_path: Path, clips: list[Any]
) -> None:
    env = gym.make(ROUND_FOOT, render_mode=mode, disturbance="none")
    recorder = gym.wrappers.RecordVideo(env, str(tmp_path / "videos"), lambda episode: True)
    recorder.reset(seed=0)
    for _ in range(3):
        recorder.step(ZERO)
    recorder.close()
    ((frames, _),) = clips
    assert len(frames) == 4 and all(map(is_picture, frames))


def test_gymnasiums_save_video_takes_all_pictures(tmp_path: Path, clips: list[Any]) -> None:
    from gymnasium.utils.save_video import save_video

    env = gym.make(ROUND_FOOT, render_mode="rgb_array_list", disturbance="none")
    env.reset(seed=0)
    walked = sum(env.step(ZERO)[4]["duration"] for _ in range(3))
    save_video(env.render(), str(tmp_path / "videos"), fps=env.metadata["render_fps"])
    ((frames, fps),) = clips
    assert len(frames) / fps == pytest.approx(walked, abs=0.1)
