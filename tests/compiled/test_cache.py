"""Machine code on disk: thrown away by an edit of what it was made from and by no other edit,
honest about where it lies, and never in the way.

A small package of its own stands in for the walker's (`toy.py`).
"""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numba
import pytest
from numba.core.caching import FunctionCache

from powered_walker_env import PRESETS, stride
from powered_walker_env.compiled import cache
from powered_walker_env.compiled.decorators import _Announcer
from powered_walker_env.simulation import kernel
from tests.compiled.toy import FORMULA, PACKAGE, TOY, Toy, files

LINE = _Announcer.LINE + "\n"


@pytest.mark.parametrize("chosen", [False, True], ids=["beside", "NUMBA_CACHE_DIR"])
def test_code_is_loaded_until_what_it_was_made_from_changes(
    toy: Toy, chosen: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    folder = tmp_path / "chosen"
    if chosen:
        monkeypatch.setattr(numba.config, "CACHE_DIR", str(folder))
    assert toy.run() == (6.0, False)
    assert capsys.readouterr().err == LINE  # it is said that it compiles
    assert toy.run() == (6.0, True)
    assert capsys.readouterr().err == ""  # and not that it does not
    toy.write("model/formulas.py", FORMULA.format(5.0))
    assert toy.run() == (15.0, False)
    toy.write("envs/task.py", "reward = 2.0\n")
    assert toy.run() == (15.0, True)
    toy.write("model/formulas.py", FORMULA.format(2.0))
    assert toy.run() == (6.0, True)  # the old folder is there still
    assert bool(files(folder)) == chosen
    assert bool(files(toy.root)) == (not chosen)
    assert (str(folder) if chosen else "") == numba.config.CACHE_DIR


def test_old_folders_are_cleared_away(toy: Toy) -> None:
    for factor in range(8):
        toy.write("model/formulas.py", FORMULA.format(float(factor)))
        assert toy.run() == (3.0 * factor, False)
    folders = list((toy.root / "__pycache__" / "kernels").iterdir())
    assert 1 < len(folders) < 8


@pytest.mark.parametrize("damage", [b"", b"no machine code", None], ids=["empty", "other", "cut"])
def test_a_damaged_file_is_thrown_away(
    toy: Toy, damage: bytes | None, capsys: pytest.CaptureFixture[str]
) -> None:
    assert toy.run() == (6.0, False)
    written = files(toy.root)
    assert len(written) == 2  # an index and the code
    for kind in range(len(written)):
        path = files(toy.root)[kind]
        whole = path.read_bytes()
        path.write_bytes(whole[: len(whole) // 2] if damage is None else damage)
        capsys.readouterr()
        assert toy.run() == (6.0, False)
        assert capsys.readouterr().err == LINE
        assert toy.run() == (6.0, True)


def test_beside_a_package_that_cannot_be_written_to_the_user_s_cache_serves(
    toy: Toy, tmp_path: Path
) -> None:
    toy.block()
    assert toy.run() == (6.0, False)
    assert toy.run() == (6.0, True)
    assert files(tmp_path / "user" / TOY)


@pytest.mark.parametrize("home", [True, False])
def test_where_nothing_can_be_written_kernels_are_compiled_and_a_line_says_so(
    toy: Toy, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str], home: bool,
) -> None:  # fmt: skip
    toy.block()
    if home:
        (tmp_path / "user").write_text("in the way")
    else:
        monkeypatch.delenv("XDG_CACHE_HOME")
        monkeypatch.delenv("LOCALAPPDATA", raising=False)
        monkeypatch.setattr(Path, "home", staticmethod(no_home))
    assert toy.run() == (6.0, False)
    said = capsys.readouterr().err
    assert said.count("\n") == 2
    assert "toy_walker: no folder can be written to" in said
    assert "set NUMBA_CACHE_DIR" in said


def no_home() -> Path:
    raise RuntimeError("Could not determine home directory.")


def test_a_disk_that_is_full_is_said_and_harms_nothing(
    toy: Toy, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(FunctionCache, "save_overload", full)
    assert toy.run() == (6.0, False)
    assert "were not saved: [Errno 28] No space left on device" in capsys.readouterr().err


def imported(path: Path) -> set[Path]:
    """The files of the package that a source imports anywhere in it, by its syntax tree."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"a relative import in {path}"
            names = [node.module or "", *(f"{node.module}.{alias.name}" for alias in node.names)]
        found |= {cache._file(name) for name in names if name.startswith(PACKAGE.name)}
    return found - {None}  # type: ignore[return-value]


def test_the_stride_kernel_s_hash_covers_all_that_it_is_made_from_and_no_room_above() -> None:
    needed = cache._needed(kernel.__name__)
    for path in needed:
        assert imported(path) <= needed, path
    rooms = {path.relative_to(PACKAGE).parts[0] for path in needed}
    assert rooms == {"compiled", "model", "simulation"}
    names = {path.name for path in needed}
    assert {"chain.py", "guards.py", "heel_strike.py", "arithmetic.py", "events.py"} <= names


def test_the_stride_kernel_is_not_compiled_again_in_a_new_process() -> None:
    params, control, state, _ = PRESETS["camp1997"]
    assert stride(state, control, params).outcome.name == "WALKED"  # now it is on the disk
    walk = "from powered_walker_env import *; p, c, s, _ = PRESETS['camp1997'];"
    assert process(f"{walk} print(stride(s, c, p).outcome.name)") == ("WALKED\n", "")


def test_without_a_compiler_it_is_said_at_once() -> None:
    walk = "from powered_walker_env import *; p, c, s, _ = PRESETS['camp1997']; stride(s, c, p)"
    _, said = process(walk, NUMBA_DISABLE_JIT="1")
    assert said.endswith(
        "RuntimeError: NUMBA_DISABLE_JIT is set: the kernels are made for machine code and do not "
        "run as Python; unset it (the formulas in powered_walker_env.model.mechanics do run as "
        "Python)\n"
    )
    formula = (
        "from powered_walker_env.model.mechanics.chain import pose_of;"
        "print(pose_of(0.0, 0.0, 0.0, 1.0, 1.0, 1.0).foot)"
    )
    assert process(formula, NUMBA_DISABLE_JIT="1") == ("(1+0j)\n", "")


def process(code: str, **variables: str) -> tuple[str, str]:
    """What a new Python writes to stdout and stderr."""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False,
        env={**os.environ, **variables},
    )  # fmt: skip
    return done.stdout, done.stderr
