"""What happens between the rollouts of a training: evaluation, checkpoints, progress, stopping."""

from __future__ import annotations

import contextlib
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback
from tqdm import tqdm

from agents.evaluate import evaluate
from agents.runs import (
    BEST_MODEL,
    CHECKPOINT,
    EVALUATIONS,
    save_checkpoint,
    save_model,
    write_evaluations,
)
from agents.settings import Settings
from agents.statistics import mean_estimate

EVALUATION_SEED = 1_000_000  # plus the run's: apart from those of trainings and of evaluations
History = list[dict[str, Any]]


class Progress(BaseCallback):
    """Evaluates, keeps the best model and a checkpoint, shows progress, and stops when asked.

    It acts between rollouts only, where a training can be cut and joined again exactly.

    Args:
        settings: of the run; its `n_timesteps` is where the training ends.
        folder: of the run.
        history: the evaluations of the run so far.
        quiet: print nothing.
    """

    def __init__(
        self,
        settings: Settings,
        folder: Path,
        history: History,
        quiet: bool,
    ) -> None:
        super().__init__()
        self.settings, self.folder, self.history = settings, folder, history
        self.quiet = quiet
        self.stop_requested = False
        self.stopped = False
        self._bar: Any = None

    def _on_training_start(self) -> None:
        self._bar = tqdm(
            total=self.settings.n_timesteps,
            initial=self.num_timesteps,
            unit=" strides",
            unit_scale=True,
            disable=self.quiet or not sys.stderr.isatty(),
            leave=False,
        )

    def _on_rollout_start(self) -> None:
        self._bar.update(self.num_timesteps - self._bar.n)
        if self.stop_requested:
            self._save_checkpoint()
            self.stopped = True
        elif not self.history or self._evaluation_is_due():
            self._evaluate()

    def _on_step(self) -> bool:
        return not self.stopped

    def _on_training_end(self) -> None:
        if not self.stopped and self.num_timesteps > self._last_evaluation():
            self._evaluate()
        self._bar.close()

    def close(self) -> None:
        """Leave the terminal clean."""
        if self._bar is not None:
            self._bar.close()

    def _evaluation_is_due(self) -> bool:
        """Whether it is time; the last one, soon after, is that of the end."""
        every, left = self.settings.every, self.settings.n_timesteps - self.num_timesteps
        return self.num_timesteps >= self._last_evaluation() + every and left > every // 2

    def _last_evaluation(self) -> int:
        return int(self.history[-1]["steps"]) if self.history else 0

    def _evaluate(self) -> None:
        """Evaluate; keep the model if it is the best so far; save a checkpoint."""
        settings = self.settings
        result = evaluate(
            self.model,
            settings.env_id,
            settings.episodes,
            EVALUATION_SEED + settings.seed,
            **settings.env_kwargs,
        )
        strides, returns = mean_estimate(result.strides), mean_estimate(result.returns)
        best = max((row["return"] for row in self.history), default=-np.inf)
        row: dict[str, Any] = {"steps": self.num_timesteps}
        for name, estimate in (("strides", strides), ("return", returns)):
            row |= {name: estimate.mean, f"{name}_low": estimate.low, f"{name}_high": estimate.high}
        self.history.append(row)
        if returns.mean > best:
            save_model(self.model, self.folder / BEST_MODEL)
        write_evaluations(self.folder / EVALUATIONS, self.history)
        self._save_checkpoint()
        self.logger.record("eval/strides", strides.mean)
        self.logger.record("eval/return", returns.mean)
        self._say(
            f"{self.num_timesteps:>9,} steps: {strides.text()} strides of {result.limit}, "
            f"return {returns.mean:.1f}" + ("  (best so far)" if returns.mean > best else "")
        )

    def _save_checkpoint(self) -> None:
        save_checkpoint(self.model, self.folder / CHECKPOINT, self.history)

    def _say(self, text: str) -> None:
        if not self.quiet:
            tqdm.write(text)


@contextlib.contextmanager
def polite_stop(request: Callable[[], None]) -> Iterator[None]:
    """Ctrl-C (or SIGTERM) asks once, and interrupts the second time."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def handle(number: int, frame: FrameType | None) -> None:
        request()
        signal.signal(signal.SIGINT, signal.default_int_handler)
        print("\nstopping after this rollout; again to stop at once", file=sys.stderr)

    before = {number: signal.signal(number, handle) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
