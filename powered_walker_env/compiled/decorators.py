"""The `kernel` decorator: numba, cached on disk, never stale.

Numba looks only at a function's own file to decide whether its cached machine code is
current, so an edit of a formula in one file would leave its callers in others with the
old one. Here the cache lives in a folder named after a hash of the sources that are compiled. Set
NUMBA_CACHE_DIR to choose a folder yourself.

The stride kernel takes long to compile: when the cache does not have it, a line on stderr
says what the first call waits for.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import shutil
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from numba.core import event

_PACKAGE = Path(__file__).parent.parent
# Compiled in, though not all of it is a kernel.
_COMPILED_IN = (_PACKAGE / "model/phases.py", *sorted((_PACKAGE / "compiled/lanes").glob("*.py")))


def _sources_hash() -> str:
    digest = hashlib.sha256(numba.__version__.encode())
    for path in sorted(_PACKAGE.rglob("*.py")):
        source = path.read_bytes()
        if path in _COMPILED_IN or b"powered_walker_env.compiled.decorators" in source:
            digest.update(source)
    return digest.hexdigest()[:16]


@functools.cache
def _cache_folder() -> str:
    """The folder for this version of the sources, or "" for numba's own choice."""
    if numba.config.CACHE_DIR:
        return ""
    parent = _PACKAGE / "__pycache__"
    folder = parent / f"kernels-{_sources_hash()}"
    try:
        if not folder.is_dir():
            for old in parent.glob("kernels-*"):
                shutil.rmtree(old, ignore_errors=True)
            folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return ""  # read-only installation: nobody edits it
    return str(folder) if os.access(folder, os.W_OK) else ""


def _compile(function: Callable[..., Any], **options: Any) -> Any:
    """`numba.njit` with the cache in our folder; numba picks the folder as it decorates."""
    chosen = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = chosen or _cache_folder()
    try:
        # numpy's error model: a division by zero gives inf, not an exception.
        return numba.njit(cache=True, error_model="numpy", no_cfunc_wrapper=True, **options)(
            function
        )
    finally:
        numba.config.CACHE_DIR = chosen


def kernel(function: Callable[..., Any]) -> Any:
    """Compile a function of the inner loop that Python calls, too."""
    return _compile(function, forceinline=True)


def internal(function: Callable[..., Any]) -> Any:
    """Compile a function that only kernels call; without a door to Python it takes less time."""
    return _compile(function, forceinline=True, no_cpython_wrapper=True)


def rare(function: Callable[..., Any]) -> Any:
    """Compile an `internal` function that is seldom called: not copied into its callers."""
    return _compile(function, no_cpython_wrapper=True)


def threaded_kernel(function: Callable[..., Any]) -> Any:
    """Compile a function that runs without the interpreter's lock."""
    return _compile(function, nogil=True)


def slow_kernel(function: Callable[..., Any]) -> Any:
    """A `threaded_kernel` that takes long to compile: it says so."""
    compiled = threaded_kernel(function)
    _announcer.watch(compiled)
    return compiled


class _Announcer(event.Listener):  # type: ignore[misc]
    """Writes one line to stderr, once per process, before a kernel is compiled that takes long.

    Numba tells its listeners what it compiles, and does not tell what it loads from the cache.
    """

    LINE = "powered_walker_env: compiling the stride kernel for this machine, once (about 15 s)"

    def __init__(self) -> None:
        self._watched: list[Any] = []
        self._first = threading.Lock()  # taken by who writes the line, and never given back

    def watch(self, compiled: Any) -> None:
        """Announce the compilation of this one."""
        if not self._watched:
            event.register("numba:compile", self)
        self._watched.append(compiled)

    def on_start(self, event: Any) -> None:
        """Something is about to be compiled."""
        slow = any(event.data["dispatcher"] is compiled for compiled in self._watched)
        if slow and self._first.acquire(blocking=False):
            with contextlib.suppress(AttributeError, OSError, ValueError):  # no stderr, or closed
                sys.stderr.write(self.LINE + "\n")

    def on_end(self, event: Any) -> None:
        """It is compiled; there is nothing to say."""


_announcer = _Announcer()
