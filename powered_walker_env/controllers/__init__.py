"""What decides the control of a stride, and how well it does.

- `OpenLoop`, `LQR`: the baselines; a function or an SB3 model is a controller, too;
- `TunedOpenLoop`, `OneNumber`, `FewNumbers`, `Deadbeat`, `LookAhead`: each as small as it can be,
  from no feedback to the exact map; `one_number_table`, `few_numbers_table`, `deadbeat_answer` and
  `tune_walker` say what was weighed;
- `Network`: a policy as plain numbers, `save_network` and `load_network` without code;
- `Optimal`: the best that any controller can do, as a table; `find_optimum` makes one;
  `benchmark_score`: 0 is the open loop, 1 the optimum;
- `shipped_policy`: trained policies that come with the package, `shipped_policies` what they score;
- `load_controller`: any of these by name or file;
- `evaluate`: strides survived on equal disturbances, `comparison_text` side by side;
- `policy_of`: a controller's closed loop as a policy of the stride map;
- `stable_baselines.double_precision` (import it on demand: needs torch): an SB3 model's
  actor as a `Network`.
"""

from powered_walker_env.controllers.comparison import comparison, comparison_text
from powered_walker_env.controllers.controller import Controller, FunctionController, OpenLoop
from powered_walker_env.controllers.deadbeat import Deadbeat, DeadbeatAnswer, deadbeat_answer
from powered_walker_env.controllers.estimates import (
    Estimate,
    mean_estimate,
    paired_difference,
    share_estimate,
)
from powered_walker_env.controllers.evaluation import EPISODE_SEED, Evaluation, evaluate
from powered_walker_env.controllers.few_numbers import (
    FewNumbers,
    FewNumbersLoop,
    few_numbers_table,
)
from powered_walker_env.controllers.linear import LinearFeedback
from powered_walker_env.controllers.loading import load_controller
from powered_walker_env.controllers.look_ahead import LookAhead
from powered_walker_env.controllers.lqr import LQR
from powered_walker_env.controllers.network import Network, load_network, save_network
from powered_walker_env.controllers.one_number import OneNumber, OneNumberLoop, one_number_table
from powered_walker_env.controllers.optimal import Optimal, find_optimum
from powered_walker_env.controllers.policies import TaskPolicy, policy_of
from powered_walker_env.controllers.scores import benchmark_score, normalised_score
from powered_walker_env.controllers.shipped import (
    shipped_learners,
    shipped_policies,
    shipped_policy,
)
from powered_walker_env.controllers.tuned_open_loop import (
    TunedControl,
    TunedOpenLoop,
    tune_control,
)
from powered_walker_env.controllers.tuned_walker import TunedWalker, tune_walker

__all__ = [
    "EPISODE_SEED",
    "LQR",
    "Controller",
    "Deadbeat",
    "DeadbeatAnswer",
    "Estimate",
    "Evaluation",
    "FewNumbers",
    "FewNumbersLoop",
    "FunctionController",
    "LinearFeedback",
    "LookAhead",
    "Network",
    "OneNumber",
    "OneNumberLoop",
    "OpenLoop",
    "Optimal",
    "TaskPolicy",
    "TunedControl",
    "TunedOpenLoop",
    "TunedWalker",
    "benchmark_score",
    "comparison",
    "comparison_text",
    "deadbeat_answer",
    "evaluate",
    "few_numbers_table",
    "find_optimum",
    "load_controller",
    "load_network",
    "mean_estimate",
    "normalised_score",
    "one_number_table",
    "paired_difference",
    "policy_of",
    "save_network",
    "share_estimate",
    "shipped_learners",
    "shipped_policies",
    "shipped_policy",
    "tune_control",
    "tune_walker",
]
