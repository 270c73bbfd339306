"""How far long work has come, told by the package's protocol for progress."""

from __future__ import annotations

import math
import time

from powered_walker_env.poincare.work.pieces import Progress


class Clock:
    """Counts units of work and tells how long the rest will take, from the start on."""

    def __init__(self, total: int, progress: Progress | None) -> None:
        self.total, self.progress = total, progress
        self.done, self.began = 0, time.monotonic()
        self.tick(0)

    def tick(self, units: int = 1) -> None:
        """So many units are done."""
        self.done = min(self.done + units, self.total)
        if self.progress is not None:
            taken = time.monotonic() - self.began
            left = taken / self.done * (self.total - self.done) if self.done else math.nan
            self.progress(self.done, self.total, left)


__all__ = ["Clock", "Progress"]
