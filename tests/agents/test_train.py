"""Training: a run folder that is whole, a resume that changes nothing, a stop that loses nothing."""

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from agents.controllers import make_controller
from agents.ground.cli import UsageError
from agents.ground.environments import make_vector
from agents.ground.files import read_json
from agents.judging.loop import throw_held_out
from agents.judging.throw_record import summary
from agents.learning.runs import RunFolder
from agents.learning.vec_env import SameStepVecEnv
from agents.train import Arguments, main
from tests.tools.models import weights
from tests.tools.toy_cell import ToyVectorEnv

SMALL: dict[str, Any] = {
    "policy": "MlpPolicy",
    "learning_rate": 0.001,
    "batch_size": 32,
    "gamma": 0.0,
    "policy_kwargs": {"net_arch": [16]},
}
OFF_POLICY = {**SMALL, "buffer_size": 2000, "learning_starts": 40, "gradient_steps": -1, "train_freq": 1}
SETTINGS = {"sac": OFF_POLICY, "td3": OFF_POLICY, "tqc": OFF_POLICY, "ppo": {**SMALL, "n_steps": 8}}


@pytest.fixture
def asked(tmp_path: Path) -> Arguments:
    config = tmp_path / "small.yml"
    config.write_text(yaml.safe_dump({"ToyThrow-v0": OFF_POLICY, "ToyShift-v0": OFF_POLICY}))
    return Arguments(
        env="ToyThrow-v0",
        level="waste",
        steps=200,
        num_envs=8,
        checkpoint_every=100,
        out=tmp_path / "run",
        config=config,
        eval_picks=0,
    )


def restored(folder: Path, env: str) -> Any:
    return RunFolder(folder).restore(SameStepVecEnv(make_vector(env, "waste", 8)))


def assert_acts_as_its_model(folder: Path, checkpoint: Path | None = None) -> None:
    seen = np.random.default_rng(5).standard_normal((50, 26)).astype(np.float32)
    theirs = RunFolder(folder).load(None, checkpoint).predict(seen, deterministic=True)[0]
    np.testing.assert_allclose(RunFolder(folder).actor(checkpoint)(seen), theirs, rtol=0, atol=1e-6)


def resumed(folder: Path, **changes: Any) -> Arguments:
    return replace(Arguments(resume=folder, eval_picks=0), **changes)


def test_run_folder_holds_what_it_promises(asked: Arguments, tmp_path: Path) -> None:
    main(replace(asked, eval_picks=24))
    found = {p.name for p in (tmp_path / "run").iterdir()}
    promised = {"args.yml", "config.yml", "env.yaml", "versions.json", "command.txt", "model.zip", "policy.npz"}
    assert promised | {"replay_buffer.npz", "progress.csv", "evaluation.json", "checkpoints"} <= found
    assert not any(name.startswith(".") for name in found)
    assert [p.name for p in RunFolder(tmp_path / "run").checkpoints] == ["00000000", "00000104", "00000200"]
    assert RunFolder(tmp_path / "run").arguments["steps"] == 200
    for checkpoint in (None, *RunFolder(tmp_path / "run").checkpoints):
        assert_acts_as_its_model(tmp_path / "run", checkpoint)


def test_a_policy_learns_without_a_planner(asked: Arguments, tmp_path: Path) -> None:
    """The table beside the policy names the fixed throw, not the planner."""
    (tmp_path / "small.yml").write_text(yaml.safe_dump({"PnTRelease-v0": OFF_POLICY}))
    mode = {"env": "PnTRelease-v0", "fidelity": "flight", "action_mode": "fixed_throw"}
    main(replace(asked, steps=64, eval_picks=16, **mode))
    rows = read_json(tmp_path / "run" / "evaluation.json")
    assert [row["controller"] for row in rows] == ["fixed_throw", "learned (sac)"]
    assert RunFolder(tmp_path / "run").actor(None)(np.zeros((5, 26), dtype=np.float32)).shape == (5, 3)
    env = make_vector("PnTRelease-v0", "waste", 4, action_mode="fixed_throw")
    policy = make_controller(str(tmp_path / "run"), env)
    assert np.isfinite(throw_held_out(policy, env, 8, 0).landing_error).any()
    with pytest.raises(UsageError, match="needs an action of 2 numbers, not 3"):
        make_controller("oracle", env)


@pytest.mark.parametrize("env", ["ToyThrow-v0", "ToyShift-v0"])
def test_resumed_run_is_bit_for_bit_the_uninterrupted_one(asked: Arguments, tmp_path: Path, env: str) -> None:
    # A checkpoint at 104 throws (a multiple of 8 rows), whether or not the process ends there.
    whole, halves = tmp_path / "whole", tmp_path / "halves"
    main(replace(asked, env=env, out=whole))
    main(replace(asked, env=env, out=halves, steps=100))
    main(resumed(halves, steps=200))
    one, two = restored(whole, env), restored(halves, env)
    assert one.num_timesteps == two.num_timesteps == 200
    assert one.replay_buffer.size() == two.replay_buffer.size() == 25  # throws per row
    assert len(np.unique(two.replay_buffer.observations[:25, :, 0])) == 200  # a resume goes on with new objects
    assert np.array_equal(one.replay_buffer.observations, two.replay_buffer.observations)
    assert np.array_equal(one.replay_buffer.actions, two.replay_buffer.actions)
    assert all(np.array_equal(a, b) for a, b in zip(weights(whole), weights(halves), strict=True))


def test_flights_first_and_the_full_physics_last(asked: Arguments, tmp_path: Path) -> None:
    same_random_actions = OFF_POLICY | {"learning_starts": 1000}
    (tmp_path / "small.yml").write_text(yaml.safe_dump({"PnTRelease-v0": same_random_actions}))
    begun = replace(asked, env="PnTRelease-v0", level="nominal", steps=64, checkpoint_every=32)
    main(replace(begun, fidelity="flight", full_last=32, out=tmp_path / "both"))
    main(replace(begun, out=tmp_path / "full"))
    both, full = (
        RunFolder(tmp_path / name).restore(SameStepVecEnv(make_vector("PnTRelease-v0", "nominal", 8))).replay_buffer
        for name in ("both", "full")
    )
    assert np.array_equal(both.observations, full.observations)
    assert np.array_equal(both.actions, full.actions)
    assert not np.array_equal(both.rewards[:4], full.rewards[:4])
    np.testing.assert_allclose(both.rewards[:4], full.rewards[:4], atol=0.15)  # a success on a rim may differ
    assert np.array_equal(both.rewards[4:8], full.rewards[4:8])
    recorded = yaml.safe_load((tmp_path / "both" / "env.yaml").read_text())
    assert recorded["fidelity"] == "full", "evaluation is in full physics unless it is asked otherwise"


@pytest.mark.parametrize("algo", ["td3", "tqc", "ppo"])
def test_other_algorithms_train_and_resume(asked: Arguments, tmp_path: Path, algo: Any) -> None:
    config = tmp_path / "other.yml"
    config.write_text(yaml.safe_dump({"ToyThrow-v0": SETTINGS[algo]}))
    begun = replace(asked, algo=algo, config=config, steps=64, checkpoint_every=64)
    main(begun)
    main(resumed(tmp_path / "run", steps=128))
    assert RunFolder(tmp_path / "run").load().num_timesteps == 128
    assert_acts_as_its_model(tmp_path / "run")
    main(replace(begun, steps=128, out=tmp_path / "whole"))
    pairs = zip(weights(tmp_path / "run"), weights(tmp_path / "whole"), strict=True)
    assert all(np.array_equal(one, other) for one, other in pairs)


def test_training_learns(asked: Arguments, tmp_path: Path) -> None:
    main(replace(asked, steps=900, checkpoint_every=900))
    env = ToyVectorEnv(8)
    error = {
        name: summary(throw_held_out(make_controller(name, env), env, 400, 0))["landing_error_mean_m"]
        for name in ("analytic", str(tmp_path / "run"))
    }
    assert error[str(tmp_path / "run")] < 0.85 * error["analytic"]


def torn(run: Path, name: str) -> None:
    """Files of a name, in checkpoints too, of which only the beginning is left."""
    for file in run.rglob(name):
        file.write_bytes(file.read_bytes()[:200])


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (shutil.rmtree, "does not exist"),
        (lambda run: (run / "args.yml").write_text("env: ["), "args.yml': it is not valid YAML"),
        (lambda run: (run / "args.yml").write_text("env: ToyThrow-v0"), "args.yml lacks level, algo"),
        (lambda run: torn(run, "model.zip"), "model.zip is truncated or not a model"),
        (lambda run: torn(run, "replay_buffer.npz"), "checkpoint 00000016 is truncated"),
        (lambda run: shutil.rmtree(run / "checkpoints"), "has no checkpoint"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_damaged_runs_are_refused_with_one_sentence(run: Path, damage: Callable[[Path], Any], said: str) -> None:
    damage(run)
    with pytest.raises(UsageError, match=said) as refused:
        main(resumed(run, steps=200))
    assert "\n" not in str(refused.value)


def test_a_policy_that_cannot_be_kept_as_numbers_is_not_begun(asked: Arguments, tmp_path: Path) -> None:
    kwargs = "dict(net_arch=[8], activation_fn=nn.PReLU)"
    (tmp_path / "small.yml").write_text(yaml.safe_dump({"default": {**OFF_POLICY, "policy_kwargs": kwargs}}))
    with pytest.raises(UsageError, match=r"the policy cannot be saved as arrays: .* activation_fn one of ELU, GELU"):
        main(asked)
    assert [p.name for p in tmp_path.iterdir()] == ["small.yml"]
