"""Run folders: what a training writes, and where.

`runs/NAME/` holds `config.yml` (the settings, complete), `versions.json` (where the
results come from), `evaluations.csv`, the best policy as `policy.npz`, and of SB3's
trainings `best_model.zip` and `checkpoint.zip`. Every file is written aside, then renamed:
it is there complete or not at all.
"""

from __future__ import annotations

import contextlib
import csv
import importlib.metadata
import io
import json
import platform
import re
import shlex
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import yaml
from filelock import FileLock, Timeout

from powered_walker_env.controllers import Evaluation
from powered_walker_env.files import write_text
from powered_walker_env.results import versions

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

RUNS = Path("runs")
CONFIG, VERSIONS, EVALUATIONS = "config.yml", "versions.json", "evaluations.csv"
CHECKPOINT = "checkpoint.zip"
History = list[dict[str, Any]]


@contextlib.contextmanager
def alone(lock: Path, what: str) -> Iterator[None]:
    """Be the only one who does it, as long as the block runs.

    Args:
        lock: a file, made if it is not there.
        what: is going on, for the message: "a study is running in FOLDER".

    Raises:
        ValueError: another process holds the lock.
    """
    held = FileLock(lock)
    try:
        held.acquire(blocking=False)
    except Timeout:
        raise ValueError(f"{what} already; wait for it, or choose another place") from None
    try:
        yield
    finally:
        held.release()


def run_folder(name: str, runs: Path = RUNS) -> Path:
    """The folder of a run.

    Raises:
        ValueError: a name that would not be one folder inside `runs`.
    """
    if not re.fullmatch(r"[A-Za-z0-9_][A-Za-z0-9_.-]*", name):
        raise ValueError(f"name must be letters, digits, '_', '-' and '.', got {name!r}")
    return runs / name


def create_run(folder: Path, settings: DataclassInstance, *, overwrite: bool = False) -> None:
    """Make the folder of a new run, with its configuration and versions.

    Raises:
        ValueError: it exists, and `overwrite` is false or it is no run; or it cannot be made.
    """
    config = config_text(settings)
    if folder.exists() and not overwrite:
        raise ValueError(
            f"{str(folder)!r} exists; choose another name, replace it by --overwrite, or, if "
            "agents.train made it, go on with it by agents.train --resume"
        )
    if folder.exists() and not (folder.is_dir() and _is_run(folder)):
        raise ValueError(f"{str(folder)!r} is no run, so --overwrite leaves it alone; move it away")
    aside = folder.with_name(f".{folder.name}.part")
    try:
        aside.mkdir(parents=True, exist_ok=True)
        write_text(aside / CONFIG, config)
        write_json(aside / VERSIONS, provenance())
        if folder.exists():
            shutil.rmtree(folder)
        aside.rename(folder)
    except OSError as error:
        raise ValueError(
            f"the run folder {str(folder)!r} cannot be made ({error.strerror}); choose another "
            "place"
        ) from error
    finally:
        shutil.rmtree(aside, ignore_errors=True)


def _is_run(folder: Path) -> bool:
    return not any(folder.iterdir()) or (folder / CONFIG).is_file()


def config_text(settings: DataclassInstance) -> str:
    """The settings as YAML.

    Raises:
        ValueError: a value that is no plain number, text, list or mapping.
    """
    try:
        return str(yaml.safe_dump(vars(settings), sort_keys=False))
    except yaml.YAMLError as error:
        raise ValueError(
            f"settings must be plain numbers, texts, lists and mappings, got {error.args[-1]!r}"
        ) from error


def write_json(target: Path, content: Any) -> None:
    """Write a JSON file: complete or not at all."""
    write_text(target, json.dumps(content, indent=2, allow_nan=False) + "\n")


def evaluation_row(steps: int, result: Evaluation) -> dict[str, Any]:
    """A row of `evaluations.csv`: means and intervals after so many strides of training."""
    row: dict[str, Any] = {"steps": steps}
    for name, found in (("strides", result.mean_strides), ("return", result.mean_return)):
        row |= {name: found.mean, f"{name}_low": found.low, f"{name}_high": found.high}
    return row


def write_evaluations(target: Path, history: Sequence[Mapping[str, Any]]) -> None:
    """The evaluations as CSV."""
    text = io.StringIO()
    table = csv.DictWriter(text, list(history[0]), lineterminator="\n")
    table.writeheader()
    table.writerows(history)
    write_text(target, text.getvalue())


def evaluate_command(folder: Path, env_id: str, env_kwargs: Mapping[str, Any]) -> str:
    """The command that evaluates a run where it was trained, ready to be pasted."""
    words = ["python", "-m", "agents.evaluate", "open-loop", "lqr", str(folder), "--env", env_id]
    pairs = [f"{name}:{json.dumps(value)}" for name, value in env_kwargs.items()]
    return shlex.join([*words, *(["--env-kwargs", *pairs] if pairs else [])])


def provenance() -> dict[str, Any]:
    """What a result depends on besides its settings; the commit, if it is a repository's."""
    known = versions() | {
        name: importlib.metadata.version(name)
        for name in ("gymnasium", "sb3-contrib", "stable-baselines3", "torch")
    }
    words = ["git", "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    commit = None
    with contextlib.suppress(OSError, subprocess.SubprocessError):
        done = subprocess.run(
            words, cwd=Path(__file__).parent, capture_output=True, text=True, timeout=10
        )
        commit = done.stdout.strip() or None
    return {
        "started": time.strftime("%Y-%m-%dT%H:%M:%S%z"),
        "command": [Path(sys.argv[0]).name, *sys.argv[1:]],
        "versions": known | {"system": f"{platform.system()} {platform.machine()}"},
        "git_commit": commit,
    }
