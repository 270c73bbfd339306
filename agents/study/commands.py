"""The command behind every row of the study, and the page that lists them."""

from __future__ import annotations

import shlex
from collections.abc import Iterable

from agents.own_learners import OWN_LEARNERS
from agents.study.budgets import FULL
from agents.study.cells import LIGHT, Cell, cells

HEAD = """\
# Agents

Scripts that use the package as any user would. From the root of the repository, with
`pip install -e ".[train,render]"`:

- `python -m agents.quickstart` trains, compares and draws, in a minute;
- `python -m agents.study` makes every number of the control study on two cores, in two hours at
  most, and goes on where it was stopped (`--small` tries the same code in half a minute;
  `docs/benchmark.md`);
- the others say what they do with `--help`.

Trained policies come with the package, in `powered_walker_env/controllers/trained/`: of each
learner at each environment the seed with the median return, as numpy's `.npz` in single
precision; `policies.json` has their scores. Nothing in them runs when they are loaded; SB3's own
`.zip` are pickles, which do. They are controllers by the names of their learners:

```sh
python -m agents.evaluate open-loop lqr ppo optimal --env ID
```

`powered_walker_env.controllers.sb3_models.sb3_model(network, env)` makes a model of
Stable-Baselines3 of one, to go on with.

## The command of every row

One cell of the study each. A training leaves its policy in `runs/NAME/`, which `agents.evaluate`
takes as a controller; learners have the seeds 0 to 4, of which 0 is shown.

"""


def command_of(cell: Cell) -> str:
    """What one types to have a cell by itself: its evaluation, or its training."""
    kwargs = [f"{name}:{value}" for name, value in cell.env_kwargs.items()]
    if not cell.learns:
        words = ["python", "-m", "agents.evaluate", cell.controller, "--env", cell.env_id]
        words += [] if cell.level == LIGHT else ["--disturbance", cell.level]
        return shlex.join([*words, "--episodes", str(FULL.episodes)])
    own = OWN_LEARNERS.get(cell.controller)
    words = ["python", "-m", f"agents.{own.module if own else 'train'}"]
    words += [] if own else ["--algo", cell.algo]
    if cell.config:
        words += ["--config", f"configs/{cell.config}"]
    words += ["--env", cell.env_id, *(["--env-kwargs", *kwargs] if kwargs else [])]
    return shlex.join([*words, "--seed", str(cell.seed), "--name", cell.name])


def page() -> str:
    """`agents/README.md`."""
    first = [cell for cell in cells(FULL) if cell.seed == 0]
    return HEAD + "".join(_sections(first))


def _sections(every: Iterable[Cell]) -> Iterable[str]:
    listed = list(every)
    for env_id, level in dict.fromkeys((cell.env_id, cell.level) for cell in listed):
        some = [cell for cell in listed if (cell.env_id, cell.level) == (env_id, level)]
        rows = "".join(f"| {cell.controller} | `{command_of(cell)}` |\n" for cell in some)
        yield f"### {env_id}, {level}\n\n| row | command |\n| --- | --- |\n{rows}\n"
