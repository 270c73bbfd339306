"""How rl-baselines3-zoo writes values in YAML: schedules, and literals that are not run."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from typing import Any

import torch

from powered_walker_env.controllers.stable_baselines import StrideMetric

_ACTIVATIONS = ("ReLU", "Tanh", "ELU", "LeakyReLU", "SiLU", "GELU")


def linear_schedule(key: str, text: str) -> Callable[[float], float]:
    """The zoo's `lin_1e-3`: from 1e-3 down to 0 over the training.

    Raises:
        ValueError: a text of another form.
    """
    kind, _, number = text.rpartition("_")
    try:
        initial = float(number)
    except ValueError:
        initial = math.nan
    if kind not in ("", "lin") or not 0 <= initial < math.inf:
        raise ValueError(f"{key} must be a number or like 'lin_1e-3', got {text!r}")
    if not kind:  # YAML takes 1e-3 for a text
        return lambda _: initial
    return lambda remaining: remaining * initial


def python_literal(key: str, text: str) -> dict[str, Any]:
    """The zoo's `"dict(net_arch=[64, 64], activation_fn=nn.ReLU)"`, read without running it.

    Raises:
        ValueError: anything but a dictionary of literals and activation functions.
    """
    try:
        value = _evaluate(ast.parse(text.strip(), mode="eval").body)
    except (SyntaxError, ValueError) as error:
        raise ValueError(
            f"{key} must be a dictionary of plain values, got {text!r}: {error}"
        ) from error
    if not isinstance(value, dict):
        raise ValueError(f"{key} must be a dictionary, got {text!r}")
    return value


def _evaluate(node: ast.expr) -> Any:
    """The value of a literal, in which `dict(...)`, `nn.NAME` and `StrideMetric` may stand."""
    match node:
        case ast.Call(func=ast.Name(id="dict"), args=[], keywords=keywords) if all(
            word.arg for word in keywords
        ):
            return {str(word.arg): _evaluate(word.value) for word in keywords}
        case ast.List(elts=elements):
            return [_evaluate(element) for element in elements]
        case ast.Name(id=StrideMetric.__name__):
            return StrideMetric
        case ast.Attribute(value=ast.Name(id="nn"), attr=name) if name in _ACTIVATIONS:
            return getattr(torch.nn, name)
    return ast.literal_eval(node)
