"""Room for the strides of a batch: every step writes it anew; new memory would cost more."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.envs.disturbances import STEP_DRAWS
from powered_walker_env.simulation.arguments import Array
from powered_walker_env.simulation.record import RESULTS
from powered_walker_env.simulation.threads import WHOLE


class Room(NamedTuple):
    """What n strides are made in."""

    rows: NDArray[np.intp]  # (n,) which walkers
    packed: Array  # (n or 1, ROW) they themselves
    starts: Array  # (n, 4) their states
    draws: Array  # (n, STEP_DRAWS) what disturbs them
    controls: Array  # (n, k)
    heights: Array  # (n,) m, steps of the ground
    results: Array  # (n, RESULTS)

    def part(self, part: slice) -> Room:
        """Of some of the strides: the same memory."""
        if part is WHOLE:
            return self
        rows, packed, *others = self
        packed = packed if len(packed) == 1 else packed[part]
        return Room(rows[part], packed, *(each[part] for each in others))

    def of(self, rows: NDArray[np.intp]) -> Room:
        """Of some walkers of a whole batch; starts, controls and heights are copies."""
        n, packed = len(rows), self.packed
        return Room(
            rows,
            packed if len(packed) == 1 else packed[rows],
            np.empty((n, 4)),
            self.draws[:n],
            np.empty((n, self.controls.shape[1])),
            np.empty(n),
            self.results[:n],
        )


def room_for(packed: Array, states: Array, controls: Array, heights: Array) -> Room:
    """Of a whole batch, whose own arrays these are."""
    n = len(states)
    draws, results = np.empty((n, STEP_DRAWS)), np.empty((n, RESULTS))
    return Room(np.arange(n), packed, states, draws, controls, heights, results)
