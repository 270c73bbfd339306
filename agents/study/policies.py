"""Trained policies as small files without code: of each learner at each id the median seed's.

They are saved in single precision, in which they were trained (all but those by gradients), and
evaluated as saved; what they scored stands in the file, and a test holds them to it.
"""

from __future__ import annotations

import json
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
    Network,
    evaluate,
    load_network,
    save_network,
)
from powered_walker_env.controllers.loading import POLICY

FOLDER = Path(__file__).parents[1] / "policies"
MOST = 1_000_000  # bytes of all files together
DECLARED = "policies.json"  # in the folder: the names of the files that are there


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
    written: list[Path] = []
    for (env_id, level, learner), group in grouped(records).items():
        done = [record for record in group if record.status == DONE and record.training]
        if level != LIGHT or not done:
            continue
        record = median_seed(done)
        source = study / RUNS / record.cell.name / POLICY
        if not source.is_file():
            continue
        target = folder / f"{env_id.removesuffix('-v0')}-{learner}.npz"
        network = load_network(source)
        # As saved, and as it will be loaded: the rounding first.
        save_network(network, target, single=True)
        saved = load_network(target)
        about = _about(record, network, evaluate(saved, env_id, episodes, EPISODE_SEED))
        save_network(Network(saved.layers, saved.activation, saved.squash, about), target,
                     single=True)  # fmt: skip
        written.append(target)
    if (size := sum(path.stat().st_size for path in written)) > MOST:
        raise ValueError(
            f"policies must be smaller than {MOST:,} bytes in all, got {size:,}; take smaller "
            "networks in configs/"
        )
    write_json(folder / DECLARED, sorted(path.name for path in written))
    return written


def shipped(folder: Path = FOLDER) -> list[str]:
    """The names of the policies that are declared to be there."""
    found: list[str] = json.loads((folder / DECLARED).read_text(encoding="utf-8"))
    return found


def _about(record: Record, network: Network, found: Evaluation) -> dict[str, Any]:
    """What is kept with a policy: of its training, and what it scores."""
    return {
        **network.settings,
        "learner": record.cell.controller,
        "trained_strides": record.training["strides"],
        "episodes": len(found.strides),
        "episode_seed": found.seed,
        "strides": list(found.mean_strides),
        "return": list(found.mean_return),
    }
