"""Whatever happens to a command, it ends in one line and a status, never in a traceback."""

from __future__ import annotations

import argparse
import io
import os
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path

import pytest

from powered_walker_env.cli import main, walking
from powered_walker_env.cli.output import Report
from powered_walker_env.cli.running import FAULT, PIPE_CLOSED, USER_ERROR, run_command

CODE = "import sys; from powered_walker_env.cli import main; sys.exit(main())"
COMMANDS = ("walk", "gait", "presets", "branch", "bifurcation", "boundary", "basin", "energetics",
            "validate", "reproduce")  # fmt: skip
SILLY = [
    ["--json", "--nonsense"],
    ["--preset", "nobody"],
    ["--preset", ""],
    ["--scheme", "magic"],
    ["--out", ""],
    ["--out", "."],
    ["--out", ".."],
    ["--out", "/"],
    ["--out", "no/such/folder"],
    ["--out", "/proc/x"],
    ["--out", "/dev/null/x"],
    ["--out", "a" * 300],
    ["--out", "a\0b"],
    ["--set", "slope=nan"],
    ["--set", "leg_mass=inf"],
    ["--set", "leg_mass=-1"],
    ["--set", "physics="],
    ["--set", "=1"],
    ["--strides", "-1"],
    ["--strides", "1000000000000"],
    ["--strides", "1.5"],
    ["--points", "0"],
    ["--points", "-5", "-5"],
    ["--points", "100000000", "100000000"],
    ["--points", "10000000000000"],
    ["--keep", "100000000000"],
    ["--keep", "-1"],
    ["--transient", "-1"],
    ["--bounds", "nan", "nan"],
    ["--bounds", "-inf", "inf"],
    ["--bounds", "inf", "inf", "nan", "0"],
    ["--bounds", "-1e-3", "1e-3"],
    ["--push", "nan", "0"],
    ["--push", "inf", "-inf"],
    ["--push", "1e300", "1"],
    ["--push", "0"],
    ["--step", "nan"],
    ["--step", "-1"],
    ["--step", "1e308"],
    ["--period", "-3"],
    ["--period", "x"],
    ["--jobs", "0"],
    ["--jobs", "-2"],
    ["--address", "nowhere:1"],
    ["--stall-torque", "nan"],
    ["--switch-angle", "-1"],
    ["--impulse", "1"],
    ["--parameter", "physics"],
    ["--parameters", "slope", "slope"],
    ["--axes", "stance_angle", "stance_angle"],
    ["--component", "speed"],
    ["--animation", "walk.mpg"],
    ["--animation", "no/such/walk.gif"],
    ["--only", "nothing"],
    ["--α"],
    ["\udcff"],
]


WILD = ["foot_length=1e300", "leg_mass=1e308", "gravity=1e-300", "stall_torque=1e308"]


@pytest.mark.parametrize("command", COMMANDS)
def test_silly_arguments_end_in_words(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    for arguments in SILLY:
        if command == "reproduce" and arguments == ["--out", "no/such/folder"]:
            continue  # its folder is made, with those above it
        idle = ["--strides", "0"] if command == "walk" else []  # where it makes sense of them
        try:
            status = main([command, *arguments, *idle])
        except SystemExit as stopped:
            status = int(str(stopped.code))
        captured = capsys.readouterr()
        assert "Traceback" not in captured.out + captured.err
        assert status in (1, USER_ERROR), (arguments, captured)
        assert not captured.out
        assert captured.err.splitlines()[-1].startswith("powered-walker")
        assert not list(tmp_path.iterdir()), arguments


def test_a_fault_of_the_program_is_one_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def faulty(*_: object, **__: object) -> None:
        raise KeyError("gone")

    monkeypatch.setattr(walking, "walk", faulty)
    assert main(["walk"]) == FAULT
    error = capsys.readouterr().err
    assert error == (
        "powered-walker: this is a fault of the program, please report it: KeyError: 'gone'\n"
    )


def test_too_much_for_the_memory_is_one_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def greedy(*_: object, **__: object) -> None:
        raise MemoryError("Unable to allocate 1 EiB")

    monkeypatch.setattr(walking, "walk", greedy)
    assert main(["walk"]) == USER_ERROR
    assert "not enough memory: Unable to allocate 1 EiB; ask for less" in capsys.readouterr().err


def test_a_picture_that_fails_leaves_the_result(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object, **__: object) -> None:
        raise RuntimeError("latex could not be found")

    monkeypatch.setattr("powered_walker_env.pictures.charts.gait_figure", broken)
    assert main(["gait", "--out", str(tmp_path / "gait")]) == USER_ERROR
    assert [path.name for path in tmp_path.iterdir()] == ["gait.npz"]
    error = capsys.readouterr().err
    assert "gait.npz), but its picture failed: RuntimeError: latex could not be found" in error


def run(
    arguments: list[str], environment: Mapping[str, str] | None = None, stdout: int = -1
) -> subprocess.CompletedProcess[str]:
    """A command in a process of its own."""
    return subprocess.run(
        [sys.executable, "-c", CODE, *arguments],
        stdout=stdout,
        stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONUNBUFFERED": "", **(environment or {})},
        text=True,
        encoding="latin-1",
        check=False,
    )


@pytest.mark.parametrize("encoding", ["ascii", "cp1252", "latin-1", "cp437", "utf-8"])
def test_narrow_encodings_get_the_letters_spelled(
    encoding: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for command in (["gait"], ["presets"], ["validate", "--only", "wheel"]):
        said = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
        monkeypatch.setattr(sys, "stdout", said)
        assert main(command) == 0
        text = said.buffer.getvalue().decode(encoding)  # type: ignore[attr-defined]
        if command == ["gait"] and encoding in ("ascii", "cp1252", "latin-1"):
            assert "post-strike state (alpha, s, alpha', beta')" in text


def test_a_narrow_terminal_gets_no_traceback() -> None:
    done = run(["gait"], {"PYTHONIOENCODING": "ascii"})
    assert done.returncode == 0 and not done.stderr
    assert "(alpha, s, alpha', beta')" in done.stdout


@pytest.mark.parametrize("change", WILD)
def test_wild_numbers_end_in_words(change: str, capsys: pytest.CaptureFixture[str]) -> None:
    for command in ("gait", "walk"):
        status = main([command, "--set", change])
        captured = capsys.readouterr()
        assert "Traceback" not in captured.err and status in (0, 1, USER_ERROR)
        assert (status == 0) == (not captured.err)


def test_a_closed_pipe_is_no_news() -> None:
    for command in (["gait"], ["walk", "--help"]):
        reader, writer = os.pipe()
        os.close(reader)
        done = run(command, stdout=writer)
        os.close(writer)
        assert not done.stderr
        # argparse swallows the error where a help text is longer than the stream's buffer
        assert done.returncode in (PIPE_CLOSED, *([0] if "--help" in command else []))


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_is_said() -> None:
    for command in (["gait"], ["--help"]):
        with open("/dev/full", "w") as full:
            done = run(command, stdout=full.fileno())
        assert done.returncode == USER_ERROR
        assert done.stderr.startswith("powered-walker: the output cannot be written: ")
        assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("command", ["gait", "branch", "bifurcation", "boundary", "basin",
                                     "energetics", "validate", "walk"])  # fmt: skip
def test_a_folder_that_takes_no_files_is_found_out_before_the_work(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    worked: list[object] = []
    module = sys.modules[main.__module__]
    monkeypatch.setattr("powered_walker_env.files.tempfile.TemporaryFile", refuse)
    for family in ("studies", "regions", "costs", "published", "walking"):
        name = {"energetics": "_energetics"}.get(command, f"_{command}")
        monkeypatch.setattr(
            getattr(module, family), name, lambda _: worked.append(1) or Report("", {}),
            raising=False,
        )  # fmt: skip
    assert main([command, "--out", str(tmp_path / "x")]) == USER_ERROR
    assert "nothing can be written in the folder" in capsys.readouterr().err
    assert not worked


def test_a_stopped_reproduction_leaves_no_folder(tmp_path: Path) -> None:
    """Stopped while its figures are being written, after the studies."""
    saving = """
import sys, time
from powered_walker_env.cli import main
from powered_walker_env.literature import figures
from powered_walker_env.pictures import charts
def save(*_):
    print("saving", flush=True); time.sleep(60)
figures._studied = lambda *_: ({}, {"figure": None})
charts.save_drawing = save
sys.exit(main())
"""
    process = subprocess.Popen(
        [sys.executable, "-c", saving, "reproduce", "--out", str(tmp_path / "again")],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout is not None
    assert process.stdout.readline() == "saving\n"
    assert [file.name for file in tmp_path.iterdir()] == [".again.part"]
    process.terminate()
    _, error = process.communicate(timeout=60)
    assert process.returncode == 128 + signal.SIGTERM
    assert error.endswith("powered-walker: terminated\n")
    assert not [*tmp_path.iterdir()]


def test_a_second_signal_ends_everything_at_once() -> None:
    """The first is caught by code that will not stop."""
    stubborn = """
import signal, sys, time
from powered_walker_env.cli import walking, main
def walk(*_, **__):
    try:
        print("walking", flush=True); time.sleep(60)
    finally:
        print("cleaning", flush=True); time.sleep(60)
walking.walk = walk
main(["walk"])
"""
    process = subprocess.Popen(
        [sys.executable, "-c", stubborn], stdout=subprocess.PIPE, text=True
    )  # fmt: skip
    assert process.stdout is not None
    assert process.stdout.readline() == "walking\n"
    process.send_signal(signal.SIGINT)
    assert process.stdout.readline() == "cleaning\n"
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=30) == 128 + signal.SIGINT
    process.stdout.close()


def test_what_breaks_while_a_stopped_command_puts_away_is_the_stop(
    capsys: pytest.CaptureFixture[str],
) -> None:
    def command(_: argparse.Namespace) -> Report:
        try:
            os.kill(os.getpid(), signal.SIGTERM)
            time.sleep(10.0)
        finally:
            raise OSError("a worker was gone already")

    options = argparse.Namespace(out=None, overwrite=False, json=False)
    assert run_command(command, options) == 128 + signal.SIGTERM
    assert capsys.readouterr().err == "powered-walker: terminated\n"
