"""Where the walker walks: its picture, and what one reads under it."""

from __future__ import annotations

import html

from bokeh.models import ColumnDataSource, Range1d
from bokeh.models.widgets.markups import Div
from bokeh.plotting import figure

from powered_walker_env.explore.keys import Arrival
from powered_walker_env.explore.panel import rgba
from powered_walker_env.explore.session import Session


class Stage:
    """The picture of a session's walker, as often as the browser can draw it, and its status."""

    def __init__(self, session: Session, size: tuple[int, int]) -> None:
        width, height = size
        self._session = session
        self.figure = figure(
            width=width, height=height, x_range=Range1d(start=0, end=width), min_border=0,
            y_range=Range1d(start=0, end=height), toolbar_location=None, tools="", name="walker",
        )  # fmt: skip
        self.figure.axis.visible = self.figure.grid.visible = False
        self.figure.outline_line_color = None
        self._picture = ColumnDataSource({"image": [], "number": []}, name="picture")
        self.figure.image_rgba("image", source=self._picture, x=0, y=0, dw=width, dh=height)
        self.arrival = Arrival(self._picture)
        self.status = Div(width=width, height=62, name="status")

    def show(self, note: str) -> None:
        """The walker now, unless the last picture has not arrived yet; and how it fares.

        Args:
            note: what else is to be said.
        """
        text = self._text(note)
        if text != self.status.text:
            self.status.text = text
        number = self.arrival.next()
        if number is not None:
            picture = rgba(self._session.picture()[::-1])
            self._picture.data = {"image": [picture], "number": [number]}

    def _text(self, note: str) -> str:
        status = self._session.status()
        lines = [f"stride {status.stride} since the start, {status.falls} falls so far"]
        if status.pushed:
            lines[0] += " · the push comes with the next heel strike"
        if status.lies:
            lines = [f"<b>{html.escape(status.fell)}</b>", "It starts again."]
        elif status.fell:
            lines.append(f"Last fall: {html.escape(status.fell)}")
        if note:
            lines.append(f"<i>{html.escape(note)}</i>")
        return "<br>".join(lines)
