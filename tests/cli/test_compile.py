"""`powered-walker compile`: a folder of machine code, whole or not at all, that others can use."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from powered_walker_env.cli import compiling, main

USE_EVERYTHING = """
import gymnasium as gym, numpy as np
from numba.core import event
from powered_walker_env import PRESETS, differentiate_batch, find_gait, stride, stride_batch, walk
params, control, state, _ = PRESETS["camp1997"]
with event.install_recorder("numba:compile") as recorder:
    stride(state, control, params)
    find_gait(params, control, state)
    walk(state, control, params, strides=1)
    stride_batch(np.tile(state, (300, 1)), control, [params] * 300)
    differentiate_batch([state], control, params)
    kinds = dict(push=0.01, ground=0.001, slope=0.001, torque=0.01, sensor=0.1, parameters=0.01)
    for disturbance in ("light", kinds):
        env = gym.make("powered_walker_env:PoweredWalker-v0", disturbance=disturbance)
        env.reset(seed=0)
        env.step(env.action_space.sample())
        envs = gym.make_vec(
            "powered_walker_env:PoweredWalker-v0", 300, "vector_entry_point",
            disturbance=disturbance, effort_weight=1,
        )
        envs.reset(seed=0)
        for _ in range(20):
            over = envs.step(envs.action_space.sample())[2]
        assert over.any()
assert not recorder.buffer, recorder.buffer
"""


def listing(folder: Path) -> dict[str, bytes]:
    """All files under a folder."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def test_the_folder_is_all_that_another_process_needs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "kernels"
    assert main(["compile", "--to", str(folder), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["environment"] == {"NUMBA_CACHE_DIR": str(folder)}
    assert [path.name for path in tmp_path.iterdir()] == ["kernels"]
    made = listing(folder)
    done = subprocess.run(
        [sys.executable, "-c", USE_EVERYTHING], capture_output=True, text=True, check=False,
        env={**os.environ, **told["environment"]},
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    assert listing(folder) == made
    # Once more: what is there is found, and stays.
    assert main(["compile", "--to", str(folder)]) == 0
    assert f"NUMBA_CACHE_DIR={folder}" in capsys.readouterr().out
    assert listing(folder) == made


@pytest.mark.parametrize("existing", [False, True])
@pytest.mark.parametrize("way", ["status", "signal"])
def test_what_fails_leaves_nothing_behind_and_says_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
    way: str, existing: bool,
) -> None:  # fmt: skip
    folder = tmp_path / "kernels"
    if existing:
        (folder / compiling.ROOM).mkdir(parents=True)
        (folder / compiling.ROOM / "old").write_text("precious")
    ending = {"status": "os._exit(7)", "signal": "os.kill(os.getpid(), signal.SIGILL)"}[way]
    half = "import os, signal; open(os.environ['NUMBA_CACHE_DIR'] + '/half', 'w'); " + ending
    monkeypatch.setattr(compiling, "COMPILE", half)
    assert main(["compile", "--to", str(folder), "--processor", "generic"]) == 2
    said = capsys.readouterr().err
    assert "could not be compiled" in said if way == "status" else "cannot run code for" in said
    assert "'generic'" in said
    assert listing(tmp_path) == ({f"kernels/{compiling.ROOM}/old": b"precious"} if existing else {})
    assert [path.name for path in tmp_path.iterdir()] == ["kernels"] * existing


def test_stopped_it_leaves_nothing_behind(tmp_path: Path) -> None:
    code = (
        "import sys, powered_walker_env.cli as cli; from powered_walker_env.cli import compiling;"
        "compiling.COMPILE = 'import os; print(os.getppid(), flush=True); import time; "
        "time.sleep(60)';"
        f"sys.exit(cli.main(['compile', '--to', {str(tmp_path / 'kernels')!r}]))"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE) as running:
        assert running.stdout is not None
        running.stdout.readline()  # it compiles
        running.send_signal(signal.SIGTERM)
        assert running.wait(60) == 128 + signal.SIGTERM
    assert not list(tmp_path.iterdir())


def test_silly_folders_and_processors_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("precious")
    for wrong, said in {
        tmp_path / "no" / "folder": "make it first",
        tmp_path / "file": "is a file; choose another --to",
        tmp_path: "must hold compiled kernels only, got 'file'",
        Path(".."): "--to must end in the folder's name",
    }.items():
        assert main(["compile", "--to", str(wrong)]) == 2
        assert said in capsys.readouterr().err
    assert main(["compile", "--processor", "a-fast-one"]) == 2
    assert "must be a name that LLVM knows" in capsys.readouterr().err
    assert listing(tmp_path) == {"file": b"precious"}
