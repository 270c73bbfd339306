"""What is drawn beside the walker: section, multipliers, basin, diagram (Bokeh figures).

Each panel is empty until it is shown something, and says why; `clear` is called before new
numbers are shown anywhere, so that no picture is ever older than they are.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from bokeh.events import Tap
from bokeh.models.annotations import Span

from powered_walker_env.explore.panel import Panel, around, rgba
from powered_walker_env.pictures.charts import fate_pixels
from powered_walker_env.pictures.charts.sheet import (
    BLUE,
    GREY,
    INK,
    ORANGE,
    RED,
    label_of,
)
from powered_walker_env.poincare import Basin, BifurcationDiagram, Gait
from powered_walker_env.poincare.regions.slices import AXES, COORDINATES
from powered_walker_env.simulation.strides import Array

STANCE_ANGLE, STANCE_RATE = (COORDINATES.index(name) for name in AXES)
CIRCLE = np.linspace(0.0, 2.0 * np.pi, 181)
MOST_REACH = 3.0  # of a multiplier, that the picture of the unit circle still shows


class Section(Panel):
    """The post-strike states of the last strides, and the gait's."""

    def __init__(self, size: tuple[int, int]) -> None:
        super().__init__("last strides", label_of(AXES[0]), label_of(AXES[1]), size)
        self.strides.name = "strides"
        self._gait = self.source(x=[], y=[])
        self.draw_strides()
        self.figure.scatter("x", "y", source=self._gait, size=13, marker="x", color=BLUE,
                            line_width=2)  # fmt: skip

    def show_strides(self, across: Array, up: Array) -> None:
        """The last strides, the newest last, and the gait in the middle of them."""
        super().show_strides(across, up)
        gait = self._gait.data
        self.view(*(around(np.append(a, b)) for a, b in ((across, gait["x"]), (up, gait["y"]))))

    def clear(self, note: str = "") -> None:
        """Forget the gait and the strides."""
        self._gait.data = {"x": [], "y": []}
        self.show_strides(np.empty(0), np.empty(0))
        self.say(note)

    def show(self, gait: Gait) -> None:
        """Mark the gait's states."""
        self._gait.data = {"x": gait.states[:, STANCE_ANGLE], "y": gait.states[:, STANCE_RATE]}
        self.say("× the gait")


class Multipliers(Panel):
    """The Floquet multipliers and the unit circle."""

    def __init__(self, size: tuple[int, int]) -> None:
        super().__init__("multipliers", "real part", "imaginary part", size)
        self.figure.line(np.cos(CIRCLE), np.sin(CIRCLE), color=GREY, line_width=1.5)
        self._dots = self.source(x=[], y=[], colour=[])
        self.figure.scatter("x", "y", source=self._dots, size=10, color="colour", line_color=INK)
        self._reach(1.25)

    def _reach(self, reach: float) -> None:
        self.view((-reach, reach), (-reach, reach))

    def clear(self, note: str = "") -> None:
        """Forget them."""
        self._dots.data = {"x": [], "y": [], "colour": []}
        self.say(note)

    def show(self, gait: Gait) -> None:
        """Those of a gait, red outside the circle; those far outside at the picture's edge."""
        sizes = abs(gait.multipliers)
        self._reach(1.1 * min(max(1.15, float(sizes.max())), MOST_REACH))
        shown = gait.multipliers * np.minimum(1.0, MOST_REACH / np.maximum(sizes, 1e-12))
        colours = [BLUE if size < 1 else RED for size in sizes]
        self._dots.data = {"x": shown.real, "y": shown.imag, "colour": colours}
        stable = "stable" if gait.stable else "unstable"
        self.say(f"{stable}, the largest {gait.spectral_radius:.4f}")


class BasinPanel(Panel):
    """From where the gait is reached; a click starts a walk.

    Args:
        start: called with the post-strike state (4,) that was clicked.
    """

    def __init__(self, size: tuple[int, int], start: Callable[[Array], None]) -> None:
        super().__init__("basin", label_of(AXES[0]), label_of(AXES[1]), size)
        self._start = start
        self.basin: Basin | None = None
        self._picture = self.source(image=[], x=[], y=[], dw=[], dh=[])
        self.figure.image_rgba("image", source=self._picture, x="x", y="y", dw="dw", dh="dh")
        self.draw_strides("white")
        self.figure.on_event(Tap, self._tapped)

    def clear(self, note: str = "") -> None:
        """Forget it; a click starts nothing."""
        self.basin = None
        self._picture.data = {"image": [], "x": [], "y": [], "dw": [], "dh": []}
        self.show_strides(np.empty(0), np.empty(0))
        self.say(note)

    def show(self, basin: Basin) -> list[tuple[str, str]]:
        """Draw it; what its colours mean, (words, colour) each."""
        grid = basin.grid
        assert grid is not None
        pixels, meanings = fate_pixels(basin)
        self.basin = basin
        (left, right), (low, high) = grid.ranges
        self.view(*grid.ranges)
        self.figure.xaxis.axis_label, self.figure.yaxis.axis_label = map(label_of, grid.axes)
        self._picture.data = {
            "image": [rgba(np.round(255 * pixels).astype(np.uint8))],
            "x": [left], "y": [low], "dw": [right - left], "dh": [high - low],
        }  # fmt: skip
        self.say(f"{basin.attracted_share:.0%} reach the gait; click to start a walk")
        return meanings

    def state_at(self, across: float, up: float) -> Array | None:
        """The start whose pixel is there: what became of it is what the colour says."""
        if self.basin is None or self.basin.grid is None:
            return None
        grid = self.basin.grid
        row = [
            int(np.clip(round((value - low) / (high - low) * (count - 1)), 0, count - 1))
            for value, (low, high), count in zip((across, up), grid.ranges, grid.shape, strict=True)
        ]
        state: Array = grid.states[row[1] * grid.shape[0] + row[0]]
        return state

    def _tapped(self, event: Any) -> None:
        state = None if event.x is None else self.state_at(event.x, event.y)
        if state is not None:
            self._start(state)


class DiagramPanel(Panel):
    """What is walked at each value of a parameter, and where the present one is."""

    def __init__(self, size: tuple[int, int]) -> None:
        super().__init__("bifurcation diagram", "", label_of(AXES[0]), size)
        self.shown: BifurcationDiagram | None = None
        self._up, self._down = self.source(x=[], y=[]), self.source(x=[], y=[])
        self.figure.scatter("x", "y", source=self._up, size=3, color=BLUE)
        self.figure.scatter("x", "y", source=self._down, size=1.6, color=ORANGE)
        self._present = Span(dimension="height", line_color=RED, visible=False, name="now")
        self.figure.add_layout(self._present)
        self.draw_strides()

    def clear(self, note: str = "") -> None:
        """Forget it."""
        self.shown = None
        for source in (self._up, self._down):
            source.data = {"x": [], "y": []}
        self.clear_present()
        self.say(note)

    def clear_present(self) -> None:
        """Forget where the present value is and what is walked there."""
        self._present.visible = False
        self.show_strides(np.empty(0), np.empty(0))

    def show(self, diagram: BifurcationDiagram) -> None:
        """Draw it: ramped up in blue, down in orange."""
        self.shown = diagram
        x = np.repeat(diagram.values, diagram.keep)
        for source, ramp in ((self._up, diagram.up), (self._down, diagram.down)):
            y = ramp.states[:, :, STANCE_ANGLE].ravel()
            walked = np.isfinite(y)
            source.data = {"x": x[walked], "y": y[walked]}
        both = np.stack([ramp.states[..., STANCE_ANGLE] for ramp in (diagram.up, diagram.down)])
        self.view((diagram.values[0], diagram.values[-1]), around(both[np.isfinite(both)]))
        self.figure.xaxis.axis_label = label_of(diagram.parameter)
        both_fell = ~(diagram.up.walked | diagram.down.walked)
        self.say("nothing walks here" if both_fell.all() else "ramped up and down; red: now")

    def show_present(self, value: float, states: Array) -> None:
        """The last strides at the present value."""
        self._present.location, self._present.visible = value, True
        self.show_strides(np.full(len(states), value), states[:, STANCE_ANGLE])
