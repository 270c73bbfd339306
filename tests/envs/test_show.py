"""Rendering modes of the environment; what one picture shows is tested with the renderer."""

from __future__ import annotations

import copy
import pickle
import types
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.play import play
from gymnasium.vector import AutoresetMode

from powered_walker_env import Outcome, PoweredWalkerEnv
from powered_walker_env.envs import show
from powered_walker_env.envs.gallery import RENDER_FPS
from powered_walker_env.envs.levels import key_push
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


@pytest.fixture
def shown(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The frames that windows are given."""
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    frames: list[Any] = []
    monkeypatch.setattr(
        "powered_walker_env.pictures.window.Window.show", lambda window, more: frames.extend(more)
    )
    return frames


def test_the_window_shows_every_stride_at_once(shown: list[Any]) -> None:
    env = gym.make(ROUND_FOOT, render_mode="human")
    env.reset(seed=0)
    assert len(shown) == 1
    duration = env.step(ZERO)[4]["duration"]
    assert len(shown) == pytest.approx(1 + duration * RENDER_FPS, abs=1.5)
    assert env.render() is None
    env.close()


def test_a_window_opens_and_closes(window: None) -> None:
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
def window(monkeypatch: pytest.MonkeyPatch) -> None:
    """A screen that nobody sees, on which time does not pass."""
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    clock = types.SimpleNamespace(tick=lambda rate: None)
    monkeypatch.setattr(pygame.time, "Clock", lambda: clock)


def test_pictures_nobody_takes_are_kept_as_numbers_and_not_without_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert show.KEPT <= 100
    monkeypatch.setattr(show, "KEPT", 6)
    env = PoweredWalkerEnv(preset="round-foot", render_mode="rgb_array_list", disturbance="none")
    env.reset(seed=0)
    size = len(pickle.dumps(env))
    durations = [env.step(ZERO)[4]["duration"] for _ in range(6)]
    kept = len(pickle.dumps(env)) - size
    assert kept < 2000 * 6
    for _ in range(30):
        durations.append(env.step(ZERO)[4]["duration"])
    assert len(pickle.dumps(env)) - size < kept + 20_000  # and where it stands
    frames = env.render()
    assert len(frames) == pytest.approx(RENDER_FPS * sum(durations[-6:]), abs=2)
    assert env.render() == []


@pytest.mark.parametrize("mode", ["rgb_array", "rgb_array_list"])
def test_when_one_looks_does_not_change_what_one_sees(
    mode: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every stride, or once at the end, past what is kept."""
    often, once = (
        PoweredWalkerEnv(preset="round-foot", render_mode=mode, disturbance={"ground": 0.001})
        for _ in range(2)
    )
    for env in (often, once):
        env.reset(seed=3)
    monkeypatch.setattr(show, "KEPT", 3)
    for _ in range(5):
        over = [env.step(ZERO)[2] for env in (often, once)]
        seen = often.render()
        assert not any(over)
    last = once.render()
    if mode == "rgb_array_list":
        seen, last = seen[-1], last[-1]
    np.testing.assert_array_equal(last, seen)


COPIES = [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))]


@pytest.mark.parametrize("copies", COPIES, ids=["deepcopy", "pickle"])
@pytest.mark.parametrize("mode", ["rgb_array", "rgb_array_list", "human"])
def test_a_copy_draws_what_the_original_draws(mode: str, copies: Any, window: None) -> None:
    env = gym.make(ROUND_FOOT, render_mode=mode, disturbance="none")
    for before in ("reset", "step"):
        env.reset(seed=0)
        if before == "step":
            env.step(ZERO)
        twin = copies(env)
        assert_same(env.step(ZERO), twin.step(ZERO))
        assert_same(env.render(), twin.render())
        twin.close()
    env.close()


@pytest.mark.parametrize("mode", ["rgb_array", "human"])
def test_others_may_quit_pygame(mode: str, window: None) -> None:
    """As the environments of Gymnasium do when they are closed."""
    env, untouched = make(render_mode=mode), make(render_mode=mode)
    for each in (env, untouched):
        each.reset(seed=0)
        each.render()
    pygame.quit()
    for _ in range(2):
        env.step(ZERO)
        untouched.step(ZERO)
        assert_same(env.render(), untouched.render())
    cartpole = gym.make("CartPole-v1", render_mode="rgb_array")
    cartpole.reset()
    cartpole.render()
    cartpole.close()
    env.reset(seed=1)
    env.render()
    env.close()
    untouched.close()


def test_closing_one_window_leaves_the_others_open(window: None) -> None:
    one, two = (gym.make(ROUND_FOOT, render_mode="human", disturbance="none") for _ in range(2))
    for env in (one, two):
        env.reset(seed=0)
    one.close()
    assert pygame.display.get_init() and pygame.display.get_surface() is not None
    two.step(ZERO)
    two.close()
    assert not pygame.display.get_init()


def batches(mode: AutoresetMode) -> tuple[Any, Any]:
    """The native environment and Gymnasium's, both with pictures."""
    arguments = {"render_mode": "rgb_array", "max_episode_steps": 3, "disturbance": EVERYTHING}
    native = gym.make_vec(ROUND_FOOT, 3, autoreset_mode=mode, **arguments)
    sync = gym.make_vec(
        ROUND_FOOT,
        3,
        vectorization_mode="sync",
        vector_kwargs={"autoreset_mode": mode},
        **arguments,
    )
    return native, sync


@pytest.mark.parametrize("mode", list(AutoresetMode)[:2], ids=lambda mode: mode.value)
def test_a_batch_draws_what_gymnasiums_own_draws(mode: AutoresetMode) -> None:
    native, sync = batches(mode)
    with pytest.raises(gym.error.ResetNeeded, match=r"call reset\(\) before render"):
        native.render()
    native.reset(seed=2), sync.reset(seed=2)
    ended = 0
    for _ in range(6):
        assert_same(native.render(), sync.render())
        given = native.step(np.zeros((3, 2), np.float32))
        sync.step(np.zeros((3, 2), np.float32))
        ended += int((given[2] | given[3]).sum())
    assert ended >= 3
    twin = pickle.loads(pickle.dumps(native))
    assert_same(twin.render(), native.render())
    native.close()


def test_one_walker_of_a_batch_is_reset_and_the_others_are_drawn_on() -> None:
    native, sync = batches(AutoresetMode.DISABLED)
    mask = np.array([True, False, True])
    for envs in (native, sync):
        envs.reset(seed=5)
        envs.step(np.zeros((3, 2), np.float32))
        envs.reset(options={"reset_mask": mask.copy()})
    assert_same(native.render(), sync.render())


def test_a_window_shows_the_first_walker_of_a_batch(shown: list[Any]) -> None:
    envs = gym.make_vec(ROUND_FOOT, 2, render_mode="human", disturbance="none")
    envs.reset(seed=0)
    duration = envs.step(np.zeros((2, 2)))[4]["duration"][0]
    assert len(shown) == pytest.approx(1 + duration * RENDER_FPS, abs=1.5)
    assert envs.render() is None
    envs.close()


def test_a_batch_without_a_mode_says_what_to_do() -> None:
    envs = gym.make_vec(ROUND_FOOT, 2)
    envs.reset(seed=0)
    with pytest.warns(UserWarning, match='render_mode="rgb_array"'):
        assert envs.render() is None


def press(*keys: int) -> None:
    """As a user would, once the window is there."""
    for key in keys:
        pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=key))


@pytest.mark.parametrize(("key", "sign"), [("K_RIGHT", 1), ("K_LEFT", -1)])
def test_a_key_pushes_the_walker_and_the_observation_feels_it(
    key: str, sign: int, window: None
) -> None:
    shown, silent = (make(render_mode=mode, disturbance="none") for mode in ("human", None))
    for env in (shown, silent):
        env.reset(seed=0)
    press(getattr(pygame, key))
    seen, *_, info = shown.step(ZERO)
    before, *_, plain = silent.step(ZERO)
    task = shown.unwrapped.task
    push = sign * key_push(task)
    assert push == pytest.approx(sign * 3 * 0.005)  # of the light pushes, to scale
    felt = plain["state"] + [0, 0, push, push]
    np.testing.assert_allclose(info["state"], felt, rtol=1e-14)
    np.testing.assert_allclose(seen - before, [0, 0, *(push / task.scale[2:])], atol=1e-6)
    after = shown.step(ZERO)[4]["state"]  # it walks on from there
    silent.reset(options={"state": felt})
    np.testing.assert_allclose(after, silent.step(ZERO)[4]["state"], rtol=1e-12)
    shown.close()


def test_a_push_by_key_is_as_large_as_the_environments_own() -> None:
    for preset in ("camp1997", "round-foot", "toe-off"):
        task = PoweredWalkerEnv(preset=preset, disturbance="rough").task
        assert key_push(task) == 3 * task.disturbance.push > 0


def test_a_key_ends_the_episode_and_another_begins(window: None) -> None:
    env = gym.make(ROUND_FOOT, render_mode="human", disturbance="none")
    env.reset(seed=0)
    press(pygame.K_r)
    *_, terminated, truncated, _ = env.step(ZERO)
    assert truncated and not terminated
    env.reset()
    assert not env.step(ZERO)[3]
    env.close()


def test_slow_motion_shows_four_times_the_pictures_from_there_on(
    monkeypatch: pytest.MonkeyPatch, window: None
) -> None:
    flips: list[int] = []
    flip = pygame.display.flip
    monkeypatch.setattr(pygame.display, "flip", lambda: (flips.append(1), flip()))
    env = gym.make(ROUND_FOOT, render_mode="human", disturbance="none")
    env.reset(seed=0)
    counts = []
    for key in (None, pygame.K_s, None, pygame.K_s):
        flips.clear()
        if key is not None:
            press(key)
        duration = env.step(ZERO)[4]["duration"]
        counts.append(len(flips) / (duration * RENDER_FPS))
    assert counts == pytest.approx([1, 4, 4, 1], rel=0.2)
    env.close()


def test_a_pause_lasts_until_the_key_is_pressed_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    waits: list[float] = []

    def tick(rate: float) -> None:
        waits.append(rate)
        if len(waits) in (5, 200):
            press(pygame.K_SPACE)

    monkeypatch.setattr(pygame.time, "Clock", lambda: types.SimpleNamespace(tick=tick))
    env = gym.make(ROUND_FOOT, render_mode="human", disturbance="none")
    env.reset(seed=0)
    duration = env.step(ZERO)[4]["duration"]
    assert len(waits) == pytest.approx(1 + duration * RENDER_FPS + 195, abs=2)
    env.close()


def test_closing_a_paused_window_lets_the_program_go_on(monkeypatch: pytest.MonkeyPatch) -> None:
    waits: list[float] = []

    def tick(rate: float) -> None:
        waits.append(rate)
        assert len(waits) < 100
        if len(waits) == 5:
            press(pygame.K_SPACE)
        if len(waits) == 9:
            pygame.event.post(pygame.event.Event(pygame.QUIT))

    monkeypatch.setattr(pygame.time, "Clock", lambda: types.SimpleNamespace(tick=tick))
    env = gym.make(ROUND_FOOT, render_mode="human", disturbance="none")
    env.reset(seed=0)
    for _ in range(3):
        env.step(ZERO)
    assert len(waits) == 9
    env.close()


def test_gymnasiums_play_plays_with_pictures(window: None) -> None:
    env = gym.make(ROUND_FOOT, render_mode="rgb_array", disturbance="none")
    taken: list[np.ndarray] = []

    def after_each(before: Any, after: Any, action: Any, *rest: Any) -> None:
        taken.append(np.asarray(action))
        assert rest[0] != 0 or rest[1]  # a reward
        if len(taken) == 2:
            press(pygame.K_d)
        if len(taken) == 4:
            pygame.event.post(pygame.event.Event(pygame.QUIT))

    faster = np.array([0.1, 0.0], np.float32)
    rate = env.metadata["render_fps"]
    play(env, fps=rate, keys_to_action={"d": faster}, noop=ZERO, seed=0, callback=after_each)
    assert [action.tolist() for action in taken] == [[0, 0], [0, 0], faster.tolist()] + (
        [faster.tolist()] * (len(taken) - 3)
    )
    assert len(taken) >= 4
