"""Ctrl-C and SIGTERM, for programs that have something to do before they end."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any

STOPPING = [getattr(signal, name) for name in ("SIGINT", "SIGTERM") if hasattr(signal, name)]

BY_SIGNAL = 128  # and the number of the signal: an exit status, as shells have it

Handler = Callable[[int, FrameType | None], Any]


_last = signal.SIGINT


def status_of_stop() -> int:
    """The exit status of a program that the last of the signals has stopped."""
    return BY_SIGNAL + _last


@contextlib.contextmanager
def stop_signals(handler: Handler) -> Iterator[None]:
    """Both go to a handler (in the main thread; others get no signals)."""

    def note(number: int, frame: FrameType | None) -> Any:
        global _last
        _last = signal.Signals(number)
        return handler(number, frame)

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.signal(number, note) for number in STOPPING}
    try:
        yield
    finally:
        for number, previous in before.items():
            signal.signal(number, previous)
