"""rl-baselines3-zoo: its own commands train, evaluate and film with our settings' file."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

# Not imported here: it patches Gymnasium's time limit for the whole process.
MISSING = importlib.util.find_spec("rl_zoo3") is None
pytestmark = [pytest.mark.slow, pytest.mark.skipif(MISSING, reason="needs rl_zoo3")]
ROOT = Path(__file__).parents[2]
ENV = "PoweredWalkerRoundFoot-v0"
QUIET = {"SDL_VIDEODRIVER": "dummy", "OMP_NUM_THREADS": "1"}  # no screen, and no fight for cores


def zoo(folder: Path, module: str, *arguments: str) -> str:
    """What one of its commands says."""
    done = subprocess.run(
        [sys.executable, "-m", f"rl_zoo3.{module}", *arguments],
        cwd=folder,
        env={**os.environ, **QUIET, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-4000:]
    return done.stdout


@pytest.mark.parametrize("algo", ["ppo", "sac"])
def test_it_trains_and_evaluates_with_our_file(algo: str, tmp_path: Path) -> None:
    common = ("--algo", algo, "--env", ENV, "--gym-packages", "powered_walker_env", "-f", "logs")
    settings = str(ROOT / "configs" / f"{algo}.yml")
    zoo(
        tmp_path, "train", *common, "--conf-file", settings, "--n-timesteps", "1024",
        "--eval-freq", "1024", "--eval-episodes", "2", "--n-eval-envs", "1", "--seed", "1",
    )  # fmt: skip
    assert list((tmp_path / "logs" / algo).glob(f"{ENV}_1/{ENV}.zip"))
    said = zoo(tmp_path, "enjoy", *common, "--exp-id", "1", "--n-timesteps", "100", "--no-render")
    assert "Episode Reward" in said or "Mean reward" in said
