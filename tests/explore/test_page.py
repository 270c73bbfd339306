"""The page without a browser: what is cleared when, and what is dropped."""

from __future__ import annotations

import gc
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from powered_walker_env import PRESETS
from powered_walker_env.cli import main
from powered_walker_env.explore.choice import Choice
from powered_walker_env.model.powering import SCHEMES

pytest.importorskip("bokeh")
pytest.importorskip("pygame")

from bokeh.document import Document
from bokeh.server.callbacks import NextTickCallback

from powered_walker_env.explore.page import Page
from powered_walker_env.explore.server import make_server


class Visit:
    """A page in a document that no browser looks at; answers arrive when they are let in."""

    def __init__(self, choice: Choice) -> None:
        self.document = Document()
        self.page = Page(self.document, choice)

    def let_in(self) -> int:
        """Hand over the answers that have arrived; how many."""
        arrived = [c for c in self.document.session_callbacks if isinstance(c, NextTickCallback)]
        for callback in arrived:
            callback.callback()
        return len(arrived)

    def until(self, condition: Callable[[], bool]) -> None:
        """Let answers in until something is so; turns are counted, and no seconds."""
        for _ in range(6000):
            if condition():
                return
            self.let_in()
            time.sleep(0.01)
        raise AssertionError("no answer")

    @property
    def known(self) -> bool:
        """Whether the gait of the present choice is known, or that there is none."""
        return self.page.found is not None and self.page.found.choice == self.page.choice

    @property
    def complete(self) -> bool:
        """Whether everything of the present choice is drawn."""
        page = self.page
        drawn = self.known and page.diagram.shown is not None
        return drawn and (page.found.gait is None or page.basin.basin is not None)


@pytest.fixture
def visit() -> Iterator[Visit]:
    visiting = Visit(Choice.of_preset("round-foot"))
    yield visiting
    visiting.page.close()


def is_empty(panel: Any) -> bool:
    """Whether nothing but the axes (and the unit circle) is drawn."""
    sources = [each.data_source for each in panel.figure.renderers]
    drawn = [len(next(iter(source.data.values()))) for source in sources]
    return max(n for n in drawn if n != 181) == 0


def test_new_numbers_clear_every_old_picture_at_once(visit: Visit) -> None:
    page = visit.page
    visit.until(lambda: visit.complete)
    page.tick()
    page._clock -= 0.05
    page.tick()
    assert not is_empty(page.section)
    assert not is_empty(page.basin)
    assert not is_empty(page.diagram)
    page.chooser.sliders["switch_angle"].value += 0.01
    for panel in (page.section, page.multipliers, page.basin, page.diagram):
        assert is_empty(panel), panel.name
        assert "being computed" in panel.title.text
    assert page.meanings.text == ""
    assert page.basin.state_at(-0.36, 1.18) is None  # a click starts nothing
    page.tick()  # the walk goes on, under the numbers before, and draws none of them
    for panel in (page.section, page.multipliers, page.basin, page.diagram):
        assert is_empty(panel), panel.name
    visit.until(lambda: visit.complete)
    assert page.basin.basin is not None
    assert page.basin.basin.control == page.choice.control
    assert page.session.policy == page.choice.control


def test_answers_to_an_older_question_are_dropped(coarse: None, visit: Visit) -> None:
    page, slider = visit.page, visit.page.chooser.sliders["switch_angle"]
    for _ in range(5):
        slider.value += 0.002
        time.sleep(0.05)  # answers may arrive, but are not let in yet
    visit.until(lambda: visit.complete)
    assert page.found.choice.control.switch_angle == slider.value
    assert page.found.gait is not None
    assert page.found.gait.control.switch_angle == slider.value
    shown = page.multipliers.title.text
    assert f"{page.found.gait.spectral_radius:.4f}" in shown


def test_a_diagram_is_kept_while_only_its_own_parameter_moves(coarse: None, visit: Visit) -> None:
    page = visit.page
    visit.until(lambda: visit.complete)
    before = page.diagram.shown
    page.chooser.sliders["stall_torque"].value += 5.0
    assert page.diagram.shown is before
    assert not page.diagram._present.visible
    visit.until(lambda: visit.complete)
    assert page.diagram.shown is before
    page.session.advance(0.1)
    page._show_strides()
    assert page.diagram._present.location == page.choice.value("stall_torque")


def test_a_click_starts_the_walk_of_its_pixel(visit: Visit) -> None:
    page = visit.page
    visit.until(lambda: visit.complete)
    basin = page.basin.basin
    assert basin is not None and basin.grid is not None
    for row in (0, len(basin.states) // 2 + 7, len(basin.states) - 1):
        state = basin.states[row]
        found = page.basin.state_at(state[0], state[2])
        assert found is not None
        np.testing.assert_array_equal(found, state)
        page.session.start(found.tolist())
        page.session.advance(0.01)
        np.testing.assert_array_equal(page.session.section()[-1], state)


@pytest.mark.parametrize("preset", PRESETS)
def test_every_walker_under_every_scheme_has_a_page(
    preset: str, coarse: None, visit: Visit
) -> None:
    page = visit.page
    page.chooser.preset.value = preset
    for scheme in SCHEMES:
        page.chooser.scheme.value = scheme
        if page.choice.scheme.name != scheme:  # refused: it says why, and goes on as before
            assert "must be" in page._note
            assert page.chooser.scheme.value == page.choice.scheme.name
            continue
        visit.until(lambda: visit.known)
        assert set(page.chooser.sliders) == set(page.choice.numbers)
        for _ in range(3):
            page._clock -= 0.2
            page.tick()
        if page.found.gait is None:
            assert page._note.startswith("no gait")
            assert "no gait" in page.basin.title.text
        else:
            visit.until(lambda: page.basin.basin is not None)


def test_a_controller_that_cannot_act_is_said(coarse: None, visit: Visit) -> None:
    page = visit.page
    page.chooser.preset.value = "simplest"
    page.chooser.controller.value = "lqr"
    visit.until(lambda: visit.complete)
    page.tick()
    assert "nothing to decide" in page.stage.status.text


def test_a_controller_that_fails_under_way_leaves_the_open_loop(coarse: None, visit: Visit) -> None:
    page = visit.page
    visit.until(lambda: visit.complete)

    def fails(states: Any) -> Any:
        raise ValueError("lost its way")

    page.session.change(page.choice, fails)
    for _ in range(40):
        page._clock -= 0.2
        page.tick()
        if page._note:
            break
    assert "lost its way" in page._note
    visit.until(lambda: visit.complete)
    assert page.session.policy == page.choice.control


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_server_is_for_this_machine_and_says_when_its_port_is_taken() -> None:
    first = make_server(Choice.of_preset("camp1997"))
    try:
        with pytest.raises(OSError, match=f"port {first.port} cannot be had"):
            make_server(Choice.of_preset("camp1997"), port=first.port)
        gc.collect()  # Bokeh leaves the socket that it could not bind to the collector
        assert first.address == "127.0.0.1"
    finally:
        first.stop()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--port", "70000"), "--port must lie in"),
        (("--controller", "nobody.npz"), "nobody.npz"),
        (("--controller", "nobody"), "controllers are"),
        (("--preset", "simplest", "--controller", "nobody"), "powered walker"),
    ],
)
def test_silly_arguments_are_said_in_a_line(
    arguments: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["explore", "--no-browser", *arguments]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert len(said.strip().splitlines()) == 1


def test_without_bokeh_it_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "bokeh.server.server", None)
    assert main(["explore", "--no-browser"]) == 2
    assert 'pip install "powered-walker-env[explore]"' in capsys.readouterr().err
