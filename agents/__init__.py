"""Scripts that use the package as any user would: train, evaluate, and the quickstart.

- `quickstart`: the main job, end to end;
- `train`: any algorithm of Stable-Baselines3 from a configuration file, under `runs/NAME/`;
- `analytic_gradient`: a policy by the exact gradients of the stride map, from few strides;
- `evolution`: a policy by an evolution strategy, from many;
- `learning_curves`: a picture of several trainings of one environment;
- `evaluate`: controllers and saved policies on equal disturbances;
- `study`: the control study, every number of it by one command;
- `severity`: how hard the disturbances are;
- `tune_lqr`: weights for the linear-quadratic regulator, the baseline.

A training is told by `configuration` (what it needs, read as `zoo` writes it), `train`,
`supervisor` (what happens between rollouts), `runs` (its folder) and `resume` (how it goes on
bit for bit). Learners that are not of SB3 share `own_training`; they are `gradient_learner`, with
`segments`, and `evolution_learner`.

Run them from the root of the repository, as `python -m agents.quickstart --help`.
"""

import importlib.util

_NEEDED = ("stable_baselines3", "sb3_contrib", "yaml", "rich", "tqdm", "matplotlib", "filelock",
           "cma")  # fmt: skip
_missing = [name for name in _NEEDED if importlib.util.find_spec(name) is None]
if _missing:
    raise ImportError(
        f"agents needs {', '.join(_missing)}, not installed; "
        'in the repository: pip install -e ".[train,render]"'
    )
