"""Derivatives by fourth-order differences, where nothing carries the exact ones along.

Of a policy alone, of a controller, of strides by the height of a step: all that is
differentiated otherwise goes with the variational equations (`sensitivity.py`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


class Stencil(NamedTuple):
    """Where a function is asked, in steps, and with which weights (over 12 steps)."""

    offsets: tuple[float, ...]
    weights: tuple[float, ...]


_ONE_SIDED = (-25.0, 48.0, -36.0, 16.0, -3.0)
CENTRAL = Stencil((-2.0, -1.0, 1.0, 2.0), (1.0, -8.0, 8.0, -1.0))
FORWARD = Stencil((0.0, 1.0, 2.0, 3.0, 4.0), _ONE_SIDED)
BACKWARD = Stencil((0.0, -1.0, -2.0, -3.0, -4.0), tuple(-weight for weight in _ONE_SIDED))


def differences(
    function: Callable[[Array], ArrayLike],
    points: Array,
    steps: ArrayLike,
    stencil: Stencil = CENTRAL,
) -> Array:
    """Derivatives of a function of many points at once.

    Args:
        function: (M, n) to (M, k).
        points: (N, n).
        steps: (n,) or one for all.

    Returns:
        (N, k, n) derivatives of the k values by the n coordinates.
    """
    count, size = points.shape
    each = np.broadcast_to(np.asarray(steps, np.float64), (size,))
    moves = np.array(stencil.offsets)[:, np.newaxis, np.newaxis] * np.diag(each)
    asked = (points[:, np.newaxis, np.newaxis] + moves).reshape(-1, size)
    values = np.asarray(function(asked), np.float64)
    values = values.reshape(count, len(stencil.offsets), size, -1)
    found: Array = np.einsum("o,nodk->nkd", np.array(stencil.weights) / 12.0, values)
    return found / each
