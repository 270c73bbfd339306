"""From where is a gait reached, and from where can a fall be avoided?

- what becomes of each start? `basins`, over the planes of `slices`;
- how much of the state space does a gait attract? `volumes`;
- which states can any control within bounds save? `viability`.
"""

from powered_walker_env.poincare.regions.basins import Basin, basin
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
    "Slice",
    "Viability",
    "basin",
    "basin_volume",
    "schwab_wisse_slice",
    "slice_through",
    "viable_states",
]
