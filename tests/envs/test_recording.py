"""Films: how many pictures, how many seconds, by our own recorder and by those of others."""

from __future__ import annotations

import copy
import sys
import types
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from powered_walker_env import PRESETS, PoweredWalkerEnv, PoweredWalkerVectorEnv, stride
from powered_walker_env.envs import RecordWalk
from powered_walker_env.envs.gallery import RENDER_FPS
from powered_walker_env.envs.recording import often_at_first
from tests.helpers.episodes import FORWARD_FALL, ROUND_FOOT, make
from tests.helpers.samples import POWERED

pytest.importorskip("pygame")
ffmpeg = pytest.importorskip("imageio_ffmpeg")
image = pytest.importorskip("PIL.Image")
STRIDES = 3


def zero(env: Any) -> np.ndarray:
    return np.zeros(env.action_space.shape, np.float32)


def walk(env: Any, strides: int = STRIDES, **reset: Any) -> float:
    """Walk the open loop, in one episode; how long it takes, s."""
    env.reset(**({"seed": 0} | reset))
    return float(sum(env.step(zero(env))[4]["duration"] for _ in range(strides)))


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


def is_picture(frame: Any) -> bool:
    return isinstance(frame, np.ndarray) and frame.dtype == np.uint8 and frame.shape[2:] == (3,)


@pytest.mark.parametrize("maker", [PoweredWalkerEnv, PoweredWalkerVectorEnv])
@pytest.mark.parametrize("preset", POWERED)
def test_a_picture_a_stride_plays_at_the_rate_of_the_strides(preset: str, maker: Any) -> None:
    params, control, state, _ = PRESETS[preset]
    env = maker(preset=preset, render_mode="rgb_array")
    assert env.metadata["render_fps"] == pytest.approx(
        1.0 / stride(state, control, params).duration, rel=1e-6
    )
    for mode in (None, "human"):
        assert maker(preset=preset, render_mode=mode).metadata["render_fps"] == RENDER_FPS
    assert PoweredWalkerEnv.metadata["render_fps"] == RENDER_FPS


def test_a_gait_of_several_strides_has_their_mean_rate() -> None:
    params, control, state, _ = PRESETS["round-foot"]
    points = [list(state), [x + 0.01 for x in state]]
    env = make(gait=points, render_mode="rgb_array")
    durations = [stride(point, control, params).duration for point in points]
    assert durations[0] != durations[1]
    assert env.metadata["render_fps"] == pytest.approx(1.0 / np.mean(durations), rel=1e-9)


@pytest.mark.parametrize("preset", POWERED)
def test_gymnasiums_recorder_plays_in_real_time(
    preset: str, tmp_path: Path, clips: list[Any]
) -> None:
    env = PoweredWalkerEnv(preset=preset, render_mode="rgb_array", disturbance="none")
    recorder = gym.wrappers.RecordVideo(env, str(tmp_path / "videos"), lambda episode: True)
    seconds = walk(recorder, 5)
    recorder.close()
    ((frames, fps),) = clips
    assert len(frames) == 6 and all(map(is_picture, frames))  # the start and the strides
    assert (len(frames) - 1) / fps == pytest.approx(seconds, rel=1e-4)


def test_gymnasiums_save_video_takes_all_pictures(tmp_path: Path, clips: list[Any]) -> None:
    from gymnasium.utils.save_video import save_video

    env = gym.make(ROUND_FOOT, render_mode="rgb_array_list", disturbance="none")
    seconds = walk(env)
    save_video(env.render(), str(tmp_path / "videos"), fps=env.metadata["render_fps"])
    ((frames, fps),) = clips
    assert len(frames) / fps == pytest.approx(seconds, abs=0.1)


def test_stable_baselines3s_recorder_plays_in_real_time(tmp_path: Path, clips: list[Any]) -> None:
    pytest.importorskip("stable_baselines3")
    from stable_baselines3.common.vec_env import VecMonitor, VecVideoRecorder

    from powered_walker_env.sb3 import PoweredWalkerVecEnv

    walkers = PoweredWalkerVecEnv(
        ROUND_FOOT, 3, seed=0, render_mode="rgb_array", disturbance="none", monitor=False
    )
    assert walkers.render_mode == "rgb_array"
    recorder = VecVideoRecorder(
        VecMonitor(walkers), str(tmp_path), lambda step: step == 0, video_length=4
    )
    recorder.reset()
    seconds = sum(recorder.step(np.zeros((3, 2)))[3][0]["duration"] for _ in range(4))
    recorder.close()
    ((frames, fps),) = clips
    assert len(frames) == 5 and all(map(is_picture, frames))
    one = walkers.envs.single_observation_space  # only to say that there is a walker left
    assert one is not None and frames[0].shape == (2 * 360, 2 * 640, 3)  # tiles of three
    assert (len(frames) - 1) / fps == pytest.approx(seconds, rel=1e-4)


def film_of(path: Path) -> tuple[int, float]:
    """Pictures and seconds of a film."""
    if path.suffix == ".mp4":
        count, seconds = ffmpeg.count_frames_and_secs(str(path))
        return int(count), float(seconds)
    with image.open(path) as film:
        durations = []
        for k in range(film.n_frames):
            film.seek(k)
            durations.append(film.info["duration"])
        return film.n_frames, sum(durations) / 1000


@pytest.mark.parametrize("preset", POWERED)
def test_a_film_has_every_picture_of_every_stride(preset: str, tmp_path: Path) -> None:
    env = PoweredWalkerEnv(preset=preset, disturbance="none")
    slow = 25.0 * env.task.scale[3] / 0.3  # pictures in the walker's own time
    recorder = RecordWalk(env, tmp_path / "films", lambda episode: True, fps=slow)
    seconds = walk(recorder)
    recorder.close()
    count, length = film_of(tmp_path / "films/walk-episode-0.mp4")
    assert count == pytest.approx(1 + slow * seconds, abs=1)
    assert length == pytest.approx(seconds, abs=1.5 / slow)


@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
def test_a_film_of_a_fall_rests_on_it(suffix: str, tmp_path: Path) -> None:
    recorder = RecordWalk(gym.make(ROUND_FOOT), tmp_path, lambda episode: True, suffix=suffix)
    seconds = walk(recorder, 1, options={"state": FORWARD_FALL})
    path = tmp_path / f"walk-episode-0{suffix}"
    assert path.exists()  # as soon as the episode is over
    assert film_of(path)[1] == pytest.approx(seconds + 1.0, abs=0.13)
    with pytest.warns(UserWarning, match="after a fall"):
        recorder.step(np.zeros(2, np.float32))  # nothing to see
    recorder.close()
    assert sorted(tmp_path.iterdir()) == [path]


def test_by_default_films_are_frequent_at_first() -> None:
    wanted = [episode for episode in range(4001) if often_at_first(episode)]
    assert wanted == [k**3 for k in range(10)] + [1000, 2000, 3000, 4000]


def test_films_are_of_the_episodes_wanted(tmp_path: Path) -> None:
    env = gym.make(ROUND_FOOT, max_episode_steps=2, disturbance="none")
    recorder = RecordWalk(env, tmp_path, lambda episode: episode % 2 == 1, suffix=".gif")
    for _ in range(4):
        walk(recorder, 2)
    recorder.close()
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "walk-episode-1.gif",
        "walk-episode-3.gif",
    ]


def test_a_film_does_not_disturb_the_walk_and_ends_at_its_longest(tmp_path: Path) -> None:
    plain, env = make(), make()
    recorder = RecordWalk(env, tmp_path, lambda episode: True, longest=1, suffix=".gif")
    assert walk(recorder, 4) == walk(plain, 4)
    assert env.get_state() == plain.get_state()
    recorder.close()
    first = walk(make(), 1)
    assert film_of(tmp_path / "walk-episode-0.gif")[1] == pytest.approx(first, abs=0.05)


def test_films_that_are_there_are_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "walk-episode-7.mp4").write_bytes(b"precious")
    with pytest.raises(FileExistsError, match=r"walk-episode-7.mp4.*choose another folder"):
        RecordWalk(make(), tmp_path)
    RecordWalk(make(), tmp_path, name_prefix="other").close()
    assert (tmp_path / "walk-episode-7.mp4").read_bytes() == b"precious"


def test_what_cannot_be_filmed_is_refused_at_once(tmp_path: Path) -> None:
    with pytest.raises(TypeError, match="env must be an environment of this package"):
        RecordWalk(gym.make("CartPole-v1"), tmp_path)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"must end in .gif or .mp4"):
        RecordWalk(make(), tmp_path, suffix=".avi")
    with pytest.raises(ValueError, match="fps must be positive"):
        RecordWalk(make(), tmp_path, fps=0.0)
    with pytest.raises(ValueError, match="longest must be at least 1, got 0"):
        RecordWalk(make(), tmp_path, longest=0)


def test_the_recorder_is_named_where_people_look_for_recorders() -> None:
    assert "RecordWalk(env, folder)` in the place of `RecordVideo`" in (
        PoweredWalkerEnv.__doc__ or ""
    )


def test_a_recorder_can_be_copied_in_the_middle_of_a_film(tmp_path: Path) -> None:
    recorder = RecordWalk(make(disturbance="none"), tmp_path, lambda episode: True, suffix=".gif")
    walk(recorder, 1)
    twin = copy.deepcopy(recorder)
    twin.step(np.zeros(2, np.float32))
    assert not list(tmp_path.iterdir())
    recorder.close()
    once = film_of(tmp_path / "walk-episode-0.gif")[1]
    twin.close()
    assert film_of(tmp_path / "walk-episode-0.gif")[1] == pytest.approx(2 * once, abs=0.1)
