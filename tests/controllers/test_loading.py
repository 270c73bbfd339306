"""Controllers by name, by import path, and out of files; Stable-Baselines3's models among them."""

from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from powered_walker_env.controllers import Network, OpenLoop, evaluate, load_controller
from powered_walker_env.controllers import save_network as save
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.controllers.loading import NAMED
from powered_walker_env.envs.task import Task

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"
TASK: Task = task_of(ROUND_FOOT)
ONE_NUMBER: Task = task_of(ROUND_FOOT, preset="toe-off")
PICKLE = r"is a pickle of Stable-Baselines3: loading it runs the code it holds"


def a_network(actions: int = 2, **settings: Any) -> Network:
    return Network([(0.1 * np.ones((actions, 4)), np.zeros(actions))], settings=settings)


def model_of(algo: str, **kwargs: Any) -> Any:
    """An untrained model with a small network."""
    module = pytest.importorskip("stable_baselines3" if algo.isupper() else "sb3_contrib")
    from powered_walker_env.sb3 import PoweredWalkerVecEnv

    if algo in ("SAC", "TD3", "DDPG", "Tqc", "CrossQ"):
        kwargs["buffer_size"] = 10
    kind = getattr(module, {"Tqc": "TQC", "Trpo": "TRPO", "Lstm": "RecurrentPPO"}.get(algo, algo))
    policy = "MlpLstmPolicy" if algo == "Lstm" else "MlpPolicy"
    size: dict[str, Any] = {"net_arch": [8]}
    if kwargs.pop("metric", False):
        size |= a_metric()
    env = PoweredWalkerVecEnv(ROUND_FOOT, 1)
    return kind(policy, env, policy_kwargs=size, seed=1, device="cpu", **kwargs)


def a_metric() -> dict[str, Any]:
    """Policy arguments that stretch what is seen."""
    from powered_walker_env.controllers.stable_baselines import StrideMetric

    matrix = (np.eye(4) + np.diag([2.0, 0.5, 1.0], 1)).tolist()
    kwargs = {"matrix": matrix}
    return {"features_extractor_class": StrideMetric, "features_extractor_kwargs": kwargs}


def use_norms(model: Any) -> None:
    """Give CrossQ's normalisations numbers, as a training does: untrained they change nothing."""
    torch = pytest.importorskip("torch")
    generator = torch.Generator().manual_seed(0)
    norms = [part for part in model.actor.modules() if hasattr(part, "ra_mean")]
    assert len(norms) == 2  # before the one hidden layer and behind it
    for norm in norms:
        for values in (norm.ra_mean, norm.ra_var, norm.scale.data, norm.bias.data):
            values += torch.rand(values.shape, generator=generator)


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("models") / "good.zip"
    model_of("PPO").save(path)
    return path


def test_the_baselines_have_names() -> None:
    name, controller = load_controller("open-loop", ONE_NUMBER)
    assert name == "open loop"
    assert controller.predict(np.ones((3, 4)))[0].shape == (3, 1)
    assert load_controller("lqr", TASK)[0] == "LQR"


@pytest.mark.parametrize("name", [name for name in NAMED if name != "optimal"])
def test_every_name_is_a_controller_of_any_task(name: str) -> None:
    slow = name.startswith(("numbers", "one", "trial", "tuned"))  # two actions: in their own tests
    for task in (ONE_NUMBER,) if slow else (TASK, ONE_NUMBER):
        label, controller = load_controller(name, task)
        assert label == NAMED[name][0]
        actions, memory = controller.predict(np.zeros((3, 4), np.float32), deterministic=True)
        assert memory is None
        assert actions.shape == (3, len(task.nominal))
        derivative = getattr(controller, "derivative", None)
        if derivative is not None:
            assert derivative(np.zeros((3, 4))).shape == (3, len(task.nominal), 4)


def test_the_room_needs_no_learning_library() -> None:
    program = (
        "import sys, powered_walker_env.controllers as room\n"
        "room.load_controller('lqr', room.evaluation.task_of('PoweredWalker-v0'))\n"
        "print([name for name in ('torch', 'stable_baselines3', 'rich') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.stdout, done.returncode) == ("[]\n", 0)


def test_a_function_is_a_controller_by_itself_and_by_import_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "my_own_module.py").write_text(
        "import numpy as np\n\ndef stiffer(x):\n    return np.tile([0.0, 0.1], (len(x), 1))\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    name, controller = load_controller("my_own_module:stiffer", TASK)
    assert name == "my_own_module:stiffer"
    from my_own_module import stiffer  # type: ignore[import-not-found]

    assert load_controller(stiffer, TASK)[0] == "stiffer"
    runs = [evaluate(who, ROUND_FOOT, 5) for who in (controller, stiffer)]
    assert runs[0].strides.tolist() == runs[1].strides.tolist()
    assert runs[0].strides.tolist() != evaluate(OpenLoop(), ROUND_FOOT, 5).strides.tolist()
    for wrong in ("my_own_module:softer", "no_such_module:f"):
        with pytest.raises(ImportError, match=f"the controller {wrong!r} cannot be imported"):
            load_controller(wrong, TASK)
    with pytest.raises(TypeError, match="or be a function from"):
        load_controller("math:pi", TASK)


@pytest.mark.parametrize("algo", ["PPO", "A2C", "SAC", "TD3", "Tqc", "CrossQ", "Trpo", "Lstm"])
def test_a_saved_model_of_any_algorithm_acts_as_before(algo: str, tmp_path: Path) -> None:
    model = model_of(algo, metric=algo != "Lstm")
    model.save(tmp_path / "model.zip")
    with pytest.warns(UserWarning, match=PICKLE):
        name, loaded = load_controller(tmp_path / "model.zip", TASK)
    assert name == f"SB3 {tmp_path.name}/model"
    x = np.random.default_rng(0).normal(size=(5, 4)).astype(np.float32)
    first, memory = model.predict(x, deterministic=True)
    actions, again = loaded.predict(x, None, np.ones(5, bool), deterministic=True)
    np.testing.assert_array_equal(actions, first)
    if memory is not None:
        np.testing.assert_array_equal(again[0], memory[0])


@pytest.mark.parametrize(
    "kwargs", [{"use_sde": True}, {}, {"metric": True}], ids=["sde", "plain", "metric"]
)
@pytest.mark.parametrize("algo", ["PPO", "SAC", "TD3", "Tqc", "CrossQ"])
def test_the_numbers_of_a_model_are_its_policy(
    algo: str, kwargs: dict[str, Any], tmp_path: Path
) -> None:
    from powered_walker_env.controllers.stable_baselines import double_precision

    sde = "use_sde" in kwargs
    if sde and algo == "TD3":
        pytest.skip("TD3 has no state-dependent exploration")
    model = model_of(algo, **kwargs)
    if algo == "CrossQ":
        use_norms(model)
    if sde and algo != "PPO":  # bends its mean a second time
        with pytest.raises(TypeError, match="the network must be linear layers"):
            double_precision(model)
        return
    save(double_precision(model, {"algo": algo, "env_id": ROUND_FOOT}), tmp_path / "p.npz")
    name, network = load_controller(tmp_path / "p.npz", TASK, ROUND_FOOT)
    assert name == f"{algo} {tmp_path.name}/p"
    x = np.random.default_rng(0).normal(size=(50, 4)).astype(np.float32)
    wanted, _ = model.predict(x, deterministic=True)
    np.testing.assert_allclose(network.predict(x)[0], wanted, atol=1e-6)


def test_a_policy_with_a_memory_has_no_numbers_alone() -> None:
    from powered_walker_env.controllers.stable_baselines import double_precision

    with pytest.raises(TypeError, match="without memory"):
        double_precision(model_of("Lstm"))


def test_a_folder_gives_its_policy_without_code_first(tmp_path: Path, saved: Path) -> None:
    folder = tmp_path / "first"
    folder.mkdir()
    shutil.copy(saved, folder / "best_model.zip")
    with pytest.warns(UserWarning, match=PICKLE):
        assert load_controller(folder, TASK)[0] == "SB3 first"
    save(a_network(algo="PPO"), folder / "policy.npz")
    assert load_controller(str(folder), TASK)[0] == "PPO first"
    shutil.rmtree(folder)
    folder.mkdir()
    with pytest.raises(FileNotFoundError, match=r"no model file .*best_model\.zip"):
        load_controller(folder, TASK)


def test_what_is_not_there_is_named() -> None:
    with pytest.raises(FileNotFoundError, match=r"no model file 'nowhere/model\.zip'; train one"):
        load_controller("nowhere/model.zip", TASK)
    with pytest.raises(FileNotFoundError, match=r"controllers are 'open-loop', 'lqr', .* 'pid'"):
        load_controller("pid", TASK)


def test_a_policy_of_another_walker_is_noted(tmp_path: Path) -> None:
    save(a_network(env_id=ROUND_FOOT), tmp_path / "x.npz")
    load_controller(tmp_path / "x.npz", TASK, f"powered_walker_env:{ROUND_FOOT}")
    with pytest.warns(UserWarning, match=f"was trained on {ROUND_FOOT}, not on PoweredWalker-v0"):
        load_controller(tmp_path / "x.npz", TASK, "PoweredWalker-v0")


def test_a_policy_for_other_actions_is_refused(tmp_path: Path, saved: Path) -> None:
    save(a_network(2), tmp_path / "x.npz")
    with pytest.raises(ValueError, match=r"of shape \(4,\) and \(2,\), not \(4,\) and \(1,\)"):
        load_controller(tmp_path / "x.npz", ONE_NUMBER)
    with (
        pytest.warns(UserWarning, match=PICKLE),
        pytest.raises(ValueError, match=r"another task: .* \(2,\), not \(4,\) and \(1,\)"),
    ):
        load_controller(saved, ONE_NUMBER)


@pytest.mark.filterwarnings("ignore:.*is a pickle of Stable-Baselines3")
def test_damaged_models_are_named(tmp_path: Path, saved: Path) -> None:
    content, bad = saved.read_bytes(), tmp_path / "bad.zip"
    with zipfile.ZipFile(saved) as good, zipfile.ZipFile(tmp_path / "part.zip", "w") as part:
        part.writestr("data", good.read("data"))
    (tmp_path / "notes").mkdir()
    (tmp_path / "notes" / "a.txt").write_text("no model")
    shutil.make_archive(str(tmp_path / "notes"), "zip", tmp_path / "notes")
    contents = [b"", b"no zip at all", content[: len(content) // 2]]
    contents += [(tmp_path / name).read_bytes() for name in ("part.zip", "notes.zip")]
    for damaged in contents:
        bad.write_bytes(damaged)
        with pytest.raises(ValueError, match=r"bad\.zip' is not a saved model .* or is damaged"):
            load_controller(bad, TASK)
