"""Machine code that is carried elsewhere: used where it fits, from places that nobody may write to,
and left alone where it does not."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Any

import numba
import pytest
from numba.core import codegen

from tests.compiled.toy import FORMULA, TOY, Toy, files


class Carried:
    """A folder of machine code made by one installation, for another that may only read it."""

    def __init__(self, toy: Toy, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.folder, self._monkeypatch = tmp_path / "image" / "kernels", monkeypatch
        made = tmp_path / "made"
        monkeypatch.setattr(numba.config, "CACHE_DIR", str(made))
        assert toy.run() == (6.0, False)
        shutil.copytree(made, self.folder)  # other dates, another path
        shutil.rmtree(made)
        elsewhere = tmp_path / "elsewhere"
        shutil.move(toy.root, elsewhere / TOY)
        toy.root = elsewhere / TOY
        for source in toy.root.rglob("*.py"):
            source.touch()
        monkeypatch.syspath_prepend(elsewhere)
        monkeypatch.setattr(numba.config, "CACHE_DIR", str(self.folder))
        self._write = tempfile.TemporaryFile
        monkeypatch.setattr(tempfile, "TemporaryFile", self._refuse)  # root may write anywhere
        self.before = self.listing()

    def _refuse(self, *, dir: Path) -> Any:
        if dir.is_relative_to(self.folder):
            raise PermissionError(13, "Permission denied")
        return self._write(dir=dir)

    def listing(self) -> list[tuple[Path, bytes]]:
        """What is in it."""
        return [(path, path.read_bytes()) for path in files(self.folder)]


@pytest.fixture
def carried(toy: Toy, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Carried:
    return Carried(toy, tmp_path, monkeypatch)


def test_it_is_used_by_another_installation(toy: Toy, carried: Carried) -> None:
    assert toy.run() == (6.0, True)
    assert carried.listing() == carried.before
    assert not files(toy.root)


def test_an_edited_package_compiles_anew_beside_itself(toy: Toy, carried: Carried) -> None:
    toy.write("model/formulas.py", FORMULA.format(5.0))
    assert toy.run() == (15.0, False)
    assert toy.run() == (15.0, True)
    assert carried.listing() == carried.before
    assert files(toy.root)


def test_another_processor_compiles_anew_beside_itself(
    toy: Toy, carried: Carried, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(codegen.JITCPUCodegen, "magic_tuple", lambda _: ("other", "kind", ""))
    capsys.readouterr()
    assert toy.run() == (6.0, False)
    assert capsys.readouterr().err.count("\n") == 1  # that it compiles, and nothing else
    assert toy.run() == (6.0, True)
    assert carried.listing() == carried.before
    assert files(toy.root)


def test_another_release_of_numba_compiles_anew_beside_itself(
    toy: Toy, carried: Carried, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(numba, "__version__", "0.0.1")
    assert toy.run() == (6.0, False)
    assert toy.run() == (6.0, True)
    assert carried.listing() == carried.before


@pytest.mark.parametrize("kind", [0, 1], ids=["code", "index"])
def test_a_damaged_file_is_passed_over(toy: Toy, carried: Carried, kind: int) -> None:
    damaged = files(carried.folder)[kind]
    damaged.write_bytes(damaged.read_bytes()[:100])
    assert toy.run() == (6.0, False)
    assert toy.run() == (6.0, True)
