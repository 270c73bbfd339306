"""Eight walkers in one number: SIMD lanes as numba types, so that formulas need no loop.

A compiled function that is given `Lanes` (eight floats), `Plane` (eight complex numbers)
or `Mask` (eight truths) in place of a float, a complex or a bool does the same thing to
all of them with single machine instructions. The mechanics in `physics/` is written once,
with `+ - * /`, comparisons, `complex`, `math.cos`, `math.sin`, `math.sqrt`, `abs` and
`where`; plain Python runs it on floats, the kernel on lanes.

Each lane's result depends on that lane alone, whatever its neighbours hold: a walker
walks the same walk, bit for bit, in any lane of any batch. Products and sums may be
fused (`contract`), in all lanes alike.
"""

from powered_walker_env.compiled.lanes import (
    trigonometry as trigonometry,  # gives them sine and cosine
)
from powered_walker_env.compiled.lanes.arithmetic import at_lane_0, bits, mask_of, where
from powered_walker_env.compiled.lanes.kinds import LANES, Lanes, Mask, Plane
from powered_walker_env.compiled.lanes.tables import (
    TABLE,
    Table,
    eights,
    load,
    rows_from,
    store,
    table,
    unseen,
)

__all__ = [
    "LANES",
    "TABLE",
    "Lanes",
    "Mask",
    "Plane",
    "Table",
    "at_lane_0",
    "bits",
    "eights",
    "load",
    "mask_of",
    "rows_from",
    "store",
    "table",
    "unseen",
    "where",
]
