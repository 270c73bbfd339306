"""Decorators of compiled functions: formulas, what only kernels call, and the kernels.

A `formula` of the mechanics is plain Python to whoever calls it from Python, and machine code
inside a kernel. Only kernels are kept on disk (`cache.py`); what they call is compiled into them.
"""

from __future__ import annotations

import contextlib
import gc
import sys
import threading
from collections.abc import Callable
from typing import Any

import numba
from numba.core import event
from numba.core.registry import CPUDispatcher

from powered_walker_env.compiled.cache import kept_on_disk

# numpy's error model: a division by zero gives inf, not an exception.
_OPTIONS: dict[str, Any] = {"error_model": "numpy", "no_cfunc_wrapper": True}
_INSIDE = {**_OPTIONS, "no_cpython_wrapper": True}  # without a door to Python it takes less time


class _Formula(CPUDispatcher):  # type: ignore[misc]
    """Compiled where kernels call it; where Python does, the Python function."""

    def __call__(self, *arguments: Any) -> Any:
        return self.py_func(*arguments)


def formula(function: Callable[..., Any]) -> Any:
    """A formula of the mechanics: of floats in Python, of eight walkers in a kernel."""
    return _Formula(function, targetoptions={**_INSIDE, "nopython": True, "forceinline": True})


def small(function: Callable[..., Any]) -> Any:
    """A `formula` of a line or two: it becomes part of its callers before they are compiled."""
    return _Formula(function, targetoptions={**_INSIDE, "nopython": True, "inline": "always"})


def internal(function: Callable[..., Any]) -> Any:
    """A function that only kernels call, copied into its callers."""
    return numba.njit(forceinline=True, **_INSIDE)(function)


def once(function: Callable[..., Any]) -> Any:
    """An `internal` function with a single caller: it becomes part of it before it is compiled."""
    return numba.njit(inline="always", **_INSIDE)(function)


def rare(function: Callable[..., Any]) -> Any:
    """An `internal` function that is seldom called: not copied into its callers."""
    return numba.njit(**_INSIDE)(function)


def kernel(function: Callable[..., Any]) -> Any:
    """A function that Python calls, kept on disk; it runs without the interpreter's lock."""
    return kept_on_disk(numba.njit(nogil=True, **_OPTIONS)(function))


def slow_kernel(function: Callable[..., Any]) -> Any:
    """A `kernel` that takes long to compile: it says so, and looks seldom for garbage meanwhile."""
    compiled = kernel(function)
    _announcer.watch(compiled)
    _collector.watch(compiled)
    return compiled


class _Watcher(event.Listener):  # type: ignore[misc]
    """Is told when certain kernels are compiled; numba does not tell what it loads from disk."""

    def __init__(self) -> None:
        self._watched: list[Any] = []

    def watch(self, compiled: Any) -> None:
        """Watch this one, too."""
        if not self._watched:
            event.register("numba:compile", self)
        self._watched.append(compiled)

    def on_start(self, event: Any) -> None:
        """Something is about to be compiled."""
        if any(event.data["dispatcher"] is compiled for compiled in self._watched):
            self.begin()

    def on_end(self, event: Any) -> None:
        """It is compiled."""
        if any(event.data["dispatcher"] is compiled for compiled in self._watched):
            self.end()

    def begin(self) -> None:
        """One of the watched is about to be compiled."""

    def end(self) -> None:
        """It is compiled, or that has failed."""


class _Announcer(_Watcher):
    """Writes one line to stderr, once per process, before a kernel is compiled that takes long."""

    LINE = "powered_walker_env: compiling the stride kernel for this machine, once (10 to 30 s)"

    def __init__(self) -> None:
        super().__init__()
        self._first = threading.Lock()  # taken by who writes the line, and never given back

    def begin(self) -> None:
        if self._first.acquire(blocking=False):
            with contextlib.suppress(AttributeError, OSError, ValueError):  # no stderr, or closed
                sys.stderr.write(self.LINE + "\n")


class _Collector(_Watcher):
    """Lets the garbage collector look seldom meanwhile: most of the compiler's millions of objects
    live to its end, and to look through them again and again takes a tenth of the time."""

    SELDOM = 200_000, 20, 100

    def __init__(self) -> None:
        super().__init__()
        self._before = gc.get_threshold()

    def begin(self) -> None:
        self._before = gc.get_threshold()
        gc.set_threshold(*self.SELDOM)

    def end(self) -> None:
        gc.set_threshold(*self._before)


_announcer, _collector = _Announcer(), _Collector()
