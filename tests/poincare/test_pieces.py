"""Pieces of work give the same results wherever they run, whatever dies on the way."""

from __future__ import annotations

import functools
import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest

from powered_walker_env import PRESETS
from powered_walker_env.poincare import StrideMap
from powered_walker_env.poincare.work.pieces import (
    LostWorkersError,
    blocks,
    run_chains,
    run_pieces,
)
from powered_walker_env.simulation import threads
from tests.helpers.derivation import Array

PARAMS, CONTROL, STATE, _ = PRESETS["round-foot"]
STARTS = np.random.default_rng(1).normal(STATE, 0.01, (24, 4))


def walk_piece(rows: slice) -> Array:
    return StrideMap(PARAMS, CONTROL, 1e-9)(STARTS[rows], 3)


def die_once(piece: tuple[Path, int]) -> int:
    """Kill this worker process, the first time piece 3 is tried."""
    flag, number = piece
    if number == 3 and not flag.exists():
        flag.touch()
        time.sleep(0.2)
        os.kill(os.getpid(), signal.SIGKILL)
    return number * number


def die(piece: int) -> int:
    os.kill(os.getpid(), signal.SIGKILL)
    return piece


def fail_at_two(piece: int) -> int:
    if piece == 2:
        raise ArithmeticError("two")
    return piece


def count_calls(piece: tuple[Path, int]) -> int:
    folder, number = piece
    (folder / f"{number}-{time.monotonic_ns()}").touch()
    if number == 4 and not (folder / "go").exists():
        raise KeyboardInterrupt
    return number


@pytest.mark.parametrize("backend", ["loky", "threading"])
def test_results_are_in_order_and_the_same_for_any_backend(backend: str) -> None:
    parts = blocks(len(STARTS), 5)
    assert [part.stop for part in parts] == [5, 10, 15, 20, 24]
    seen: list[tuple[int, int, float]] = []
    found = run_pieces(
        walk_piece, parts, backend=backend, jobs=2, progress=lambda *news: seen.append(news)
    )
    np.testing.assert_array_equal(np.concatenate(found), walk_piece(slice(None)))
    assert [news[:2] for news in seen] == [(k, 5) for k in range(1, 6)]
    assert seen[-1][2] == 0.0 and all(news[2] >= 0 for news in seen)


def test_pieces_of_a_worker_that_died_are_tried_again(tmp_path: Path) -> None:
    pieces = [(tmp_path / "died", number) for number in range(6)]
    assert run_pieces(die_once, pieces, jobs=2) == [k * k for k in range(6)]
    assert (tmp_path / "died").exists()


def test_pieces_that_kill_every_worker_end_with_a_reason() -> None:
    with pytest.raises(LostWorkersError, match="workers died 2 times, 0 of 1 pieces"):
        run_pieces(die, [0], jobs=2, retries=1)


@pytest.mark.parametrize("backend", ["loky", "threading"])
def test_an_error_of_the_function_comes_out_as_it_is_and_names_the_piece(backend: str) -> None:
    with pytest.raises(ArithmeticError, match="two") as caught:
        run_pieces(fail_at_two, [0, 1, 2, 3], backend=backend, jobs=2)
    assert caught.value.__notes__ == ["in piece 2 of 4"]


def test_interrupted_work_is_resumed_and_other_work_refused(tmp_path: Path) -> None:
    calls, kept = tmp_path / "calls", tmp_path / "kept"
    calls.mkdir()
    pieces = [(calls, number) for number in range(6)]
    with pytest.raises(KeyboardInterrupt):
        run_pieces(count_calls, pieces, backend="threading", jobs=1, checkpoint=kept)
    assert sorted(file.name for file in kept.glob("*.npz")) == [f"{k:06d}.npz" for k in range(4)]
    (calls / "go").touch()
    resumed = run_pieces(count_calls, pieces, backend="threading", jobs=1, checkpoint=kept)
    assert resumed == list(range(6))
    assert len(list(calls.glob("0-*"))) == 1  # computed once
    with pytest.raises(ValueError, match=r"belongs to other work: its pieces is 6, not 5"):
        run_pieces(count_calls, pieces[:5], checkpoint=kept)
    with pytest.raises(ValueError, match=r"its fingerprint is .* choose another folder"):
        run_pieces(count_calls, [(tmp_path, k) for k in range(6)], checkpoint=kept)


@pytest.mark.parametrize("content", [b"", b"PK", None], ids=["empty", "cut", "half"])
def test_a_damaged_piece_is_computed_again(content: bytes | None, tmp_path: Path) -> None:
    kept, parts = tmp_path / "kept", blocks(len(STARTS), 6)
    whole = run_pieces(walk_piece, parts, backend="threading", checkpoint=kept)
    file = kept / "000002.npz"
    before = file.read_bytes()
    file.write_bytes(before[: len(before) // 2] if content is None else content)
    again = run_pieces(walk_piece, parts, backend="threading", checkpoint=kept)
    np.testing.assert_array_equal(np.concatenate(again), np.concatenate(whole))
    with np.load(file, allow_pickle=False) as stored:  # a file that can run no code
        np.testing.assert_array_equal(stored["value"], whole[2])


def test_results_that_cannot_be_kept_are_named(tmp_path: Path) -> None:
    with pytest.raises(TypeError, match="cannot be saved"):
        run_pieces(lambda n: {n}, [1], backend="threading", checkpoint=tmp_path / "kept")


def add(piece: int, before: int | None) -> int:
    if piece < 0:
        raise ArithmeticError(piece)
    return piece + (before or 0)


@pytest.mark.parametrize("backend", ["loky", "threading"])
def test_each_link_of_a_chain_gets_what_the_one_before_found(backend: str, tmp_path: Path) -> None:
    chains = [[1, 2, 3, 4], [], [10], [5, 5]]
    found = run_chains(add, chains, backend=backend, jobs=2, checkpoint=tmp_path / "kept")
    assert found == [[1, 3, 6, 10], [], [10], [5, 10]]
    (tmp_path / "kept" / "000001.npz").unlink()
    again = run_chains(add, chains, backend=backend, jobs=2, checkpoint=tmp_path / "kept")
    assert again == found
    with pytest.raises(ArithmeticError) as caught:
        run_chains(add, [[1], [1, 1, -1]], backend=backend, jobs=2)
    assert caught.value.__notes__ == ["in piece 3 of 4"]


def test_what_a_function_is_given_beforehand_belongs_to_the_work(tmp_path: Path) -> None:
    kept = tmp_path / "kept"
    power = functools.partial(pow, 2)
    assert run_pieces(power, [1, 2, 3], backend="threading", checkpoint=kept) == [2, 4, 8]
    with pytest.raises(ValueError, match=r"belongs to other work: its fingerprint"):
        run_pieces(functools.partial(pow, 3), [1, 2, 3], backend="threading", checkpoint=kept)


def test_a_folder_with_other_files_is_no_checkpoint(tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").touch()
    with pytest.raises(ValueError, match="checkpoint must be a new or empty folder"):
        run_pieces(fail_at_two, [1], checkpoint=tmp_path)


def test_bad_options_are_refused() -> None:
    with pytest.raises(ValueError, match=r"backend must be one of loky, .* got 'mpi'"):
        run_pieces(fail_at_two, [1], backend="mpi")
    with pytest.raises(ValueError, match="address must be left out for 'loky'"):
        run_pieces(fail_at_two, [1], address="tcp://10.0.0.1:8786")
    with pytest.raises(ValueError, match="jobs must be at least 1, got 0"):
        run_pieces(fail_at_two, [1], jobs=0)
    with pytest.raises(ValueError, match="retries must be at least 0, got -1"):
        run_pieces(fail_at_two, [1], retries=-1)


def count_slices(rows: int) -> int:
    calls: list[slice] = []
    threads.run_in_slices(calls.append, rows)
    return len(calls)


def test_a_piece_keeps_to_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(threads.THREADS_VARIABLE, "3")
    assert threads.cores() == 3
    assert count_slices(1000) > 1
    assert run_pieces(count_slices, [1000], backend="threading", jobs=2) == [1]
    monkeypatch.setenv(threads.THREADS_VARIABLE, "many")
    with pytest.raises(ValueError, match="POWERED_WALKER_THREADS must be a positive integer"):
        threads.cores()


@pytest.mark.filterwarnings("ignore")  # of the cluster's own
def test_a_dask_cluster_that_loses_a_worker_gives_the_results_of_one_machine(
    tmp_path: Path,
) -> None:
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None
    ) as cluster:
        address = cluster.scheduler_address
        pieces = [(tmp_path / "died", number) for number in range(8)]
        found = run_pieces(die_once, pieces, backend="dask", address=address)
        walked = run_pieces(walk_piece, blocks(len(STARTS), 5), backend="dask", address=address)
    assert (tmp_path / "died").exists()
    assert found == [k * k for k in range(8)]
    np.testing.assert_array_equal(np.concatenate(walked), walk_piece(slice(None)))


def test_ray_gives_the_results_of_this_machine_though_a_worker_dies(tmp_path: Path) -> None:
    pytest.importorskip("ray", reason="needs pip install ray, which CI leaves out for its size")
    died = tmp_path / "died"

    def piece(number: int) -> int:
        if number == 3 and not died.exists():
            died.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return number + 100

    assert run_pieces(piece, range(6), backend="ray", jobs=2) == [*range(100, 106)]
