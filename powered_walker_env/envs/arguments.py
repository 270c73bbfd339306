"""The arguments that say what an environment's task is: declared once, for all that pass them on.

A new argument is one field here, with its meaning, and its use in `setup.make_task`.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from powered_walker_env.envs.disturbances import Disturbance
from powered_walker_env.envs.rewards import Reward, path_of
from powered_walker_env.model.powering import AnyControl, scheme_of
from powered_walker_env.model.walker import WalkerParams


@dataclass(frozen=True, kw_only=True, eq=False)
class TaskArguments:
    """What `PoweredWalkerEnv`, `PoweredWalkerVectorEnv` and `PoweredWalkerVecEnv` take alike.

    Nothing is checked before `setup.make_task` puts them together.
    """

    preset: str | None = field(
        default=None,
        metadata={"meaning": "a powered one of `PRESETS`, by default `camp1997`; the ids set it"},
    )
    params: WalkerParams | Mapping[str, Any] | None = field(
        default=None, metadata={"meaning": "with `preset=None`: `WalkerParams`, or a dict"}
    )
    scheme: str | None = field(
        default=None, metadata={"meaning": "what powers it, by name; the preset's, or `motor`"}
    )
    control: AnyControl | Sequence[float] | None = field(
        default=None, metadata={"meaning": "nominal: the scheme's numbers, or an object"}
    )
    gait: Sequence[Any] | None = field(
        default=None, metadata={"meaning": "its post-strike state, or those of its cycle"}
    )
    action_range: Sequence[float] | None = field(
        default=None, metadata={"meaning": "what action 1 adds: rad, fraction of a strength"}
    )
    reward: str | Reward = field(
        default="deviation", metadata={"meaning": "a name, a function, or its path (see Rewards)"}
    )
    effort_weight: float = field(
        default=0.0, metadata={"meaning": "reward lost per unit of cost of transport"}
    )
    disturbance: str | Mapping[str, float] | Disturbance = field(
        default="light", metadata={"meaning": "a level, or standard deviations by kind"}
    )

    @classmethod
    def of(cls, arguments: Mapping[str, Any]) -> TaskArguments:
        """From keyword arguments.

        Raises:
            TypeError: an argument that does not exist, named with those that do.
        """
        known = [each.name for each in dataclasses.fields(cls)]
        unknown = [name for name in arguments if name not in known]
        if unknown:
            raise TypeError(
                # Python's own words: torchrl tries some arguments, and looks for them.
                f"unexpected keyword argument {unknown[0]!r}; the arguments of an environment are "
                f"{', '.join(known)}"
            )
        return cls(**arguments)

    def to_dict(self) -> dict[str, Any]:
        """Those that are not the default, as JSON can hold them.

        Raises:
            ValueError: an argument that JSON cannot hold, as a function that has no path.
            TypeError: a control that is none.
        """
        given = {
            each.name: _plain(getattr(self, each.name))
            for each in dataclasses.fields(self)
            if getattr(self, each.name) is not each.default
        }
        if dataclasses.is_dataclass(self.control):
            given["scheme"] = scheme_of(self.control).name
        try:
            json.dumps(given, allow_nan=False)
        except (TypeError, ValueError) as error:
            raise ValueError(f"arguments must be JSON, got {given!r}: {error}") from None
        return given


def _plain(value: Any) -> Any:
    """A value as JSON has it: numbers, names, lists and mappings."""
    if isinstance(value, WalkerParams):
        return value.to_dict()
    if isinstance(value, Disturbance):
        return dataclasses.asdict(value)
    if dataclasses.is_dataclass(value):
        return list(dataclasses.astuple(value))  # type: ignore[arg-type]
    if isinstance(value, Mapping):
        return {name: _plain(each) for name, each in value.items()}
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_plain(each) for each in value]
    return path_of(value) if callable(value) else value
