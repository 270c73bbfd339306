"""Pieces of walks with their exact derivatives, and what a policy would have made of them.

A segment is H strides of N walkers under a policy and pushes, with the derivatives A by the
state and B by the control of every stride. With another policy the same walkers, under the
same pushes, would to first order have landed at

    x' + A (x̂ − x) + B (π(x̂) − a),

x̂ being where they would have been by then. At the policy that walked the segment this has
the value and the gradient of the walk itself (backpropagation through `H` strides); near
it, it stands for strides that need not be walked. Observations and actions are those of
the environment: deviations from the gait over their scale, and fractions of the range.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray

from powered_walker_env.envs.contract import STRIDE_RTOL
from powered_walker_env.envs.task import Task
from powered_walker_env.simulation.derivatives import differentiate_batch

# Of the square by which an action exceeds its range: clipping has no gradient to bring it back.
OVERSHOOT_COST = 0.1


class Segment(NamedTuple):
    """H strides of N walkers; a walker that has fallen stays on the gait, and does not count."""

    observations: torch.Tensor  # (H, N, 4) before the strides
    actions: torch.Tensor  # (H, N, 2), clipped
    landed: torch.Tensor  # (H, N, 4) after heel strike and push
    by_state: torch.Tensor  # (H, N, 4, 4) of what is landed
    by_action: torch.Tensor  # (H, N, 4, 2)
    walking: torch.Tensor  # (H, N) bool: no fall up to and including this stride

    @property
    def strides(self) -> int:
        """How many were simulated: those of the fallen, too."""
        return self.walking.numel()


def walk_segment(
    task: Task, policy: torch.nn.Module, start: torch.Tensor, pushes: torch.Tensor
) -> Segment:
    """Walk from the observations `start` (N, 4), pushed (H, N, 4) after every heel strike."""
    scale, half_range = task.scale, task.half_range
    per_state, per_action = scale / scale[:, np.newaxis], half_range / scale[:, np.newaxis]
    walking, observation = torch.ones(len(start), dtype=torch.bool), start
    steps = []
    for push in pushes:
        with torch.no_grad():
            action = policy(observation).clamp(-1.0, 1.0)
        states = task.gait[0] + observation.numpy() * scale
        controls = task.nominal + action.numpy() * half_range
        found = differentiate_batch(states, controls, task.params, rtol=STRIDE_RTOL)
        walking = walking & torch.from_numpy(found.strides.walked)
        after = torch.from_numpy((found.strides.state - task.gait[0]) / scale) + push
        landed = torch.where(walking[:, None], after, 0.0)
        A, B = (
            torch.from_numpy(_without_nan(by * unit))
            for by, unit in ((found.by_state, per_state), (found.by_control, per_action))
        )
        steps.append((observation, action, landed, A, B, walking))
        observation = landed
    return Segment(*(torch.stack(column) for column in zip(*steps, strict=True)))


def segment_loss(
    policy: torch.nn.Module, segment: Segment, state_cost: torch.Tensor, trust: float
) -> torch.Tensor:
    """What the policy's strides of a segment cost, to first order, a walker in the mean.

    The cost of a stride is √(1 + Σ q x²) − 1: the squared deviation near the gait, the
    deviation itself far from it, where squares would drown all else. Walkers that fell, or
    whose actions have changed too much, drop out from there on.

    Args:
        state_cost: (4,) q.
        trust: change of an action, of 1, up to which a first-order walk counts.
    """
    total = torch.zeros((), dtype=torch.float64)
    observation = segment.observations[0]
    counted = torch.ones(len(observation), dtype=torch.bool)
    for before, chosen, landed, A, B, walking in zip(*segment, strict=True):
        wanted = policy(observation)
        action = wanted.clamp(-1.0, 1.0)
        change = action - chosen
        counted = counted & walking & (change.detach().abs().amax(1) < trust)
        moved = torch.einsum("nij,nj->ni", A, observation - before)
        moved = moved + torch.einsum("nij,nj->ni", B, change)
        observation = torch.where(counted[:, None], landed + moved, landed)
        cost = torch.sqrt(1.0 + (state_cost * observation**2).sum(1)) - 1.0
        cost = cost + OVERSHOOT_COST * ((wanted - action) ** 2).sum(1)
        total = total + torch.where(counted, cost, 0.0).mean()
    return total


def _without_nan(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Zero where a walker fell and has no derivatives."""
    return np.where(np.isfinite(values), values, 0.0)
