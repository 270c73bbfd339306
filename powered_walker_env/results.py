"""Results saved and loaded: gaits, branches, basins, reports ... as self-describing .npz files.

A result is a frozen dataclass (or a named tuple) of numbers, strings, arrays, enums and
other such objects. Its file is numpy's own `.npz`: every array is an entry under its
dotted name (`states`, `gaits.0.multipliers`), so that `numpy.load` alone reads it, and
pandas or xarray take it from there; the entry `result` is one JSON text with everything
else (fields, walker, settings, versions). Chosen over netCDF-3, which knows neither
complex numbers nor booleans nor 64-bit integers: here what is loaded equals what was saved
bit for bit. No pickle: a file cannot run code.

    save_result(gait, "gait.npz", settings={"section": "switch"})
    gait = load_result("gait.npz")
    numpy.load("gait.npz")["jacobian"]
"""

from __future__ import annotations

import contextlib
import dataclasses
import enum
import functools
import importlib
import inspect
import json
import math
import os
import pkgutil
import platform
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from powered_walker_env.files import written_aside
from powered_walker_env.model.powering import SCHEMES

FORMAT = "powered-walker result"
REVISION = 1  # of the layout described above
DOCUMENT = "result"  # the entry that holds the JSON text
ROOMS = ("model", "simulation", "poincare")  # whose classes a file may name


@dataclasses.dataclass(frozen=True)
class UnsavedPolicy:
    """What stands in a loaded result for a policy, which is a program and was not saved."""

    description: str

    def __call__(self, states: Any, /) -> Any:
        """Refuse.

        Raises:
            ValueError: always; the message names the policy.
        """
        raise ValueError(
            f"the policy {self.description} was not saved with the result; "
            "load it from where it was made and compute again"
        )


def save_result(
    result: Any, path: str | os.PathLike[str], settings: Mapping[str, Any] | None = None
) -> Path:
    """Write a result; the file appears complete or not at all.

    Args:
        result: a dataclass or named tuple of this package.
        path: the file, by custom `.npz`.
        settings: what the result was asked for with (plain numbers, strings, lists).

    Raises:
        TypeError: a value that the format cannot hold, named.
        FileNotFoundError: the folder does not exist.
    """
    target = Path(path)
    if not target.parent.is_dir():
        raise FileNotFoundError(f"the folder {str(target.parent)!r} does not exist; make it first")
    arrays: dict[str, np.ndarray] = {}
    document = {
        "format": FORMAT,
        "revision": REVISION,
        "versions": versions(),
        "settings": _encode(dict(settings or {}), "settings", arrays),
        "result": _encode(result, "", arrays),
    }
    arrays[DOCUMENT] = np.array(json.dumps(document, allow_nan=False, ensure_ascii=False))
    with written_aside(target) as aside, aside.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)
    return target


def load_result(path: str | os.PathLike[str]) -> Any:
    """The result in a file, equal to the one saved (policies come back as `UnsavedPolicy`).

    Raises:
        FileNotFoundError: no such file.
        ValueError: not a result file, a damaged one, or one of a newer version; named.
    """
    document, arrays = _read(Path(path))
    with _named(path):
        return _decode(document["result"], arrays)


def result_info(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Type, settings and versions of a result file, without building the result.

    Raises:
        FileNotFoundError, ValueError: as `load_result`.
    """
    document, arrays = _read(Path(path))
    with _named(path):
        return {
            "type": document["result"].get("object"),
            "settings": _decode(document["settings"], arrays),
            "versions": document["versions"],
        }


def holds_result(path: str | os.PathLike[str]) -> bool:
    """Whether a file is a result's, as far as its entries say; False if it cannot be read."""
    try:
        with zipfile.ZipFile(path) as archive:
            return f"{DOCUMENT}.npy" in archive.namelist()
    except (OSError, zipfile.BadZipFile):
        return False


@functools.cache
def versions() -> dict[str, str]:
    """Versions of what computed a result."""
    names = ("powered-walker-env", "numpy", "numba", "scipy")
    return {**{name: version(name) for name in names}, "python": platform.python_version()}


@contextlib.contextmanager
def _named(path: str | os.PathLike[str]) -> Iterator[None]:
    """Turn whatever a damaged file causes into one ValueError that names the file."""
    try:
        yield
    except (
        KeyError, IndexError, TypeError, AttributeError, ValueError, EOFError, OSError,
        zipfile.BadZipFile, zlib.error,
    ) as error:  # fmt: skip
        reason = f"{type(error).__name__}: {error}"
        raise ValueError(
            f"{str(path)!r} is a damaged or foreign result file ({reason}); "
            "make it again with save_result"
        ) from error


def _read(path: Path) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    if not path.is_file():
        raise FileNotFoundError(f"there is no result file {str(path)!r}")
    with _named(path), path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
        arrays = {name: stored[name] for name in stored.files}
        document = json.loads(str(arrays[DOCUMENT][()]))
        if document["format"] != FORMAT:
            raise ValueError(f"its format is {document['format']!r}, not {FORMAT!r}")
        if document["revision"] > REVISION:
            raise ValueError(f"its layout {document['revision']} is newer than this package's")
    return document, arrays


@functools.cache
def _types() -> dict[str, Any]:
    """The classes that a file may name: those of the package's mechanics and studies."""
    packages = (importlib.import_module(f"powered_walker_env.{room}") for room in ROOMS)
    sources = (
        found.name
        for package in packages
        for found in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
    )
    known: dict[str, Any] = {"UnsavedPolicy": UnsavedPolicy}
    for source in sources:
        module = importlib.import_module(source)
        for name, found in inspect.getmembers(module, inspect.isclass):
            ours = found.__module__ == module.__name__
            if ours and (_is_record(found) or issubclass(found, enum.Enum)):
                known[name] = found
    return known


def _type_named(name: str) -> Any:
    """A class that a file may name, the controls of registered schemes included; or None."""
    controls = (each.control for each in SCHEMES.values() if each.control is not None)
    return _types().get(name) or {kind.__name__: kind for kind in controls}.get(name)


def _is_record(kind: type) -> bool:
    return dataclasses.is_dataclass(kind) or (issubclass(kind, tuple) and hasattr(kind, "_fields"))


def _fields(record: Any) -> tuple[str, ...]:
    if dataclasses.is_dataclass(record):
        return tuple(field.name for field in dataclasses.fields(record) if field.init)
    return tuple(record._fields)


def _encode(value: Any, name: str, arrays: dict[str, np.ndarray]) -> Any:
    """`value` as JSON; what JSON has no word for is an object that says what it is."""
    if value is None or type(value) in (str, bool, int):
        return value
    if type(value) is float:  # JSON's shortest form gives the same float back
        return value if math.isfinite(value) else {"float": repr(value)}
    if isinstance(value, np.ndarray | np.generic | complex):
        key = name or "value"
        arrays[key] = np.asarray(value)
        if arrays[key].dtype == object:
            raise TypeError(f"{key} must be an array of numbers or strings, got objects")
        kind = {np.ndarray: "array", complex: "complex"}.get(type(value), "scalar")
        return {kind: key}
    within = f"{name}." if name else ""
    if isinstance(value, Mapping):
        pairs = enumerate(value.items())
        return {"mapping": [[k, _encode(v, f"{within}{i}", arrays)] for i, (k, v) in pairs]}
    if isinstance(value, enum.Enum) or _is_record(type(value)):
        return _encode_object(value, within, arrays)
    if isinstance(value, list | tuple):
        items = [_encode(item, f"{within}{i}", arrays) for i, item in enumerate(value)]
        return items if isinstance(value, list) else {"tuple": items}
    if callable(value):
        return _encode_object(UnsavedPolicy(repr(value)), within, arrays)
    raise TypeError(f"{name or 'result'} cannot be saved: {value!r}")


def _encode_object(value: Any, within: str, arrays: dict[str, np.ndarray]) -> dict[str, Any]:
    kind = type(value)
    if _type_named(kind.__name__) is not kind:
        if callable(value):  # a policy that happens to be a dataclass
            return _encode_object(UnsavedPolicy(repr(value)), within, arrays)
        raise TypeError(
            f"{within or 'result'} cannot be saved: {kind.__name__} is not of this package"
        )
    if isinstance(value, enum.Enum):
        return {"enum": kind.__name__, "name": value.name}
    fields = {n: _encode(getattr(value, n), within + n, arrays) for n in _fields(value)}
    return {"object": kind.__name__, "fields": fields}


def _decode(value: Any, arrays: dict[str, np.ndarray]) -> Any:
    """The inverse of `_encode`."""
    if isinstance(value, list):
        return [_decode(item, arrays) for item in value]
    if not isinstance(value, dict):
        return value
    word, content = next(iter(value.items()))
    if word == "array":
        return arrays[content]
    if word == "scalar":
        return arrays[content][()]
    if word == "complex":
        return complex(arrays[content][()])
    if word == "float":
        return float(content)
    if word == "tuple":
        return tuple(_decode(item, arrays) for item in content)
    if word == "mapping":
        return {key: _decode(item, arrays) for key, item in content}
    kind = _type_named(content)
    if kind is None:
        raise KeyError(
            f"{content}: no type of this package, nor the control of a registered scheme"
        )
    if word == "enum":
        return kind[value["name"]]
    return kind(**{name: _decode(item, arrays) for name, item in value["fields"].items()})
