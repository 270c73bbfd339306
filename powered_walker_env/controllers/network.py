"""A policy network without a learning library: numbers, saved as numpy's `.npz`.

Observations pass through layers of one activation; the last layer is linear, and its answer
is clipped to the range of the actions or bent into it by tanh. It calculates in double
precision and knows its own derivative, so that the laboratory can take it as it is
(`policy_of`). A file of it holds arrays and one JSON text: nothing in it can run.
"""

from __future__ import annotations

import json
import os
import zipfile
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from powered_walker_env.files import written_aside
from powered_walker_env.simulation.strides import Array

#: By the names of torch's modules: the function, and its derivative by its argument.
ACTIVATIONS: dict[str, tuple[Callable[[Array], Array], Callable[[Array], Array]]] = {
    "Tanh": (np.tanh, lambda x: 1.0 - np.tanh(x) ** 2),
    "ReLU": (lambda x: np.maximum(x, 0.0), lambda x: (x > 0.0).astype(float)),
    "ELU": (
        lambda x: np.where(x > 0.0, x, np.expm1(np.minimum(x, 0.0))),
        lambda x: np.exp(np.minimum(x, 0.0)),
    ),
}
CLIP, TANH = "clip", "tanh"  # how an answer comes into the range of the actions


@dataclass(frozen=True, eq=False)
class Network:
    """Observations (N, 4) to actions (N, k).

    Raises:
        ValueError: layers that do not fit together or are not finite, an unknown activation.
    """

    layers: Sequence[tuple[Array, Array]]  # (out, in) weights and (out,) biases, from the input
    activation: str = "Tanh"  # of `ACTIVATIONS`
    squash: str = CLIP
    settings: Mapping[str, Any] = field(default_factory=dict)  # JSON-able; of its training

    def __post_init__(self) -> None:
        if self.activation not in ACTIVATIONS or self.squash not in (CLIP, TANH):
            raise ValueError(
                f"activation must be one of {', '.join(ACTIVATIONS)} and squash {CLIP!r} or "
                f"{TANH!r}, got {self.activation!r} and {self.squash!r}"
            )
        if not _lead_from(4, self.layers):
            shapes = ", ".join(str(np.shape(weights)) for weights, _ in self.layers) or "none"
            raise ValueError(
                "layers must lead from 4 observations to the actions with finite weights, got "
                f"the shapes {shapes}"
            )

    @property
    def actions(self) -> int:
        """k, how many numbers it decides."""
        return len(self.layers[-1][1])

    def predict(self, observation: Any, *_: Any, deterministic: bool = True) -> tuple[Array, None]:
        """The actions, in their range."""
        answer = self._forward(np.asarray(observation, np.float64))[-1]
        return (np.tanh(answer) if self.squash == TANH else np.clip(answer, -1.0, 1.0)), None

    def derivative(self, observations: Any) -> Array:
        """(N, k, 4) of the actions by the observations (clipping left out)."""
        *hidden, answer = self._forward(np.asarray(observations, np.float64))
        slope = ACTIVATIONS[self.activation][1]
        found: Array = np.broadcast_to(np.eye(4), (len(answer), 4, 4))
        for (weights, _), values in zip(self.layers, hidden, strict=False):
            found = slope(values)[:, :, np.newaxis] * (weights @ found)
        found = self.layers[-1][0] @ found
        bent = (1.0 - np.tanh(answer) ** 2)[:, :, np.newaxis]
        return found * bent if self.squash == TANH else found

    def _forward(self, values: Array) -> list[Array]:
        """What comes out of every layer, before its activation."""
        function, out = ACTIVATIONS[self.activation][0], []
        for weights, biases in self.layers:
            out.append(values @ weights.T + biases)
            values = function(out[-1])
        return out


def _lead_from(width: int, layers: Sequence[tuple[Array, Array]]) -> bool:
    """Whether layers fit together, and their numbers are finite."""
    for weights, biases in layers:
        if weights.shape != (*biases.shape, width) or biases.ndim != 1:
            return False
        if not (np.isfinite(weights).all() and np.isfinite(biases).all()):
            return False
        width = len(biases)
    return len(layers) > 0


def save_network(network: Network, path: str | os.PathLike[str], *, single: bool = False) -> None:
    """Write a network, complete or not at all.

    Args:
        single: in single precision, half the size: nothing is lost of what was trained so.
    """
    kind = np.float32 if single else np.float64
    about = {"activation": network.activation, "squash": network.squash}
    text = json.dumps({**about, "settings": dict(network.settings)}, allow_nan=False)
    arrays: dict[str, Any] = {"network": np.array(text)}
    for k, (weights, biases) in enumerate(network.layers):
        arrays |= {f"weights_{k}": weights.astype(kind), f"biases_{k}": biases.astype(kind)}
    with written_aside(Path(path)) as aside:
        np.savez(aside, **arrays)


def load_network(path: str | os.PathLike[str]) -> Network:
    """The inverse of `save_network`. Nothing in the file is run.

    Raises:
        FileNotFoundError: no such file.
        ValueError: a file that is damaged, or no network from four observations.
    """
    if not Path(path).is_file():
        raise FileNotFoundError(f"there is no policy {str(path)!r}; train one with agents.train")
    try:
        with open(path, "rb") as file, np.load(file, allow_pickle=False) as content:
            about = json.loads(str(content["network"][()]))
            count = sum(name.startswith("weights_") for name in content.files)
            layers = [
                (content[f"weights_{k}"].astype(float), content[f"biases_{k}"].astype(float))
                for k in range(count)
            ]
        return Network(layers, about["activation"], about["squash"], about["settings"])
    except (
        zipfile.BadZipFile, zlib.error, AttributeError, EOFError, KeyError, OSError, TypeError,
        ValueError,
    ) as error:  # fmt: skip
        raise ValueError(f"{str(path)!r} is not a saved policy, or is damaged: {error}") from error
