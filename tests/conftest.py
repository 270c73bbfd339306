"""What must be in the environment before pygame is imported, and no word on compiling."""

from __future__ import annotations

import os

import pytest

from powered_walker_env.compiled import decorators as compilation

os.environ.setdefault("SDL_VIDEODRIVER", "dummy")  # no screen needed
# Tests that look at stderr must not depend on which of them is the first to walk.
compilation._announcer._first.acquire(blocking=False)
#: Files of few and long tests; begun last, they would be waited for by one worker alone.
FIRST = ("explore/test_browser.py", "cli/test_compile.py", "compiled/test_processors.py")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: not item.path.as_posix().endswith(FIRST))
