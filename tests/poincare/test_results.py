"""Results on disk: what comes back is what was saved, and what is no result is refused."""

from __future__ import annotations

import dataclasses
import json
import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from powered_walker_env import PRESETS, Outcome, find_gait, stride, walk
from powered_walker_env.poincare.energy.contact import contact_of
from powered_walker_env.results import (
    UnsavedPolicy,
    load_result,
    result_info,
    save_result,
    versions,
)

THESIS = PRESETS["camp1997"]


def same(one: Any, other: Any) -> bool:
    """Equal in type and to the last bit, all the way down."""
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return (
            one.dtype == other.dtype
            and one.shape == other.shape
            and bytes_of(one) == bytes_of(other)
        )
    if dataclasses.is_dataclass(one):
        names = [field.name for field in dataclasses.fields(one)]
        return all(same(getattr(one, name), getattr(other, name)) for name in names)
    if isinstance(one, tuple | list):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, float) and math.isnan(one):
        return math.isnan(other)
    return bool(one == other)


def bytes_of(array: np.ndarray) -> bytes:
    return np.ascontiguousarray(array).tobytes()


@cache
def results() -> dict[str, Any]:
    gait = find_gait(THESIS.params, THESIS.control, THESIS.state)
    fall = walk((-1.0, 0.2, 0.0, 0.0), THESIS.control, THESIS.params, 2)
    return {
        "gait": gait,
        "contact": contact_of(gait),
        "stride": stride(THESIS.state, THESIS.control, THESIS.params),
        "fall": stride((-1.0, 0.2, 0.0, 0.0), THESIS.control, THESIS.params),
        "walk": walk(THESIS.state, THESIS.control, THESIS.params, 2),
        "walk that falls": fall,
        "preset": THESIS,
        "walker": THESIS.params,
        "state": THESIS.state,
    }


RESULTS = (
    "gait", "contact", "stride", "fall", "walk", "walk that falls", "preset", "walker", "state",
)  # fmt: skip


def test_all_results_are_tried() -> None:
    assert set(results()) == set(RESULTS)


@pytest.mark.parametrize("name", RESULTS)
def test_what_is_loaded_is_what_was_saved(name: str, tmp_path: Path) -> None:
    result = results()[name]
    path = save_result(result, tmp_path / "result.npz", settings={"name": name, "rtol": 1e-9})
    assert same(load_result(path), result)
    assert [file.name for file in tmp_path.iterdir()] == ["result.npz"]


ODDITIES = (
    {"a": 1, "b": [1.5, None, True]},
    (np.float64(0.1), np.int64(-3), np.bool_(True), np.complex128(1 - 2j)),
    1 + 2j,
    (math.inf, -math.inf, math.nan, -0.0, 5e-324, 0.1 + 0.2),
    [np.zeros((0, 4)), np.array(["α", "b"]), np.array([True, False]), np.array(1 + 1j)],
    np.array([np.nan, np.inf, -0.0]),
    np.arange(3, dtype=np.int8),
    np.asfortranarray(np.arange(6.0).reshape(2, 3)),
    ("α'", Outcome.FELL_FORWARD),
    2**70,
)


@pytest.mark.parametrize("value", ODDITIES, ids=repr)
def test_every_kind_of_value_survives(value: Any, tmp_path: Path) -> None:
    assert same(load_result(save_result(value, tmp_path / "value.npz")), value)


def test_numpy_alone_reads_the_arrays_and_the_rest_is_json(tmp_path: Path) -> None:
    gait = find_gait(THESIS.params, THESIS.control, THESIS.state)
    with np.load(save_result(gait, tmp_path / "gait.npz")) as stored:
        np.testing.assert_array_equal(stored["jacobian"], gait.jacobian)
        document = json.loads(str(stored["result"]))
    fields = document["result"]["fields"]
    assert fields["params"]["fields"]["leg_mass"] == gait.params.leg_mass
    assert fields["params"]["fields"]["physics"] == "conserving"


def test_settings_and_versions_are_inside(tmp_path: Path) -> None:
    settings = {"bounds": (690.0, 760.0), "seed": 1, "cold": math.inf}
    path = save_result(THESIS.params, tmp_path / "walker.npz", settings)
    info = result_info(path)
    assert info["type"] == "WalkerParams"
    assert info["settings"] == settings
    assert info["versions"] == versions()
    assert set(versions()) == {"powered-walker-env", "numpy", "numba", "scipy", "python"}


def test_a_policy_comes_back_as_its_name_and_says_so(tmp_path: Path) -> None:
    control = THESIS.control
    assert control is not None
    row = np.array([[control.switch_angle, control.stall_torque]])
    gait = find_gait(THESIS.params, lambda states: np.repeat(row, len(states), 0), THESIS.state)
    loaded = load_result(save_result(gait, tmp_path / "gait.npz"))
    assert isinstance(loaded.control.function, UnsavedPolicy)
    assert loaded.control.scheme == gait.control.scheme == "motor"
    assert "lambda" in loaded.control.function.description
    with pytest.raises(ValueError, match=r"the policy .*lambda.* was not saved"):
        loaded.control(np.zeros((1, 4)))
    assert same(loaded, dataclasses.replace(gait, control=loaded.control))


@pytest.mark.parametrize(
    "value",
    [object(), {1, 2}, np.array([None]), (Path("x"),)],
    ids=["object", "set", "array", "tuple"],
)
def test_what_cannot_be_saved_is_named_and_leaves_no_file(value: Any, tmp_path: Path) -> None:
    with pytest.raises(TypeError, match=r"cannot be saved|must be an array of numbers"):
        save_result(value, tmp_path / "x.npz")
    assert not list(tmp_path.iterdir())


def test_an_earlier_file_survives_a_failed_save(tmp_path: Path) -> None:
    path = save_result(THESIS.params, tmp_path / "x.npz")
    with pytest.raises(TypeError):
        save_result(object(), path)
    assert load_result(path) == THESIS.params


def rewritten(path: Path, change: Any) -> Path:
    """The file with its JSON changed by a function."""
    with np.load(path) as stored:
        arrays = {name: stored[name] for name in stored.files}
    document = json.loads(str(arrays["result"]))
    change(document)
    np.savez(path, **(arrays | {"result": np.array(json.dumps(document))}))
    return path


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.update(format="other"), "its format is 'other'"),
        (lambda d: d.update(revision=99), "newer than this package's"),
        (lambda d: d.pop("result"), "KeyError"),
        (lambda d: d["result"].update(object="Path"), "KeyError: 'Path: no type of this package"),
        (lambda d: d["result"]["fields"].update(leg_mass=-1.0), "leg_mass must be positive"),
        (lambda d: d["result"]["fields"].update(wheels=2), "wheels"),
        (lambda d: d["result"]["fields"].update(leg_mass={"array": "gone"}), "gone"),
    ],
)
def test_changed_files_are_refused_with_the_reason(
    change: Any, message: str, tmp_path: Path
) -> None:
    path = rewritten(save_result(THESIS.params, tmp_path / "x.npz"), change)
    with pytest.raises(ValueError, match=message) as refused:
        load_result(path)
    assert str(path) in str(refused.value)


def test_foreign_damaged_and_missing_files_are_refused(tmp_path: Path) -> None:
    whole = save_result(THESIS.params, tmp_path / "whole.npz").read_bytes()
    contents = {"text": b"hello", "empty": b"", "cut": whole[: len(whole) // 2]}
    for name, content in contents.items():
        path = tmp_path / f"{name}.npz"
        path.write_bytes(content)
        with pytest.raises(ValueError, match="damaged or foreign result file"):
            load_result(path)
    np.savez(tmp_path / "other.npz", x=np.zeros(3))
    np.save(tmp_path / "single.npy", np.zeros(3))
    for name in ("other.npz", "single.npy"):
        with pytest.raises(ValueError, match="damaged or foreign result file"):
            result_info(tmp_path / name)
    with pytest.raises(FileNotFoundError, match="no result file"):
        load_result(tmp_path / "none.npz")
    with pytest.raises(FileNotFoundError, match="does not exist; make it first"):
        save_result(THESIS.params, tmp_path / "nowhere" / "x.npz")
