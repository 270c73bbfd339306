"""Pictures share one pygame with other programs, and one display with each other."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pygame", reason='needs pip install "powered-walker-env[render]"')

import pygame
from PIL import Image

from powered_walker_env.model.presets import PRESETS
from powered_walker_env.pictures.film import save_frames, save_side_by_side
from powered_walker_env.pictures.renderer import Renderer
from powered_walker_env.pictures.window import Window
from tests.pictures.test_animation import gif_frames
from tests.pictures.test_rendering import MOTOR, fall, following, gait, near


@pytest.fixture(autouse=True)
def afterwards() -> Iterator[None]:
    """Leave no window open and no module quit."""
    yield
    for window in [*Window._open]:
        window.close()
    pygame.quit()


def picture(rows: int, shade: int) -> np.ndarray:
    return np.full((rows, 64, 3), shade, np.uint8)


def shown() -> np.ndarray:
    screen = pygame.display.get_surface()
    return np.asarray(pygame.surfarray.array3d(screen).swapaxes(0, 1))


@pytest.mark.parametrize("again", [copy.deepcopy, lambda r: pickle.loads(pickle.dumps(r))])
def test_a_renderer_is_copied_with_its_walk(again: object) -> None:
    assert callable(again)
    renderer = following(gait("round-foot", 2))
    twin = again(renderer)
    np.testing.assert_array_equal(twin.frame(), renderer.frame())
    twin.follow(gait("round-foot", 1))  # its walk goes on alone
    assert twin.span != renderer.span
    assert renderer.frame(0.3).shape == twin.frame().shape


def test_other_programs_may_quit_pygame() -> None:
    renderer = following(gait("round-foot", 1))
    before = renderer.frame(0.5)
    for leave in (pygame.quit, pygame.font.quit, pygame.display.quit):
        leave()
        np.testing.assert_array_equal(renderer.frame(0.5), before)
    window = Window(500.0)
    window.show([before])
    pygame.quit()
    window.show([before])
    np.testing.assert_array_equal(shown(), before)
    assert not window.closed


def test_windows_share_the_display_and_close_one_by_one() -> None:
    first, second = Window(500.0), Window(500.0)
    first.show([picture(40, 10)])
    second.show([picture(30, 200)])
    np.testing.assert_array_equal(shown(), np.concatenate([picture(40, 10), picture(30, 200)]))
    first.show([picture(40, 90)])
    np.testing.assert_array_equal(shown()[:40], picture(40, 90))
    first.close()
    np.testing.assert_array_equal(shown(), picture(30, 200))
    second.show([picture(30, 50)])
    np.testing.assert_array_equal(shown(), picture(30, 50))
    first.show([picture(40, 1)])  # it stays closed
    np.testing.assert_array_equal(shown(), picture(30, 50))
    second.close()
    assert not pygame.display.get_init()


def test_a_display_of_another_program_stays_open() -> None:
    pygame.display.init()
    pygame.display.set_mode((300, 200))
    window = Window(500.0)
    window.show([picture(40, 10)])
    window.close()
    assert pygame.display.get_surface() is not None


def test_a_copy_of_a_window_is_one_not_yet_opened() -> None:
    window = Window(500.0, "walking")
    window.show([picture(40, 10)])
    twin = copy.deepcopy(window)
    assert (twin.fps, twin.caption, twin.closed) == (500.0, "walking", False)
    twin.close()
    assert pygame.display.get_surface() is not None
    assert not pickle.loads(pickle.dumps(window)).closed


@pytest.mark.parametrize("name", PRESETS)
def test_only_ankle_motors_have_a_label(name: str) -> None:
    """Nothing stands in the corner of a walker that has no motor to be on or off."""
    renderer = following(gait(name, 1))
    motor = bool(gait(name, 1).motor_on.any())
    sky = Renderer(PRESETS[name].params)
    sky.reset(PRESETS[name].state)
    corner = renderer.frame(0.0)[4:32, 540:630]
    assert (len(np.unique(corner.reshape(-1, 3), axis=0)) > 1) == motor
    assert (renderer.scene(0.0).motor_on is None) != motor


def test_walks_side_by_side_have_names_one_clock_and_the_same_soles(tmp_path: Path) -> None:
    walks = {"steady": gait("round-foot", 2), "falls": fall()}
    path = save_side_by_side(walks, tmp_path / "two.gif", fps=10.0, width=320, height=180)
    with Image.open(path) as image:
        assert image.size == (320, 360)
        image.seek(0)
        first = np.asarray(image.convert("RGB"))
    seconds = max(float(walk.t[-1]) for walk in walks.values()) + 1.0  # and the rest on a fall
    assert gif_frames(path)[1] / 1000 == pytest.approx(seconds, abs=0.21)
    # Both stand in the same state: but for the names, the same picture, soles and all.
    differ = (first[:180] != first[180:]).any(axis=2)
    assert differ[24:40, :80].any()
    differ[24:40, :80] = False
    assert not differ.any()


def test_frames_of_any_maker_become_a_film(tmp_path: Path) -> None:
    frames = [picture(40, shade) for shade in (0, 80, 160, 240)]
    with Image.open(save_frames(iter(frames), tmp_path / "grey.gif", 20.0)) as image:
        shades = []
        for number in range(image.n_frames):
            image.seek(number)
            shades.append(int(np.asarray(image.convert("RGB"))[0, 0, 0]))
    assert shades == [0, 80, 160, 240]
    with pytest.raises(ValueError, match=r"\.gif or \.mp4"):
        save_frames(iter(frames), tmp_path / "grey.png", 20.0)


def test_a_motor_is_lit_in_a_named_picture() -> None:
    trajectory = gait("round-foot", 1)
    renderer = Renderer(trajectory.params, name="PPO")
    renderer.follow(trajectory)
    lit = float(trajectory.t[trajectory.motor_on][1])
    assert near(renderer.frame(lit), MOTOR, 16).any()
