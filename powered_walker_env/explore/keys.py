"""Keys and acknowledgements: what a Bokeh page tells its server besides its widgets."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from bokeh.events import DocumentReady
from bokeh.models import CustomJS
from bokeh.models.widgets.inputs import TextInput

# Keys that move a slider, or write in a field, are theirs.
_LISTEN = """
if (!window.walker_listens) {
  window.walker_listens = true
  let count = 0
  document.addEventListener("keydown", (event) => {
    const target = event.composedPath()[0]
    const busy = target.role == "slider" || target.getAttribute?.("role") == "slider"
    const writes = ["INPUT", "SELECT", "TEXTAREA"].includes(target.tagName)
    if (busy || writes || event.ctrlKey || event.metaKey || event.altKey) return
    if (!names.includes(event.key)) return
    event.preventDefault()
    count += 1
    pressed.value = event.key + "/" + count
  })
}
"""


def listen(document: Any, actions: Mapping[str, Callable[[], None]]) -> TextInput:
    """Call an action when its key is pressed in the page; the model has to be in the page."""
    pressed = TextInput(visible=False, name="keys")
    script = CustomJS(args={"pressed": pressed, "names": list(actions)}, code=_LISTEN)
    document.js_on_event(DocumentReady, script)
    pressed.on_change("value", lambda _a, _o, new: actions[new.rpartition("/")[0]]())
    return pressed


class Arrival:
    """Whether the page has drawn the last picture: the next one waits for that.

    A slow browser then sees fewer pictures, not later ones.

    Args:
        source: of the picture; its column `number` counts them.
    """

    LONGEST = 40  # looks, after which a picture is taken for lost

    def __init__(self, source: Any) -> None:
        self.model = TextInput(visible=False, name="arrival")
        code = "requestAnimationFrame(() => { drawn.value = String(source.data.number[0]) })"
        source.js_on_change(
            "data", CustomJS(args={"drawn": self.model, "source": source}, code=code)
        )
        self._sent, self._looks = 0, 0

    def next(self) -> int | None:
        """The number of the next picture, or None while the last one is on its way."""
        self._looks += 1
        if str(self._sent) != (self.model.value or "0") and self._looks < self.LONGEST:
            return None
        self._sent, self._looks = self._sent + 1, 0
        return self._sent
