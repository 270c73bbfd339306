"""What stands at a path "module:name": how a function is written where only text can be."""

from __future__ import annotations

import importlib
from typing import Any


def imported(path: str) -> Any:
    """What the path leads to; importing a module runs it.

    Raises:
        ImportError: nothing, and why.
    """
    module, _, names = path.partition(":")
    try:
        found = importlib.import_module(module)
        for name in names.split("."):
            found = getattr(found, name)
    except (ImportError, AttributeError, ValueError) as error:
        raise ImportError(f"{path!r} cannot be imported: {error}") from error
    return found
