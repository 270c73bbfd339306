"""A nearly passive powered walker: hybrid dynamics, stride map, gaits and environments.

A walker is a list of phases over a chain of at most three moving links (`model`); a kernel walks
eight of them abreast from heel strike to heel strike with exact derivatives (`simulation`);
everything one can ask is asked of the stride map (`poincare`); an environment is that map with a
control to choose and something that disturbs it (`envs`), and `controllers` choose; pictures
(`pictures`), published numbers (`literature`) and the command line (`cli`) look on from above.
`compiled` is how formulas become machine code; `sb3` and `torch` are the doors to
Stable-Baselines3 and to gradients, imported on demand.

What one types in a day stands here; the rest comes from its room, and can be imported from
here, too.
"""

from typing import Any

from powered_walker_env import controllers, envs, model, poincare, results, simulation
from powered_walker_env.envs import (
    ENVIRONMENTS,
    Disturbance,
    PoweredWalkerEnv,
    PoweredWalkerVectorEnv,
    register_walker,
)
from powered_walker_env.envs.registration import register_environments
from powered_walker_env.model import PRESETS, Outcome, PostStrikeState, WalkerParams, powering
from powered_walker_env.model.powering import Control, HipTorque, ToeOff, register_scheme
from powered_walker_env.poincare import (
    Gait,
    GaitNotFoundError,
    basin,
    bifurcation_diagram,
    continue_gait,
    find_gait,
    find_gaits,
    regulate,
    switch_branch,
)
from powered_walker_env.results import load_result, save_result
from powered_walker_env.simulation import differentiate_batch, stride, stride_batch, walk

__version__ = "0.1.0"

__all__ = [
    "ENVIRONMENTS",
    "PRESETS",
    "Control",
    "Disturbance",
    "Gait",
    "GaitNotFoundError",
    "HipTorque",
    "Outcome",
    "PostStrikeState",
    "PoweredWalkerEnv",
    "PoweredWalkerVectorEnv",
    "ToeOff",
    "WalkerParams",
    "__version__",
    "basin",
    "bifurcation_diagram",
    "continue_gait",
    "differentiate_batch",
    "find_gait",
    "find_gaits",
    "load_result",
    "register_scheme",
    "register_walker",
    "regulate",
    "save_result",
    "stride",
    "stride_batch",
    "switch_branch",
    "walk",
]

_ROOMS = (model, powering, simulation, poincare, results, envs, controllers)


def __getattr__(name: str) -> Any:
    """A public name of one of the rooms."""
    for room in _ROOMS:
        if name in getattr(room, "__all__", ()):
            return getattr(room, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


register_environments()
