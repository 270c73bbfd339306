"""The stride map and what is asked of it (Camp 1997, section 7), by question:

- what is the map, and its derivative? `maps`;
- which gaits are there? `gaits` (near a guess), `search` (everywhere, or of a given speed);
- how do they change with a parameter? `continuation` (with `families`, `arclength`,
  `branch`, `special_points`), `cascades` to chaos, `boundary` for two parameters, `ramps`
  by brute force;
- how stable, beyond the multipliers? `lyapunov`, `transitions`, `robustness`;
- from where are they reached? `basins`, `volumes` (with `slices`, `trapping`), and from where could
  any controller reach them? `viability` (with `regulator`);
- what does walking cost, and what must it? `energetics`, `transition`;
- is the contact what the model takes it for? `contact` (with `ground_force`);
- long studies in pieces: `pieces`, with `executors`, `checkpoint`, `interruption`.
"""

from powered_walker_env.poincare.branches.arclength import CurveEnd, EndReason
from powered_walker_env.poincare.branches.boundary import (
    Boundary,
    continue_boundary,
    stability_boundaries,
)
from powered_walker_env.poincare.branches.branch import Branch
from powered_walker_env.poincare.branches.cascades import Cascade, doubling_cascade
from powered_walker_env.poincare.branches.continuation import continue_gait, switch_branch
from powered_walker_env.poincare.branches.ramps import BifurcationDiagram, bifurcation_diagram
from powered_walker_env.poincare.branches.special_points import SpecialKind, SpecialPoint
from powered_walker_env.poincare.branches.starts import stable_gait
from powered_walker_env.poincare.energy.contact import ContactReport, contact_of, contact_report
from powered_walker_env.poincare.energy.energetics import (
    Costs,
    at_equal_gait,
    comparison,
    costs,
    family_costs,
)
from powered_walker_env.poincare.energy.least_cost import ideal_push, least_cost
from powered_walker_env.poincare.gaits import Gait, GaitNotFoundError, find_gait
from powered_walker_env.poincare.maps import MapPoint, Policy, StrideMap
from powered_walker_env.poincare.regions.basins import Basin, basin
from powered_walker_env.poincare.regions.slices import (
    SLICES,
    Slice,
    schwab_wisse_slice,
    slice_through,
)
from powered_walker_env.poincare.regions.viability import Viability, viable_states
from powered_walker_env.poincare.regions.volumes import BasinVolume, basin_volume
from powered_walker_env.poincare.regulator import Regulator, regulate
from powered_walker_env.poincare.search import find_gait_with, find_gaits
from powered_walker_env.poincare.stability.lyapunov import LyapunovExponent, lyapunov_exponent
from powered_walker_env.poincare.stability.robustness import GaitSensitivity, gait_sensitivity
from powered_walker_env.poincare.stability.transitions import TransitionTimes, transition_times
from powered_walker_env.poincare.work.pieces import LostWorkersError, run_chains, run_pieces
from powered_walker_env.simulation.derivatives import PARAMETERS

__all__ = [
    "PARAMETERS",
    "SLICES",
    "Basin",
    "BasinVolume",
    "BifurcationDiagram",
    "Boundary",
    "Branch",
    "Cascade",
    "ContactReport",
    "Costs",
    "CurveEnd",
    "EndReason",
    "Gait",
    "GaitNotFoundError",
    "GaitSensitivity",
    "LostWorkersError",
    "LyapunovExponent",
    "MapPoint",
    "Policy",
    "Regulator",
    "Slice",
    "SpecialKind",
    "SpecialPoint",
    "StrideMap",
    "TransitionTimes",
    "Viability",
    "at_equal_gait",
    "basin",
    "basin_volume",
    "bifurcation_diagram",
    "comparison",
    "contact_of",
    "contact_report",
    "continue_boundary",
    "continue_gait",
    "costs",
    "doubling_cascade",
    "family_costs",
    "find_gait",
    "find_gait_with",
    "find_gaits",
    "gait_sensitivity",
    "ideal_push",
    "least_cost",
    "lyapunov_exponent",
    "regulate",
    "run_chains",
    "run_pieces",
    "schwab_wisse_slice",
    "slice_through",
    "stability_boundaries",
    "stable_gait",
    "switch_branch",
    "transition_times",
    "viable_states",
]
