"""Machine code on disk: never stale, never in the way, and fit to be carried elsewhere.

Numba looks only at a function's own file to decide whether its cached machine code is current, so
an edit of a formula in one file would leave its callers in others with the old one. Here the code
of a kernel lies in a folder named after a hash of all the package's sources that the kernel's
module imports, directly or not, and of numba's release: no others throw it away, and no path or
date of this installation counts, so that folders can be copied (`powered-walker compile`). Numba's
own key in it has the processor.

Places are asked in turn: NUMBA_CACHE_DIR if that is set, beside the package, the user's cache. One
that cannot be written to serves if it has the code; the first that can be written to keeps what
has to be compiled. Where none can, kernels are compiled anew in each process, and a line says so.
A damaged file is thrown away.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numba
from numba.core.caching import CompileResultCacheImpl, FunctionCache

_PACKAGE = Path(__file__).parents[1]
_IMPORT = re.compile(
    rf"^(?:from|import) ({_PACKAGE.name}[\w.]*)(?: import ([\w, ]+|\([^)]*\)))?", re.M
)
_KEPT = 4  # folders of one kernel's earlier sources that are left alone: other processes' own


class _Place:
    """A folder for the kernels of one module, as numba asks for it (a locator)."""

    def __init__(self, folder: Path, line: int) -> None:
        self.folder, self._line = folder, line

    def from_function(self, *_: Any) -> _Place:
        return self

    def get_cache_path(self) -> str:
        return str(self.folder)

    def get_source_stamp(self) -> str:
        return self.folder.name  # the hash of all sources

    def get_disambiguator(self) -> str:
        return str(self._line)

    def ensure_cache_path(self) -> None:
        """Make the folder; old ones are cleared away.

        Raises:
            OSError: it cannot be written to.
        """
        if not self.folder.is_dir():
            _clear(self.folder)
            self.folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=self.folder).close()


class _Kept(FunctionCache):  # type: ignore[misc]
    """Numba's cache of one function, in one place."""

    def __init__(self, function: Callable[..., Any], folder: Path) -> None:
        self._place = _Place(folder, function.__code__.co_firstlineno)
        super().__init__(function)

    def _impl_class(self, function: Callable[..., Any]) -> Any:
        class Here(CompileResultCacheImpl):  # type: ignore[misc]
            _locator_classes = (self._place,)

        return Here(function)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The machine code; None where there is none, or none that is whole."""
        try:
            if not self._place.folder.is_dir():
                return None
            return super().load_overload(sig, target_context)
        except Exception:  # a file that is cut off can fail in any way
            with contextlib.suppress(OSError):
                self.flush()
            return None

    def writable(self) -> bool:
        """Whether it can keep anything."""
        try:
            self._place.ensure_cache_path()
        except OSError:
            return False
        return True


class _Cache:
    """The machine code of one function, wherever it lies."""

    def __init__(self, function: Callable[..., Any]) -> None:
        name = _folder_name(function.__module__)
        self._kept = [_Kept(function, parent / name) for parent in _parents()]
        self.home: _Kept | None = None  # where it is kept: the last place asked

    @property
    def cache_path(self) -> str:
        """The folder that it lies in, once it has been asked for."""
        return str((self.home or self._kept[0]).cache_path)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The machine code for a signature on this processor; None if it has to be compiled."""
        for place in self._kept:
            self.home = place
            found = place.load_overload(sig, target_context)
            if found is not None or place.writable():
                return found
        self.home = None
        _say_once(
            "no folder can be written to, so kernels are compiled anew in each process; "
            "set NUMBA_CACHE_DIR"
        )
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep it, if there is a place for it."""
        if self.home is None:
            return
        try:
            self.home.save_overload(sig, data)
        except OSError as error:
            self.home = None
            _say_once(f"compiled kernels were not saved: {error}")

    def flush(self) -> None:
        """Throw away what is kept."""
        if self.home is not None:
            self.home.flush()


def kept_on_disk(compiled: Any) -> Any:
    """Keep a compiled function's machine code on disk, if there is a place for it."""
    if not hasattr(compiled, "_cache"):  # NUMBA_DISABLE_JIT
        return _refused(compiled)
    compiled._cache = _Cache(compiled.py_func)
    return compiled


def is_kept(compiled: Any) -> bool:
    """Whether a kernel's machine code, which has been used, is on disk."""
    return compiled._cache.home is not None


def _refused(function: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(function)
    def refuse(*_: Any) -> Any:
        raise RuntimeError(
            "NUMBA_DISABLE_JIT is set: the kernels are made for machine code and do not run as "
            "Python; unset it (the formulas in powered_walker_env.model.mechanics do run as Python)"
        )

    return refuse


@functools.cache
def _folder_name(module: str) -> str:
    return f"{module.split('.', 1)[-1]}-{sources_hash(module)}"


def _parents() -> Iterator[Path]:
    if numba.config.CACHE_DIR:
        yield Path(numba.config.CACHE_DIR) / _PACKAGE.name
    yield _PACKAGE / "__pycache__" / "kernels"
    cache = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA")
    try:
        yield (Path(cache) if cache else Path.home() / ".cache") / _PACKAGE.name
    except RuntimeError:  # no home
        return


def _clear(folder: Path) -> None:
    """Remove all but the latest folders of earlier sources of the same module."""
    stem = folder.name.rpartition("-")[0]
    old = sorted(folder.parent.glob(f"{stem}-*"), key=lambda folder: folder.stat().st_mtime)
    for each in old[: max(0, len(old) - _KEPT)]:
        shutil.rmtree(each, ignore_errors=True)


def sources_hash(module: str) -> str:
    """Of numba's version and of every source of the package that a module needs."""
    digest = hashlib.sha256(numba.__version__.encode())
    for path in sorted(_needed(module)):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _needed(module: str) -> set[Path]:
    """The files of the package that a module imports, directly or not, itself included."""
    found: set[Path] = set()
    waiting = [_file(module)]
    while waiting:
        path = waiting.pop()
        if path is None or path in found:
            continue
        found.add(path)
        for source, names in _IMPORT.findall(path.read_text(encoding="utf-8")):
            parts = (part.split()[0] for part in names.strip("()").split(",") if part.strip())
            waiting += [_file(source), *(_file(f"{source}.{part}") for part in parts)]
    return found


def _file(module: str) -> Path | None:
    """The file of a module of the package; None for a name that is no module."""
    path = _PACKAGE.parent / module.replace(".", "/")
    known = (path.with_suffix(".py"), path / "__init__.py")
    return next((file for file in known if file.is_file()), None)


@functools.cache
def _say_once(line: str) -> None:
    if sys.stderr is not None:
        sys.stderr.write(f"{_PACKAGE.name}: {line}\n")
