"""Eight walkers in one number: SIMD lanes as numba types, so that formulas need no loop.

Eight with AVX-512; on narrower processors the register holds four or two (`width.py`), and
all that is said of eight is true of them.

A compiled function that is given `Lanes` (eight floats), `Plane` (eight complex numbers)
or `Mask` (eight truths) in place of a float, a complex or a bool does the same thing to
all of them with single machine instructions; given `Dual` or `DualPlane` it also carries their
derivatives along one direction. The mechanics in `model/mechanics/` is written once,
with `+ - * /`, comparisons, `complex`, `unit`, `math.sqrt`, `abs` and
`where`; plain Python runs it on floats, the kernel on lanes.

Each lane's result depends on that lane alone, whatever its neighbours hold: a walker
walks the same walk, bit for bit, in any lane of any batch. Products and sums may be
fused (`contract`), in all lanes alike.
"""

from powered_walker_env.compiled.lanes import arithmetic as arithmetic  # gives them + - * /
from powered_walker_env.compiled.lanes import parts as parts  # gives them .real, .tangent
from powered_walker_env.compiled.lanes import (
    trigonometry as trigonometry,  # gives them sine and cosine
)
from powered_walker_env.compiled.lanes.exponents import eighth_root
from powered_walker_env.compiled.lanes.kinds import LANES, Dual, DualPlane, Lanes, Mask, Plane
from powered_walker_env.compiled.lanes.selection import at_lane_0, bits, count, dual, mask_of, where
from powered_walker_env.compiled.lanes.states import (
    SIZE,
    blend_state,
    dual_state,
    load_like,
    load_state,
    plus,
    scaled,
    selected,
    store_state,
    tangents_of,
)
from powered_walker_env.compiled.lanes.tables import (
    TABLE,
    Table,
    blend,
    eights,
    load,
    rows_from,
    store,
    table,
)
from powered_walker_env.compiled.lanes.trigonometry import unit
from powered_walker_env.compiled.lanes.zero import zero

__all__ = [
    "LANES",
    "SIZE",
    "TABLE",
    "Dual",
    "DualPlane",
    "Lanes",
    "Mask",
    "Plane",
    "Table",
    "at_lane_0",
    "bits",
    "blend",
    "blend_state",
    "count",
    "dual",
    "dual_state",
    "eighth_root",
    "eights",
    "load",
    "load_like",
    "load_state",
    "mask_of",
    "plus",
    "rows_from",
    "scaled",
    "selected",
    "store",
    "store_state",
    "table",
    "tangents_of",
    "unit",
    "where",
    "zero",
]
