"""Ctrl-C and SIGTERM, for programs that have something to do before they end."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any

STOPPING = [getattr(signal, name) for name in ("SIGINT", "SIGTERM") if hasattr(signal, name)]

Handler = Callable[[int, FrameType | None], Any]


@contextlib.contextmanager
def stop_signals(handler: Handler) -> Iterator[None]:
    """Both go to a handler (in the main thread; others get no signals)."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.signal(number, handler) for number in STOPPING}
    try:
        yield
    finally:
        for number, previous in before.items():
            signal.signal(number, previous)
