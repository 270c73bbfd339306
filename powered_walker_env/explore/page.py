"""The page: a walker walking, what moves it, and what the laboratory says of it."""

from __future__ import annotations

import html
import time
from collections.abc import Sequence
from typing import Any

from bokeh.layouts import column, row
from bokeh.models.widgets.inputs import Select
from bokeh.models.widgets.markups import Div

from powered_walker_env.controllers.loading import OPEN_LOOP
from powered_walker_env.explore.aside import Aside
from powered_walker_env.explore.choice import Choice
from powered_walker_env.explore.controls import Chooser, Handles
from powered_walker_env.explore.keys import listen
from powered_walker_env.explore.panels import (
    STANCE_ANGLE,
    STANCE_RATE,
    BasinPanel,
    DiagramPanel,
    Multipliers,
    Section,
)
from powered_walker_env.explore.session import Session
from powered_walker_env.explore.stage import Stage
from powered_walker_env.explore.views import (
    Prospect,
    basin_view,
    diagram_view,
    parameters_of,
    prospect,
)

PICTURE = (640, 360)  # px
PERIOD = 40  # ms between pictures
HELP = (
    "Keys: <b>→ ←</b> push forwards, backwards · <b>space</b> pause · <b>s</b> slow motion · "
    "<b>r</b> start again"
)
WORKING = "being computed"


class Page:
    """One visitor's page: widgets, panels, a session, and two threads that compute.

    Args:
        document: Bokeh's.
        choice: what walks first.
        controllers: besides those of the package, as `load_controller` takes them.
    """

    def __init__(self, document: Any, choice: Choice, controllers: Sequence[str] = ()) -> None:
        self.session = Session(choice, PICTURE)
        self.choice = choice
        self.found: Prospect | None = None  # the last that was known
        self.chooser = Chooser(controllers, self._choose, self._refuse)
        self.handles = Handles(self.session)
        self.stage = Stage(self.session, PICTURE)
        self._quick = Aside(document.add_next_tick_callback, "gaits")
        self._slow = Aside(document.add_next_tick_callback, "diagrams")
        self._diagram_of: Any = None  # what the diagram in the panel holds for
        self._offering = False  # whether it is the page that chooses the diagram's parameter
        self._note = ""
        self._make_panels()
        self._lay_out(document)
        self.chooser.show(choice)
        self._choose(choice, begin=True)
        self._clock = time.monotonic()
        document.add_periodic_callback(self.tick, PERIOD)
        document.on_session_destroyed(lambda _: self.close())

    def close(self) -> None:
        """End the threads."""
        self._quick.close()
        self._slow.close()

    # What one sees --------------------------------------------------------------------

    def _make_panels(self) -> None:
        self.section = Section((230, 230))
        self.multipliers = Multipliers((230, 230))
        self.basin = BasinPanel((350, 280), lambda state: self.session.start(state.tolist()))
        self.diagram = DiagramPanel((350, 250))
        self.meanings = Div(width=430, name="meanings")
        self.parameter = Select(title="diagram against", options=[], width=300, name="parameter")
        self.parameter.on_change("value", lambda _a, _o, _n: self._draw_diagram())

    def _lay_out(self, document: Any) -> None:
        middle = column(
            self.stage.figure,
            self.handles.layout,
            self.stage.status,
            row(self.section.figure, self.multipliers.figure),
        )
        right = column(self.basin.figure, self.meanings, self.parameter, self.diagram.figure)
        unseen = row(listen(document, self.handles.keys), self.stage.arrival.model)
        document.add_root(
            column(row(self.chooser.layout, middle, right), Div(text=HELP, width=700), unseen)
        )
        document.title = "powered-walker explore"

    # A choice and what follows from it ------------------------------------------------

    def _choose(self, choice: Choice, begin: bool) -> None:
        """Nothing drawn before holds any more: clear it, and ask anew."""
        self.choice, self._note = choice, ""
        near = None if begin or self.found is None else list(self.found.start)
        if begin:
            self.handles.suit(choice)
        self._clear(WORKING)
        self._quick.ask(lambda _: prospect(choice, near), lambda found: self._take(found, begin))

    def _refuse(self, reason: str) -> None:
        self._note = reason

    def _clear(self, note: str) -> None:
        for panel in (self.section, self.multipliers, self.basin):
            panel.clear(note)
        self.meanings.text = ""
        self.diagram.clear_present()
        if self._diagram_of != self._diagram_key(self.choice):
            self._slow.forget()
            self._diagram_of = None
            self.diagram.clear(note)

    def _take(self, found: Any, begin: bool) -> None:
        """The gait is known, or why there is none: walk, and draw the rest."""
        if isinstance(found, Exception):
            self._clear("no answer")
            self._note = f"{type(found).__name__}: {found}"
            return
        self.found, self._note = found, found.problem
        if begin:
            self.session.begin(found.choice, found.policy, found.start)
        else:
            self.session.change(found.choice, found.policy)
            self.session.home = found.start
        if found.gait is None:
            for panel in (self.section, self.multipliers, self.basin):
                panel.clear("there is no gait")
        else:
            self.section.show(found.gait)
            self.multipliers.show(found.gait)
            self._quick.ask(lambda check: basin_view(found, check), self._take_basin)
        self._offer_parameters(parameters_of(found))
        self._draw_diagram()

    def _take_basin(self, basin: Any) -> None:
        if isinstance(basin, Exception):
            self.basin.clear(str(basin))
            return
        self.meanings.text = "&nbsp; ".join(
            f'<span style="color:{colour}">■</span>&nbsp;{html.escape(words)}'
            for words, colour in self.basin.show(basin)
        )
        self._show_strides()

    def _offer_parameters(self, names: list[str]) -> None:
        """What the diagram can be drawn against; what powers the walker if nothing is chosen."""
        self._offering = True
        options: list[Any] = [(name, name.replace("_", " ")) for name in names]
        self.parameter.options = options
        if self.parameter.value not in names:
            likely = [*self.choice.scheme.numbers[::-1], "slope"]
            self.parameter.value = next(name for name in likely if name in names)
        self._offering = False

    def _diagram_key(self, choice: Choice) -> Any:
        """What a diagram holds for: under a constant control not the parameter's own value."""
        parameter = self.parameter.value
        if choice.controller == OPEN_LOOP and parameter in choice.numbers:
            choice = choice.replace(parameter, choice.reach(parameter).low)
        return choice, parameter

    def _draw_diagram(self) -> None:
        found, parameter = self.found, self.parameter.value
        if self._offering or found is None or found.choice != self.choice:
            return  # the gait to start from is on its way
        key = self._diagram_key(found.choice)
        if key != self._diagram_of:
            self._diagram_of = key
            self.diagram.clear(WORKING)
            self._slow.ask(lambda check: diagram_view(found, parameter, check), self._take_diagram)

    def _take_diagram(self, diagram: Any) -> None:
        if isinstance(diagram, Exception):
            self.diagram.clear(str(diagram))
        else:
            self.diagram.show(diagram)
            self._show_strides()

    # The walk -------------------------------------------------------------------------

    def tick(self) -> None:
        """Let the time that has passed pass in the walk, and show it."""
        now = time.monotonic()
        passed, self._clock = now - self._clock, now
        try:
            struck = self.session.advance(passed)
        except (ValueError, TypeError) as error:  # of a controller from outside
            self.chooser.controller.value = OPEN_LOOP
            self.session.change(self.choice, self.choice.control)
            self._note = f"open loop, since the controller failed: {error}"
            return
        if struck:
            self._show_strides()
        self.stage.show(self._note)

    def _show_strides(self) -> None:
        """The last strides in the panels, if they were walked under the present choice."""
        if self.session.choice != self.choice:
            return
        states = self.session.section()
        for panel in (self.section, self.basin):
            panel.show_strides(states[:, STANCE_ANGLE], states[:, STANCE_RATE])
        if self.diagram.shown is not None:
            value = self.choice.value(self.diagram.shown.parameter)
            self.diagram.show_present(value, states)
