"""What a visitor touches: a walker to choose, sliders for its numbers, buttons that push it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from bokeh.layouts import column, row
from bokeh.models import PrintfTickFormatter
from bokeh.models.layouts import TabPanel, Tabs
from bokeh.models.widgets.buttons import Button, Toggle
from bokeh.models.widgets.inputs import Select
from bokeh.models.widgets.markups import Div
from bokeh.models.widgets.sliders import Slider

from powered_walker_env.explore.choice import Choice, controllers_offered
from powered_walker_env.explore.session import SLOW, Session
from powered_walker_env.model.powering import SCHEMES
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.model.quantities import Quantity

WIDTH = 286  # px, of the column of sliders
REAL_TIME, SLOW_MOTION = "real time", "slow motion"
SPEEDS = {REAL_TIME: 1.0, SLOW_MOTION: SLOW, "four times": 4.0}
MOST_PUSH = 10.0  # times the usual push: the reach of its slider


class Chooser:
    """The widgets of a choice: walker, scheme, controller, and a slider for each number.

    Args:
        controllers: besides those that come with the package.
        chosen: called with what a visitor has chosen, and whether the walk begins anew.
        refused: called with the reason if there is no such walker.
    """

    def __init__(
        self,
        controllers: Sequence[str],
        chosen: Callable[[Choice, bool], None],
        refused: Callable[[str], None],
    ) -> None:
        self._chosen, self._refused = chosen, refused
        self._setting = False  # whether it is the program that moves the widgets
        names: list[Any] = [*dict.fromkeys([*controllers_offered(), *controllers])]
        walkers, schemes = (list[Any](known) for known in (PRESETS, SCHEMES))
        half = (WIDTH - 10) // 2
        self.preset = Select(title="walker", options=walkers, width=WIDTH, name="preset")
        self.scheme = Select(title="powered by", options=schemes, width=half, name="scheme")
        self.controller = Select(title="controller", options=names, width=half, name="controller")
        self.sliders: dict[str, Slider] = {}
        self._tabs = Tabs(tabs=[], width=WIDTH + 14)
        self.layout = column(
            self.preset, row(self.scheme, self.controller), self._tabs, width=WIDTH + 24
        )
        self.preset.on_change("value", lambda _a, _o, new: self._choose_preset(new))
        self.scheme.on_change("value", lambda _a, _o, new: self._choose_scheme(new))
        self.controller.on_change("value", lambda _a, _o, new: self._choose_controller(new))

    def show(self, choice: Choice) -> None:
        """Set the widgets to a choice, with sliders for the numbers that it has."""
        self._setting = True
        self.choice = choice
        self.preset.value, self.scheme.value = choice.preset, choice.scheme.name
        self.controller.value = choice.controller
        self.sliders = {name: self._slider(name) for name in choice.numbers}
        of_control = [self.sliders[name] for name in choice.scheme.numbers]
        others = [each for name, each in self.sliders.items() if name not in choice.scheme.numbers]
        nothing = [Div(text="Nothing to control: the slope powers it.", width=WIDTH)]
        self._tabs.tabs = [
            TabPanel(title="control", child=column(*(of_control or nothing))),
            TabPanel(title="legs and floor", child=column(*others)),
        ]
        self._tabs.active = 0 if of_control else 1
        self._setting = False

    def _slider(self, name: str) -> Slider:
        number, reach = self.choice.numbers[name], self.choice.reach(name)
        slider = Slider(
            title=title_of(number), start=reach.low, end=reach.high, step=reach.step,
            value=self.choice.value(name), width=WIDTH - 6, name=name,
            format=PrintfTickFormatter(format="%.6g"),
        )  # fmt: skip
        slider.on_change("value", lambda _a, _o, new: self._set_number(name, float(new)))
        return slider

    def _choose_preset(self, name: str) -> None:
        if not self._setting:
            self.show(Choice.of_preset(name))
            self._chosen(self.choice, True)

    def _choose_scheme(self, name: str) -> None:
        if self._setting:
            return
        try:
            choice = self.choice.powered_by(name)
        except ValueError as error:
            self._refuse(error)
            return
        self.show(choice)
        self._chosen(choice, True)

    def _choose_controller(self, name: str) -> None:
        if not self._setting:
            self.choice = self.choice.decided_by(name)
            self._chosen(self.choice, False)

    def _set_number(self, name: str, value: float) -> None:
        if self._setting or value == self.choice.value(name):
            return
        try:
            self.choice = self.choice.replace(name, value)
        except ValueError as error:
            self._refuse(error)
            return
        self._chosen(self.choice, False)

    def _refuse(self, error: Exception) -> None:
        """Put the widgets back to what is walking, and say why."""
        self.show(self.choice)
        self._refused(str(error))


class Handles:
    """Buttons and keys that push a walk, stop it, slow it down and begin it again."""

    def __init__(self, session: Session) -> None:
        self.session = session
        speeds = list[Any](SPEEDS)
        self.speed = Select(title="", options=speeds, value=REAL_TIME, width=110, name="speed")
        self.pause = Toggle(label="pause", width=70, name="pause")
        again = Button(label="start again", width=90, name="again")
        back = Button(label="← push", width=75, name="back")
        forth = Button(label="push →", width=75, name="forth")
        self.strength = Slider(
            title="push, rad/s", start=0, end=1, step=0.01, value=0, width=170, name="strength",
            format=PrintfTickFormatter(format="%.3g"),
        )  # fmt: skip
        self.layout = row(back, forth, self.strength, self.pause, again, self.speed)
        self.speed.on_change("value", lambda _a, _o, new: self._set_speed(new))
        self.pause.on_change("active", lambda _a, _o, new: self._set_pause(new))
        again.on_click(session.restart)
        back.on_click(lambda: self.push(-1.0))
        forth.on_click(lambda: self.push(1.0))

    @property
    def keys(self) -> dict[str, Callable[[], Any]]:
        """What each key does, by the name that browsers give it."""
        return {
            "ArrowRight": lambda: self.push(1.0),
            "ArrowLeft": lambda: self.push(-1.0),
            " ": self._toggle_pause,
            "s": self._toggle_slow,
            "r": self.session.restart,
        }

    def suit(self, choice: Choice) -> None:
        """Set the strength of a push to what is usual for a walker."""
        usual = choice.usual_push
        self.strength.update(end=MOST_PUSH * usual, step=0.1 * usual, value=usual)

    def push(self, direction: float) -> None:
        """Push both legs, forwards or backwards, with the strength that is set."""
        each = direction * float(self.strength.value)
        self.session.push(each, each)

    def _set_pause(self, paused: bool) -> None:
        self.session.paused = paused

    def _set_speed(self, name: str) -> None:
        self.session.speed = SPEEDS[name]

    def _toggle_pause(self) -> None:
        self.pause.active = not self.pause.active

    def _toggle_slow(self) -> None:
        self.speed.value = REAL_TIME if self.speed.value == SLOW_MOTION else SLOW_MOTION


def title_of(number: Quantity) -> str:
    """Symbol, what it is in few words, unit."""
    words = number.label.partition(",")[0]
    return f"{number.symbol}  {words}" + (f", {number.unit}" if number.unit else "")
