"""Trained policies as small files without code: of each learner at each id the median seed's.

They are saved in single precision, in which they were trained (all but those by gradients), and
evaluated as saved; what they scored is declared beside them, and tests hold them to it. The package
ships them (`controllers.shipped`).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from agents.runs import write_json
from agents.study.cells import LIGHT
from agents.study.records import DONE, RUNS, Record
from agents.study.summary import grouped
from powered_walker_env.controllers import (
    EPISODE_SEED,
    Evaluation,
    evaluate,
    load_network,
    save_network,
)
from powered_walker_env.controllers.loading import POLICY
from powered_walker_env.controllers.shipped import DECLARED, policy_name

MOST = 1_000_000  # bytes of all files together
FIRST = 20  # episodes that are declared one by one


def median_seed(group: Sequence[Record]) -> Record:
    """The run whose mean return is the median one; of an even number the lower middle."""
    order = sorted(group, key=lambda record: float(np.mean(record.get("episodes", "returns"))))
    return order[(len(order) - 1) // 2]


def export(records: Sequence[Record], study: Path, folder: Path, episodes: int) -> list[Path]:
    """Write the policies of a study; those of runs that left no network are left out.

    Args:
        study: its folder, with the runs.
        folder: where they go; made if it is not there.
        episodes: of the evaluation that is kept with each.

    Raises:
        ValueError: files larger than all together may be.
    """
    folder.mkdir(parents=True, exist_ok=True)
    written: dict[Path, dict[str, Any]] = {}
    for (env_id, level, learner), group in grouped(records).items():
        done = [record for record in group if record.status == DONE and record.training]
        if level != LIGHT or not done:
            continue
        record = median_seed(done)
        source = study / RUNS / record.cell.name / POLICY
        if not source.is_file():
            continue
        target = folder / policy_name(env_id, learner)
        network = load_network(source)
        save_network(network, target, single=True)
        # As it will be loaded: rounded.
        found = evaluate(load_network(target), env_id, episodes, EPISODE_SEED)
        written[target] = _about(record, found)
    if (size := sum(path.stat().st_size for path in written)) > MOST:
        raise ValueError(
            f"policies must be smaller than {MOST:,} bytes in all, got {size:,}; take smaller "
            "networks in configs/"
        )
    about = {path.name: written[path] for path in sorted(written)}
    write_json(folder / DECLARED, about)
    return list(written)


def _about(record: Record, found: Evaluation) -> dict[str, Any]:
    """What is declared of a policy: its training, and what it scores."""
    return {
        "env_id": record.cell.env_id,
        "learner": record.cell.controller,
        "seed": record.cell.seed,
        "trained_strides": record.training["strides"],
        "episodes": len(found.strides),
        "episode_seed": found.seed,
        "strides": list(found.mean_strides),
        "return": list(found.mean_return),
        "first": {
            "strides": found.strides[:FIRST].tolist(),
            "returns": np.round(found.returns[:FIRST], 4).tolist(),
        },
    }
