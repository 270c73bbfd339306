"""Search good settings of a learner with Optuna: a section in rl-baselines3-zoo's format.

    python -m agents.tune --algo ppo --env PoweredWalker-v0 --trials 30 --out tuned.yml

A trial is one training (or several, `--repeats`), with its evaluations on the way: those that lag
behind the median of the trials before are broken off. Trainings and evaluations have the seeds
`study_seeds(1_000_000 + 1000 S + k)` for `--seed` S and repeat k; studies count from 0, and
evaluations have other seeds altogether. The same command goes on with a search that was stopped: it
chooses as if it had not been.
"""

from __future__ import annotations

import argparse
import contextlib
import shlex
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import torch
import yaml

from agents.command import (
    ROUND_FOOT,
    add_env_arguments,
    exit_status,
    natural_int,
    pairs,
    positive_int,
)  # fmt: skip
from agents.configuration import read_settings, study_seeds
from agents.runs import RUNS, alone, run_folder
from agents.search_space import SPACES, chosen
from agents.train import TORCH_THREADS
from agents.trials import FIRST_SEED, Search, optuna, score
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.files import check_writable, write_text

STARTUP = 8  # trials at random before the sampler learns, and before the pruner prunes
JOURNAL = "trials.log"
_DONE = (optuna.trial.TrialState.COMPLETE, optuna.trial.TrialState.PRUNED)


def search_on(search: Search, study: optuna.Study, trials: int) -> None:
    """Go on with a study until it has so many trials; each says how it went."""
    for broken in study.get_trials(states=(optuna.trial.TrialState.RUNNING,)):
        study.tell(broken.number, state=optuna.trial.TrialState.FAIL)
    run = search.settings
    if "present" not in study.user_attrs:
        study.set_user_attr("present", score(search, run.hyperparameters))
    print(f"present settings: {search.objective} {study.user_attrs['present']:.1f}", flush=True)

    def objective(trial: optuna.Trial) -> float:
        values = chosen(run.algo, trial, run.n_envs, run.hyperparameters)
        trial.set_user_attr("section", values)
        return score(search, values, trial)

    while (done := len(study.get_trials(states=_DONE))) < trials:
        began = time.monotonic()
        # Seeded by its number, not once: whoever goes on chooses as if there had been no stop.
        study.sampler = optuna.samplers.TPESampler(
            n_startup_trials=STARTUP, seed=study_seeds(FIRST_SEED + search.seed + done)[0]
        )
        study.optimize(objective, n_trials=1)
        last = study.get_trials(states=_DONE)[-1]
        pruned = last.state is optuna.trial.TrialState.PRUNED
        result = "broken off" if pruned else f"{search.objective} {last.value:.1f}"
        known = [each.value or 0.0 for each in study.get_trials(states=_DONE[:1])]
        best = f", best {max(known):.1f}" if known else ""
        print(f"trial {done + 1} of {trials}: {result}{best}, "
              f"{time.monotonic() - began:.0f} s", flush=True)  # fmt: skip


def _alone(storage: str) -> contextlib.AbstractContextManager[None]:
    """One process at a time goes on with a journal: each would break off the other's trial."""
    if "://" in storage:
        return contextlib.nullcontext()
    return alone(Path(f"{storage}.busy"), f"a search goes on in {storage!r}")


def open_study(search: Search, storage: str) -> optuna.Study:
    """The study in a storage, new or to go on with.

    Args:
        storage: a URL as Optuna takes it (`sqlite:///FILE`), or the path of a journal.

    Raises:
        ValueError: a storage that cannot be opened, or with a search of another kind.
    """
    about = yaml.safe_dump(asdict(search), sort_keys=False)
    try:
        where: Any = storage
        if "://" not in storage:
            Path(storage).parent.mkdir(parents=True, exist_ok=True)
            from optuna.storages.journal import JournalFileBackend

            backend = JournalFileBackend(storage)
            where = optuna.storages.JournalStorage(backend)
        study = optuna.create_study(
            storage=where,
            study_name="tune",
            direction="maximize",
            load_if_exists=True,
            pruner=optuna.pruners.MedianPruner(n_startup_trials=STARTUP, n_warmup_steps=1),
        )
    except Exception as error:  # of Optuna, of the file system, of SQLAlchemy and its drivers
        raise ValueError(f"the storage {storage!r} cannot be opened: {error}") from error
    if study.user_attrs.setdefault("search", about) != about:
        raise ValueError(
            f"the storage {storage!r} holds a search with other settings; give another --name or "
            f"--storage, or the settings it has: {' '.join(study.user_attrs['search'].split())}"
        )
    study.set_user_attr("search", about)
    return study


def section_text(search: Search, study: optuna.Study) -> str:
    """The best trial as a file for `--config`, with what it cost to find.

    Raises:
        ValueError: no trial came to its end.
    """
    complete = study.get_trials(states=_DONE[:1])
    if not complete:
        raise ValueError("no trial came to its end; go on with more --trials")
    run, best = search.settings, study.best_trial
    seconds = sum(each.duration.total_seconds() for each in study.trials if each.duration)
    kept: dict[str, Any] = {"n_envs": run.n_envs, "n_timesteps": run.n_timesteps}
    if run.env_kwargs:
        kept["env_kwargs"] = run.env_kwargs
    lines = yaml.safe_dump(
        {run.env_id.rpartition(":")[2]: {**kept, **best.user_attrs["section"]}}, sort_keys=False
    )
    count = len(study.get_trials(states=_DONE))
    return (
        f"# {run.algo}: {search.objective} {best.value:.1f}; with the settings before, "
        f"{study.user_attrs['present']:.1f}. The best of {count} trials ({len(complete)} to their\n"
        f"# end) of {search.repeats} x {run.n_timesteps} strides, {seconds / 60:.0f} minutes; "
        f"python -m agents.tune --seed {search.seed}\n{lines}"
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command."""
    options = parser().parse_args(arguments)
    settings = read_settings(
        options.algo, options.env, options.config, env_kwargs=pairs(options.env_kwargs),
        n_timesteps=options.steps, episodes=options.episodes,
    )  # fmt: skip
    task_of(settings.env_id, **settings.env_kwargs)  # says what is wrong with them
    check_writable([options.out], options.overwrite)
    search = Search(settings, options.seed, options.repeats, options.objective)
    name = (
        options.name or f"tune-{settings.algo}-{settings.env_id.rpartition(':')[2]}-{search.seed}"
    )
    storage = options.storage or str(run_folder(name, options.runs) / JOURNAL)
    torch.set_num_threads(TORCH_THREADS)
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    study = open_study(search, storage)
    print(
        f"{settings.algo} on {settings.env_id}, {options.trials} trials, in {storage}", flush=True
    )
    try:
        with _alone(storage):
            search_on(search, study, options.trials)
    except KeyboardInterrupt:
        command = shlex.join(["python", "-m", "agents.tune", *(arguments or sys.argv[1:])])
        raise KeyboardInterrupt(f"interrupted; go on: {command}") from None
    write_text(options.out, section_text(search, study))
    print(f"{options.out}: try it by agents.train --algo {settings.algo} --config {options.out}")


def parser() -> argparse.ArgumentParser:
    """The command line."""
    result = argparse.ArgumentParser(
        prog="python -m agents.tune",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    result.add_argument("--algo", choices=SPACES, default="ppo", help="(default: %(default)s)")
    add_env_arguments(result, default=ROUND_FOOT)
    result.add_argument(
        "--objective", choices=("return", "strides"), default="return",
        help="of an episode; what is to be greatest (default: %(default)s)",
    )  # fmt: skip
    result.add_argument("--trials", type=positive_int, default=30, help="(default: %(default)s)")
    result.add_argument("--seed", type=natural_int, default=0, help="(default: %(default)s)")
    result.add_argument("--out", type=Path, required=True, metavar="FILE", help="of the winner")
    result.add_argument("--overwrite", action="store_true", help="replace FILE if it exists")
    result.add_argument(
        "--config", type=Path, metavar="FILE", help="where to begin (default: configs/ALGO.yml)"
    )
    result.add_argument(
        "--steps", type=positive_int, help="strides of a training (default: those of the file)"
    )
    for name, value, what in (("repeats", 1, "trainings of a trial"),
                              ("episodes", 200, "of an evaluation")):  # fmt: skip
        result.add_argument(
            f"--{name}", type=positive_int, default=value, help=f"{what} (default: {value})"
        )
    result.add_argument("--name", help="of the folder (default: tune-ALGO-ENV-SEED)")
    result.add_argument("--runs", type=Path, default=RUNS, help="where runs go (default: runs)")
    result.add_argument(
        "--storage", metavar="URL", help=f"sqlite:///FILE, or a journal (default: {JOURNAL})"
    )
    return result


if __name__ == "__main__":
    sys.exit(exit_status(main))
