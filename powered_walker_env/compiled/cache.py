"""Machine code on disk: never stale, never in the way.

Numba looks only at a function's own file to decide whether its cached machine code is current, so
an edit of a formula in one file would leave its callers in others with the old one. Here the cache
lies in a folder named after a hash of all the package's sources that a kernel's module imports,
directly or not: no others throw it away. A folder is looked for in NUMBA_CACHE_DIR if that is set,
else beside the package, else in the user's cache; where none can be written to, kernels are
compiled anew in each process, and a line says so. A damaged file is thrown away.
"""

from __future__ import annotations

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
from numba.core.caching import FunctionCache

_PACKAGE = Path(__file__).parents[1]
_IMPORT = re.compile(
    rf"^(?:from|import) ({_PACKAGE.name}[\w.]*)(?: import ([\w, ]+|\([^)]*\)))?", re.M
)
_KEPT = 4  # folders of one kernel's earlier sources that are left alone: other processes' own


class _Cache(FunctionCache):  # type: ignore[misc]
    """Numba's cache of one function, of which no file can do harm."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # a file that is cut off can fail in any way
            self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        try:
            super().save_overload(sig, data)
        except OSError as error:
            _say(f"compiled kernels were not saved: {error}")


def kept_on_disk(compiled: Any) -> Any:
    """Keep a compiled function's machine code on disk, if there is a place for it."""
    if not hasattr(compiled, "_cache"):  # NUMBA_DISABLE_JIT
        return _refused(compiled)
    folder = _folder(compiled.py_func.__module__)
    if folder is None:
        return compiled
    chosen = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(folder)  # numba picks the folder as the cache is made
    try:
        compiled._cache = _Cache(compiled.py_func)
    finally:
        numba.config.CACHE_DIR = chosen
    return compiled


def _refused(function: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(function)
    def refuse(*_: Any) -> Any:
        raise RuntimeError(
            "NUMBA_DISABLE_JIT is set: the kernels are made for machine code and do not run as "
            "Python; unset it (the formulas in powered_walker_env.model.mechanics do run as Python)"
        )

    return refuse


@functools.cache
def _folder(module: str) -> Path | None:
    """A folder for the kernels of a module that can be written to; old ones are cleared away."""
    name = f"{module.split('.', 1)[-1]}-{sources_hash(module)}"
    for parent in _parents():
        folder = parent / name
        try:
            if not folder.is_dir():
                _clear(parent, name)
                folder.mkdir(parents=True)
            with tempfile.TemporaryFile(dir=folder):
                return folder
        except OSError:
            continue
    _say(
        "no folder can be written to, so kernels are compiled anew in each process; "
        "set NUMBA_CACHE_DIR"
    )
    return None


def _parents() -> Iterator[Path]:
    if numba.config.CACHE_DIR:
        yield Path(numba.config.CACHE_DIR) / _PACKAGE.name
        return
    yield _PACKAGE / "__pycache__" / "kernels"
    cache = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA")
    try:
        yield (Path(cache) if cache else Path.home() / ".cache") / _PACKAGE.name
    except RuntimeError:  # no home
        return


def _clear(parent: Path, name: str) -> None:
    """Remove all but the latest folders of earlier sources of the same module."""
    stem = name.rpartition("-")[0]
    old = sorted(parent.glob(f"{stem}-*"), key=lambda folder: folder.stat().st_mtime)
    for folder in old[: max(0, len(old) - _KEPT)]:
        shutil.rmtree(folder, ignore_errors=True)


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


def _say(line: str) -> None:
    if sys.stderr is not None:
        sys.stderr.write(f"{_PACKAGE.name}: {line}\n")
