"""The rough root is as near as it is said to be, and in order, over all sizes that an error has."""

from __future__ import annotations

import numba
import numpy as np

from powered_walker_env.compiled.lanes import LANES, eighth_root, eights, load, store
from tests.helpers.lanes import block_of


@numba.njit
def rooted(block, count):
    """Rows of lanes, in place."""
    m = eights(block)
    for i in range(count):
        store(m, i, eighth_root(load(m, i)))


def test_the_eighth_root_is_near_and_rises_with_its_argument() -> None:
    x = np.sort(np.append(10.0 ** np.linspace(-100, 100, 80_000 - 256), 2.0 ** np.arange(256)))
    block, rows = block_of(len(x) // LANES)
    rows.flat[: len(x)] = x
    rooted(block, len(rows))
    found = rows.ravel()[: len(x)]
    ratio = found / x**0.125
    assert 0.99 < ratio.min() <= 1.0 < ratio.max() < 1.07
    assert (np.diff(found) >= 0.0).all()
    assert found[x == 256.0] == 2.0
