"""What must be in the environment before pygame is imported, and no word on compiling."""

from __future__ import annotations

import os

from powered_walker_env.compiled import decorators as compilation

os.environ.setdefault("SDL_VIDEODRIVER", "dummy")  # no screen needed
# Tests that look at stderr must not depend on which of them is the first to walk.
compilation._announcer._first.acquire(blocking=False)
