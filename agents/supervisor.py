"""What happens between the rollouts of a training: evaluation, the best policy, checkpoints."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from stable_baselines3.common.callbacks import BaseCallback

from agents.configuration import Settings
from agents.resume import restore_draws, save_checkpoint, save_model
from agents.runs import CHECKPOINT, EVALUATIONS, History, evaluation_row, write_evaluations
from powered_walker_env.controllers import evaluate, save_network
from powered_walker_env.controllers.loading import BEST_MODEL, POLICY
from powered_walker_env.controllers.stable_baselines import double_precision


class Supervisor(BaseCallback):
    """Evaluates, keeps the best policy and a checkpoint, and stops when asked.

    It acts at the start of rollouts only, where a training can be cut and joined again
    exactly. (SB3's `EvalCallback` acts within them, writes its files in place, and measures
    returns on other disturbances every time.)

    Args:
        settings: of the run; its `n_timesteps` is where the training ends.
        folder: of the run.
        history: the evaluations of the run so far.
        draws: what a checkpoint has for `restore_draws`.
        stop_at: strides after which to stop with a checkpoint, before the end.
        quiet: print nothing.
    """

    def __init__(
        self,
        settings: Settings,
        folder: Path,
        history: History,
        draws: dict[str, Any] | None,
        stop_at: int | None,
        quiet: bool,
    ) -> None:
        super().__init__()
        self.settings, self.folder, self.history, self.quiet = settings, folder, history, quiet
        self.stop_at = settings.n_timesteps if stop_at is None else stop_at
        self.stop_requested = self.stopped = False
        self.saved_steps = 0  # of the checkpoint
        self._draws = draws

    def _on_rollout_start(self) -> None:
        if self._draws is not None:
            restore_draws(self.model, self._draws)
            self.saved_steps, self._draws = self.num_timesteps, None
        if self.stop_requested or self.num_timesteps >= self.stop_at:
            self._save_checkpoint()
            self.stopped = True
        elif not self.history or self._evaluation_is_due():
            self._evaluate()

    def _on_step(self) -> bool:
        return not self.stopped

    def _on_training_end(self) -> None:
        if not self.stopped and self.num_timesteps > self._last_evaluation():
            self._evaluate()

    def _evaluation_is_due(self) -> bool:
        """Whether it is time; the last one, soon after, is that of the end."""
        every, left = self.settings.every, self.settings.n_timesteps - self.num_timesteps
        return self.num_timesteps >= self._last_evaluation() + every and left > every // 2

    def _last_evaluation(self) -> int:
        return int(self.history[-1]["steps"]) if self.history else 0

    def _evaluate(self) -> None:
        """Evaluate, always on the same disturbances; keep the best so far; save a checkpoint."""
        run = self.settings
        result = evaluate(self.model, run.env_id, run.episodes, run.seeds[1], **run.env_kwargs)
        row = evaluation_row(self.num_timesteps, result)
        better = all(_merit(row) > _merit(other) for other in self.history)
        self.history.append(row)
        if better:
            self._save_best()
        write_evaluations(self.folder / EVALUATIONS, self.history)
        self._save_checkpoint()
        self.logger.record("eval/strides", result.mean_strides.mean)
        self.logger.record("eval/return", result.mean_return.mean)
        if not self.quiet:
            mark = "  (best so far)" if better else ""
            survived = f"{result.mean_strides.text()} strides of {result.limit}"
            print(f"{self.num_timesteps:>9,} steps: {survived}{mark}", flush=True)

    def _save_best(self) -> None:
        save_model(self.model, self.folder / BEST_MODEL)
        run = self.settings
        about = {"algo": run.algo.upper(), "env_id": run.env_id, "seed": run.seed}
        try:
            network = double_precision(self.model, {**about, "steps": self.num_timesteps})
        except TypeError:  # a policy with a memory, say: there is the model alone
            return
        save_network(network, self.folder / POLICY)

    def _save_checkpoint(self) -> None:
        save_checkpoint(self.model, self.folder / CHECKPOINT, self.history, self.settings)
        self.saved_steps = self.num_timesteps


def _merit(row: dict[str, Any]) -> tuple[float, float]:
    """What makes a policy the best: the return, as it is scored; among equals the strides."""
    return row["return"], row["strides"]
