"""The wait for the first stride is announced once (that it is where a kernel is compiled, and not
where it is loaded: `test_cache.py`); formulas are Python to Python."""

from __future__ import annotations

import gc
import sys
import threading
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numba
import pytest

from powered_walker_env.compiled import decorators as compilation
from powered_walker_env.simulation import kernel

LINE = compilation._Announcer.LINE


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


def test_a_formula_is_plain_python_to_python_and_machine_code_in_a_kernel() -> None:
    seen: list[float] = []

    @compilation.formula
    def double(x):  # type: ignore[no-untyped-def]
        return x + x

    @compilation.formula
    def noted(x):  # type: ignore[no-untyped-def]
        seen.append(x)  # which no machine code could do
        return double(x)

    assert noted(2.0) == 4.0
    assert noted("ab") == "abab"
    assert seen == [2.0, "ab"]
    assert not double.signatures  # nothing was compiled

    @numba.njit
    def inside(x):  # type: ignore[no-untyped-def]
        return double(x)

    assert inside(2.0) == 4.0
    assert double.signatures


def test_the_garbage_collector_rests_while_a_slow_kernel_is_compiled_and_no_longer() -> None:
    before, seen = gc.get_threshold(), []
    collector = compilation._Collector()
    collector._watched.append(kernel.run_strides)
    for compiled in (compilation.kernel(lambda x: x), kernel.run_strides):
        collector.on_start(compiling(compiled))
        seen.append(gc.get_threshold())
        collector.on_end(compiling(compiled))
        assert gc.get_threshold() == before
    assert seen == [before, collector.SELDOM]
