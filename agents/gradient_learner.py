"""The learner behind `agents.analytic_gradient`: walkers, walks remembered, and a policy.

Walks of the past are worth keeping: their pushes were as good as any, and the rare large ones
decide how long a walker survives. As long as the policy has not moved far from the one that
walked them, their first-order models tell what it would do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from agents.configuration import check_numbers
from agents.segments import Segment, segment_loss, walk_segment
from powered_walker_env.controllers import Network
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.model.powering import MOTOR

ALGO = "apg"
FAR = 7.0  # scaled deviation from which a walker starts anew: nothing there can be saved
CLIP = 1.0  # of the gradient's norm: the step map multiplies, and so does a walk of it
MOMENTA = (0.9, 0.99)  # of Adam; gradients of walks differ in size from one to the next


@dataclass(frozen=True)
class Settings:
    """What a training needs."""

    env_id: str
    seed: int = 0
    n_timesteps: int = 9760  # strides, every one of them differentiated
    n_envs: int = 16  # walkers
    n_steps: int = 5  # strides of a segment
    n_epochs: int = 10  # gradient steps after each segment of the walkers
    batch_size: int = 128  # walks of a gradient step
    buffer_size: int = 2000  # walks remembered
    trust: float = 0.3  # change of an action up to which a walk remembered counts
    learning_rate: float = 3e-3  # falls to 0 over the training
    hidden: int = 64  # units of the two layers
    input_gain: float = 1.0  # of the first layer at the start: large where deviations are small
    episode: int = 20  # strides after which a walker starts anew
    spread: float = 0.2  # of the starts about the gait, scaled
    push_factor: float = 1.4  # of the pushes in training: what fells a walker is rare without
    # The stance leg counts: it carries the walker, the swing leg comes out of a stride anew.
    state_cost: tuple[float, ...] = (1.0, 0.1, 1.0, 0.1)
    episodes: int = 50  # of an evaluation
    env_kwargs: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_numbers(self, seed=0)
        if self.n_timesteps < self.n_envs * self.n_steps:
            raise ValueError(
                f"n_timesteps must be at least n_envs times n_steps, {self.n_envs * self.n_steps}, "
                f"got {self.n_timesteps}"
            )
        costs = np.array(self.state_cost)
        numbers = costs.shape == (4,) and costs.dtype.kind in "if"
        if not (numbers and (costs >= 0).all() and 0 < costs.sum() < math.inf):
            raise ValueError(
                f"state_cost must be four numbers >= 0, not all 0, got {self.state_cost!r}"
            )


class GradientLearner:
    """Walkers, their policy, and the walks remembered.

    Raises:
        ValueError: disturbances other than pushes, or a gait of several strides.
    """

    def __init__(self, settings: Settings) -> None:
        task = task_of(settings.env_id, **settings.env_kwargs)
        others = [kind for kind, size in vars(task.disturbance).items() if size and kind != "push"]
        if others:
            raise ValueError(
                f"an analytic gradient knows pushes alone, got a disturbance of {others[0]}; "
                "train against pushes, or with agents.train"
            )
        if len(task.gait) != 1:
            raise ValueError(f"the gait must have one stride, got one of {len(task.gait)}")
        self.settings, self.task = settings, task
        if task.scheme is not MOTOR:
            raise ValueError(
                f"env must be one of the motor's, got scheme {task.scheme.name!r}: this learner "
                "takes the derivatives of its strides only"
            )
        self.strides = self.falls = 0
        self._rng = np.random.default_rng(settings.seed)
        self.policy = _new_policy(settings)
        self._optimizer = torch.optim.Adam(self.policy.parameters(), betas=MOMENTA)
        self._state_cost = torch.tensor(settings.state_cost, dtype=torch.float64)
        self._walks: list[Segment] = []
        self._age = torch.from_numpy(self._rng.integers(0, settings.episode, settings.n_envs))
        self._now = self._starts()

    @property
    def finished(self) -> bool:
        """Whether no further segment fits into the strides."""
        more = self.settings.n_envs * self.settings.n_steps
        return self.strides + more > self.settings.n_timesteps

    def update(self) -> float:
        """Walk on, then learn; the mean cost of a walk."""
        settings = self.settings
        pushes = self._pushes(settings.n_steps, settings.n_envs)
        walk = walk_segment(self.task, self.policy, self._now, pushes)
        self.strides += walk.strides
        self._remember(walk)
        self._go_on(walk)
        remembered = Segment(*(torch.cat(parts, 1) for parts in zip(*self._walks, strict=True)))
        left = max(0.0, 1.0 - self.strides / settings.n_timesteps)
        for group in self._optimizer.param_groups:
            group["lr"] = settings.learning_rate * max(left, 1e-3)
        losses = [self._descend(remembered) for _ in range(settings.n_epochs)]
        return float(np.mean(losses))

    def network(self) -> Network:
        """The policy as it is now."""
        layers = [
            (layer.weight.detach().numpy().copy(), layer.bias.detach().numpy().copy())
            for layer in self.policy
            if isinstance(layer, torch.nn.Linear)
        ]
        run = self.settings
        about = {"algo": "analytic gradient", "env_id": run.env_id, "seed": run.seed}
        return Network(layers, settings={**about, "steps": self.strides})

    def _descend(self, remembered: Segment) -> float:
        count = remembered.walking.shape[1]
        size = min(self.settings.batch_size, count)
        chosen = torch.from_numpy(self._rng.choice(count, size, replace=False))
        batch = Segment(*(column[:, chosen] for column in remembered))
        loss = segment_loss(self.policy, batch, self._state_cost, self.settings.trust)
        self._optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(self.policy.parameters(), CLIP)
        self._optimizer.step()
        return loss.item()

    def _remember(self, walk: Segment) -> None:
        kept = max(1, self.settings.buffer_size // self.settings.n_envs)
        self._walks = [*self._walks, walk][-kept:]

    def _go_on(self, walk: Segment) -> None:
        """Where the walkers are now; those that fell, or have walked for long, start anew."""
        fell, last = ~walk.walking[-1], walk.landed[-1]
        self.falls += int(fell.sum())
        self._age += self.settings.n_steps
        anew = fell | (self._age >= self.settings.episode) | (last.norm(dim=1) > FAR)
        self._now = torch.where(anew[:, None], self._starts(), last)
        self._age[anew] = 0

    def _starts(self) -> torch.Tensor:
        count = self.settings.n_envs
        around = self.settings.spread * self._rng.normal(size=(count, 4))
        return torch.from_numpy(around) + self._pushes(count)

    def _pushes(self, *shape: int) -> torch.Tensor:
        """(..., 4) the environment's pushes, on the two rates, scaled."""
        pushes: NDArray[np.float64] = np.zeros((*shape, 4))
        size = self.settings.push_factor * self.task.disturbance.push
        pushes[..., 2:] = size * self._rng.normal(size=(*shape, 2))
        return torch.from_numpy(pushes / self.task.scale)


def _new_policy(settings: Settings) -> torch.nn.Sequential:
    """A policy that begins as the open loop: its last layer is zero."""
    generator = torch.Generator().manual_seed(settings.seed)
    sizes = (4, settings.hidden, settings.hidden, 2)
    linear = [torch.nn.Linear(sizes[k], sizes[k + 1], dtype=torch.float64) for k in range(3)]
    for layer in linear:
        bound = layer.in_features**-0.5 if layer is not linear[-1] else 0.0
        for values in (layer.weight, layer.bias):
            torch.nn.init.uniform_(values, -bound, bound, generator=generator)
    with torch.no_grad():
        linear[0].weight *= settings.input_gain
    return torch.nn.Sequential(linear[0], torch.nn.Tanh(), linear[1], torch.nn.Tanh(), linear[2])
