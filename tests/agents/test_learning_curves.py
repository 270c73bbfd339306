"""Learning curves of several trainings in one picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import PIL.Image
import pytest

from agents.learning_curves import main, read_curve
from powered_walker_env.controllers import OpenLoop, evaluate

KNEED = "PoweredWalkerKneed-v0"


def a_run(folder: Path, env_id: str = KNEED, steps: tuple[int, ...] = (0, 10, 20)) -> Path:
    """A run's folder as `agents.train` leaves it."""
    folder.mkdir()
    (folder / "config.yml").write_text(f"algo: ppo\nenv_id: {env_id}\nenv_kwargs: {{}}\n")
    rows = "".join(f"{step},{10 + step}\n" for step in steps)
    (folder / "evaluations.csv").write_text(f"steps,strides\n{rows}")
    return folder


def test_runs_are_drawn_beside_the_baselines(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    runs = [str(a_run(tmp_path / name)) for name in ("a", "b")]
    out = tmp_path / "curves.png"
    main([*runs, "--out", str(out), "--episodes", "20"])
    printed = capsys.readouterr().out
    strides = evaluate(OpenLoop(), KNEED, 20).strides.mean()
    assert f"open loop: {strides:.1f} strides in 20 episodes" in printed and "LQR" in printed
    with PIL.Image.open(out) as picture:
        assert min(picture.size) > 500
    with pytest.raises(FileExistsError, match="exists already"):
        main([*runs, "--out", str(out)])


def test_a_curve_is_that_of_the_evaluations(tmp_path: Path) -> None:
    steps, strides = read_curve(a_run(tmp_path / "a"))
    np.testing.assert_array_equal([steps, strides], [[0, 10, 20], [10, 20, 30]])


def test_runs_that_cannot_be_compared_are_refused(tmp_path: Path) -> None:
    first, out = str(a_run(tmp_path / "a")), str(tmp_path / "x.png")
    other = str(a_run(tmp_path / "other", "PoweredWalker-v0"))
    shorter = str(a_run(tmp_path / "shorter", steps=(0, 10)))
    for second in (other, shorter):
        with pytest.raises(ValueError, match=f"evaluated at equal times; '{second}' differs from"):
            main([first, second, "--out", out])
    with pytest.raises(ValueError, match=r"config\.yml' cannot be read"):
        main([str(tmp_path), "--out", out])
    (tmp_path / "a" / "evaluations.csv").write_text("")
    with pytest.raises(ValueError, match="holds no evaluations of a training"):
        main([first, "--out", out])
    assert not Path(out).exists()
