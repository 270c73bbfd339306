"""What decides the control of a stride, and how well it does.

- `OpenLoop`, `LQR`: the baselines; a function or an SB3 model is a controller, too;
- `Network`: a policy as plain numbers, `save_network` and `load_network` without code;
- `Optimal`: the best that any controller can do, as a table; `find_optimum` makes one;
  `benchmark_score`: 0 is the open loop, 1 the optimum;
- `load_controller`: any of these by name or file;
- `evaluate`: strides survived on equal disturbances, `comparison_text` side by side;
- `policy_of`: a controller's closed loop as a policy of the stride map;
- `stable_baselines.double_precision` (import it on demand: needs torch): an SB3 model's
  actor as a `Network`.
"""

from powered_walker_env.controllers.comparison import comparison, comparison_text
from powered_walker_env.controllers.controller import Controller, FunctionController, OpenLoop
from powered_walker_env.controllers.evaluation import (
    EPISODE_SEED,
    Estimate,
    Evaluation,
    evaluate,
    mean_estimate,
    paired_difference,
    share_estimate,
)
from powered_walker_env.controllers.loading import load_controller
from powered_walker_env.controllers.lqr import LQR
from powered_walker_env.controllers.network import Network, load_network, save_network
from powered_walker_env.controllers.optimal import Optimal, find_optimum
from powered_walker_env.controllers.policies import TaskPolicy, policy_of
from powered_walker_env.controllers.scores import benchmark_score, normalised_score

__all__ = [
    "EPISODE_SEED",
    "LQR",
    "Controller",
    "Estimate",
    "Evaluation",
    "FunctionController",
    "Network",
    "OpenLoop",
    "Optimal",
    "TaskPolicy",
    "benchmark_score",
    "comparison",
    "comparison_text",
    "evaluate",
    "find_optimum",
    "load_controller",
    "load_network",
    "mean_estimate",
    "normalised_score",
    "paired_difference",
    "policy_of",
    "save_network",
    "share_estimate",
]
