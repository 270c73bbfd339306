"""A nearly passive powered walker: hybrid dynamics, stride map, gaits and environments.

The map of the package, from the ground up:

- `params`, `phases`, `schemes`, `presets`: the walker, a stride as a list of phases (read
  `phases.py` first), the ways to power it, walkers with known gaits;
- `rimless_wheel`: the wheel that a walker with a massless swing leg is, in closed form;
- `physics`: swing, torques, ground, heel strike and push-off, equation by equation; and
  `lanes`, which let the same formulas move eight walkers at once;
- `integrator` and `dense`, `lockstep`, `events`, `resets`, `turns`, `record`,
  `sensitivity`, `kernel`: compiled strides and their derivatives;
- `stride`, `derivatives`, `trajectory`: one stride, many at once, many with their
  derivatives, a walk sampled in time;
- `poincare`: gaits as fixed points of the stride map, and all that is asked of them;
- `results`: what they answer, saved and loaded;
- `validation`: published values, and what comes out here;
- `envs`: the Gymnasium environments, registered when this package is imported;
- on demand, since they need more than the core: `rendering` and `animation` (pygame),
  `figures`, `plotting` and `reproduce` (matplotlib), `sb3` and `sb3_policies`
  (Stable-Baselines3), `torch` (the differentiable stride);
- `benchmark`: speed and accuracy beside other integrators, and what the machine allows;
- `cli`: the command `powered-walker`.
"""

from powered_walker_env.envs.disturbances import Disturbance
from powered_walker_env.envs.registration import ENVIRONMENTS, register_environments
from powered_walker_env.envs.vector import PoweredWalkerVectorEnv
from powered_walker_env.envs.walker import PoweredWalkerEnv
from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.powering import (
    SCHEMES,
    HipTorque,
    LateToeOff,
    Scheme,
    StoppedControl,
    ToeOff,
    ToeOffAtStrike,
)
from powered_walker_env.model.powering.motor import Control
from powered_walker_env.model.presets import PRESETS, Preset
from powered_walker_env.model.rimless_wheel import RimlessWheel
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare import (
    PARAMETERS,
    Basin,
    BasinVolume,
    BifurcationDiagram,
    Boundary,
    Branch,
    Cascade,
    ContactReport,
    CurveEnd,
    EndReason,
    Gait,
    GaitNotFoundError,
    GaitSensitivity,
    LostWorkersError,
    LyapunovExponent,
    MapPoint,
    Policy,
    Regulator,
    Slice,
    SpecialKind,
    SpecialPoint,
    StrideMap,
    TransitionTimes,
    Viability,
    basin,
    basin_volume,
    bifurcation_diagram,
    contact_of,
    contact_report,
    continue_boundary,
    continue_gait,
    doubling_cascade,
    find_gait,
    find_gait_with,
    find_gaits,
    gait_sensitivity,
    lyapunov_exponent,
    regulate,
    run_pieces,
    switch_branch,
    transition_times,
    viable_states,
)
from powered_walker_env.results import load_result, save_result
from powered_walker_env.simulation.derivatives import BatchDerivatives, differentiate_batch
from powered_walker_env.simulation.strides import Stride, StrideBatch, stride, stride_batch
from powered_walker_env.simulation.trajectory import Trajectory, walk

__version__ = "0.1.0"

__all__ = [
    "ENVIRONMENTS",
    "PARAMETERS",
    "PRESETS",
    "SCHEMES",
    "Basin",
    "BasinVolume",
    "BatchDerivatives",
    "BifurcationDiagram",
    "Boundary",
    "Branch",
    "Cascade",
    "ContactReport",
    "Control",
    "CurveEnd",
    "Disturbance",
    "EndReason",
    "Gait",
    "GaitNotFoundError",
    "GaitSensitivity",
    "HipTorque",
    "LateToeOff",
    "LostWorkersError",
    "LyapunovExponent",
    "MapPoint",
    "Outcome",
    "Policy",
    "PostStrikeState",
    "PoweredWalkerEnv",
    "PoweredWalkerVectorEnv",
    "Preset",
    "Regulator",
    "RimlessWheel",
    "Scheme",
    "Slice",
    "SpecialKind",
    "SpecialPoint",
    "StoppedControl",
    "Stride",
    "StrideBatch",
    "StrideMap",
    "ToeOff",
    "ToeOffAtStrike",
    "Trajectory",
    "TransitionTimes",
    "Viability",
    "WalkerParams",
    "__version__",
    "basin",
    "basin_volume",
    "bifurcation_diagram",
    "contact_of",
    "contact_report",
    "continue_boundary",
    "continue_gait",
    "differentiate_batch",
    "doubling_cascade",
    "find_gait",
    "find_gait_with",
    "find_gaits",
    "gait_sensitivity",
    "load_result",
    "lyapunov_exponent",
    "regulate",
    "run_pieces",
    "save_result",
    "stride",
    "stride_batch",
    "switch_branch",
    "transition_times",
    "viable_states",
    "walk",
]

register_environments()
