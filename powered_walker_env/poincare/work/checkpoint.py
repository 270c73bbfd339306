"""A folder that keeps finished pieces of work, so that interrupted work can be resumed.

Each is a result file (`results.py`): written whole, and no program. One that is damaged
counts as not there.
"""

from __future__ import annotations

import functools
import hashlib
import json
import pickle
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import cloudpickle

from powered_walker_env.files import write_text
from powered_walker_env.results import load_result, save_result

SETTINGS = "settings.json"


class Checkpoint:
    """A folder with one file for each finished piece, and what the pieces are.

    Raises:
        ValueError: a folder that holds other work, or other files.
    """

    def __init__(self, folder: Path, function: Callable[..., Any], pieces: list[Any]) -> None:
        self.folder = folder
        named = function.func if isinstance(function, functools.partial) else function
        settings = {
            "function": f"{named.__module__}.{named.__qualname__}",
            "pieces": len(pieces),
            "fingerprint": _fingerprint([function, *pieces]),
        }
        folder.mkdir(parents=True, exist_ok=True)
        known = folder / SETTINGS
        if not known.exists():
            if any(folder.iterdir()):
                raise ValueError(f"checkpoint must be a new or empty folder, got {str(folder)!r}")
            write_text(known, json.dumps(settings, indent=2))
            return
        try:
            there = dict(json.loads(known.read_text(encoding="utf-8")))
        except (ValueError, TypeError):
            there = {}
        different = [name for name in settings if there.get(name) != settings[name]]
        if different:
            raise ValueError(
                f"checkpoint {str(folder)!r} belongs to other work: its {different[0]} is "
                f"{there.get(different[0])!r}, not {settings[different[0]]!r}; choose another "
                "folder, or the settings it was begun with"
            )

    def _file(self, number: int) -> Path:
        return self.folder / f"{number:06d}.npz"

    def save(self, number: int, result: Any) -> None:
        """Keep the result of a piece.

        Raises:
            TypeError: a result that `save_result` cannot keep.
        """
        save_result(result, self._file(number))

    def load(self, numbers: Iterable[int]) -> list[Any]:
        """The results of these pieces, up to the first that is not there whole."""
        found: list[Any] = []
        for number in numbers:
            try:
                found.append(load_result(self._file(number)))
            except (FileNotFoundError, ValueError):
                break
        return found


def _fingerprint(things: Iterable[Any]) -> str:
    """A hash of everything in the work; local functions by their code."""
    digest = hashlib.sha256()
    for thing in things:
        try:
            digest.update(pickle.dumps(thing))
        except (pickle.PicklingError, AttributeError, TypeError):
            digest.update(cloudpickle.dumps(thing))
    return digest.hexdigest()
