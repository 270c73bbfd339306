"""The wait for the first stride is announced: where the kernel is compiled, and only there."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
import threading
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from powered_walker_env.compiled import decorators as compilation
from powered_walker_env.simulation import kernel

LINE = compilation._Announcer.LINE
FIRST_STRIDE = """
    import threading
    from powered_walker_env import PRESETS, stride
    params, control, state, _ = PRESETS["camp1997"]
    print(stride(state, control, params).outcome.name)
    threads = [threading.Thread(target=stride, args=(state, control, params)) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
"""


def first_stride(cache: Path) -> tuple[str, str]:
    """What a new process with this cache writes to stdout and stderr."""
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(FIRST_STRIDE)],
        capture_output=True, text=True, check=True,
        env={**os.environ, "NUMBA_CACHE_DIR": str(cache)},
    )  # fmt: skip
    return done.stdout, done.stderr


def test_the_first_stride_says_that_it_compiles_and_the_next_process_s_does_not(
    tmp_path: Path,
) -> None:
    assert first_stride(tmp_path) == ("WALKED\n", LINE + "\n")
    assert first_stride(tmp_path) == ("WALKED\n", "")


def compiling(dispatcher: Any) -> Any:
    """Numba's word that it is about to compile."""
    return SimpleNamespace(data={"dispatcher": dispatcher})


def test_the_line_is_written_once_for_the_stride_kernel_alone(
    capsys: pytest.CaptureFixture[str],
) -> None:
    announcer = compilation._Announcer()
    announcer._watched.append(kernel.run_strides)
    announcer.on_start(compiling(compilation.kernel(lambda x: x)))
    assert capsys.readouterr() == ("", "")
    threads = [
        threading.Thread(target=announcer.on_start, args=(compiling(kernel.run_strides),))
        for _ in range(8)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert capsys.readouterr() == ("", LINE + "\n")


def test_without_a_stderr_nothing_is_said(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    closed = (tmp_path / "closed").open("w")
    closed.close()
    for stream in (None, closed):
        announcer = compilation._Announcer()
        announcer._watched.append(kernel.run_strides)
        monkeypatch.setattr(sys, "stderr", stream)
        announcer.on_start(compiling(kernel.run_strides))


def test_the_package_s_stride_kernel_is_watched() -> None:
    assert compilation._announcer._watched == [kernel.run_strides]
