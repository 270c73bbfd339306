"""Rows of lanes in memory, for small compiled functions of tests."""

from __future__ import annotations

from typing import Any

import numpy as np

from powered_walker_env.compiled.lanes import LANES
from tests.helpers.derivation import Array


def block_of(rows: int) -> tuple[Array, Array]:
    """Memory for so many rows of lanes, and the rows in it, where `eights` begins them."""
    block = np.zeros((rows + 1) * LANES)
    start = -block.ctypes.data % (8 * LANES) // 8
    return block, block[start : start + rows * LANES].reshape(rows, LANES)


def through(function: Any, outputs: int, *inputs: Array) -> Array:
    """What a compiled function of a block writes behind its input rows."""
    block, rows = block_of(len(inputs) + outputs)
    rows[: len(inputs)] = inputs
    function(block)
    return rows[len(inputs) :].copy()
