"""A folder that keeps finished pieces of work, so that interrupted work can be resumed."""

from __future__ import annotations

import hashlib
import json
import pickle
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import joblib

from powered_walker_env.files import write_text, written_aside

SETTINGS = "settings.json"


class Checkpoint:
    """A folder with one file for each finished piece, and what the pieces are.

    Raises:
        ValueError: a folder that holds other work, or other files.
    """

    def __init__(self, folder: Path, function: Callable[[Any], Any], pieces: Sequence[Any]) -> None:
        self.folder, self.count = folder, len(pieces)
        settings = {
            "function": f"{function.__module__}.{function.__qualname__}",
            "pieces": len(pieces),
            "fingerprint": _fingerprint(pieces),
        }
        folder.mkdir(parents=True, exist_ok=True)
        known = folder / SETTINGS
        if not known.exists():
            if any(folder.iterdir()):
                raise ValueError(f"checkpoint must be a new or empty folder, got {str(folder)!r}")
            write_text(known, json.dumps(settings, indent=2))
            return
        there = json.loads(known.read_text(encoding="utf-8"))
        different = [name for name in settings if there.get(name) != settings[name]]
        if different:
            raise ValueError(
                f"checkpoint {str(folder)!r} belongs to other work: its {different[0]} is "
                f"{there.get(different[0])!r}, not {settings[different[0]]!r}; choose another "
                "folder, or the settings it was begun with"
            )

    def _file(self, index: int) -> Path:
        return self.folder / f"{index:06d}.pickle"

    def save(self, index: int, result: Any) -> None:
        """Keep the result of a piece."""
        with written_aside(self._file(index)) as aside:
            aside.write_bytes(pickle.dumps(result))

    def load(self) -> dict[int, Any]:
        files = ((index, self._file(index)) for index in range(self.count))
        """The finished pieces' results by number."""
        return {i: pickle.loads(file.read_bytes()) for i, file in files if file.exists()}


def _fingerprint(pieces: Sequence[Any]) -> str:
    """A hash of everything in the pieces; local functions by their code."""
    try:
        return str(joblib.hash(list(pieces)))
    except (pickle.PicklingError, AttributeError, TypeError):
        from joblib.externals import cloudpickle

        return hashlib.md5(cloudpickle.dumps(list(pieces)), usedforsecurity=False).hexdigest()
