"""Infos that are put together when somebody looks: dictionaries, whatever is done to them."""

from __future__ import annotations

import copy
import json
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from powered_walker_env.envs.on_demand import WalkerInfo, infos_of

COUNT = 3
COLUMNS = {
    "duration": np.array([1.0, 2.0, 3.0]),
    "outcome": np.arange(COUNT),
    "step_length": np.array([0.25, 0.5, 0.75]),
}
PLAIN = {"TimeLimit.truncated": False, "duration": 2.0, "outcome": 1, "step_length": 0.5}
NEW = {"duration": -1.0, "episode": {"r": 2.0}}


def lazy() -> dict[str, Any]:
    """The info of walker 1, at which nobody has looked."""
    made = infos_of(COLUMNS)[1]
    made["TimeLimit.truncated"] = False
    return made


def emptied(info: dict[str, Any]) -> Any:
    info.clear()
    return info, info.get("duration")


def without(info: dict[str, Any]) -> Any:
    del info["duration"]
    return info, info.get("duration"), "duration" in info


def joined(info: dict[str, Any]) -> Any:
    info |= NEW
    return info


def written(info: dict[str, Any]) -> Any:
    info["duration"] = 7.0
    return info, info["step_length"]


USES: dict[str, Callable[[dict[str, Any]], Any]] = {
    "item": lambda info: info["step_length"],
    "get": lambda info: (info.get("duration"), info.get("episode"), info.get("episode", 3)),
    "in": lambda info: ("duration" in info, "TimeLimit.truncated" in info, "episode" in info),
    "len": lambda info: (len(info), bool(info)),
    "iteration": lambda info: (set(info), set(info.keys()), sorted(info.items(), key=str)),
    "values": lambda info: sorted(info.values()),
    "reversed": lambda info: set(reversed(info)),
    "equal": lambda info: (info == PLAIN, info != PLAIN, info == PLAIN, info == lazy(), info == {}),
    "copy": lambda info: (info.copy(), type(info.copy())),
    "deepcopy": lambda info: (copy.deepcopy(info), copy.copy(info)),
    "pickle": lambda info: pickle.loads(pickle.dumps(info)),
    "dict": lambda info: (dict(info), {**info}, dict(**info)),
    "union": lambda info: (info | NEW, NEW | info),
    "update": lambda info: ({}.update(info), info.update(NEW), info),
    "updates others": lambda info: (other := dict(NEW)).update(info) or other,
    "ior": joined,
    "json": lambda info: json.loads(json.dumps(info)),
    "pop": lambda info: (info.pop("duration"), info.pop("episode", None), info),
    "setdefault": lambda info: (info.setdefault("duration", 9.0), info.setdefault("own", 1), info),
    "clear": emptied,
    "del": without,
    "set": written,
    "match": lambda info: matched(info),
}


def matched(info: dict[str, Any]) -> Any:
    match info:
        case {"duration": duration, "outcome": 1}:
            return duration
    return None


@pytest.mark.parametrize("use", USES.values(), ids=USES)
def test_it_is_a_dictionary_to_everybody(use: Callable[[dict[str, Any]], Any]) -> None:
    assert use(lazy()) == use(dict(PLAIN))


def test_it_tells_its_entries_and_names_what_it_lacks() -> None:
    assert isinstance(lazy(), dict)
    assert eval(repr(lazy())) == PLAIN
    for info in (lazy(), dict(PLAIN)):
        with pytest.raises(KeyError, match="episode"):
            info["episode"]
    filled = lazy()
    assert filled["duration"] == 2.0
    with pytest.raises(KeyError, match="episode"):
        filled["episode"]


def test_numbers_are_pythons_and_arrays_are_its_own() -> None:
    states = np.arange(6.0).reshape(COUNT, 2)
    info = WalkerInfo({"state": states, "outcome": np.arange(COUNT)}, 2)
    assert type(info["outcome"]) is int
    info["state"][:] = 0.0
    assert states[2].tolist() == [4.0, 5.0]


def test_who_looks_for_what_no_column_has_lets_it_be() -> None:
    info = WalkerInfo(COLUMNS, 0)
    assert info.get("episode") is info.get("is_success") is None
    assert dict.__len__(info) == 0
    assert info.get("duration") == 1.0
    assert dict.__len__(info) == len(COLUMNS)
