"""Files that are there whole or not at all."""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path


@contextlib.contextmanager
def written_aside(target: Path) -> Iterator[Path]:
    """A path beside `target` to write to; it replaces `target` if all goes well.

    Its suffix is that of the target, for writers that go by it.
    """
    aside = target.with_name(f".{target.stem}.{os.getpid()}.part{target.suffix}")
    try:
        yield aside
        with aside.open("rb+") as file:
            os.fsync(file.fileno())  # the content before the name, should the power fail
        os.replace(aside, target)
    finally:
        aside.unlink(missing_ok=True)


def write_text(target: Path, text: str) -> None:
    """Write a text file (UTF-8)."""
    with written_aside(target) as aside:
        aside.write_text(text, encoding="utf-8")


def check_writable(targets: Sequence[Path], overwrite: bool, name: str = "--out") -> None:
    """Find out before the work begins whether files can be put where they should go.

    Args:
        targets: all in one folder. overwrite: whether files that exist may be replaced.
        name: of the argument that asked for them, for the message.

    Raises:
        ValueError, FileNotFoundError, FileExistsError, OSError: they cannot, or must not; with
            the remedy.
    """
    if any("\0" in str(target) for target in targets):
        raise ValueError(f"the name of a file cannot hold a NUL character; choose another {name}")
    folder = targets[0].parent
    if not folder.is_dir():
        raise FileNotFoundError(f"the folder {str(folder)!r} does not exist; make it first")
    for target in targets:
        if target.is_dir():
            raise FileExistsError(f"{str(target)!r} is a folder; choose another {name}")
        if target.exists() and not overwrite:
            raise FileExistsError(
                f"{str(target)!r} exists already; choose another {name}, or --overwrite"
            )
    try:
        with tempfile.TemporaryFile(dir=folder) as trial:
            trial.write(b" " * 4096)  # a full disk makes a file, but holds nothing
    except OSError as error:
        raise OSError(
            f"nothing can be written in the folder {str(folder)!r} ({error.strerror}); "
            f"choose another {name}"
        ) from error


@contextlib.contextmanager
def folder_aside(target: Path) -> Iterator[Path]:
    """A new folder beside `target` to fill; it takes the place of `target` if all goes well."""
    aside = target.with_name(f".{target.name}.{os.getpid()}.part")
    before = target.with_name(f".{target.name}.{os.getpid()}.old")
    aside.mkdir()
    try:
        yield aside
        if target.exists():
            os.replace(target, before)
        os.replace(aside, target)
    finally:
        if before.exists() and not target.exists():
            os.replace(before, target)
        shutil.rmtree(before, ignore_errors=True)
        shutil.rmtree(aside, ignore_errors=True)
