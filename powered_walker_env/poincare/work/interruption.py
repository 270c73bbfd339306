"""How a command is interrupted: SIGTERM is Ctrl-C, and a second of either ends it at once."""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Iterator
from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM)


@contextlib.contextmanager
def interruptible() -> Iterator[None]:
    """Inside, the first SIGINT or SIGTERM raises KeyboardInterrupt; a second ends the process.

    For programs, in their main thread: a library leaves signals alone. Handlers that somebody
    else has set stay.
    """
    ours = (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM))
    if ours != (signal.default_int_handler, signal.SIG_DFL):
        yield
        return
    came: list[int] = []

    def interrupt(number: int, _: FrameType | None) -> None:
        came.append(number)
        if len(came) > 1:
            os._exit(128 + number)  # worker processes notice, and end themselves
        raise KeyboardInterrupt

    before = {number: signal.signal(number, interrupt) for number in SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
