"""Policies as plain numbers: the same answers, exact derivatives, and files without code."""

from __future__ import annotations

import io
import itertools
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from powered_walker_env.controllers import Network, load_network, save_network
from powered_walker_env.controllers.network import ACTIVATIONS


def a_network(activation: str = "Tanh", squash: str = "clip", actions: int = 2) -> Network:
    rng = np.random.default_rng(0)
    sizes = (4, 7, 5, actions)
    layers = [
        (0.5 * rng.normal(size=(n, m)), 0.1 * rng.normal(size=n))
        for m, n in itertools.pairwise(sizes)
    ]
    return Network(layers, activation, squash, {"env_id": "Mine-v0", "seed": 3})


@pytest.mark.parametrize("squash", ["clip", "tanh"])
@pytest.mark.parametrize("activation", ACTIVATIONS)
def test_a_network_answers_as_torch_does(activation: str, squash: str) -> None:
    torch = pytest.importorskip("torch")
    network, modules = a_network(activation, squash), []
    for weights, biases in network.layers:
        linear = torch.nn.Linear(*weights.shape[::-1], dtype=torch.float64)
        linear.weight.data[:], linear.bias.data[:] = map(torch.from_numpy, (weights, biases))
        modules += [linear, getattr(torch.nn, activation)()]
    theirs = torch.nn.Sequential(*modules[:-1])
    bend = torch.tanh if squash == "tanh" else lambda x: x.clamp(-1, 1)
    x = np.random.default_rng(1).normal(size=(6, 4))
    given = torch.from_numpy(x)
    np.testing.assert_allclose(
        network.predict(x)[0], bend(theirs(given)).detach().numpy(), rtol=1e-12
    )
    inner = torch.tanh if squash == "tanh" else lambda x: x  # clipping is left out
    jacobian = torch.autograd.functional.jacobian(lambda v: inner(theirs(v)).sum(0), given)
    np.testing.assert_allclose(network.derivative(x), jacobian.permute(1, 0, 2), rtol=1e-10)


@pytest.mark.parametrize("actions", [1, 2, 3])
def test_what_is_saved_comes_back_bit_for_bit(actions: int, tmp_path: Path) -> None:
    network = a_network("ELU", "tanh", actions)
    save_network(network, tmp_path / "p.npz")
    again = load_network(tmp_path / "p.npz")
    for first, second in zip(network.layers, again.layers, strict=True):
        assert all(np.array_equal(a, b) for a, b in zip(first, second, strict=True))
    assert (again.activation, again.squash) == ("ELU", "tanh")
    assert again.settings == {"env_id": "Mine-v0", "seed": 3}
    assert again.actions == actions


def test_nothing_in_a_file_can_run(tmp_path: Path) -> None:
    save_network(a_network(), tmp_path / "p.npz")
    with zipfile.ZipFile(tmp_path / "p.npz") as archive:
        for name in archive.namelist():
            array = np.load(io.BytesIO(archive.read(name)), allow_pickle=False)
            assert array.dtype != object
    hostile: Any = {"weights_0": np.array([print], dtype=object), "network": np.array("{}")}
    np.savez(tmp_path / "bad.npz", **hostile)
    with pytest.raises(ValueError, match=r"bad\.npz' is not a saved policy, or is damaged"):
        load_network(tmp_path / "bad.npz")


def test_bad_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"there is no policy .*none\.npz"):
        load_network(tmp_path / "none.npz")
    save_network(a_network(), tmp_path / "good.npz")
    content, bad = (tmp_path / "good.npz").read_bytes(), tmp_path / "bad.npz"
    for damaged in (b"", b"no zip at all", content[: len(content) // 2], content[:-9]):
        bad.write_bytes(damaged)
        with pytest.raises(ValueError, match=r"bad\.npz' is not a saved policy, or is damaged"):
            load_network(bad)


@pytest.mark.parametrize(
    "layers",
    [
        [],
        [(np.ones((2, 3)), np.ones(2))],
        [(np.ones((2, 4)), np.ones(3))],
        [(np.ones((5, 4)), np.ones(5)), (np.ones((2, 4)), np.ones(2))],
        [(np.full((2, 4), np.nan), np.ones(2))],
    ],
)
def test_layers_that_lead_nowhere_are_refused(layers: list[Any]) -> None:
    with pytest.raises(ValueError, match="layers must lead from 4 observations to the actions"):
        Network(layers)


def test_another_activation_is_refused() -> None:
    with pytest.raises(ValueError, match="activation must be one of Tanh, ReLU, ELU"):
        Network(a_network().layers, "Sine")
