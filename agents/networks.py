"""A small policy network without a learning library: numbers, saved as numpy's `.npz`.

Observations pass through layers of tanh; the last layer is linear and its answer clipped to
the range of the actions. It calculates in double precision and knows its own derivative,
so that the laboratory can take it as it is (`envs.policies.policy_of`).
"""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.command import UserError
from powered_walker_env.files import written_aside

Floats = NDArray[np.float64]
SUFFIX = ".npz"


@dataclass(frozen=True, eq=False)
class Network:
    """Observations (N, 4) to actions (N, 2), and where it was trained."""

    layers: Sequence[tuple[Floats, Floats]]  # (out, in) weights and (out,) biases, from the input
    env_id: str

    def predict(
        self,
        observation: Any,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[Floats, None]:
        """The actions, clipped to their range."""
        values = np.asarray(observation, np.float64)
        for weights, biases in self.layers[:-1]:
            values = np.tanh(values @ weights.T + biases)
        weights, biases = self.layers[-1]
        return np.clip(values @ weights.T + biases, -1.0, 1.0), None

    def derivative(self, observations: Any) -> Floats:
        """(N, 2, 4) of the actions before clipping by the observations."""
        values = np.asarray(observations, np.float64)
        found = np.eye(values.shape[1])[np.newaxis]
        for weights, biases in self.layers[:-1]:
            values = np.tanh(values @ weights.T + biases)
            found = (1.0 - values**2)[:, :, np.newaxis] * (weights @ found)
        return np.asarray(self.layers[-1][0] @ found, np.float64)


def save_network(network: Network, target: Path) -> None:
    """Write a network, complete or not at all."""
    arrays: dict[str, Any] = {"env_id": np.array(network.env_id)}
    for k, (weights, biases) in enumerate(network.layers):
        arrays |= {f"weights_{k}": weights, f"biases_{k}": biases}
    with written_aside(target) as aside:
        np.savez(aside, **arrays)


def load_network(path: Path) -> Network:
    """The inverse of `save_network`. Nothing in the file is run.

    Raises:
        UserError: a file that is missing, damaged, or no network of four observations and
            two actions.
    """
    if not path.is_file():
        raise UserError(
            f"there is no policy {str(path)!r}; train one with agents.analytic_gradient"
        )
    try:
        with np.load(path, allow_pickle=False) as content:
            names = [name for name in content.files if name.startswith("weights_")]
            layers = [
                (content[f"weights_{k}"].astype(float), content[f"biases_{k}"].astype(float))
                for k in range(len(names))
            ]
            env_id = str(content["env_id"])
    except (zipfile.BadZipFile, KeyError, ValueError, OSError, EOFError, TypeError) as error:
        raise UserError(f"{str(path)!r} is not a saved network, or is damaged: {error}") from error
    network = Network(layers, env_id)
    if not _fits(network):
        raise UserError(
            f"{str(path)!r} is no network of 4 observations and 2 actions with finite weights: its "
            f"layers have the shapes {', '.join(str(weights.shape) for weights, _ in layers)}"
        )
    return network


def _fits(network: Network) -> bool:
    """Whether the layers fit together, from 4 observations to 2 actions."""
    width = 4
    for weights, biases in network.layers:
        if weights.shape != (len(biases), width) or biases.ndim != 1:
            return False
        if not (np.isfinite(weights).all() and np.isfinite(biases).all()):
            return False
        width = len(biases)
    return width == 2 and len(network.layers) > 0
