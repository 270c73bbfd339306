"""Commands that are killed: no process stays behind, and the same command goes on to the bit."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from powered_walker_env.cli import main
from powered_walker_env.poincare.regions import basins

STUDIES = {
    "basin": ("basin", "--preset", "compass", "--points", "160", "120", "--strides", "60"),
    "bifurcation": (
        "bifurcation", "--preset", "simplest", "--bounds", "0.016", "0.018", "--points", "48",
        "--transient", "300",
    ),
    "boundary": ("boundary", "--step", "0.1"),
}  # fmt: skip
PATIENCE = 120.0  # s, for a loaded machine; nothing is asserted of how long it takes
COMMAND = "import sys; from powered_walker_env.cli import main; sys.exit(main(sys.argv[1:]))"

pytestmark = pytest.mark.skipif(
    not Path("/proc/self/stat").exists(), reason="looks for child processes in /proc"
)


def begin(*arguments: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", COMMAND, *arguments], stderr=subprocess.PIPE, text=True
    )


def wait_until(holds: Callable[[], bool]) -> None:
    for _ in range(int(PATIENCE / 0.01)):
        if holds():
            return
        time.sleep(0.01)
    raise TimeoutError(holds)


def descendants(parent: int) -> set[int]:
    """Processes whose parents go back to this one."""
    children: dict[int, list[int]] = {}
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            words = (entry / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue  # it has ended
        children.setdefault(int(words[1]), []).append(int(entry.name))
    found, new = set[int](), {parent}
    while new:
        found |= new
        new = {child for one in new for child in children.get(one, [])}
    return found - {parent}


def gone(processes: set[int]) -> bool:
    def alive(number: int) -> bool:
        try:
            return ") Z " not in Path(f"/proc/{number}/stat").read_text()
        except OSError:
            return False

    return not any(map(alive, processes))


@pytest.mark.parametrize("name", STUDIES)
def test_a_killed_study_leaves_no_process_and_goes_on_to_the_bit(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "kept.unfinished"
    command = (*STUDIES[name], "--no-plot", "--overwrite", "--jobs", "2", "--out")

    def pieces() -> int:
        return len(list(folder.glob("[0-9]*.npz")))

    for number in (signal.SIGTERM, signal.SIGKILL):
        process, before = begin(*command, str(tmp_path / "kept")), pieces()
        wait_until(lambda before=before: pieces() > before)  # type: ignore[misc]
        workers = descendants(process.pid)
        assert workers
        process.send_signal(number)
        error = process.communicate(timeout=PATIENCE)[1]
        wait_until(lambda workers=workers: gone(workers))  # type: ignore[misc]
        assert pieces() > before
        if number == signal.SIGTERM:
            assert process.returncode == 128 + signal.SIGTERM
            assert error.endswith("; the same command goes on from here\n")
    assert main([*command, str(tmp_path / "kept")]) == 0
    assert not folder.exists()
    assert main([*command, str(tmp_path / "whole"), "--backend", "threading"]) == 0
    with np.load(tmp_path / "kept.npz") as kept, np.load(tmp_path / "whole.npz") as whole:
        assert kept.files == whole.files
        for entry in kept.files:
            if kept[entry].dtype.kind != "U":  # the document tells the settings, too
                np.testing.assert_array_equal(kept[entry], whole[entry])


def test_a_second_signal_ends_a_study_and_its_workers_at_once(tmp_path: Path) -> None:
    folder = tmp_path / "kept.unfinished"
    process = begin(*STUDIES["basin"], "--no-plot", "--jobs", "2", "--out", str(tmp_path / "kept"))
    wait_until(lambda: any(folder.glob("[0-9]*.npz")))
    workers = descendants(process.pid)
    process.send_signal(signal.SIGINT)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=PATIENCE)
    assert process.returncode == 128 + signal.SIGINT
    wait_until(lambda: gone(workers))


def test_the_pieces_of_the_basin_are_several() -> None:
    assert 8 * basins.ROWS < 160 * 120
