"""The stride map and what is asked of it (Camp 1997, section 7), by question:

- what is the map, and its derivative? `maps`; on which three numbers of the state does it live?
  `sections`; which tolerances hold everywhere? `tolerances`;
- which gaits are there? `gaits` (near a guess, by `fixed_points`), `search` (everywhere),
  `wanted` (of a given speed or step length);
- how do they change with a parameter? `families`, and the room `branches`: continuation,
  special points, cascades to chaos, boundaries in two parameters, ramps by brute force;
- how stable, beyond the multipliers? the room `stability`;
- disturbed at every step, how long does it walk, and how long could it? the room `stochastic`;
- from where are they reached, and from where could any controller reach them? the room
  `regions`, with the `regulator`;
- what does walking cost, what must it, and is the contact possible? the room `energy`;
- long studies in pieces: the room `work`.

A walker is asked under a constant control, none (passive), or a policy: a closed loop is a
map like any other.
"""

from powered_walker_env.model.powering import FunctionPolicy, Policy
from powered_walker_env.poincare.branches import (
    BifurcationDiagram,
    Boundary,
    Branch,
    Cascade,
    CurveEnd,
    EndReason,
    PathBranch,
    Ramp,
    SpecialKind,
    SpecialPoint,
    bifurcation_diagram,
    continue_boundary,
    continue_gait,
    continue_path,
    doubling_cascade,
    stability_boundaries,
    stable_gait,
    switch_branch,
)
from powered_walker_env.poincare.energy import (
    ContactReport,
    Costs,
    GroundForce,
    at_equal_gait,
    comparison,
    contact_of,
    contact_report,
    costs,
    family_costs,
    gait_at,
    ground_force,
    ideal_push,
    least_cost,
)
from powered_walker_env.poincare.gaits import Gait, GaitNotFoundError, find_gait
from powered_walker_env.poincare.maps import MapPoint, StrideMap
from powered_walker_env.poincare.regions import (
    SLICES,
    Basin,
    BasinVolume,
    Capture,
    Largest,
    Slice,
    Viability,
    basin,
    basin_volume,
    capture,
    largest_push,
    largest_step,
    schwab_wisse_slice,
    slice_through,
    viable_states,
)
from powered_walker_env.poincare.regulator import Regulator, regulate
from powered_walker_env.poincare.search import find_gaits
from powered_walker_env.poincare.sections import Section, section_of
from powered_walker_env.poincare.stability import (
    GaitSensitivity,
    LyapunovExponent,
    TransitionTimes,
    Trap,
    gait_sensitivity,
    lyapunov_exponent,
    transition_times,
    trap_around,
)
from powered_walker_env.poincare.stochastic import (
    FirstPassage,
    Grid,
    Law,
    Optimum,
    StepNoise,
    TablePolicy,
    Walks,
    disturbed_walks,
    first_passage,
    optimum,
    step_law,
)
from powered_walker_env.poincare.wanted import find_gait_with
from powered_walker_env.poincare.work import LostWorkersError, run_chains, run_pieces
from powered_walker_env.simulation.derivatives import PARAMETERS

__all__ = [
    "PARAMETERS",
    "SLICES",
    "Basin",
    "BasinVolume",
    "BifurcationDiagram",
    "Boundary",
    "Branch",
    "Capture",
    "Cascade",
    "ContactReport",
    "Costs",
    "CurveEnd",
    "EndReason",
    "FirstPassage",
    "FunctionPolicy",
    "Gait",
    "GaitNotFoundError",
    "GaitSensitivity",
    "Grid",
    "GroundForce",
    "Largest",
    "Law",
    "LostWorkersError",
    "LyapunovExponent",
    "MapPoint",
    "Optimum",
    "PathBranch",
    "Policy",
    "Ramp",
    "Regulator",
    "Section",
    "Slice",
    "SpecialKind",
    "SpecialPoint",
    "StepNoise",
    "StrideMap",
    "TablePolicy",
    "TransitionTimes",
    "Trap",
    "Viability",
    "Walks",
    "at_equal_gait",
    "basin",
    "basin_volume",
    "bifurcation_diagram",
    "capture",
    "comparison",
    "contact_of",
    "contact_report",
    "continue_boundary",
    "continue_gait",
    "continue_path",
    "costs",
    "disturbed_walks",
    "doubling_cascade",
    "family_costs",
    "find_gait",
    "find_gait_with",
    "find_gaits",
    "first_passage",
    "gait_at",
    "gait_sensitivity",
    "ground_force",
    "ideal_push",
    "largest_push",
    "largest_step",
    "least_cost",
    "lyapunov_exponent",
    "optimum",
    "regulate",
    "run_chains",
    "run_pieces",
    "schwab_wisse_slice",
    "section_of",
    "slice_through",
    "stability_boundaries",
    "stable_gait",
    "step_law",
    "switch_branch",
    "transition_times",
    "trap_around",
    "viable_states",
]
