"""What all panels have: a figure, a title that says what it shows, the last strides."""

from __future__ import annotations

from typing import Any

import numpy as np
from bokeh.models import ColumnDataSource, Range1d
from bokeh.models.annotations import Title
from bokeh.models.tickers import BasicTicker
from bokeh.plotting import figure

from powered_walker_env.pictures.charts.sheet import INK, PALE, RED
from powered_walker_env.simulation.strides import Array

TICKS = 4  # of an axis, about: their labels are long


class Panel:
    """A figure with a title that says what it shows, or why it shows nothing."""

    def __init__(self, name: str, across: str, up: str, size: tuple[int, int]) -> None:
        self.name = name
        self.title = Title(text=name, text_font_size="12px")
        self.figure = figure(
            frame_width=size[0], frame_height=size[1], title=self.title, toolbar_location=None,
            tools="", x_axis_label=across, y_axis_label=up, x_range=Range1d(), y_range=Range1d(),
            name=name,
        )  # fmt: skip
        for axis in self.figure.axis:
            axis.axis_label_text_font_style = "normal"
            axis.axis_label_text_font_size = "12px"
            axis.ticker = BasicTicker(desired_num_ticks=TICKS)
        self.figure.grid.grid_line_color = PALE
        self.strides = self.source(x=[], y=[])  # the last strides' points
        self.newest = self.source(x=[], y=[])

    def source(self, **columns: Any) -> Any:
        """Data of the figure's own."""
        return ColumnDataSource(columns)

    def say(self, note: str) -> None:
        """Put a note after the name."""
        self.title.text = f"{self.name}: {note}" if note else self.name

    def view(self, across: tuple[float, float], up: tuple[float, float]) -> None:
        """Show this part of the plane."""
        for axis, (low, high) in zip(
            (self.figure.x_range, self.figure.y_range), (across, up), strict=True
        ):
            axis.update(start=low, end=high)

    def draw_strides(self, colour: str = RED) -> None:
        """Small dots for the last strides, a ring for the newest: above all else."""
        self.figure.scatter("x", "y", source=self.strides, size=4, color=colour, alpha=0.6)
        self.figure.scatter("x", "y", source=self.newest, size=10, line_color=INK, line_width=1.5,
                            fill_color=colour)  # fmt: skip

    def show_strides(self, across: Array, up: Array) -> None:
        """The last strides, the newest last."""
        self.strides.data = {"x": across, "y": up}
        self.newest.data = {"x": across[-1:], "y": up[-1:]}


def around(values: Array, least: float = 0.005) -> tuple[float, float]:
    """A range with these values inside, wide enough that rounding errors do not fill it."""
    if not len(values):
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    reach = max(0.55 * (high - low), least)
    return 0.5 * (low + high) - reach, 0.5 * (low + high) + reach


def rgba(pixels: Any) -> Any:
    """(height, width) numbers of Bokeh's pictures, of (height, width, 3) bytes."""
    four = np.full((*pixels.shape[:2], 4), 255, np.uint8)
    four[..., :3] = pixels
    return four.view(np.uint32)[..., 0]
