"""The page in a real browser: the Chromium of the system, driven by Playwright."""

from __future__ import annotations

import contextlib
import io
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from powered_walker_env import PRESETS, find_gait
from powered_walker_env.controllers import LQR, policy_of
from powered_walker_env.envs.arguments import TaskArguments
from powered_walker_env.envs.setup import make_task
from powered_walker_env.explore.choice import Choice, controllers_offered
from powered_walker_env.explore.views import prospect
from powered_walker_env.pictures.painter import HIP, LEGS, SOIL

pytest.importorskip("bokeh")
pytest.importorskip("pygame")
sync_api = pytest.importorskip("playwright.sync_api")
image = pytest.importorskip("PIL.Image")

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)
pytestmark = pytest.mark.skipif(
    CHROMIUM is None, reason="no Chromium on this machine (Debian: apt-get install chromium)"
)
OPTIONS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
PROGRAM = [
    sys.executable,
    "-c",
    "from powered_walker_env.cli import main; raise SystemExit(main())",
]
PATIENCE = 90_000  # ms: CI is busy
MODEL = "Bokeh.documents[0].get_model_by_name('{}')"


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """Where the command serves the page."""
    command = [*PROGRAM, "explore", "--no-browser"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as server:
        assert server.stderr is not None
        found = None
        for line in server.stderr:
            if found := re.search(r"http://\S+", line):
                break
        assert found, "the server has not said where it is"
        yield found[0]
        server.terminate()
        assert server.wait(20) == 128 + 15
        assert "terminated" in server.stderr.read()


class Visitor:
    """Somebody who looks at the page and touches it; complaints of the console are kept."""

    def __init__(self, page: Any) -> None:
        self.page, self.complaints = page, []
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on(
            "console",
            lambda said: (
                self.complaints.append(said.text) if said.type in ("error", "warning") else None
            ),
        )

    def until(self, condition: str) -> None:
        """Wait for something to be true in the page (JavaScript)."""
        self.page.wait_for_function(condition, timeout=PATIENCE)

    def value(self, name: str, of: str = "value") -> Any:
        """Of a model of the page."""
        return self.page.evaluate(f"{MODEL.format(name)}.{of}")

    def title(self, name: str) -> str:
        """Of a panel."""
        return str(self.page.evaluate(f"{MODEL.format(name)}.title.text"))

    def until_drawn(self) -> None:
        """Wait until nothing is being computed any more."""
        panels = ("last strides", "multipliers", "basin", "bifurcation diagram")
        titles = ", ".join(f"{MODEL.format(name)}.title.text" for name in panels)
        self.until(f"[{titles}].every((t) => t.includes(': ') && !t.includes('being computed'))")

    def status(self) -> str:
        """What stands under the walker."""
        return str(self.value("status", "text"))

    def until_status(self, words: str) -> None:
        """Wait until it says so."""
        self.until(f"{MODEL.format('status')}.text.includes({words!r})")

    def until_strides(self, least: int) -> None:
        """Wait until so many are walked."""
        text = MODEL.format("status") + ".text"
        self.until(f"Number(({text}.match(/^stride (\\d+)/) || [0, 0])[1]) > {least}")

    def press(self, key: str) -> None:
        """A key that no widget claims."""
        self.page.evaluate("document.activeElement.blur()")
        self.page.keyboard.press(key)

    def nudge(self, slider: str, times: int) -> None:
        """Move a slider by its arrow keys."""
        self.page.locator(".bk-Slider", has_text=slider).locator(".noUi-handle").focus()
        for _ in range(times):
            self.page.keyboard.press("ArrowRight")


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Chromium."""
    with sync_api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=OPTIONS)
        yield chromium
        chromium.close()


@pytest.fixture
def visitor(browser: Any, address: str) -> Iterator[Visitor]:
    """A page that is loaded, drawn and walking; it must not complain to the end."""
    page = browser.new_page(viewport={"width": 1440, "height": 900})
    visiting = Visitor(page)
    page.goto(address)
    visiting.until("window.Bokeh && Bokeh.documents.length > 0")
    visiting.until_drawn()
    yield visiting
    page.close()
    assert visiting.complaints == []


def radius(title: str) -> float:
    """The largest multiplier that a title tells."""
    return float(title.rpartition(" ")[2])


def test_it_loads_and_walks(visitor: Visitor) -> None:
    assert radius(visitor.title("multipliers")) == pytest.approx(0.6152, abs=1e-4)
    first = visitor.value("picture", "data.number[0]")
    visitor.until(f"{MODEL.format('picture')}.data.number[0] > {first} + 10")
    shot = visitor.page.locator(".bk-Figure").first.screenshot()
    colours = np.asarray(image.open(io.BytesIO(shot)).convert("RGB")).reshape(-1, 3)
    for either in (LEGS, [SOIL], [HIP]):
        away = [abs(colours.astype(int) - colour).max(axis=1) for colour in either]
        assert (np.min(away, axis=0) < 12).mean() > 1e-3, either
    visitor.until_strides(2)


def test_a_slider_moves_the_gait_and_all_that_is_drawn_of_it(visitor: Visitor) -> None:
    visitor.nudge("stall torque", 8)
    visitor.until(f"{MODEL.format('stall_torque')}.value > 3372")
    torque = visitor.value("stall_torque")
    preset = PRESETS["round-foot"]
    control = type(preset.control)(preset.control.switch_angle, torque)  # type: ignore[union-attr]
    expected = find_gait(preset.params, control, preset.state).spectral_radius
    visitor.until(f"{MODEL.format('multipliers')}.title.text.endsWith('{expected:.4f}')")
    visitor.until_drawn()
    visitor.until(f"{MODEL.format('now')}.visible && {MODEL.format('now')}.location == {torque}")


def test_a_click_in_the_basin_starts_a_walk_there(visitor: Visitor) -> None:
    visitor.until_strides(1)
    ranges = [[visitor.value("basin", f"{axis}_range.{end}") for end in ("start", "end")]
              for axis in "xy"]  # fmt: skip
    frame = visitor.page.locator(".bk-Figure").nth(3).bounding_box()
    inner = [visitor.value("basin", f"inner_{side}") for side in ("width", "height")]
    right = frame["x"] + frame["width"]
    visitor.page.mouse.click(right - 0.15 * inner[0], frame["y"] + 0.2 * inner[1])
    visitor.until_status("foot rolled over after")  # above the basin, where the colour says so
    started = [list(visitor.value("strides", f"data.{axis}")) for axis in "xy"]
    for clicked, (low, high) in zip(started, ranges, strict=True):
        assert any(0.5 * (low + high) + 0.05 * (high - low) < x <= high for x in clicked)


def test_pushes_by_button_and_key_a_fall_and_a_new_start(visitor: Visitor) -> None:
    visitor.press(" ")
    visitor.until(f"{MODEL.format('pause')}.active")
    visitor.press(" ")
    visitor.page.get_by_role("button", name="push →").click()
    visitor.until_status("the push comes with the next heel strike")
    for _ in range(12):
        visitor.press("ArrowRight")
    visitor.until_status("It starts again.")
    visitor.until_status("Last fall: ")
    visitor.until_status("1 falls so far")
    visitor.press("s")
    visitor.until(f"{MODEL.format('speed')}.value == 'slow motion'")
    visitor.press("r")
    visitor.until_status("stride 1 ")


def test_another_controller_has_other_multipliers(visitor: Visitor) -> None:
    visitor.page.get_by_label("controller").select_option("lqr")
    visitor.until(f"!{MODEL.format('multipliers')}.title.text.endsWith('0.6152')")
    visitor.until_drawn()
    task = make_task(TaskArguments(preset="round-foot"))
    closed = find_gait(task.params, policy_of(task, LQR(task)), task.gait[0].tolist())
    assert radius(visitor.title("multipliers")) == pytest.approx(closed.spectral_radius, abs=1e-4)
    assert visitor.value("parameter") == "slope"  # the torque is the regulator's to choose
    visitor.until_strides(2)


def test_whoever_comes_with_the_package_decides(visitor: Visitor) -> None:
    for name in controllers_offered()[::-1]:
        visitor.page.get_by_label("controller").select_option(name)
        visitor.until(f"{MODEL.format('controller')}.value == '{name}'")
        found = prospect(Choice.of_preset("round-foot", name))
        assert found.problem == "" and found.gait is not None
        radius_of = f"{found.gait.spectral_radius:.4f}"
        visitor.until(f"{MODEL.format('multipliers')}.title.text.endsWith('{radius_of}')")
        visitor.until(f"{MODEL.format('basin')}.title.text.includes('click')")
        if name == "optimal":
            said = f"{MODEL.format('bifurcation diagram')}.title.text"
            visitor.until(f"{said}.includes('the optimum is of this walker alone')")
        visitor.press("r")
        visitor.until_strides(1)


def test_who_does_not_come_for_a_walker_says_so(visitor: Visitor) -> None:
    visitor.page.get_by_label("walker").select_option("toe-off")
    visitor.until(f"{MODEL.format('preset')}.value == 'toe-off'")
    visitor.page.get_by_label("controller").select_option("ppo")
    visitor.until_status("open loop, since ppo cannot act")
    visitor.page.get_by_label("controller").select_option("optimal")
    visitor.until_status("open loop, since optimal cannot act")
    visitor.page.get_by_label("controller").select_option("open-loop")
    visitor.until(f"!{MODEL.format('status')}.text.includes('cannot act')")


def test_every_walker_is_shown(visitor: Visitor) -> None:
    for name, preset in PRESETS.items():
        visitor.page.get_by_label("walker").select_option(name)
        visitor.until(f"{MODEL.format('preset')}.value == '{name}'")
        gait = find_gait(preset.params, preset.control, preset.state)
        text = f"stable, the largest {gait.spectral_radius:.4f}"
        visitor.until(f"{MODEL.format('multipliers')}.title.text.includes('{text}')")
        visitor.until(f"{MODEL.format('basin')}.title.text.includes('click')")


def test_two_visitors_have_walkers_of_their_own(visitor: Visitor, browser: Any) -> None:
    with contextlib.closing(browser.new_page()) as other:
        other.goto(visitor.page.url)
        second = Visitor(other)
        second.until("window.Bokeh && Bokeh.documents.length > 0")
        second.page.get_by_label("walker").select_option("compass")
        second.until(f"{MODEL.format('multipliers')}.title.text.endsWith('0.5800')")
        assert radius(visitor.title("multipliers")) == pytest.approx(0.6152, abs=1e-4)
