"""From where is a gait reached, and from where can a fall be avoided?

- what becomes of each start? `basins`, over the planes of `slices`;
- how much of the state space does a gait attract? `volumes`;
- which states can any control within bounds save? `viability` by search from given starts,
  `capture` by backward induction on a grid of the section, from both sides;
- how large a single step or push is survived? `largest`.
"""

from powered_walker_env.poincare.regions.basins import Basin, basin
from powered_walker_env.poincare.regions.capture import Capture, capture
from powered_walker_env.poincare.regions.largest import Largest, largest_push, largest_step
from powered_walker_env.poincare.regions.slices import (
    SLICES,
    Slice,
    schwab_wisse_slice,
    slice_through,
)
from powered_walker_env.poincare.regions.viability import Viability, viable_states
from powered_walker_env.poincare.regions.volumes import BasinVolume, basin_volume

__all__ = [
    "SLICES",
    "Basin",
    "BasinVolume",
    "Capture",
    "Largest",
    "Slice",
    "Viability",
    "basin",
    "basin_volume",
    "capture",
    "largest_push",
    "largest_step",
    "schwab_wisse_slice",
    "slice_through",
    "viable_states",
]
